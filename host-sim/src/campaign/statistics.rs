//! Statistics over the runs of a campaign: bias and RMS error compared with the bound, and NEES
//! compared with its chi-square interval.
//!
//! Diverged runs are counted and left out of every other figure, since a single one dominates any
//! mean. Runs with an unobserved spacecraft are left out as well.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::score::{Score, Verdict};

/// Degrees of freedom of the error of one run: the six elements.
const DEGREES: f64 = 6.0;

/// Statistics of the runs. Counts are over all runs, other figures over the used runs; `None`
/// without a used run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Number of runs.
    pub runs: usize,
    /// Number of runs neither diverged nor unobserved.
    pub used: usize,
    /// Number of runs with [`Verdict::Unobserved`].
    pub unobserved: usize,
    /// Number of runs with [`Verdict::Diverged`].
    pub diverged: usize,
    /// Number of runs with [`Verdict::NotConverged`]; these are used.
    pub not_converged: usize,
    /// RMS error of each element, kg m².
    pub rmse_kg_m2: [Option<f64>; 6],
    /// Mean error of each element, kg m².
    pub bias_kg_m2: [Option<f64>; 6],
    /// RMS of the error of each run over its own bound; none where any run has no bound.
    pub rmse_over_bound: [Option<f64>; 6],
    /// Mean of the error of each run over its own bound; none where any run has no bound.
    pub bias_over_bound: [Option<f64>; 6],
    /// RMS of the error of each run over its own joint bound; none where any run has none.
    pub rmse_over_joint_bound: [Option<f64>; 6],
    /// RMS of the reported sigma of each element, kg m².
    pub sigma_kg_m2: [Option<f64>; 6],
    /// RMS of its part by the noise alone, kg m².
    pub sigma_random_kg_m2: [Option<f64>; 6],
    /// Mean NEES over its degrees of freedom: 1 for a consistent covariance, above 1 for an
    /// overconfident one.
    pub nees_per_dof: Option<f64>,
    /// Number of runs in that mean: those used with a positive definite covariance.
    pub nees_runs: usize,
    /// Interval that contains that mean with 95 % probability if the covariance is consistent.
    pub nees_95: Option<[f64; 2]>,
}

impl Statistics {
    /// RMS over runs and elements of error over bound; none where any run has no bound.
    pub fn rmse_over_bound_of_all(&self) -> Option<f64> {
        let squares: Option<f64> = self.rmse_over_bound.iter().map(|rms| rms.map(|x| x * x)).sum();
        squares.map(|sum| (sum / 6.0).sqrt())
    }
}

/// Statistics of the scores, summed in their order: the same scores give the same bits.
pub fn reduce<'a>(scores: impl IntoIterator<Item = &'a Score>) -> Statistics {
    let mut sums = Sums::default();
    for score in scores {
        sums.add(score);
    }
    sums.statistics()
}

/// Counts and moments of the scores.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    runs: usize,
    unobserved: usize,
    diverged: usize,
    not_converged: usize,
    error: [Moments; 6],
    over_bound: [Moments; 6],
    over_joint_bound: [Moments; 6],
    sigma: [Moments; 6],
    random: [Moments; 6],
    nees: Moments,
}

impl Sums {
    pub(super) fn add(&mut self, score: &Score) {
        self.runs += 1;
        match score.verdict {
            Verdict::Converged => {}
            Verdict::NotConverged => self.not_converged += 1,
            Verdict::Diverged => {
                self.diverged += 1;
                return;
            }
            Verdict::Unobserved => {
                self.unobserved += 1;
                return;
            }
        }
        for i in 0..6 {
            self.error[i].add(score.error_kg_m2[i]);
            self.sigma[i].add(score.sigma_kg_m2[i]);
            self.random[i].add(score.sigma_random_kg_m2[i]);
            if let Some(ratio) = score.error_over_bound[i] {
                self.over_bound[i].add(ratio);
            }
            if let Some(ratio) = score.error_over_joint_bound[i] {
                self.over_joint_bound[i].add(ratio);
            }
        }
        if let Some(nees) = score.nees {
            self.nees.add(nees / DEGREES);
        }
    }

    pub(super) fn statistics(&self) -> Statistics {
        let used = self.error[0].count;
        let of_all = |moments: Moments| Some(moments).filter(|moments| moments.count == used);
        let bounded = |i: usize| of_all(self.over_bound[i]);
        Statistics {
            runs: self.runs,
            used,
            unobserved: self.unobserved,
            diverged: self.diverged,
            not_converged: self.not_converged,
            rmse_kg_m2: self.error.map(|moments| moments.rms()),
            bias_kg_m2: self.error.map(|moments| moments.mean()),
            rmse_over_bound: std::array::from_fn(|i| bounded(i)?.rms()),
            bias_over_bound: std::array::from_fn(|i| bounded(i)?.mean()),
            rmse_over_joint_bound: self.over_joint_bound.map(|moments| of_all(moments)?.rms()),
            sigma_kg_m2: self.sigma.map(|moments| moments.rms()),
            sigma_random_kg_m2: self.random.map(|moments| moments.rms()),
            nees_per_dof: self.nees.mean(),
            nees_runs: self.nees.count,
            nees_95: nees_95(self.nees.count),
        }
    }
}

/// Interval that contains the mean NEES per degree of freedom of `runs` runs with 95 % probability,
/// if each NEES is chi-square with six degrees of freedom; none for no runs.
///
/// `[χ²₀.₀₂₅(n), χ²₀.₉₇₅(n)] / n`, `n = 6 · runs`, since the sum of independent chi-square variables
/// is chi-square with the sum of their degrees of freedom. Source:
/// \[BarShalom2001\] section 5.4.2.
pub fn nees_95(runs: usize) -> Option<[f64; 2]> {
    let degrees = DEGREES * runs as f64;
    let distribution = ChiSquared::new(degrees).ok()?;
    Some([0.025, 0.975].map(|probability| distribution.inverse_cdf(probability) / degrees))
}

/// Count, sum and sum of squares.
#[derive(Clone, Copy, Debug, Default)]
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
    use fsw_core::Status;

    use super::*;
    use crate::campaign::score::Reference;
    use crate::campaign::score::fixture::{REFERENCE, assert_near, estimate, score};

    #[test]
    fn figures_exclude_diverged_runs() {
        let partial = estimate([-0.3, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, Status::Partial);
        let scores = [
            score([0.1, 0.0, 0.0, 0.02, 0.0, 0.4], 0.1),
            REFERENCE.score(&partial),
            // Beyond 20 bounds and 5 sigmas, reported as converged; then reported as diverged.
            score([0.0, 2.1, 0.0, 0.0, 0.0, 0.0], 0.1),
            REFERENCE.score(&estimate([0.0; 6], 0.1, Status::Diverged)),
            score([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1),
            // Not finite on an element without a bound.
            score([0.0, 0.0, 0.0, 0.0, 0.0, f64::INFINITY], 0.1),
        ];
        let statistics = reduce(&scores);
        assert_eq!((statistics.runs, statistics.used, statistics.diverged), (6, 2, 4));
        assert_eq!(statistics.not_converged, 1);
        assert_near(statistics.rmse_kg_m2[0], 0.05f64.sqrt());
        assert_near(statistics.bias_kg_m2[0], -0.1);
        assert_near(statistics.rmse_over_bound[0], 5.0f64.sqrt());
        assert_near(statistics.bias_over_bound[0], -1.0);
        assert_near(statistics.rmse_over_bound[3], 2.0f64.sqrt());
        assert_near(statistics.rmse_kg_m2[5], 0.08f64.sqrt());
        assert_eq!(statistics.rmse_over_bound[5], None);
        // (1 + 0.04 + 16 and 9) / 2 / 6.
        assert_near(statistics.nees_per_dof, 26.04 / 12.0);
        assert_eq!(statistics.nees_runs, 2);
    }

    #[test]
    fn figures_exclude_unobserved_runs() {
        let observed = Reference { bound_kg_m2: [Some(0.1); 6], ..REFERENCE };
        assert!(observed.is_observed() && !REFERENCE.is_observed());
        // A tenth of the mean moment is 1.1.
        assert!(!Reference { bound_kg_m2: [Some(1.2); 6], ..REFERENCE }.is_observed());
        let unobserved = Score { verdict: Verdict::Unobserved, ..score([9.0; 6], 0.1) };
        let errors = [0.1, 0.2, 0.3, 0.1, 0.2, 0.3];
        let used = observed.score(&estimate(errors, 0.1, Status::Converged));
        let statistics = reduce([&unobserved, &used]);
        assert_eq!((statistics.runs, statistics.used, statistics.unobserved), (2, 1, 1));
        assert_eq!(statistics.diverged, 0);
        assert_near(statistics.rmse_kg_m2[1], 0.2);
        // 1, 4 and 9 twice, over six.
        assert_near(statistics.rmse_over_bound_of_all(), (28.0f64 / 6.0).sqrt());
        assert_eq!(reduce([&unobserved]).rmse_over_bound_of_all(), None);
    }

    #[test]
    fn figures_are_none_without_used_runs() {
        for scores in [&[][..], &[score([9.0; 6], 0.1)]] {
            let statistics = reduce(scores);
            assert_eq!((statistics.used, statistics.diverged), (0, scores.len()));
            assert_eq!(statistics.rmse_kg_m2, [None; 6]);
            assert_eq!(statistics.bias_over_bound, [None; 6]);
            assert_eq!((statistics.nees_per_dof, statistics.nees_95), (None, None));
        }
    }

    #[test]
    fn nees_interval_matches_tabulated_quantiles() {
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
    fn nees_interval_approaches_a_normal_distribution() {
        // Mean 1, variance 2 / (6 · runs); the skewness shifts both ends by about 1e-5.
        let [low, high] = nees_95(10_000).unwrap();
        let half = 1.959_964 * (2.0f64 / 60_000.0).sqrt();
        assert!((low - (1.0 - half)).abs() < 5e-5, "{low}");
        assert!((high - (1.0 + half)).abs() < 5e-5, "{high}");
    }
}
