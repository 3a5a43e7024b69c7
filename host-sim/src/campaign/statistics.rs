//! What many runs come to: their errors beside the truth and the bound, and whether the covariance
//! that the estimator reports is honest.
//!
//! A run is scored against its own [`Yardstick`], so that runs may differ in spacecraft, and may
//! come from anywhere: all that is asked of one is its last [`Estimate`].
//!
//! Diverged runs are counted and left out of every other figure: a single one would drown the rest
//! in any mean. So are those whose drawn spacecraft doesn't move enough to show its inertia.

use fsw_core::{Estimate, Real, Status};
use nalgebra::{Matrix6, Vector6};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// An error of more bounds than this on any element has not converged on the truth, whatever the
/// estimator says of it: no estimate that makes good use of the data comes near.
pub const FAR: f64 = 20.0;

/// An error that is as far as that, and of more than this many of the estimator's own sigmas, is
/// diverged: far off, and sure of it. Honest sigmas are exceeded so far once in 2 million.
pub const SURE: f64 = 5.0;

/// An element whose bound is above this share of the mean moment isn't shown by the motion.
pub const SHOWN: f64 = 0.1;

/// Degrees of freedom of one run's error: the six elements.
const DEGREES: f64 = 6.0;

/// What runs are measured with. Elements are ordered `jxx jyy jzz jxy jxz jyz`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardstick {
    /// The true elements at the end of the flight, kg m².
    pub truth_kg_m2: [f64; 6],
    /// Cramér-Rao bound of each, one sigma, kg m²; none where the motion doesn't show it.
    pub bound_kg_m2: [Option<f64>; 6],
}

/// One run beside the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// What the estimator says of its estimate.
    pub status: Status,
    /// Estimated elements, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each by the estimator's covariance, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// Estimated minus true, kg m².
    pub error_kg_m2: [f64; 6],
    /// The same over the bound; none where there is no bound.
    pub error_over_bound: [Option<f64>; 6],
    /// Normalised estimation error squared, six degrees of freedom; none where the covariance
    /// isn't positive definite.
    pub nees: Option<f64>,
    /// What the run came to.
    pub verdict: Verdict,
}

/// What a run came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It says so, and every error is within [`FAR`] bounds, where there is one.
    Converged,
    /// Neither: it says that it hasn't seen all, or is far off with a sigma to match.
    NotConverged,
    /// It says so; or an error isn't finite, or is beyond both [`FAR`] bounds and [`SURE`] of its own
    /// sigmas, if its covariance is one at all.
    Diverged,
    /// Its spacecraft was drawn, and the motion doesn't show all six elements: see [`SHOWN`]. A
    /// campaign says so, not the score by itself.
    NotShown,
}

impl Yardstick {
    /// Whether the motion shows all six elements.
    pub fn is_shown(&self) -> bool {
        let mean_moment = self.truth_kg_m2[..3].iter().sum::<f64>() / 3.0;
        self.bound_kg_m2.iter().all(|bound| bound.is_some_and(|bound| bound < SHOWN * mean_moment))
    }

    /// Sets an estimate beside the truth.
    pub fn score<T: Real>(&self, estimate: &Estimate<T>) -> Score {
        let inertia_kg_m2 = estimate.inertia.elements_kg_m2().map(T::to_f64);
        let error: [f64; 6] = std::array::from_fn(|i| inertia_kg_m2[i] - self.truth_kg_m2[i]);
        let error_over_bound: [Option<f64>; 6] =
            std::array::from_fn(|i| self.bound_kg_m2[i].map(|bound| error[i] / bound));
        let sigma_kg_m2 = estimate.sigma_kg_m2().map(T::to_f64);
        let nees = nees(&error, &estimate.covariance_kg2_m4.map(T::to_f64));
        let trusted = nees.map(|_| sigma_kg_m2);
        Score {
            status: estimate.status,
            inertia_kg_m2,
            sigma_kg_m2,
            error_kg_m2: error,
            error_over_bound,
            nees,
            verdict: self.verdict(estimate.status, &error, trusted.as_ref()),
        }
    }

    /// `sigma` is none where the covariance isn't positive definite, and so excuses nothing. An
    /// element without a bound is far by its sigma alone.
    fn verdict(&self, status: Status, error: &[f64; 6], sigma: Option<&[f64; 6]>) -> Verdict {
        let is_far =
            |i: usize| self.bound_kg_m2[i].is_none_or(|bound| error[i].abs() > FAR * bound);
        let is_sure = |i: usize| sigma.is_none_or(|sigma| error[i].abs() > SURE * sigma[i]);
        let is_finite = error.iter().all(|x| x.is_finite());
        if status == Status::Diverged || !is_finite || (0..6).any(|i| is_far(i) && is_sure(i)) {
            Verdict::Diverged
        } else if status == Status::Converged
            && !(0..6).any(|i| self.bound_kg_m2[i].is_some() && is_far(i))
        {
            Verdict::Converged
        } else {
            Verdict::NotConverged
        }
    }
}

/// `eᵀ P⁻¹ e` by the Cholesky factor of the symmetric part of `P`. A `P` that has none is no
/// covariance, and its inverse means nothing.
fn nees(error_kg_m2: &[f64; 6], covariance_kg2_m4: &Matrix6<f64>) -> Option<f64> {
    let symmetric = (covariance_kg2_m4 + covariance_kg2_m4.transpose()) * 0.5;
    let whitened =
        symmetric.cholesky()?.l().solve_lower_triangular(&Vector6::from(*error_kg_m2))?;
    Some(whitened.norm_squared()).filter(|nees| nees.is_finite())
}

/// What the runs come to. All figures but the counts are of the runs that are used, and none where
/// there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// How many runs there are.
    pub runs: usize,
    /// How many are neither diverged nor not shown.
    pub used: usize,
    /// How many have a spacecraft whose motion doesn't show it: see [`Verdict`].
    pub not_shown: usize,
    /// How many diverged: see [`Verdict`].
    pub diverged: usize,
    /// How many of those used have not converged.
    pub not_converged: usize,
    /// RMS error of each element, kg m².
    pub rmse_kg_m2: [Option<f64>; 6],
    /// Mean error of each element, kg m².
    pub bias_kg_m2: [Option<f64>; 6],
    /// RMS of each run's error over its own bound; none where any run has no bound.
    pub rmse_over_bound: [Option<f64>; 6],
    /// Mean of each run's error over its own bound; none where any run has no bound.
    pub bias_over_bound: [Option<f64>; 6],
    /// Mean NEES over its degrees of freedom: 1 for an honest covariance, above for an overconfident
    /// one.
    pub nees_per_dof: Option<f64>,
    /// How many runs that mean is of: those used whose covariance is positive definite.
    pub nees_runs: usize,
    /// Where the mean of that many should lie, 95 % of the time, if the covariance is honest.
    pub nees_95: Option<[f64; 2]>,
}

impl Statistics {
    /// RMS over runs and elements of error over bound; none where any run has no bound.
    pub fn rmse_over_bound_of_all(&self) -> Option<f64> {
        let squares: Option<f64> = self.rmse_over_bound.iter().map(|rms| rms.map(|x| x * x)).sum();
        squares.map(|sum| (sum / 6.0).sqrt())
    }
}

/// Reduces the scores in their order: the same scores give the same bits.
pub fn reduce<'a>(scores: impl IntoIterator<Item = &'a Score>) -> Statistics {
    let mut runs = 0;
    let (mut not_shown, mut diverged, mut not_converged) = (0, 0, 0);
    let mut error = [Moments::default(); 6];
    let mut over_bound = [Moments::default(); 6];
    let mut nees = Moments::default();
    for score in scores {
        runs += 1;
        match score.verdict {
            Verdict::Converged => {}
            Verdict::NotConverged => not_converged += 1,
            Verdict::Diverged => {
                diverged += 1;
                continue;
            }
            Verdict::NotShown => {
                not_shown += 1;
                continue;
            }
        }
        for i in 0..6 {
            error[i].add(score.error_kg_m2[i]);
            if let Some(ratio) = score.error_over_bound[i] {
                over_bound[i].add(ratio);
            }
        }
        if let Some(one) = score.nees {
            nees.add(one / DEGREES);
        }
    }
    let used = error[0].count;
    let bounded = |i: usize| Some(&over_bound[i]).filter(|moments| moments.count == used);
    Statistics {
        runs,
        used,
        not_shown,
        diverged,
        not_converged,
        rmse_kg_m2: error.map(|moments| moments.rms()),
        bias_kg_m2: error.map(|moments| moments.mean()),
        rmse_over_bound: std::array::from_fn(|i| bounded(i)?.rms()),
        bias_over_bound: std::array::from_fn(|i| bounded(i)?.mean()),
        nees_per_dof: nees.mean(),
        nees_runs: nees.count,
        nees_95: nees_95(nees.count),
    }
}

/// Where the mean NEES per degree of freedom of so many runs lies 95 % of the time, if each is
/// chi-square with six degrees of freedom: the quantiles at 2.5 % and 97.5 % of chi-square with
/// `6 · runs` degrees of freedom, over that number. None for no runs.
pub fn nees_95(runs: usize) -> Option<[f64; 2]> {
    let degrees = DEGREES * runs as f64;
    let distribution = ChiSquared::new(degrees).ok()?;
    Some([0.025, 0.975].map(|share| distribution.inverse_cdf(share) / degrees))
}

/// Count, sum and sum of squares.
#[derive(Clone, Copy, Default)]
struct Moments {
    count: usize,
    sum: f64,
    square: f64,
}

impl Moments {
    fn add(&mut self, x: f64) {
        self.count += 1;
        self.sum += x;
        self.square += x * x;
    }

    fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    fn rms(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.square / self.count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use fsw_core::Inertia;
    use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
    use fsw_core::{Estimator, WheelArray};

    use super::*;

    const YARDSTICK: Yardstick = Yardstick {
        truth_kg_m2: [10.0, 11.0, 12.0, 0.0, 0.0, 0.0],
        bound_kg_m2: [Some(0.1), Some(0.1), Some(0.1), Some(0.01), Some(0.01), None],
    };

    /// An estimate this far from the truth, of uncorrelated elements with this sigma, kg m².
    fn estimate(error: [f64; 6], sigma: f64, status: Status) -> Estimate<f64> {
        let wheels = WheelArray::<f64, 0>::new([], []).unwrap();
        let blank = JointEkfUd::<f64, 0>::new(Config::new(1e-4), wheels).unwrap().estimate();
        Estimate {
            inertia: Inertia::new(std::array::from_fn(|i| YARDSTICK.truth_kg_m2[i] + error[i])),
            covariance_kg2_m4: Matrix6::from_diagonal_element(sigma * sigma),
            status,
            ..blank
        }
    }

    fn score(error: [f64; 6], sigma: f64) -> Score {
        YARDSTICK.score(&estimate(error, sigma, Status::Converged))
    }

    fn near(found: Option<f64>, expected: f64) {
        let found = found.unwrap();
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found}, {expected}");
    }

    #[test]
    fn a_score_is_error_over_bound_and_over_sigma() {
        let score = score([0.2, 0.0, -0.1, 0.02, 0.0, 0.5], 0.1);
        assert_eq!(score.verdict, Verdict::Converged);
        near(score.error_over_bound[0], 2.0);
        near(score.error_over_bound[2], -1.0);
        near(score.error_over_bound[3], 2.0);
        assert_eq!(score.error_over_bound[5], None);
        near(Some(score.sigma_kg_m2[4]), 0.1);
        // 4 + 1 + 0.04 + 25.
        near(score.nees, 30.04);
    }

    #[test]
    fn nees_heeds_correlation() {
        // Variances 2 and correlation ½ of two elements: eᵀ P⁻¹ e = (2 + 2 − 2) / 3 for e = (1, 1).
        let mut covariance = Matrix6::identity();
        (covariance[(0, 0)], covariance[(1, 1)]) = (2.0, 2.0);
        (covariance[(0, 1)], covariance[(1, 0)]) = (1.0, 1.0);
        near(nees(&[1.0, 1.0, 0.0, 0.0, 0.0, 0.0], &covariance), 2.0 / 3.0);
    }

    #[test]
    fn what_is_no_covariance_has_no_nees() {
        let mut covariance = Matrix6::identity();
        covariance[(2, 2)] = -1.0;
        assert_eq!(nees(&[1.0; 6], &covariance), None);
        assert_eq!(nees(&[1.0; 6], &Matrix6::zeros()), None);
        assert_eq!(nees(&[1.0; 6], &Matrix6::repeat(f64::NAN)), None);
    }

    #[test]
    fn figures_are_of_the_runs_that_did_not_diverge() {
        let partial = estimate([-0.3, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, Status::Partial);
        let scores = [
            score([0.1, 0.0, 0.0, 0.02, 0.0, 0.4], 0.1),
            YARDSTICK.score(&partial),
            // Beyond 20 bounds and sigmas, whatever it says of itself; and diverged by its own word.
            score([0.0, 2.1, 0.0, 0.0, 0.0, 0.0], 0.1),
            YARDSTICK.score(&estimate([0.0; 6], 0.1, Status::Diverged)),
            score([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1),
            // Not finite where there is no bound either.
            score([0.0, 0.0, 0.0, 0.0, 0.0, f64::INFINITY], 0.1),
        ];
        let statistics = reduce(&scores);
        assert_eq!((statistics.runs, statistics.used, statistics.diverged), (6, 2, 4));
        assert_eq!(statistics.not_converged, 1);
        near(statistics.rmse_kg_m2[0], 0.05f64.sqrt());
        near(statistics.bias_kg_m2[0], -0.1);
        near(statistics.rmse_over_bound[0], 5.0f64.sqrt());
        near(statistics.bias_over_bound[0], -1.0);
        near(statistics.rmse_over_bound[3], 2.0f64.sqrt());
        near(statistics.rmse_kg_m2[5], 0.08f64.sqrt());
        assert_eq!(statistics.rmse_over_bound[5], None);
        // (1 + 0.04 + 16 and 9) / 2 / 6.
        near(statistics.nees_per_dof, 26.04 / 12.0);
        assert_eq!(statistics.nees_runs, 2);
    }

    #[test]
    fn what_the_motion_does_not_show_is_counted_and_no_more() {
        let seen = Yardstick { bound_kg_m2: [Some(0.1); 6], ..YARDSTICK };
        assert!(seen.is_shown() && !YARDSTICK.is_shown());
        // A tenth of the mean moment is 1.1.
        assert!(!Yardstick { bound_kg_m2: [Some(1.2); 6], ..YARDSTICK }.is_shown());
        let hidden = Score { verdict: Verdict::NotShown, ..score([9.0; 6], 0.1) };
        let kept = seen.score(&estimate([0.1, 0.2, 0.3, 0.1, 0.2, 0.3], 0.1, Status::Converged));
        let statistics = reduce([&hidden, &kept]);
        assert_eq!((statistics.runs, statistics.used, statistics.not_shown), (2, 1, 1));
        assert_eq!(statistics.diverged, 0);
        near(statistics.rmse_kg_m2[1], 0.2);
        // 1, 4 and 9 twice, over six.
        near(statistics.rmse_over_bound_of_all(), (28.0f64 / 6.0).sqrt());
        assert_eq!(reduce([&hidden]).rmse_over_bound_of_all(), None);
    }

    #[test]
    fn far_off_and_owning_up_to_it_is_not_diverged() {
        // Jxy is 25 bounds off.
        let error = [0.0, 0.0, 0.0, 0.25, 0.0, 0.0];
        assert_eq!(score(error, 0.06).verdict, Verdict::NotConverged);
        assert_eq!(score(error, 0.04).verdict, Verdict::Diverged);
        // Without a bound only the sigma tells.
        let error = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(score(error, 0.3).verdict, Verdict::Converged);
        assert_eq!(score(error, 0.1).verdict, Verdict::Diverged);
        // A covariance that isn't one is no excuse.
        assert_eq!(score([2.1; 6], f64::NAN).verdict, Verdict::Diverged);
    }

    #[test]
    fn nothing_comes_of_no_runs() {
        for scores in [&[][..], &[score([9.0; 6], 0.1)]] {
            let statistics = reduce(scores);
            assert_eq!((statistics.used, statistics.diverged), (0, scores.len()));
            assert_eq!(statistics.rmse_kg_m2, [None; 6]);
            assert_eq!(statistics.bias_over_bound, [None; 6]);
            assert_eq!((statistics.nees_per_dof, statistics.nees_95), (None, None));
        }
    }

    #[test]
    fn the_interval_is_that_of_the_tables() {
        // Runs, and the tabulated quantiles of chi-square with 6 · runs degrees of freedom.
        for (runs, low, high) in [
            (1, 1.237_344, 14.449_375),
            (5, 16.790_772, 46.979_242),
            (10, 40.481_748, 83.297_675),
            (100, 534.018_6, 669.769_2),
        ] {
            let [found_low, found_high] = nees_95(runs).unwrap();
            let degrees = 6.0 * runs as f64;
            assert!((found_low * degrees / low - 1.0).abs() < 1e-6, "{runs}: {found_low}");
            assert!((found_high * degrees / high - 1.0).abs() < 1e-6, "{runs}: {found_high}");
        }
    }

    #[test]
    fn the_interval_narrows_as_a_normal_distribution_for_many_runs() {
        // Mean 1, variance 2 / (6 · runs); the skewness shifts both ends by about 1e-5.
        let [low, high] = nees_95(10_000).unwrap();
        let half = 1.959_964 * (2.0f64 / 60_000.0).sqrt();
        assert!((low - (1.0 - half)).abs() < 5e-5, "{low}");
        assert!((high - (1.0 + half)).abs() < 5e-5, "{high}");
    }
}
