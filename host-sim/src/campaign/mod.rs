//! Monte Carlo: one flight, many draws of the gyro's noise.
//!
//! The truth and the bound don't depend on the noise and are simulated once; run `i` has the seed
//! `first_seed + i`. Runs are spread over rayon's threads and put back in order, and each draws from
//! a generator of its own, so the numbers are the same however many threads there are.

pub mod statistics;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::iter::{ParallelBridge, ParallelIterator};

use crate::estimation::{EstimatorName, Precision, SetUpError, Setup, fly, set_up};
use crate::input::{Craft, Scenario};
use crate::simulation::log_of;
use crate::truth::Flight;
use statistics::{Score, Yardstick};

/// What to fly, with what, how often.
#[derive(Clone, Copy, Debug)]
pub struct Campaign<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its truth and bound.
    pub flight: &'a Flight,
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
    /// Seed of its noise: `run --seed` flies it again.
    pub seed: u64,
    /// What came of it.
    pub score: Score,
    /// Samples that the estimator was given.
    pub steps: u64,
    /// Time that it took over them; sensors and set-up don't count.
    pub estimator_time: Duration,
}

impl Campaign<'_> {
    /// Truth and bound of every run.
    pub fn yardstick(&self) -> Yardstick {
        Yardstick {
            truth_kg_m2: self.scenario.spacecraft.inertia_kg_m2,
            bound_kg_m2: self.flight.bound.sigma_kg_m2,
        }
    }

    /// Flies the runs on all of rayon's threads, and calls `done` after each.
    ///
    /// Once `stop` is set no further run is begun. Runs are begun in order and those begun are
    /// completed, so what comes back is what a campaign of fewer runs would have given.
    pub fn fly(&self, stop: &AtomicBool, done: impl Fn() + Sync) -> Result<Vec<Run>, SetUpError> {
        let craft = self.scenario.craft();
        let yardstick = self.yardstick();
        let fly_one = |index| {
            let run = self.run(index, &craft, &yardstick);
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

    fn run(&self, index: u64, craft: &Craft, yardstick: &Yardstick) -> Result<Run, SetUpError> {
        // Seeds go round at the end of the numbers rather than run out.
        let seed = self.first_seed.wrapping_add(index);
        let gyro = &self.scenario.gyro;
        let log = log_of(self.scenario, self.flight, seed);
        let on_board = set_up(&Setup {
            estimator: self.estimator,
            precision: self.precision,
            craft,
            gyro_noise_rad_s: gyro.noise_rad_s,
            sample_period_s: 1.0 / gyro.rate_hz,
            refuse_spikes: true,
        })?;
        let begun = Instant::now();
        let flown = fly(&log, on_board, |_, _, _| ());
        let estimator_time = begun.elapsed();
        let score = yardstick.score(&flown.estimate);
        Ok(Run { index, seed, score, steps: log.len() as u64, estimator_time })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use super::*;

    /// Flies the CubeSat, and stops after so many runs.
    fn scores(runs: u64, stop_after: u64) -> Vec<(u64, u64, Score)> {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        let campaign = Campaign {
            scenario: &scenario,
            flight: &flight,
            estimator: EstimatorName::JointEkf,
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
        pool.install(|| scores(runs, u64::MAX))
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let one = on_threads(1, 12);
        assert_eq!(one, on_threads(3, 12));
        for (i, (index, seed, score)) in one.iter().enumerate() {
            assert_eq!((*index, *seed), (i as u64, 40 + i as u64));
            assert!(!score.diverged);
        }
        assert_ne!(one[0].2, one[1].2);
    }

    #[test]
    fn a_stopped_campaign_is_a_shorter_one() {
        let stopped = scores(1_000_000, 5);
        assert!((5..1000).contains(&stopped.len()), "{}", stopped.len());
        assert_eq!(stopped, on_threads(2, stopped.len() as u64));
    }
}
