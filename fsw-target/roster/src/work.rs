//! Work of an estimator beside its steps, in slices.

use fsw_core::estimator::window::Remaining;
use fsw_steps::{EkfSgfRls, JointEkf, JointEkfOfHardware, Window9, Window18, WindowOfHardware};

/// Work beside the steps.
pub trait Work {
    /// Does up to this number of slices, each of bounded cost, and returns what is left. Estimators that
    /// complete their work within each step have none.
    fn work_in_slices(&mut self, _slices: u32) -> Remaining {
        Remaining::Nothing
    }
}

impl Work for JointEkf {}
impl Work for JointEkfOfHardware {}
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

work_of_windows!(Window9, Window18, WindowOfHardware);
