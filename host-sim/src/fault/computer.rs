//! Faults of the computer around any estimator: restarts and flipped bits.
//!
//! A checkpoint is the state as [`fsw_core::checkpoint`] writes it to flash. It covers everything that a
//! step changes, in the order and encoding of the stream: factors, covariances, blocks, counters, tags and
//! indices, and the configuration, which the restore compares. It does not cover unused places of
//! buffers, the stack, and the layout of the state in memory.

use fsw_core::checkpoint::{FromWords, Words};
use fsw_core::hardware::Finding;
use fsw_core::{Estimate, Innovation, Outcome};
use nalgebra::Vector3;
use rand::RngExt;

use super::{Drawn, micros};
use crate::estimation::{Acceleration, AnyEstimator, SetUpError, Setup, set_up};
use crate::input::log::LogRow;
use crate::input::scenario::Fault;
use crate::input::scenario::fault::FaultKind;

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
        let keeps = |due: &&Due| matches!(due.fault.kind, FaultKind::Reset | FaultKind::PowerCut);
        let period_us = due.iter().filter(keeps).map(|due| micros(due.fault.magnitude)).min();
        let schedule = period_us.map(|period_us| [period_us; 2]);
        Ok(Box::new(Self { estimator, fresh, due, saved: [None, None], schedule, first_us: None }))
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
            FaultKind::BitFlip => words(self.estimator.as_mut()).map(|mut words| {
                for _ in 0..fault.magnitude as usize {
                    let at = drawn.random.random_range(0..words.len() * u32::BITS as usize);
                    words[at / u32::BITS as usize] ^= 1 << (at % u32::BITS as usize);
                }
                words
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
        self.estimator.step(row)
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
