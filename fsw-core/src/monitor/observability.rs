//! Observed directions of the inertia: those that the data have made known.
//!
//! Input: covariance P of the six elements, kg² m⁴; sigma σ₀ of each element before the data, kg
//! m². Output: number of observed directions, observed elements, observed scale.
//!
//! Each element is scaled by its prior sigma, `P'ᵢₖ = Pᵢₖ / (σ₀ᵢ σ₀ₖ)`, so that a tensor of 1e-5 kg
//! m² and one of 1e3 are judged alike. A direction, an eigenvector of P', is observed once the data
//! have reduced its sigma to a tenth: eigenvalue below 0.01.
//!
//! A sigma of many times the moments is no statement about the body, and a reduction of it to the
//! size of the moments is none about the data: [`range_before_data`] limits the yardstick to the
//! range of a body of the estimated size. With a prior of 1 ± 30 kg m² an estimate of 1 ± 1 is
//! thus unobserved, and one of 1 ± 0.09 observed.

use crate::math::{Entries, Mat, eigen::symmetric_eigen, scalar::Real};
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Ratio of posterior to prior sigma below which a direction is observed.
const OBSERVED_RATIO: f64 = 0.1;

/// Observed part of the inertia. The default is nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Observed {
    /// Independent directions in the space of the six elements, 0 to 6.
    pub directions: u8,
    /// Observed elements, `jxx jyy jzz jxy jxz jyz`.
    pub element: [bool; 6],
    /// Observed trace: the size of the tensor and not only its ratios.
    pub scale: bool,
}

crate::persist!([] Observed { directions, element, scale });

/// Range of each element before the data, kg m²: the prior's sigma, but not above that of a body of
/// the estimated size, [`Prior::of_size`] with the mean moment `tr(J) / 3`.
///
/// Zeros where the mean moment is not positive: nothing is then observed.
///
/// ```
/// use fsw_core::Inertia;
/// use fsw_core::monitor::observability::range_before_data;
///
/// let estimate = Inertia::new([1.0, 2.0, 3.0, 0.1, 0.0, 0.0f64]);
/// let range_kg_m2 = range_before_data(&estimate, &[30.0, 30.0, 0.5, 10.0, 0.2, 10.0]);
/// assert_eq!(range_kg_m2, [2.0, 2.0, 0.5, 1.0, 0.2, 1.0]);
/// ```
pub fn range_before_data<T: Real>(estimate: &Inertia<T>, prior_sigma: &[T; 6]) -> [T; 6] {
    let mean_moment = estimate.trace_kg_m2() * T::lit(1.0 / 3.0);
    let largest = Prior::of_size(mean_moment.max(T::zero())).sigma_kg_m2;
    core::array::from_fn(|i| prior_sigma[i].min(largest[i]))
}

/// Observed directions from the covariance of the six elements (kg² m⁴) and the range of each before
/// the data (kg m²); nothing where a range is not positive.
///
/// The trace counts as observed by `tᵀ P t / tᵀ diag(σ₀²) t < 0.01`, `t = (1 1 1 0 0 0)`.
///
/// ```
/// use fsw_core::math::Mat;
/// use fsw_core::monitor::observability::observed;
///
/// // Moments known to 1 % of their prior sigma, products not at all.
/// let prior_sigma_kg_m2 = [30.0, 30.0, 30.0, 10.0, 10.0, 10.0];
/// let sigma_kg_m2 = [0.3, 0.3, 0.3, 10.0, 10.0, 10.0f64];
/// let covariance = Mat::from_diagonal(&sigma_kg_m2.map(|s| s * s).into());
/// let observed = observed(&covariance, &prior_sigma_kg_m2);
/// assert_eq!(observed.directions, 3);
/// assert_eq!(observed.element, [true, true, true, false, false, false]);
/// assert!(observed.scale);
/// ```
#[inline(never)]
pub fn observed<T: Real>(covariance: &Mat<T, 6, 6>, prior_sigma: &[T; 6]) -> Observed {
    if !prior_sigma.iter().all(|sigma| *sigma > T::zero()) {
        return Observed::default();
    }
    let mut scaled = *covariance;
    for i in 0..6 {
        for k in 0..6 {
            // Two divisions: the product of two sigmas may underflow in f32.
            *scaled.at_mut(i, k) = covariance.at(i, k) / prior_sigma[i] / prior_sigma[k];
        }
    }
    let is_observed = |variance: T| variance < T::lit(OBSERVED_RATIO * OBSERVED_RATIO);
    let (variances, _) = symmetric_eigen(&scaled);
    let directions = variances.iter().filter(|v| is_observed(**v)).count() as u8;
    let element = core::array::from_fn(|i| is_observed(scaled.at(i, i)));
    let (mut trace, mut prior_trace) = (T::zero(), T::zero());
    for i in 0..3 {
        prior_trace += prior_sigma[i] * prior_sigma[i];
        for k in 0..3 {
            trace += covariance.at(i, k);
        }
    }
    Observed { directions, element, scale: is_observed(trace / prior_trace) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: [f64; 6] = [30.0, 30.0, 30.0, 10.0, 10.0, 10.0];

    fn prior_covariance() -> Mat<f64, 6, 6> {
        Mat::<f64, 6, 6>::from_diagonal(&PRIOR.map(|s| s * s).into())
    }

    /// Posterior equal to the prior.
    #[test]
    fn the_prior_alone_observes_nothing() {
        assert_eq!(observed(&prior_covariance(), &PRIOR), Observed::default());
    }

    #[test]
    fn a_hundredth_of_the_prior_sigma_observes_all_six() {
        let o = observed(&(prior_covariance() * 1e-4), &PRIOR);
        assert_eq!(o, Observed { directions: 6, element: [true; 6], scale: true });
    }

    /// `Jxx − Jyy` known to 1 %, the sum unknown: one direction, no element.
    #[test]
    fn a_difference_is_observable_without_its_terms() {
        let mut p = prior_covariance();
        p[(0, 1)] = 0.9999 * p[(0, 0)];
        p[(1, 0)] = p[(0, 1)];
        let o = observed(&p, &PRIOR);
        assert_eq!(o.directions, 1);
        assert_eq!(o.element, [false; 6]);
        assert!(!o.scale);
    }

    /// Covariance of the prior, and that of a body of the prior's size: no data.
    #[test]
    fn a_prior_far_above_its_moments_observes_nothing() {
        for times in [10.0, 30.0, 1e4] {
            let inertia = [1.0, 1.2, 1.4, 0.1, -0.1, 0.05f64];
            let sigma = inertia.map(|_| 1.2 * times);
            let range = range_before_data(&Inertia::new(inertia), &sigma);
            for sigma in [sigma, Prior::of_size(1.2).sigma_kg_m2] {
                let covariance = Mat::<f64, 6, 6>::from_diagonal(&sigma.map(|s| s * s).into());
                assert_eq!(observed(&covariance, &range), Observed::default());
            }
            let known = Mat::<f64, 6, 6>::identity() * (0.05 * 0.05);
            assert_eq!(observed(&known, &range).directions, 6);
        }
    }

    /// Estimate without a positive trace.
    #[test]
    fn an_impossible_size_observes_nothing() {
        for moment in [0.0f32, -1.0, f32::NAN] {
            let range = range_before_data(&Inertia::spherical(moment), &[1.0; 6]);
            assert_eq!(observed(&Mat::<f32, 6, 6>::zeros(), &range), Observed::default());
        }
    }

    /// Prior sigma of 3e-8 to 3e10 kg m², in single precision.
    #[test]
    fn the_result_is_independent_of_size_in_single_precision() {
        for size in [1e-9, 1.0, 1e9] {
            let prior = PRIOR.map(|s| (s * size) as f32);
            let p = prior_covariance().map(|x| (x * size * size * 1e-4) as f32);
            let all = Observed { directions: 6, element: [true; 6], scale: true };
            assert_eq!(observed(&p, &prior), all, "{size}");
        }
    }

    #[test]
    fn a_range_that_is_not_positive_observes_nothing() {
        for sigma in [0.0, -30.0, f64::NAN] {
            let range = [30.0, sigma, 30.0, 10.0, 10.0, 10.0];
            assert_eq!(observed(&(prior_covariance() * 1e-4), &range), Observed::default());
        }
    }

    /// The mean moment of the estimate is the largest range of a moment, half of it that of a product.
    #[test]
    fn range_is_that_of_a_body_of_the_estimated_size() {
        let estimate = Inertia::new([1.0, 2.0, 3.0, 0.1, 0.0, 0.0f64]);
        let range = range_before_data(&estimate, &[30.0, 30.0, 0.5, 10.0, 0.2, 10.0]);
        assert_eq!(range, [2.0, 2.0, 0.5, 1.0, 0.2, 1.0]);
    }
}
