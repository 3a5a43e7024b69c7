//! Judgement of one estimate: right, announced as wrong, or wrong unannounced.

use fsw_core::{Estimate, Status};
use host_sim::campaign::Reference;
use host_sim::input::craft::Prior;

/// Error that is allowed besides the sigmas, as a share of the mean moment of inertia, where an
/// estimate is judged before the end of its log.
pub const SHARE_IN_FLIGHT: f64 = 0.02;

/// Errors of a usable estimate in sigmas, on any element.
pub const MAX_SIGMAS: f64 = 5.0;

/// Least sigma of an unobserved trace over that of the prior, with an allowance for rounding.
const LEAST_SCALE_SIGMA: f64 = 0.98;
/// Least sigma over bound.
const LEAST_OVER_BOUND: f64 = 0.9;
/// Rounding error of a ratio to the trace in single precision, and of its conversion.
const RATIO_ROUNDING: f64 = 1e-6;

/// One estimate compared with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// Converged, residuals not called other than white, and within the limit.
    Right,
    /// Not converged, or residuals called not white.
    Announced,
    /// Converged, residuals not called other than white, and an element beyond the limit.
    Silent,
}

/// Judges an estimate. The limit of each element is `MAX_SIGMAS` of its sigma and `share` of the mean
/// true moment of inertia.
pub fn judge(estimate: &Estimate<f64>, truth_kg_m2: &[f64; 6], share: f64) -> Judgement {
    if estimate.status != Status::Converged || estimate.residuals_white == Some(false) {
        return Judgement::Announced;
    }
    let sigma = estimate.sigma_kg_m2();
    let found = estimate.inertia.elements_kg_m2();
    let allowance = share * mean_moment_kg_m2(truth_kg_m2);
    let is_within =
        |i: usize| (found[i] - truth_kg_m2[i]).abs() <= MAX_SIGMAS * sigma[i] + allowance;
    if (0..6).all(is_within) { Judgement::Right } else { Judgement::Silent }
}

/// Mean moment of inertia, kg m².
fn mean_moment_kg_m2(elements_kg_m2: &[f64; 6]) -> f64 {
    elements_kg_m2[..3].iter().sum::<f64>() / 3.0
}

/// True if a motion without information on the scale is said to have some: the scale is called
/// observed, or the sigma of the trace is below that of the prior; or the ratios are wrong, see
/// [`claims_ratios`].
///
/// On a body of the ratios `n`, a prior with sigmas `σᵢ` leaves the trace with the sigma
/// `1 / √(Σ nᵢ² / σᵢ²)`. The ratios are those of the estimate: where the motion shows only some of them, they
/// differ from the true ones by several per cent, and so does that sigma. Without a prior the sigma must not be below the trace itself.
pub fn claims_scale(
    estimate: &Estimate<f64>,
    truth_kg_m2: &[f64; 6],
    prior: Option<&Prior>,
) -> bool {
    let variance = estimate.covariance_kg2_m4.fixed_view::<3, 3>(0, 0).sum();
    let ratios = estimate.over_trace().0;
    let least = match prior {
        Some(prior) => {
            let information = (0..6).map(|i| (ratios[i] / prior.sigma_kg_m2[i]).powi(2));
            1.0 / information.sum::<f64>().sqrt()
        }
        None => estimate.inertia.trace_kg_m2().abs(),
    };
    let is_uncertain = variance.max(0.0).sqrt() >= LEAST_SCALE_SIGMA * least;
    estimate.observed.scale
        || estimate.observed.directions == 6
        || !is_uncertain
        || claims_ratios(estimate, truth_kg_m2)
}

/// True if five directions are observed, the residuals are not called other than white, and a ratio to
/// the trace is beyond 5 of its sigmas.
pub fn claims_ratios(estimate: &Estimate<f64>, truth_kg_m2: &[f64; 6]) -> bool {
    let truth = over_trace(truth_kg_m2);
    let (ratio, sigma) = estimate.over_trace();
    let is_within =
        |i: usize| (ratio[i] - truth[i]).abs() <= MAX_SIGMAS * sigma[i] + RATIO_ROUNDING;
    estimate.observed.directions == 5
        && estimate.residuals_white != Some(false)
        && !(0..6).all(is_within)
}

/// True if a sigma is below nine tenths of the bound; where there is no bound, of the range of the element: the mean
/// moment, and half of it for a product.
pub fn claims_below_bound(estimate: &Estimate<f64>, reference: &Reference) -> bool {
    let range = fsw_core::Prior::of_size(mean_moment_kg_m2(&reference.truth_kg_m2)).sigma_kg_m2;
    let sigma = estimate.sigma_kg_m2();
    let least = |i: usize| LEAST_OVER_BOUND * reference.bound_kg_m2[i].unwrap_or(range[i]);
    !(0..6).all(|i| sigma[i] >= least(i))
}

/// Elements over the trace.
fn over_trace(elements_kg_m2: &[f64; 6]) -> [f64; 6] {
    let trace: f64 = elements_kg_m2[..3].iter().sum();
    elements_kg_m2.map(|j| j / trace)
}
