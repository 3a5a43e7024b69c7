//! 1. Sample: one time-tagged gyro reading with the drive of the body at that instant.
//!
//! Input of every estimator. Values may be invalid in any way: the [`gate`](crate::gate) rejects a
//! sample that is not usable.
//!
//! # Timing
//!
//! All values belong to one instant. A delay δ between gyro and wheels appears as an error `ω̇ δ`
//! of the rate, and biases the inertia where the motion is fast; the caller interpolates the wheel
//! speeds to the gyro's instant. The sample period may vary. A rate averaged over the interval that
//! ends with it belongs to the middle of that interval.
//!
//! # Torque
//!
//! `torque_n_m` is the external torque as commanded or measured. An unmodelled torque, such as drag
//! or gravity gradient, is not part of it: the estimator `window` can estimate a constant one.
//! Between samples the torque is taken as linear in time.

use crate::attitude::Quaternion;
use crate::dynamics::interval::Drive;
use crate::dynamics::wheels::WheelArray;
use crate::math::{Vec3, scalar::Real};

/// One sample of a spacecraft with W wheels.
///
/// | field | unit | frame |
/// |---|---|---|
/// | `time_us` | µs since any epoch | – |
/// | `rate_rad_s` | rad/s, body relative to inertial space | body axes |
/// | `wheel_speed_rad_s` | rad/s, relative to the body, positive about the wheel's axis | wheel axes |
/// | `torque_n_m` | N m, external, known or commanded; zero where unknown | body axes |
/// | `attitude` | unit quaternion, scalar last, optional | inertial to body axes |
///
/// All values belong to the instant `time_us`. Between samples, torque is taken as linear in time
/// and wheel momentum as a parabola through three samples
/// ([`interval`](crate::dynamics::interval)).
///
/// ```
/// use fsw_core::{Sample, Vec3, WheelArray};
///
/// let wheels = WheelArray::new([Vec3::z()], [1e-3f32])?;
/// let sample = Sample {
///     time_us: 1_500_000,
///     rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
///     wheel_speed_rad_s: [200.0],
///     torque_n_m: Vec3::zeros(),
///     attitude: None,
/// };
/// assert!(sample.is_finite());
/// assert!((sample.drive(&wheels).wheel_momentum_n_m_s.z - 0.2).abs() < 1e-6);
/// # Ok::<(), fsw_core::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T: Real, const W: usize> {
    /// Time stamp in whole microseconds; only differences are used.
    pub time_us: u64,
    /// Gyro reading, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Tachometer reading of each wheel, rad/s.
    pub wheel_speed_rad_s: [T; W],
    /// External torque (thrusters, magnetorquers), N m, without that of the wheels.
    pub torque_n_m: Vec3<T>,
    /// Attitude relative to inertial space, for the estimators that use it; ignored by the others.
    pub attitude: Option<Quaternion<T>>,
}

impl<T: Real, const W: usize> Sample<T, W> {
    /// True where rate, wheel speeds and torque are finite. The attitude is not included: the
    /// estimator that uses it checks it.
    pub fn is_finite(&self) -> bool {
        self.rate_rad_s.iter().all(|x| x.is_finite()) && self.is_drive_finite()
    }

    /// True where wheel speeds and torque are finite.
    pub fn is_drive_finite(&self) -> bool {
        self.wheel_speed_rad_s.iter().all(|x| x.is_finite())
            && self.torque_n_m.iter().all(|x| x.is_finite())
    }

    /// External torque `τ` (N m) and wheel momentum `h_w` (N m s) at the instant of the sample,
    /// body axes.
    pub fn drive(&self, wheels: &WheelArray<T, W>) -> Drive<T> {
        Drive {
            torque_n_m: self.torque_n_m,
            wheel_momentum_n_m_s: wheels.momentum_n_m_s(&self.wheel_speed_rad_s),
        }
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format, const W: usize> defmt::Format for Sample<T, W> {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(
            f,
            "t {=u64} us, rate {} rad/s, wheels {} rad/s, torque {} N m",
            self.time_us,
            self.rate_rad_s.as_slice(),
            self.wheel_speed_rad_s.as_slice(),
            self.torque_n_m.as_slice()
        );
    }
}
