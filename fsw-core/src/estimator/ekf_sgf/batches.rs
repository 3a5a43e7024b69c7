//! Sums of the regression, and the copy of them that is read out.
//!
//! | readout | sums of the estimate | present batch after an interval |
//! |---|---|---|
//! | [`Readout::EverySample`] | the present ones, weighted by the forgetting | – |
//! | [`Readout::EveryInterval`], [`Batch::SinceStart`] | those at the interval's end | goes on |
//! | [`Readout::EveryInterval`], [`Batch::LastInterval`] | those at the interval's end | empty |
//!
//! Recursive least squares \[Kim2013\] and batch least squares \[Kim2016\] Eq. (6) differ in
//! nothing else.

use super::config::{Batch, Readout};
use super::regression::{Instant, Regression};
use crate::math::scalar::Real;
use crate::prior::Prior;

/// Sums of the regression over the present batch and over the last complete one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Batches<T: Real> {
    /// The present batch.
    sums: Regression<T>,
    /// The sums at the end of the last interval.
    last_interval: Regression<T>,
    /// Start of the present interval, on the samples' clock.
    interval_start_us: u64,
}

crate::persist!([T: Real] Batches<T> { sums, last_interval, interval_start_us });

impl<T: Real> Batches<T> {
    /// Empty sums at `time_us`.
    pub(super) fn new(nominal: &Prior<T>, time_us: u64) -> Self {
        let empty = Regression::new(nominal);
        Self { sums: empty, last_interval: empty, interval_start_us: time_us }
    }

    /// Adds one instant to the present batch; `false` where its numbers are out of range.
    pub(super) fn add(&mut self, instant: &Instant<T>, readout: &Readout<T>) -> bool {
        if let Readout::EverySample { forgetting } = *readout {
            self.sums.forget(forgetting);
        }
        self.sums.add(instant)
    }

    /// Ends the interval at the first sample at or after its length: copies the sums for the
    /// readout, and empties them where a batch is one interval. Intervals start with the sample
    /// that ended the last.
    pub(super) fn close_interval(
        &mut self,
        time_us: u64,
        readout: &Readout<T>,
        nominal: &Prior<T>,
    ) {
        let Readout::EveryInterval { interval_us, batch } = *readout else { return };
        if time_us.saturating_sub(self.interval_start_us) < interval_us {
            return;
        }
        self.interval_start_us = time_us;
        self.last_interval = self.sums;
        if batch == Batch::LastInterval {
            self.sums = Regression::new(nominal);
        }
    }

    /// The sums that the estimate is solved from.
    pub(super) fn read_out(&self, readout: &Readout<T>) -> &Regression<T> {
        match readout {
            Readout::EverySample { .. } => &self.sums,
            Readout::EveryInterval { .. } => &self.last_interval,
        }
    }
}
