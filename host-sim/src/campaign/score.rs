//! Score of one run: its error compared with the truth, with the Cramér-Rao bound, and with the
//! estimator's own covariance.
//!
//! In: the final [`Estimate`] of a run and its [`Reference`]. Out: a [`Score`] with a [`Verdict`].
//! Each run has its own reference, since spacecraft may differ from run to run. Elements are ordered
//! `jxx jyy jzz jxy jxz jyz`.

use fsw_core::{Estimate, Real, Status};
use nalgebra::{Matrix6, Vector6};

/// Largest error of a converged run, in Cramér-Rao bounds, on any element; in joint bounds where errors
/// of the hardware are stated. An estimate that uses the
/// data well is far below it.
pub const MAX_CONVERGED_BOUNDS: f64 = 20.0;

/// Error in the estimator's own sigmas above which a run beyond [`MAX_CONVERGED_BOUNDS`] is diverged:
/// the covariance does not account for the error. A normal variable exceeds 5 sigma once in 2
/// million.
pub const MAX_CONSISTENT_SIGMAS: f64 = 5.0;

/// Largest bound of an observed element, as a share of the mean moment of inertia.
pub const MAX_OBSERVED_SHARE: f64 = 0.1;

/// Truth and bound that a run is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// True elements at the end of the flight, kg m².
    pub truth_kg_m2: [f64; 6],
    /// Cramér-Rao bound of each element, one sigma, kg m²; none where the element is unobserved.
    pub bound_kg_m2: [Option<f64>; 6],
    /// Bound with the stated errors of the hardware among the unknowns; none of ideal hardware.
    pub joint_bound_kg_m2: [Option<f64>; 6],
}

/// One run compared with its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Status that the estimator reports.
    pub status: Status,
    /// Estimated elements, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each element by the estimator's covariance, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// One sigma of each element by the noise alone, kg m².
    pub sigma_random_kg_m2: [f64; 6],
    /// Estimated minus true, kg m².
    pub error_kg_m2: [f64; 6],
    /// Error over bound; none where the element has no bound.
    pub error_over_bound: [Option<f64>; 6],
    /// Error over joint bound; none where the element has none.
    pub error_over_joint_bound: [Option<f64>; 6],
    /// Normalised estimation error squared, six degrees of freedom; none where the covariance is not
    /// positive definite.
    pub nees: Option<f64>,
    /// Classification of the run.
    pub verdict: Verdict,
}

/// Classification of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The estimator reports convergence, and every error is within [`MAX_CONVERGED_BOUNDS`] where
    /// there is a bound.
    Converged,
    /// Neither converged nor diverged: the estimator reports a partial estimate, or an error is
    /// large and so is its sigma.
    NotConverged,
    /// The estimator reports divergence; or an error is not finite; or an error is above both
    /// [`MAX_CONVERGED_BOUNDS`] and [`MAX_CONSISTENT_SIGMAS`]. Any large error is diverged where the
    /// covariance is not positive definite.
    Diverged,
    /// The spacecraft was drawn at random, and its motion leaves an element unobserved: see
    /// [`Reference::is_observed`]. Assigned by the campaign.
    Unobserved,
}

impl Score {
    /// Each error is within [`MAX_CONSISTENT_SIGMAS`] of its reported sigma.
    pub fn is_within_sigmas(&self) -> bool {
        let sigmas = self.error_kg_m2.iter().zip(&self.sigma_kg_m2);
        sigmas.into_iter().all(|(error, sigma)| error.abs() <= MAX_CONSISTENT_SIGMAS * sigma)
    }
}

impl Reference {
    /// The motion observes all six elements: each bound is below [`MAX_OBSERVED_SHARE`].
    pub fn is_observed(&self) -> bool {
        let mean_moment = self.truth_kg_m2[..3].iter().sum::<f64>() / 3.0;
        self.bound_kg_m2
            .iter()
            .all(|bound| bound.is_some_and(|bound| bound < MAX_OBSERVED_SHARE * mean_moment))
    }

    /// Score of an estimate.
    pub fn score<T: Real>(&self, estimate: &Estimate<T>) -> Score {
        let inertia_kg_m2 = estimate.inertia.elements_kg_m2().map(T::to_f64);
        let error: [f64; 6] = std::array::from_fn(|i| inertia_kg_m2[i] - self.truth_kg_m2[i]);
        let sigma_kg_m2 = estimate.sigma_kg_m2().map(T::to_f64);
        let nees = nees(&error, &estimate.covariance_kg2_m4.map(T::to_f64));
        let valid_sigma = nees.map(|_| sigma_kg_m2);
        Score {
            status: estimate.status,
            inertia_kg_m2,
            sigma_kg_m2,
            sigma_random_kg_m2: estimate
                .sigma_random_kg_m2
                .map_or(sigma_kg_m2, |sigma| sigma.map(T::to_f64)),
            error_kg_m2: error,
            error_over_bound: over(&error, &self.bound_kg_m2),
            error_over_joint_bound: over(&error, &self.joint_bound_kg_m2),
            nees,
            verdict: self.verdict(estimate.status, &error, valid_sigma.as_ref()),
        }
    }

    /// Bound of an element with the errors of the hardware, kg m².
    fn largest_bound_kg_m2(&self, element: usize) -> Option<f64> {
        let bound = self.bound_kg_m2[element]?;
        Some(self.joint_bound_kg_m2[element].map_or(bound, |joint| joint.max(bound)))
    }

    /// `sigma` is none where the covariance is not positive definite. An element without a bound is
    /// judged by its sigma alone.
    fn verdict(&self, status: Status, error: &[f64; 6], sigma: Option<&[f64; 6]>) -> Verdict {
        let is_large = |i: usize| {
            let bound = self.largest_bound_kg_m2(i);
            bound.is_none_or(|bound| error[i].abs() > MAX_CONVERGED_BOUNDS * bound)
        };
        let is_unaccounted =
            |i: usize| sigma.is_none_or(|sigma| error[i].abs() > MAX_CONSISTENT_SIGMAS * sigma[i]);
        let is_finite = error.iter().all(|x| x.is_finite());
        let is_lost = (0..6).any(|i| is_large(i) && is_unaccounted(i));
        if status == Status::Diverged || !is_finite || is_lost {
            Verdict::Diverged
        } else if status == Status::Converged
            && !(0..6).any(|i| self.bound_kg_m2[i].is_some() && is_large(i))
        {
            Verdict::Converged
        } else {
            Verdict::NotConverged
        }
    }
}

/// Errors over bounds; none without a bound.
pub(crate) fn over(error_kg_m2: &[f64; 6], bound_kg_m2: &[Option<f64>; 6]) -> [Option<f64>; 6] {
    std::array::from_fn(|i| bound_kg_m2[i].map(|bound| error_kg_m2[i] / bound))
}

/// Normalised estimation error squared, `eᵀ P⁻¹ e`, by the Cholesky factor of the symmetric part of
/// `P`; none where `P` is not positive definite.
fn nees(error_kg_m2: &[f64; 6], covariance_kg2_m4: &Matrix6<f64>) -> Option<f64> {
    let symmetric = (covariance_kg2_m4 + covariance_kg2_m4.transpose()) * 0.5;
    let whitened =
        symmetric.cholesky()?.l().solve_lower_triangular(&Vector6::from(*error_kg_m2))?;
    Some(whitened.norm_squared()).filter(|nees| nees.is_finite())
}

/// Estimates with a chosen error, for tests of scores and of their statistics.
#[cfg(test)]
pub(super) mod fixture {
    use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
    use fsw_core::{Estimator, Inertia, WheelArray};

    use super::*;

    pub const REFERENCE: Reference = Reference {
        truth_kg_m2: [10.0, 11.0, 12.0, 0.0, 0.0, 0.0],
        bound_kg_m2: [Some(0.1), Some(0.1), Some(0.1), Some(0.01), Some(0.01), None],
        joint_bound_kg_m2: [None; 6],
    };

    /// Estimate with this error and sigma of uncorrelated elements, kg m².
    pub fn estimate(error: [f64; 6], sigma: f64, status: Status) -> Estimate<f64> {
        let wheels = WheelArray::<f64, 0>::new([], []).unwrap();
        let blank = JointEkfUd::<f64, 0>::new(Config::new(1e-4), wheels).unwrap().estimate();
        Estimate {
            inertia: Inertia::new(std::array::from_fn(|i| REFERENCE.truth_kg_m2[i] + error[i])),
            covariance_kg2_m4: Matrix6::from_diagonal_element(sigma * sigma),
            status,
            ..blank
        }
    }

    pub fn score(error: [f64; 6], sigma: f64) -> Score {
        REFERENCE.score(&estimate(error, sigma, Status::Converged))
    }

    #[track_caller]
    pub fn assert_near(found: Option<f64>, expected: f64) {
        let found = found.unwrap();
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found}, {expected}");
    }
}

#[cfg(test)]
mod tests {
    use super::fixture::{assert_near, score};
    use super::*;

    #[test]
    fn score_is_error_over_bound_and_over_sigma() {
        let score = score([0.2, 0.0, -0.1, 0.02, 0.0, 0.5], 0.1);
        assert_eq!(score.verdict, Verdict::Converged);
        assert_near(score.error_over_bound[0], 2.0);
        assert_near(score.error_over_bound[2], -1.0);
        assert_near(score.error_over_bound[3], 2.0);
        assert_eq!(score.error_over_bound[5], None);
        assert_near(Some(score.sigma_kg_m2[4]), 0.1);
        // 4 + 1 + 0.04 + 25.
        assert_near(score.nees, 30.04);
    }

    #[test]
    fn nees_accounts_for_correlation() {
        // Variances 2 and correlation ½ of two elements: eᵀ P⁻¹ e = (2 + 2 − 2) / 3 for e = (1, 1).
        let mut covariance = Matrix6::identity();
        (covariance[(0, 0)], covariance[(1, 1)]) = (2.0, 2.0);
        (covariance[(0, 1)], covariance[(1, 0)]) = (1.0, 1.0);
        assert_near(nees(&[1.0, 1.0, 0.0, 0.0, 0.0, 0.0], &covariance), 2.0 / 3.0);
    }

    #[test]
    fn nees_is_none_without_a_positive_definite_covariance() {
        let mut covariance = Matrix6::identity();
        covariance[(2, 2)] = -1.0;
        assert_eq!(nees(&[1.0; 6], &covariance), None);
        assert_eq!(nees(&[1.0; 6], &Matrix6::zeros()), None);
        assert_eq!(nees(&[1.0; 6], &Matrix6::repeat(f64::NAN)), None);
    }

    #[test]
    fn error_is_within_its_sigmas_up_to_the_limit() {
        let of = |error: f64, sigma| score([0.0, 0.0, error, 0.0, 0.0, 0.0], sigma);
        assert!(of(0.4, 0.1).is_within_sigmas() && of(-0.4, 0.1).is_within_sigmas());
        for (error, sigma) in [(0.6, 0.1), (-0.6, 0.1), (f64::NAN, 0.1), (0.1, f64::NAN)] {
            assert!(!of(error, sigma).is_within_sigmas(), "{error} {sigma}");
        }
    }

    #[test]
    fn large_error_diverges_only_beyond_its_sigma() {
        // Jxy is 25 bounds off.
        let error = [0.0, 0.0, 0.0, 0.25, 0.0, 0.0];
        assert_eq!(score(error, 0.06).verdict, Verdict::NotConverged);
        assert_eq!(score(error, 0.04).verdict, Verdict::Diverged);
        // An element without a bound is judged by its sigma.
        let error = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(score(error, 0.3).verdict, Verdict::Converged);
        assert_eq!(score(error, 0.1).verdict, Verdict::Diverged);
        // An invalid covariance accounts for no error.
        assert_eq!(score([2.1; 6], f64::NAN).verdict, Verdict::Diverged);
    }
}
