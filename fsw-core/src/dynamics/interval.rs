//! What drives the body between two samples.

use crate::math::{Vec3, scalar::Real};

/// Torque and wheel momentum at one instant, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<T: Real> {
    /// External torque, N m.
    pub torque_n_m: Vec3<T>,
    /// `h_w`, N m s.
    pub wheel_momentum_n_m_s: Vec3<T>,
}

crate::persist!([T: Real] Drive<T> { torque_n_m, wheel_momentum_n_m_s });

/// The stretch from one usable sample to the next: how long, and the drive at its start, its
/// middle and its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<T: Real> {
    /// Length, s.
    pub duration_s: T,
    /// At its start.
    pub start: Drive<T>,
    /// Half-way.
    pub middle: Drive<T>,
    /// At its end.
    pub end: Drive<T>,
}

/// Turns samples into intervals.
///
/// Torque is linear between samples. Wheel momentum half-way comes from the parabola through
/// the last three samples: with quiet gyros a straight line costs tens of sigmas on a wheel that
/// speeds up and down (measured on random spacecraft), and the parabola needs no future sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveHistory<T: Real> {
    last: Option<Drive<T>>,
    /// Momentum one interval before `last`, and that interval's length, s.
    before_last: Option<(Vec3<T>, T)>,
}

crate::persist!([T: Real] DriveHistory<T> { last, before_last });

impl<T: Real> Default for DriveHistory<T> {
    fn default() -> Self {
        Self { last: None, before_last: None }
    }
}

impl<T: Real> DriveHistory<T> {
    /// Starts anew at a sample with this drive: the earlier ones are discarded.
    pub fn restart(&mut self, drive: Drive<T>) {
        *self = Self { last: Some(drive), before_last: None };
    }

    /// The interval of `duration_s` that ends with the drive `end`. Without an earlier sample the
    /// drive is taken as constant.
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

/// Value at ½ of the parabola through (−r, a), (0, b), (1, c): Lagrange's formula. With r = 1
/// its weights are −1/8, 3/4, 3/8.
fn parabola_midpoint<T: Real>(a: &Vec3<T>, b: &Vec3<T>, c: &Vec3<T>, r: T) -> Vec3<T> {
    let (one, half, quarter) = (T::one(), T::lit(0.5), T::lit(0.25));
    let reach = r + half;
    c * (half * reach / (one + r)) + b * (half * reach / r) - a * (quarter / (r * (one + r)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_parabola_is_exact_at_any_spacing() {
        let h = |t: f64| Vec3::new(1.0, 0.0, 0.0) * (3.0 + 2.0 * t - 0.7 * t * t);
        for r in [0.25, 1.0, 2.5] {
            let m = parabola_midpoint(&h(-r), &h(0.0), &h(1.0), r);
            assert!((m - h(0.5)).norm() < 1e-15);
        }
    }

    #[test]
    fn a_constant_drive_before_anything_is_known() {
        let drive = Drive { torque_n_m: Vec3::y(), wheel_momentum_n_m_s: Vec3::x() * 2.0f32 };
        let i = DriveHistory::default().advance(drive, 0.1);
        assert_eq!(i.start, i.end);
        assert_eq!(i.middle, i.end);
    }
}
