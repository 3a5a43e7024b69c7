//! Monte Carlo: many draws of the gyro's noise, and of what the scenario disperses.
//!
//! Run `i` has the seed `first_seed + i`, and all that differs from run to run follows from that.
//! Truth and bound don't depend on the noise: the few that a scenario has are simulated once, unless
//! each run draws a spacecraft of its own. Runs are spread over rayon's threads and put back in order, and each draws from a generator of its
//! own, so the numbers are the same however many threads there are.

pub mod statistics;
pub mod truths;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::iter::{ParallelBridge, ParallelIterator};
use thiserror::Error;

use crate::estimation::{EstimatorName, Precision, SetUpError, Setup, fly, set_up};
use crate::input::Scenario;
use crate::simulation::log_of;
use crate::truth::IntegrationFailed;
use statistics::{Score, Verdict, Yardstick};
pub use truths::Truths;

/// What to fly, with what, how often.
#[derive(Clone, Copy, Debug)]
pub struct Campaign<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its truths and bounds.
    pub truths: &'a Truths,
    /// The estimator under test.
    pub estimator: EstimatorName,
    /// Its arithmetic.
    pub precision: Precision,
    /// Seed of the first run's noise.
    pub first_seed: u64,
    /// How many runs.
    pub runs: u64,
}

/// One run of a campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Its number, from zero.
    pub index: u64,
    /// Seed of its noise and of its dispersion: `run --seed` flies it again.
    pub seed: u64,
    /// The truth that it flew, and its bound.
    pub yardstick: Yardstick,
    /// What came of it.
    pub score: Score,
    /// How often the estimator gave up and started anew: its state was no longer finite, its inertia
    /// had no inverse, or too many spikes came in a row.
    pub restarts: u32,
    /// How often it dropped what it knew before, since new data contradicted it.
    pub changes: u32,
    /// Whether its last residuals look like white noise; none where that isn't tested.
    pub residuals_white: Option<bool>,
    /// Samples that the estimator was given.
    pub steps: u64,
    /// Time that it took over them; sensors and set-up don't count.
    pub estimator_time: Duration,
}

/// A run could not be flown.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RunFailed {
    /// Its estimator.
    #[error(transparent)]
    SetUp(#[from] SetUpError),
    /// The motion of a spacecraft of its own.
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
}

impl Campaign<'_> {
    /// Flies the runs on all of rayon's threads, and calls `done` after each.
    ///
    /// Once `stop` is set no further run is begun. Runs are begun in order and those begun are
    /// completed, so what comes back is what a campaign of fewer runs would have given.
    pub fn fly(&self, stop: &AtomicBool, done: impl Fn() + Sync) -> Result<Vec<Run>, RunFailed> {
        let fly_one = |index| {
            let run = self.run(index);
            done();
            run
        };
        let mut runs: Vec<Run> = (0..self.runs)
            .take_while(|_| !stop.load(Ordering::Relaxed))
            .par_bridge()
            .map(fly_one)
            .collect::<Result<_, _>>()?;
        runs.sort_unstable_by_key(|run| run.index);
        Ok(runs)
    }

    /// Flies one of the runs.
    pub fn run(&self, index: u64) -> Result<Run, RunFailed> {
        // Seeds go round at the end of the numbers rather than run out.
        let seed = self.first_seed.wrapping_add(index);
        let scenario = self.scenario.of_seed(seed);
        let truth = self.truths.of_run(&scenario, seed)?;
        let yardstick = truth.yardstick;
        let log = log_of(&scenario, &truth.flight, seed);
        let on_board = set_up(&Setup {
            estimator: self.estimator,
            precision: self.precision,
            craft: &scenario.craft(),
            gyro_noise_rad_s: Some(scenario.gyro.noise_rad_s),
            sample_period_s: 1.0 / scenario.gyro.rate_hz,
            refuse_spikes: true,
        })?;
        let begun = Instant::now();
        let flown = fly(&log, on_board, |_, _, _| ());
        let estimator_time = begun.elapsed();
        let mut score = yardstick.score(&flown.estimate);
        // Of a spacecraft that the scenario names, what the motion doesn't show is its point.
        if matches!(self.truths, Truths::OfEachRun) && !yardstick.is_shown() {
            score.verdict = Verdict::NotShown;
        }
        let restarts = flown.counts.divergence_resets + flown.counts.lockout_resets;
        Ok(Run {
            index,
            seed,
            yardstick,
            score,
            restarts,
            changes: flown.changes(),
            residuals_white: flown.estimate.residuals_white,
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

    use super::statistics::Verdict;
    use super::*;

    /// The CubeSat, and copies of it a tenth and two tenths lighter, flown from anywhere.
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
            spacecraft: None,
        };
        scenario
    }

    /// Flies it, and stops after so many runs.
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
        let runs = campaign.fly(&stop, done).unwrap();
        runs.iter().map(|run| (run.index, run.seed, run.score)).collect()
    }

    fn on_threads(threads: usize, runs: u64) -> Vec<(u64, u64, Score)> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scores(EstimatorName::JointEkf, runs, u64::MAX))
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let one = on_threads(1, 12);
        assert_eq!(one, on_threads(3, 12));
        for (i, (index, seed, score)) in one.iter().enumerate() {
            assert_eq!((*index, *seed), (i as u64, 40 + i as u64));
            assert_eq!(score.verdict, Verdict::Converged);
        }
        assert_ne!(one[0].2, one[3].2);
    }

    #[test]
    fn each_run_is_measured_with_its_own_truth() {
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
    fn a_start_that_no_body_has_is_survived() {
        for estimator in [EstimatorName::JointEkfPublished, EstimatorName::JointEkfUnaligned] {
            let scores = scores(estimator, 40, u64::MAX);
            assert_eq!(scores.len(), 40);
            let verdicts: Vec<Verdict> = scores.iter().map(|(_, _, score)| score.verdict).collect();
            assert!(verdicts.iter().any(|verdict| *verdict != Verdict::Converged), "{verdicts:?}");
        }
    }

    #[test]
    fn a_run_counts_how_often_what_was_known_was_dropped() {
        let still = Scenario::load("cubesat-pyramid").unwrap();
        // Twice the inertia from half-time on: no sample fits what the filter knew.
        let mut doubled = still.clone();
        doubled.changes.sudden = vec![SuddenChange {
            time_s: 30.0,
            inertia_kg_m2: still.spacecraft.inertia_kg_m2.map(|j| 2.0 * j),
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
            campaign.run(0).unwrap()
        };
        assert_eq!(run(&still).changes, 0);
        let run = run(&doubled);
        assert!(run.changes > 0);
        let true_kg_m2 = run.score.inertia_kg_m2[0] - run.score.error_kg_m2[0];
        assert!((true_kg_m2 - 2.0 * still.spacecraft.inertia_kg_m2[0]).abs() < 1e-12);
    }

    #[test]
    fn a_stopped_campaign_is_a_shorter_one() {
        let stopped = scores(EstimatorName::JointEkf, 1_000_000, 5);
        assert!((5..1000).contains(&stopped.len()), "{}", stopped.len());
        assert_eq!(stopped, on_threads(2, stopped.len() as u64));
    }
}
