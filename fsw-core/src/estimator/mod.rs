//! 3. Estimators: one trait, and four systems that implement it independently of each other.
//!
//! | module | method | needs | source |
//! |---|---|---|---|
//! | [`window`] | batch fit of each manoeuvre as a whole, in slices | no prior | ours |
//! | [`joint_ekf`] | nine-state extended Kalman filter | a prior, or motion to align on | \[Bellar2019\] |
//! | [`ekf_sgf`] | rate filter, derivative, least squares | a nominal inertia | \[Kim2013\], \[Kim2016\] |
//! | [`momentum`] | conservation of angular momentum | attitude, start from rest | \[Kim2010\] |
//!
//! # Contract of an estimator
//!
//! * It owns a [`gate`](crate::gate), and its monitors.
//! * A step has a bounded amount of work, for any content of the sample. Work beyond that is cut into
//!   slices ([`Window::work`](window::Window::work)), and [`Estimator::finish`] completes it.
//! * No panic for any content of the sample. A state that is no longer finite is reset and reported
//!   as [`Reset::Diverged`](crate::Reset::Diverged).
//! * The estimate states covariance, observed directions and status at any time, before the first
//!   sample too.
//! * Its state implements [`Persist`](crate::persist::Persist) where it flies.
//!
//! # Memory
//!
//! The state is the size of the type; there is no other memory. A window keeps N blocks of 44 bytes and 8 for each wheel in
//! `f32`, 38 KiB of the sizes below; the rest are a fit, the front, and two factors of earlier windows.
//!
//! ```
//! use fsw_core::estimator::ekf_sgf::EkfSgf;
//! use fsw_core::estimator::joint_ekf::JointEkfUd;
//! use fsw_core::estimator::momentum::Momentum;
//! use fsw_core::estimator::window::Window;
//!
//! // Four wheels, single precision, bytes.
//! assert!(size_of::<Window<f32, 4, 512, 9>>() <= 45 * 1024);
//! assert!(size_of::<Window<f32, 4, 512, 18>>() <= 50_496);
//! assert!(size_of::<JointEkfUd<f32, 4>>() <= 2880);
//! assert!(size_of::<JointEkfUd<f32, 4, 24>>() <= 6336);
//! assert!(size_of::<EkfSgf<f32, 4>>() <= 2048);
//! assert!(size_of::<Momentum<f32, 4>>() <= 512);
//! ```
//!
//! # An estimator of one's own
//!
//! It implements [`Estimator`], lives in a folder beside the four, and takes gate, dynamics,
//! algebra and monitors from the shared modules. It depends on none of the other systems.

pub mod ekf_sgf;
pub mod joint_ekf;
pub mod momentum;
#[cfg(test)]
pub(crate) mod test_flight;
#[cfg(test)]
pub(crate) mod test_hardware;
#[cfg(test)]
mod tests_of_units;
pub mod window;

use crate::estimate::Estimate;
use crate::hardware::Finding;
use crate::math::{Vec3, scalar::Real};
use crate::monitor::innovation::Innovation;
use crate::outcome::Outcome;
use crate::sample::Sample;

/// On-board estimator of the inertia tensor, for W wheels.
///
/// A loop of one's own needs only this trait:
///
/// ```
/// use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
/// use fsw_core::{Estimator, Outcome, Sample, Status, Vec3, WheelArray};
///
/// /// Steps an estimator; true once the inertia may be used.
/// fn step<const W: usize>(
///     estimator: &mut impl Estimator<f32, W>,
///     sample: &Sample<f32, W>,
/// ) -> bool {
///     match estimator.step(sample) {
///         Outcome::Updated => estimator.estimate().status == Status::Converged,
///         Outcome::Coasting(_) | Outcome::Reset(_) => false,
///     }
/// }
///
/// let mut filter = JointEkfUd::<f32, 0>::new(Config::new(1e-4), WheelArray::new([], [])?)?;
/// let sample = Sample {
///     time_us: 0,
///     rate_rad_s: Vec3::zeros(),
///     wheel_speed_rad_s: [],
///     torque_n_m: Vec3::zeros(),
///     attitude: None,
/// };
/// assert!(!step(&mut filter, &sample));
/// # Ok::<(), fsw_core::ConfigError>(())
/// ```
pub trait Estimator<T: Real, const W: usize> {
    /// Takes in one sample and returns the outcome.
    ///
    /// Never panics, for any content of the sample, and costs a bounded amount of work.
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome;

    /// Present estimate, valid at any time. It costs more than a step (an eigenproblem of six), so
    /// that it belongs to the rate of telemetry.
    fn estimate(&self) -> Estimate<T>;

    /// Filtered body rate, rad/s, valid after every step.
    fn rate_rad_s(&self) -> Vec3<T>;

    /// Innovation of the last predicted sample, if any.
    fn innovation(&self) -> Option<Innovation<T>>;

    /// Completes all work on the samples so far. The call takes long and is meant for the end of a log.
    /// An estimator that completes its work within each step does nothing.
    fn finish(&mut self) {}

    /// Calls `visit` with the result on each parameter of the hardware that is among the unknowns or considered.
    fn each_of_hardware(&self, _visit: &mut dyn FnMut(Finding<T>)) {}
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

    fn finish(&mut self) {
        (**self).finish();
    }

    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<T>)) {
        (**self).each_of_hardware(visit);
    }
}
