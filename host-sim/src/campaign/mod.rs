//! Monte Carlo campaign over the gyro noise and the dispersion of a scenario.
//!
//! ```text
//! Scenario ─► truths ─► simulation: log ─► estimation ─► score ─► tally: statistics
//! ```
//!
//! Run `i` has the seed `first_seed + i`, and every difference between runs follows from the seed.
//! Truth and bound are independent of the gyro noise: those of a scenario are simulated once, unless
//! each run draws its own spacecraft. Runs are spread over rayon's threads and sorted afterwards.
//! Each draws from its own generator, so that the results are independent of the number of threads.

mod score;
mod shard;
mod statistics;
mod tally;
mod truths;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use fsw_core::Status;
use rayon::iter::{ParallelBridge, ParallelIterator};
use thiserror::Error;

use crate::estimation::{
    EstimatorName, Method, Precision, SetUpError, Setup, estimate_log, largest_systematic,
    with_wheel_error,
};
use crate::fault::Computer;
use crate::input::Scenario;
use crate::input::log::correct_wheels;
use crate::simulation::log_of;
use crate::truth::IntegrationFailed;
pub(crate) use score::over;
pub use score::{MAX_CONSISTENT_SIGMAS, MAX_CONVERGED_BOUNDS, MAX_OBSERVED_SHARE};
pub use score::{Reference, Score, Verdict};
pub use shard::{InvalidShard, Shard};
pub use statistics::{Statistics, nees_95, reduce};
pub use tally::Tally;
pub use truths::{Truth, Truths};

/// Runs that are in memory at once: 3 MB. The cores wait for each other at the end of a batch, for less than the time of a
/// run.
pub const BATCH: u64 = 4096;

/// Scenario, estimator and number of runs.
#[derive(Clone, Copy, Debug)]
pub struct Campaign<'a> {
    /// Scenario.
    pub scenario: &'a Scenario,
    /// Its truths and bounds.
    pub truths: &'a Truths,
    /// Estimator under test.
    pub estimator: EstimatorName,
    /// Its arithmetic.
    pub precision: Precision,
    /// Seed of the first run.
    pub first_seed: u64,
    /// Number of runs.
    pub runs: u64,
}

/// Result of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CampaignRun {
    /// Index from zero.
    pub index: u64,
    /// Seed of gyro noise and dispersion: `run --seed` repeats the run.
    pub seed: u64,
    /// Truth and bound of the run.
    pub reference: Reference,
    /// Final estimate compared with the reference.
    pub score: Score,
    /// Number of restarts: the state was not finite, the inertia had no inverse, or too many spikes
    /// came in a row.
    pub restarts: u32,
    /// Number of times that the estimator discarded its knowledge, or put it in doubt, because new data
    /// contradicted it.
    pub changes: u32,
    /// The last residuals are consistent with white noise; none where the estimator does not test
    /// it.
    pub residuals_white: Option<bool>,
    /// Kind of hardware error with the largest effect on the tensor; none for ideal hardware.
    pub largest_systematic: Option<&'static str>,
    /// Samples processed by the estimator.
    pub steps: u64,
    /// Time spent in the estimator, without sensors and set-up.
    pub estimator_time: Duration,
}

impl CampaignRun {
    /// A silent lie: the estimator reports convergence, the residuals do not contradict it, and the
    /// error of an element is not finite or exceeds [`MAX_CONSISTENT_SIGMAS`] of its reported sigma.
    pub fn is_silent_lie(&self) -> bool {
        self.score.status == Status::Converged
            && self.residuals_white != Some(false)
            && !self.score.is_within_sigmas()
    }
}

/// Reason why a run has no result.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RunFailed {
    /// The estimator cannot be set up.
    #[error(transparent)]
    SetUp(#[from] SetUpError),
    /// The motion of the run's own spacecraft cannot be integrated.
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
}

impl Campaign<'_> {
    /// Flies the runs on all of rayon's threads, in batches of at most [`BATCH`], each in the order of its runs. `done` is
    /// called after each run.
    ///
    /// No run starts once `stop` is set. Runs start in order and those started are completed, so
    /// that a stopped campaign equals a campaign of fewer runs.
    ///
    /// # Errors
    /// Of a batch: the error of any of its runs.
    pub fn batches<'s>(
        &'s self,
        stop: &'s AtomicBool,
        done: &'s (impl Fn() + Sync),
    ) -> impl Iterator<Item = Result<Vec<CampaignRun>, RunFailed>> + 's {
        let is_stopped = || stop.load(Ordering::Relaxed);
        let fly = move |first: u64| {
            let run_one = |index| {
                let run = self.run_one(index);
                done();
                run
            };
            let mut runs: Vec<CampaignRun> = (first..self.runs.min(first.saturating_add(BATCH)))
                .take_while(|_| !is_stopped())
                .par_bridge()
                .map(run_one)
                .collect::<Result<_, _>>()?;
            runs.sort_unstable_by_key(|run| run.index);
            Ok(runs)
        };
        (0..self.runs).step_by(BATCH as usize).take_while(move |_| !is_stopped()).map(fly)
    }

    /// All runs of [`batches`](Self::batches), in memory.
    ///
    /// # Errors
    /// The error of any run.
    pub fn run_all(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<Vec<CampaignRun>, RunFailed> {
        let batches: Result<Vec<_>, _> = self.batches(stop, &done).collect();
        Ok(batches?.concat())
    }

    /// Performs the run of this index.
    ///
    /// # Errors
    /// See [`RunFailed`].
    pub fn run_one(&self, index: u64) -> Result<CampaignRun, RunFailed> {
        // Seeds wrap around at the largest number.
        let seed = self.first_seed.wrapping_add(index);
        let scenario = self.scenario.of_seed(seed);
        let truth = self.truths.of_run(&scenario, seed)?;
        let reference = truth.reference;
        let mut log = log_of(&scenario, &truth.flight, seed);
        let mut craft = scenario.craft();
        if let Some(error) = correct_wheels(&mut log, &craft.hardware) {
            let method = Method { estimator: self.estimator, precision: self.precision };
            (craft, _) = with_wheel_error(method, &craft, &log, &error)?;
        }
        let setup = Setup {
            estimator: self.estimator,
            precision: self.precision,
            craft: &craft,
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
            sample_period_s: 1.0 / scenario.gyro.rate_hz,
            refuse_spikes: true,
        };
        let estimator = Computer::with(&setup, &scenario.faults, seed)?;
        let begun = Instant::now();
        let result = estimate_log(&log, estimator, |_, _, _| ());
        let estimator_time = begun.elapsed();
        let mut score = reference.score(&result.estimate);
        // A scenario with a given spacecraft may leave elements unobserved on purpose.
        if matches!(self.truths, Truths::PerRun) && !reference.is_observed() {
            score.verdict = Verdict::Unobserved;
        }
        Ok(CampaignRun {
            index,
            seed,
            reference,
            score,
            restarts: result.counts.divergence_resets + result.counts.lockout_resets,
            changes: result.changes(),
            residuals_white: result.estimate.residuals_white,
            largest_systematic: largest_systematic(&result.hardware),
            steps: log.len() as u64,
            estimator_time,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use crate::input::scenario::change::SuddenChange;
    use crate::input::scenario::dispersion::{Dispersion, InitialSpread};

    use super::*;

    /// The CubeSat with inertia factors and dispersed initial estimates.
    fn scenario() -> Scenario {
        let mut scenario = Scenario::load("cubesat-pyramid").unwrap();
        scenario.dispersion = Dispersion {
            inertia_factors: vec![1.0, 0.9, 0.8],
            initial_estimate: Some(InitialSpread {
                rate_rad_s: 1e-3,
                moments_kg_m2: 0.2,
                products_kg_m2: 0.01,
                rate_sigma_rad_s: 1e-3,
                sigma_kg_m2: [0.1, 0.1, 0.1, 0.01, 0.01, 0.01],
            }),
            ..Dispersion::default()
        };
        scenario
    }

    /// Index, seed and score of each run, of a campaign stopped after `stop_after` runs.
    fn scores(estimator: EstimatorName, runs: u64, stop_after: u64) -> Vec<(u64, u64, Score)> {
        let scenario = scenario();
        let campaign = Campaign {
            scenario: &scenario,
            truths: &Truths::simulate(&scenario).unwrap(),
            estimator,
            precision: Precision::F32,
            first_seed: 40,
            runs,
        };
        let (stop, count) = (AtomicBool::new(false), AtomicU64::new(0));
        let done = || {
            if count.fetch_add(1, Ordering::Relaxed) + 1 >= stop_after {
                stop.store(true, Ordering::Relaxed);
            }
        };
        let runs = campaign.run_all(&stop, done).unwrap();
        runs.iter().map(|run| (run.index, run.seed, run.score)).collect()
    }

    fn on_threads(threads: usize, runs: u64) -> Vec<(u64, u64, Score)> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scores(EstimatorName::JointEkf, runs, u64::MAX))
    }

    #[test]
    fn result_is_independent_of_the_number_of_threads() {
        let one = on_threads(1, 12);
        assert_eq!(one, on_threads(3, 12));
        for (i, (index, seed, score)) in one.iter().enumerate() {
            assert_eq!((*index, *seed), (i as u64, 40 + i as u64));
            assert_eq!(score.verdict, Verdict::Converged);
        }
        assert_ne!(one[0].2, one[3].2);
    }

    #[test]
    fn batches_have_every_run_once_in_order() {
        let runs = BATCH + 100;
        let scores = scores(EstimatorName::JointEkf, runs, u64::MAX);
        assert_eq!(scores.len() as u64, runs);
        for (i, (index, seed, _)) in scores.iter().enumerate() {
            assert_eq!((*index, *seed), (i as u64, 40 + i as u64));
        }
    }

    #[test]
    fn each_run_is_compared_with_its_own_truth() {
        let truth = scenario().spacecraft.inertia_kg_m2;
        for (_, seed, score) in on_threads(2, 6) {
            let factor = [1.0, 0.9, 0.8][seed as usize % 3];
            for i in 0..6 {
                let true_kg_m2 = score.inertia_kg_m2[i] - score.error_kg_m2[i];
                assert!((true_kg_m2 - factor * truth[i]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn unphysical_initial_estimate_gives_a_verdict() {
        for estimator in [EstimatorName::JointEkfPublished, EstimatorName::JointEkfUnaligned] {
            let scores = scores(estimator, 40, u64::MAX);
            assert_eq!(scores.len(), 40);
            let verdicts: Vec<Verdict> = scores.iter().map(|(_, _, score)| score.verdict).collect();
            assert!(verdicts.iter().any(|verdict| *verdict != Verdict::Converged), "{verdicts:?}");
        }
    }

    #[test]
    fn sudden_change_is_counted() {
        let constant = Scenario::load("cubesat-pyramid").unwrap();
        // Twice the inertia from half-time on: samples contradict the earlier estimate.
        let mut doubled = constant.clone();
        doubled.changes.sudden = vec![SuddenChange {
            time_s: 30.0,
            inertia_kg_m2: constant.spacecraft.inertia_kg_m2.map(|j| 2.0 * j),
        }];
        let run = |scenario: &Scenario| {
            let campaign = Campaign {
                scenario,
                truths: &Truths::simulate(scenario).unwrap(),
                estimator: EstimatorName::JointEkf,
                precision: Precision::F32,
                first_seed: 3,
                runs: 1,
            };
            campaign.run_one(0).unwrap()
        };
        assert_eq!(run(&constant).changes, 0);
        let run = run(&doubled);
        assert!(run.changes > 0);
        let true_kg_m2 = run.score.inertia_kg_m2[0] - run.score.error_kg_m2[0];
        assert!((true_kg_m2 - 2.0 * constant.spacecraft.inertia_kg_m2[0]).abs() < 1e-12);
    }

    #[test]
    fn stopped_campaign_equals_a_shorter_one() {
        let stopped = scores(EstimatorName::JointEkf, 1_000_000, 5);
        assert!((5..1000).contains(&stopped.len()), "{}", stopped.len());
        assert_eq!(stopped, on_threads(2, stopped.len() as u64));
    }
}
