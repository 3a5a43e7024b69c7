//! Work of an estimator beside its steps, in slices: the time between samples is theirs, but not without
//! limit.
//!
//! Compiled at `opt-level = "s"`. At `"z"`, the level of `fsw-roster`, a block of a pass takes 30,144
//! instructions instead of 18,112, and the most expensive slices exceed their budgets.

#![no_std]
#![forbid(unsafe_code)]

use fsw_core::estimator::window::Remaining;
use fsw_steps::{EkfSgfRls, JointEkf, Window9, Window12, Window15, Window18};

/// Work beside the steps.
pub trait Work {
    /// Does up to this number of slices, each of bounded cost, and returns what is left. Estimators that
    /// complete their work within each step have none.
    fn work_in_slices(&mut self, _slices: u32) -> Remaining {
        Remaining::Nothing
    }
}

impl Work for JointEkf {}
impl Work for EkfSgfRls {}

macro_rules! work_of_windows {
    ($($window:ty),*) => {
        $(impl Work for $window {
            #[inline(never)]
            fn work_in_slices(&mut self, slices: u32) -> Remaining {
                self.work(slices)
            }
        })*
    };
}

work_of_windows!(Window9, Window12, Window15, Window18);
