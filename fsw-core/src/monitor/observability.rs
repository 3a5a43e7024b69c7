//! Which of the six directions of the inertia the data has shown.
//!
//! A direction counts as seen once the data has cut its uncertainty to a tenth of what was held
//! before. Each element is measured in units of its prior range, so that a tensor of 1e-5 kg m²
//! and one of 1e3 are judged alike.

use crate::math::{Mat, eigen::symmetric_eigen, scalar::Real};

/// Posterior over prior sigma below which a direction has been seen.
const SEEN: f64 = 0.1;

/// What the data has shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Observed {
    /// Independent directions in the space of the six elements, 0 to 6.
    pub directions: u8,
    /// Element by element, `jxx jyy jzz jxy jxz jyz`.
    pub element: [bool; 6],
    /// The size of the tensor (its trace), not just its ratios.
    pub scale: bool,
}

/// Compares a covariance of the six elements (kg² m⁴) with the prior sigma of each (kg m²,
/// positive).
#[inline(never)]
pub fn observed<T: Real>(covariance: &Mat<T, 6, 6>, prior_sigma: &[T; 6]) -> Observed {
    let mut scaled = Mat::<T, 6, 6>::zeros();
    for i in 0..6 {
        for k in 0..6 {
            // Divided one after the other: the product of two sigmas may underflow in f32.
            scaled[(i, k)] = covariance[(i, k)] / prior_sigma[i] / prior_sigma[k];
        }
    }
    let seen = |variance: T| variance < T::lit(SEEN * SEEN);
    let (variances, _) = symmetric_eigen(&scaled);
    let directions = variances.iter().filter(|v| seen(**v)).count() as u8;
    let element = core::array::from_fn(|i| seen(scaled[(i, i)]));
    let (mut trace, mut prior_trace) = (T::zero(), T::zero());
    for i in 0..3 {
        prior_trace += prior_sigma[i] * prior_sigma[i];
        for k in 0..3 {
            trace += covariance[(i, k)];
        }
    }
    Observed { directions, element, scale: seen(trace / prior_trace) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: [f64; 6] = [30.0, 30.0, 30.0, 10.0, 10.0, 10.0];

    fn prior_covariance() -> Mat<f64, 6, 6> {
        Mat::<f64, 6, 6>::from_diagonal(&PRIOR.map(|s| s * s).into())
    }

    #[test]
    fn the_prior_alone_shows_nothing() {
        assert_eq!(observed(&prior_covariance(), &PRIOR), Observed::default());
    }

    #[test]
    fn all_six() {
        let o = observed(&(prior_covariance() * 1e-4), &PRIOR);
        assert_eq!(o, Observed { directions: 6, element: [true; 6], scale: true });
    }

    #[test]
    fn a_difference_can_be_seen_while_its_terms_are_not() {
        // Jxx − Jyy known to 1 %, their sum not at all.
        let mut p = prior_covariance();
        p[(0, 1)] = 0.9999 * p[(0, 0)];
        p[(1, 0)] = p[(0, 1)];
        let o = observed(&p, &PRIOR);
        assert_eq!(o.directions, 1);
        assert_eq!(o.element, [false; 6]);
        assert!(!o.scale);
    }

    #[test]
    fn tiny_bodies_are_judged_like_large_ones_in_single_precision() {
        let prior = PRIOR.map(|s| s as f32 * 1e-9);
        let p = prior_covariance().map(|x| (x * 1e-18 * 1e-4) as f32);
        assert_eq!(observed(&p, &prior).directions, 6);
    }
}
