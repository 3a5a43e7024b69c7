//! 3. The estimators: one trait, then a room for each system.

pub mod ekf_sgf;
pub mod joint_ekf;
pub mod momentum;
#[cfg(test)]
pub(crate) mod test_flight;
pub mod window;

use crate::estimate::Estimate;
use crate::math::{Vec3, scalar::Real};
use crate::monitor::innovation::Innovation;
use crate::outcome::Outcome;
use crate::sample::Sample;

/// An on-board estimator of the inertia tensor.
pub trait Estimator<T: Real, const W: usize> {
    /// Takes in one gyro sample and says what became of it.
    ///
    /// Never panics, whatever the sample holds, and costs a bounded amount of work.
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome;

    /// What is known by now. Valid at any time; costs more than a step (an eigenproblem of six),
    /// so call it at the rate of telemetry, not of the gyro.
    fn estimate(&self) -> Estimate<T>;

    /// Filtered body rate, rad/s: good for every step.
    fn rate_rad_s(&self) -> Vec3<T>;

    /// Innovation of the last sample that was predicted, if any.
    fn innovation(&self) -> Option<Innovation<T>>;
}

impl<T: Real, const W: usize, E: Estimator<T, W> + ?Sized> Estimator<T, W> for &mut E {
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        (**self).step(sample)
    }

    fn estimate(&self) -> Estimate<T> {
        (**self).estimate()
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        (**self).rate_rad_s()
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        (**self).innovation()
    }
}
