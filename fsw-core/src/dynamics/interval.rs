//! Torque and wheel momentum between two samples.
//!
//! Input: the drive at each usable sample. Output: the interval to the next sample, with the drive
//! at its start, middle and end, as a Runge-Kutta step needs it.
//!
//! | quantity | between samples | error for a sine of frequency f |
//! |---|---|---|
//! | torque | straight line | `(π f Δt)² / 2` of its amplitude |
//! | wheel momentum | parabola through three samples | `(π f Δt)³ / 2` of its amplitude |
//!
//! `Δt` is the sample period. The first interval after a restart has no earlier sample, and takes a
//! straight line for both.

use crate::math::{Vec3, scalar::Real};

/// Torque and wheel momentum at one instant, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<T: Real> {
    /// External torque `τ`, N m.
    pub torque_n_m: Vec3<T>,
    /// Momentum of the wheels `h_w`, N m s.
    pub wheel_momentum_n_m_s: Vec3<T>,
}

crate::persist!([T: Real] Drive<T> { torque_n_m, wheel_momentum_n_m_s });

/// Interval between two usable samples: length, and the drive at three instants.
///
/// [`DriveHistory`] builds it from samples; simulations may build it from exact functions of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<T: Real> {
    /// Length `Δt`, s.
    pub duration_s: T,
    /// Drive at the start.
    pub start: Drive<T>,
    /// Drive half-way.
    pub middle: Drive<T>,
    /// Drive at the end.
    pub end: Drive<T>,
}

/// Interpolation of the drive between samples.
///
/// Torque is linear between samples. Wheel momentum half-way comes from the parabola through the
/// last three samples, without a future one: with quiet gyros a straight line errs by tens of
/// sigmas for a wheel that reverses its acceleration (measured on random spacecraft).
///
/// ```
/// use fsw_core::Vec3;
/// use fsw_core::dynamics::interval::{Drive, DriveHistory};
///
/// let drive = |torque: f32| Drive {
///     torque_n_m: Vec3::new(torque, 0.0, 0.0),
///     wheel_momentum_n_m_s: Vec3::zeros(),
/// };
/// let mut history = DriveHistory::default();
/// history.restart(drive(0.0));
/// let interval = history.advance(drive(0.2), 0.1);
/// assert_eq!(interval.middle.torque_n_m.x, 0.1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveHistory<T: Real> {
    /// Drive at the last sample.
    last: Option<Drive<T>>,
    /// Momentum at the sample before the last, N m s, and the interval between them, s.
    before_last: Option<(Vec3<T>, T)>,
}

crate::persist!([T: Real] DriveHistory<T> { last, before_last });

impl<T: Real> Default for DriveHistory<T> {
    fn default() -> Self {
        Self { last: None, before_last: None }
    }
}

impl<T: Real> DriveHistory<T> {
    /// Starts at a sample with this drive; earlier samples are discarded.
    pub fn restart(&mut self, drive: Drive<T>) {
        *self = Self { last: Some(drive), before_last: None };
    }

    /// Interval of `duration_s` that ends with the drive `end`. Without an earlier sample the drive
    /// is taken as constant.
    pub fn advance(&mut self, end: Drive<T>, duration_s: T) -> Interval<T> {
        let half = T::lit(0.5);
        let start = self.last.unwrap_or(end);
        let (h0, h1) = (start.wheel_momentum_n_m_s, end.wheel_momentum_n_m_s);
        let momentum = match self.before_last {
            None => (h0 + h1) * half,
            Some((before, before_s)) => parabola_midpoint(&before, &h0, &h1, before_s / duration_s),
        };
        let torque = (start.torque_n_m + end.torque_n_m) * half;
        self.before_last = Some((h0, duration_s));
        self.last = Some(end);
        let middle = Drive { torque_n_m: torque, wheel_momentum_n_m_s: momentum };
        Interval { duration_s, start, middle, end }
    }
}

/// Value at ½ of the parabola through (−r, a), (0, b), (1, c), by Lagrange's formula:
///
/// `c (½ + r) / (2 (1 + r)) + b (½ + r) / (2 r) − a / (4 r (1 + r))`.
///
/// `r` is the ratio of the interval before to this one. For r = 1 the weights are −1/8, 3/4, 3/8.
fn parabola_midpoint<T: Real>(a: &Vec3<T>, b: &Vec3<T>, c: &Vec3<T>, r: T) -> Vec3<T> {
    let (one, half, quarter) = (T::one(), T::lit(0.5), T::lit(0.25));
    let reach = r + half;
    c * (half * reach / (one + r)) + b * (half * reach / r) - a * (quarter / (r * (one + r)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ratios of the two intervals from 0.25 to 2.5.
    #[test]
    fn the_midpoint_of_a_parabola_is_exact_at_any_spacing() {
        let h = |t: f64| Vec3::new(1.0, 0.0, 0.0) * (3.0 + 2.0 * t - 0.7 * t * t);
        for r in [0.25, 1.0, 2.5] {
            let m = parabola_midpoint(&h(-r), &h(0.0), &h(1.0), r);
            assert!((m - h(0.5)).norm() < 1e-15);
        }
    }

    /// The first interval has equal drives at its start, middle and end.
    #[test]
    fn without_an_earlier_sample_the_drive_is_constant() {
        let drive = Drive { torque_n_m: Vec3::y(), wheel_momentum_n_m_s: Vec3::x() * 2.0f32 };
        let i = DriveHistory::default().advance(drive, 0.1);
        assert_eq!(i.start, i.end);
        assert_eq!(i.middle, i.end);
    }
}
