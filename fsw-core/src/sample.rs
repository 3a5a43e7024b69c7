//! 1. What arrives: one time-tagged gyro sample with what drives the body at that instant.

use crate::attitude::Quaternion;
use crate::dynamics::interval::Drive;
use crate::dynamics::wheels::WheelArray;
use crate::math::{Vec3, scalar::Real};

/// One sample, W wheels.
///
/// | field | unit | frame |
/// |---|---|---|
/// | `time_us` | µs since any epoch | – |
/// | `rate_rad_s` | rad/s, body relative to inertial space | body axes |
/// | `wheel_speed_rad_s` | rad/s, relative to the body, positive about the wheel's axis | wheel axes |
/// | `torque_n_m` | N m, external, known or commanded; zero where unknown | body axes |
/// | `attitude` | unit quaternion, scalar last, where it is known | inertial to body axes |
///
/// Everything is taken at `time_us`; between two samples torque is taken as linear in time and
/// wheel momentum as a parabola through three samples. Any value may arrive broken: the
/// [`gate`](crate::gate) decides what is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T: Real, const W: usize> {
    /// Time stamp in whole microseconds; only differences matter.
    pub time_us: u64,
    /// Gyro reading.
    pub rate_rad_s: Vec3<T>,
    /// Tachometer reading of each wheel.
    pub wheel_speed_rad_s: [T; W],
    /// External torque on the spacecraft (thrusters, magnetorquers), without the wheels'.
    pub torque_n_m: Vec3<T>,
    /// Attitude in inertial space, for the estimators that use it; the others ignore it, whatever
    /// it holds.
    pub attitude: Option<Quaternion<T>>,
}

impl<T: Real, const W: usize> Sample<T, W> {
    /// No infinity and no NaN in what every estimator uses: all but the attitude.
    pub fn is_finite(&self) -> bool {
        self.rate_rad_s.iter().all(|x| x.is_finite())
            && self.wheel_speed_rad_s.iter().all(|x| x.is_finite())
            && self.torque_n_m.iter().all(|x| x.is_finite())
    }

    /// External torque and wheel momentum at the sample's instant, body axes.
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
