//! Faults of the computer around any estimator: restarts and flipped bits.
//!
//! A checkpoint is the state as [`fsw_core::checkpoint`] writes it to flash. It covers everything that a
//! step changes, in the order and encoding of the stream: factors, covariances, blocks, counters, tags and
//! indices, and the configuration, which the restore compares. It does not cover unused places of
//! buffers, the stack, and the layout of the state in memory.
//!
//! Bits flip between two steps. As on the flight computer, the state is sealed then
//! ([`fsw_target::runtime::sealed`]): a broken seal is found before the next step, that sample is not used, and the newest
//! checkpoint is restored.

use fsw_core::checkpoint::{FromWords, Words};
use fsw_core::hardware::Finding;
use fsw_core::{Estimate, Innovation, Outcome, Reset};
use fsw_target::runtime::sealed;
use nalgebra::Vector3;
use rand::RngExt;

use super::{Drawn, micros};
use crate::estimation::{Acceleration, AnyEstimator, SetUpError, Setup, set_up};
use crate::input::log::LogRow;
use crate::input::scenario::Fault;
use crate::input::scenario::fault::FaultKind;

/// Period of checkpoints where no fault states another one, s.
pub(super) const CHECKPOINT_S: f64 = 30.0;

/// An estimator on a computer with faults.
pub struct Computer {
    estimator: Box<dyn AnyEstimator>,
    /// Checkpoint of the estimator before its first sample.
    fresh: Vec<u32>,
    /// Faults that are still to come, the next one last.
    due: Vec<Due>,
    /// The newest checkpoint, and the one before it.
    saved: [Option<Vec<u32>>; 2],
    /// Time of the next checkpoint, µs since the first sample, and the period, µs; none without a fault
    /// that needs one.
    schedule: Option<[u64; 2]>,
    /// Stamp of the first sample, µs.
    first_us: Option<u64>,
    /// True where the next step finds a broken seal.
    is_unsealed: bool,
}

/// A fault that is still to come.
struct Due {
    fault: Fault,
    drawn: Drawn,
}

/// Checkpoint in memory.
#[derive(Default)]
struct Memory(Vec<u32>);

impl Words for Memory {
    fn transfer(&mut self, word: &mut u32) -> bool {
        self.0.push(*word);
        true
    }
}

impl Computer {
    /// The estimator of `setup`, on a computer with those of `faults` that are its own; the estimator
    /// alone if none is.
    ///
    /// # Errors
    /// See [`SetUpError`].
    pub fn with(
        setup: &Setup<'_>,
        faults: &[Fault],
        seed: u64,
    ) -> Result<Box<dyn AnyEstimator>, SetUpError> {
        let mut estimator = set_up(setup)?;
        let of_computer = |(index, fault): (usize, &Fault)| {
            let due = Due { fault: *fault, drawn: Drawn::new(fault, index, seed) };
            fault.kind.is_of_the_computer().then_some(due)
        };
        let mut due: Vec<Due> = faults.iter().enumerate().filter_map(of_computer).collect();
        if due.is_empty() {
            return Ok(estimator);
        }
        due.sort_by_key(|due| std::cmp::Reverse(due.drawn.start_us));
        let without = SetUpError::NotRestorable { estimator: setup.estimator };
        let fresh = words(estimator.as_mut()).ok_or(without)?;
        let period_s = |due: &Due| match due.fault.kind {
            FaultKind::Reset | FaultKind::PowerCut => Some(due.fault.magnitude),
            FaultKind::BitFlip => Some(CHECKPOINT_S),
            _ => None,
        };
        let period_us = due.iter().filter_map(period_s).map(micros).min();
        let schedule = period_us.map(|period_us| [period_us; 2]);
        let saved = [None, None];
        Ok(Box::new(Self {
            estimator,
            fresh,
            due,
            saved,
            schedule,
            first_us: None,
            is_unsealed: false,
        }))
    }

    /// Saves the checkpoints and applies the faults that are due before a sample at this time.
    fn catch_up(&mut self, elapsed_us: u64) {
        while let Some(due) = self.due.pop_if(|due| due.drawn.start_us <= elapsed_us) {
            self.save(due.drawn.start_us);
            self.strike(due);
        }
        self.save(elapsed_us);
    }

    /// Saves a checkpoint if one is due.
    fn save(&mut self, elapsed_us: u64) {
        let Some([next_us, period_us]) = self.schedule else { return };
        if elapsed_us >= next_us {
            self.saved.swap(0, 1);
            self.saved[0] = words(self.estimator.as_mut());
            let periods = (elapsed_us - next_us) / period_us.max(1) + 1;
            self.schedule = Some([next_us + periods * period_us.max(1), period_us]);
        }
    }

    fn strike(&mut self, due: Due) {
        let Due { fault, mut drawn } = due;
        let found = match fault.kind {
            FaultKind::Reset => self.saved[0].clone(),
            FaultKind::PowerCut => self.saved[1].clone(),
            FaultKind::BitFlip => words(self.estimator.as_mut()).and_then(|mut words| {
                let seal = sealed::sum(words.iter().copied());
                for _ in 0..fault.magnitude as usize {
                    let at = drawn.random.random_range(0..words.len() * u32::BITS as usize);
                    words[at / u32::BITS as usize] ^= 1 << (at % u32::BITS as usize);
                }
                self.is_unsealed = sealed::sum(words.iter().copied()) != seal;
                if self.is_unsealed { self.saved[0].clone() } else { Some(words) }
            }),
            _ => None,
        };
        if !found.is_some_and(|words| self.restore(&words)) {
            let fresh = std::mem::take(&mut self.fresh);
            self.restore(&fresh);
            self.fresh = fresh;
        }
    }

    /// False if the words are rejected.
    fn restore(&mut self, words: &[u32]) -> bool {
        matches!(self.estimator.transfer(&mut FromWords::new(words)), Some(Ok(())))
    }
}

/// Checkpoint of an estimator; none if it has no checkpoints.
fn words(estimator: &mut dyn AnyEstimator) -> Option<Vec<u32>> {
    let mut memory = Memory::default();
    estimator.transfer(&mut memory)?.ok().map(|()| memory.0)
}

impl AnyEstimator for Computer {
    fn step(&mut self, row: &LogRow) -> Outcome {
        let first_us = *self.first_us.get_or_insert(row.time_us);
        self.catch_up(row.time_us.saturating_sub(first_us));
        match std::mem::take(&mut self.is_unsealed) {
            true => Outcome::Reset(Reset::Diverged),
            false => self.estimator.step(row),
        }
    }

    fn finish(&mut self) {
        self.estimator.finish();
    }

    fn estimate(&self) -> Estimate<f64> {
        self.estimator.estimate()
    }

    fn hardware(&self) -> Vec<Finding<f64>> {
        self.estimator.hardware()
    }

    fn rate_rad_s(&self) -> Vector3<f64> {
        self.estimator.rate_rad_s()
    }

    fn innovation(&self) -> Option<Innovation<f64>> {
        self.estimator.innovation()
    }

    fn rate_sigma_rad_s(&self) -> Option<Vector3<f64>> {
        self.estimator.rate_sigma_rad_s()
    }

    fn acceleration(&self) -> Option<Acceleration> {
        self.estimator.acceleration()
    }

    fn transfer(
        &mut self,
        words: &mut dyn Words,
    ) -> Option<Result<(), fsw_core::checkpoint::InvalidWord>> {
        self.estimator.transfer(words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::{EstimatorName, Precision};
    use crate::input::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    const FLYING: [EstimatorName; 3] =
        [EstimatorName::Window, EstimatorName::JointEkf, EstimatorName::EkfSgfRls];

    fn fault(kind: FaultKind, magnitude: f64) -> Fault {
        let (start_s, latest_start_s) = (20.05, 20.05);
        let (duration_s, share) = (0.0, 1.0);
        Fault {
            kind,
            start_s,
            latest_start_s,
            duration_s,
            magnitude,
            share,
            axis: None,
            wheel: None,
        }
    }

    /// Outcome of each sample of 40 s, and the final elements.
    fn fly(estimator: EstimatorName, faults: &[Fault], seed: u64) -> (Vec<Outcome>, [f64; 6]) {
        let mut scenario = Scenario::load("fault-matrix").unwrap();
        scenario.duration_s = 40.0;
        let log = log_of(&scenario, &Flight::simulate(&scenario).unwrap(), 1);
        let craft = scenario.craft();
        let setup = Setup {
            estimator,
            precision: Precision::F32,
            craft: &craft,
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
            sample_period_s: 0.1,
            refuse_spikes: true,
        };
        let mut computer = Computer::with(&setup, faults, seed).unwrap();
        let outcomes = log.iter().map(|row| computer.step(row)).collect();
        (outcomes, computer.estimate().inertia.elements_kg_m2())
    }

    #[test]
    fn restart_from_the_state_of_the_last_sample_changes_nothing() {
        for estimator in FLYING {
            // The checkpoint is due at the instant of the reset.
            let reset = fault(FaultKind::Reset, 20.05);
            assert_eq!(fly(estimator, &[reset], 0), fly(estimator, &[], 0), "{estimator}");
        }
    }

    #[test]
    fn cold_reset_starts_again_and_a_torn_checkpoint_is_passed_over() {
        for estimator in FLYING {
            let (cold, _) = fly(estimator, &[fault(FaultKind::ColdReset, 0.0)], 0);
            assert_eq!(cold[201], Outcome::Reset(Reset::FirstSample), "{estimator}");
            // Checkpoints at 8 and 16 s: the older one is a gap of 12 s.
            let (cut, _) = fly(estimator, &[fault(FaultKind::PowerCut, 8.0)], 0);
            assert_eq!(cut[201], Outcome::Reset(Reset::Gap), "{estimator}");
        }
    }

    #[test]
    fn flipped_bits_break_the_seal_and_the_newest_checkpoint_is_restored() {
        for estimator in FLYING {
            for seed in 0..10 {
                let (outcomes, elements) = fly(estimator, &[fault(FaultKind::BitFlip, 1.0)], seed);
                assert_eq!(
                    outcomes[201],
                    Outcome::Reset(Reset::Diverged),
                    "{estimator}, seed {seed}"
                );
                // No checkpoint in the first 30 s: from the beginning.
                assert_eq!(
                    outcomes[202],
                    Outcome::Reset(Reset::FirstSample),
                    "{estimator}, seed {seed}"
                );
                assert!(elements.iter().all(|x| x.is_finite()), "{estimator}, seed {seed}");
            }
        }
    }

    #[test]
    fn estimator_without_checkpoints_is_rejected() {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let craft = scenario.craft();
        let estimator = EstimatorName::MomentumBatch;
        let setup = Setup {
            estimator,
            precision: Precision::F32,
            craft: &craft,
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
            sample_period_s: 0.1,
            refuse_spikes: true,
        };
        let rejected = Computer::with(&setup, &[fault(FaultKind::ColdReset, 0.0)], 0).err();
        assert_eq!(rejected, Some(SetUpError::NotRestorable { estimator }));
    }
}
