//! Judgement of one estimate: right, announced as wrong, or wrong unannounced.

use fsw_core::{Estimate, Status};

/// Error that is allowed besides the sigmas, as a share of the mean moment of inertia, where an
/// estimate is judged before the end of its log.
pub const SHARE_IN_FLIGHT: f64 = 0.02;

/// Errors of a usable estimate in sigmas, on any element.
pub const MAX_SIGMAS: f64 = 5.0;

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
pub fn mean_moment_kg_m2(elements_kg_m2: &[f64; 6]) -> f64 {
    elements_kg_m2[..3].iter().sum::<f64>() / 3.0
}

/// Trace of the tensor and its sigma, kg m².
pub fn trace_kg_m2(estimate: &Estimate<f64>) -> (f64, f64) {
    let variance = estimate.covariance_kg2_m4.fixed_view::<3, 3>(0, 0).sum();
    (estimate.inertia.trace_kg_m2(), variance.max(0.0).sqrt())
}
