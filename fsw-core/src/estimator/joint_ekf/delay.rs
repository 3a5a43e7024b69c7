//! Known time offset: wheels and torque of a sample at the instant of its reading.
//!
//! A reading of a gyro that is late by `δ` shows the motion at `t − δ`, wheels and torque are those at t.
//! Both are interpolated to `t − δ`, between the samples so far:
//!
//! | quantity | between samples | with one sample before | without |
//! |---|---|---|---|
//! | wheel speeds | parabola through the last three | straight line | as measured |
//! | torque | straight line between neighbours; the last one after it | the same | as measured |
//!
//! Valid range: δ from minus half a sample period to two periods; beyond, the parabola is extrapolated.
//! Error for wheels that swing as a sine of frequency f: up to `0.065 (2 π f Δt)³` of its amplitude within two
//! periods, `0.39 · (2 π f Δt)³ / 6 · …` at half a period ahead is of the same size.

use crate::math::{Vec3, scalar::Real};
use crate::sample::Sample;

/// Wheel speeds (rad/s) and torque (N m) of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measured<T: Real, const W: usize> {
    wheel_speed_rad_s: [T; W],
    torque_n_m: Vec3<T>,
}

crate::persist!([T: Real, const W: usize] Measured<T, W> { wheel_speed_rad_s, torque_n_m });

/// The last two samples, as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Delay<T: Real, const W: usize> {
    last: Option<Measured<T, W>>,
    /// The sample before the last, and the interval between them, s.
    before_last: Option<(Measured<T, W>, T)>,
}

crate::persist!([T: Real, const W: usize] Delay<T, W> { last, before_last });

impl<T: Real, const W: usize> Delay<T, W> {
    /// No sample yet.
    pub(super) fn new() -> Self {
        Self { last: None, before_last: None }
    }

    /// Starts at a sample, which stays as measured.
    pub(super) fn restart(&mut self, sample: &Sample<T, W>) {
        *self = Self { last: Some(Measured::of(sample)), before_last: None };
    }

    /// The sample, `elapsed_s` after the one before, with wheels and torque of the instant `delay_s` before it.
    pub(super) fn shifted(
        &mut self,
        sample: &Sample<T, W>,
        elapsed_s: T,
        delay_s: T,
    ) -> Sample<T, W> {
        let now = Measured::of(sample);
        let Some(last) = self.last.replace(now) else { return *sample };
        let before_last = self.before_last.replace((last, elapsed_s));
        // Time since the last sample, in intervals, of the instant that is wanted.
        let share = T::one() - delay_s / elapsed_s;
        let line = |from: T, to: T, share: T| from + (to - from) * share;
        let mut speed = now.wheel_speed_rad_s;
        let mut torque_n_m = now.torque_n_m;
        if share < T::one() {
            torque_n_m =
                last.torque_n_m + (now.torque_n_m - last.torque_n_m) * share.max(T::zero());
        }
        for (i, speed) in speed.iter_mut().enumerate() {
            *speed = line(last.wheel_speed_rad_s[i], *speed, share);
        }
        if let Some((before, before_s)) = before_last {
            let ratio = before_s / elapsed_s;
            if share < T::zero() {
                let back = -share / ratio;
                torque_n_m =
                    last.torque_n_m + (before.torque_n_m - last.torque_n_m) * back.min(T::one());
            }
            for (i, speed) in speed.iter_mut().enumerate() {
                *speed += bend(
                    [
                        before.wheel_speed_rad_s[i],
                        last.wheel_speed_rad_s[i],
                        now.wheel_speed_rad_s[i],
                    ],
                    ratio,
                ) * (share * (share - T::one()));
            }
        }
        Sample { wheel_speed_rad_s: speed, torque_n_m, ..*sample }
    }
}

impl<T: Real, const W: usize> Measured<T, W> {
    fn of(sample: &Sample<T, W>) -> Self {
        Self { wheel_speed_rad_s: sample.wheel_speed_rad_s, torque_n_m: sample.torque_n_m }
    }
}

/// Second divided difference of values at −r, 0 and 1: `((c − b) − (b − a) / r) / (1 + r)`. Newton's form of the
/// parabola is `b + (c − b) s + bend · s (s − 1)`.
fn bend<T: Real>([a, b, c]: [T; 3], ratio: T) -> T {
    ((c - b) - (b - a) / ratio) / (T::one() + ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DELAYS: [f64; 6] = [0.0, 0.004, 0.05, 0.1, 0.15, -0.03];

    fn sample(t: f64, speed: impl Fn(f64) -> f64) -> Sample<f64, 1> {
        Sample {
            time_us: (t * 1e6) as u64,
            rate_rad_s: Vec3::zeros(),
            wheel_speed_rad_s: [speed(t)],
            torque_n_m: Vec3::new(0.2 * t, 0.0, 1.0),
            attitude: None,
        }
    }

    /// Samples at unequal intervals: wheels on a parabola, torque on a line.
    #[test]
    fn a_parabola_is_interpolated_exactly() {
        let speed = |t: f64| 5.0 - 3.0 * t + 0.7 * t * t;
        for delay in DELAYS {
            let mut state = Delay::new();
            state.restart(&sample(1.0, speed));
            state.shifted(&sample(1.08, speed), 0.08, delay);
            let shifted = state.shifted(&sample(1.18, speed), 0.1, delay);
            let t = 1.18 - delay;
            assert!((shifted.wheel_speed_rad_s[0] - speed(t)).abs() < 1e-12, "{delay}");
            assert!((shifted.torque_n_m.x - 0.2 * t.min(1.18)).abs() < 1e-12, "{delay}");
            assert_eq!(shifted.torque_n_m.z, 1.0);
        }
    }

    /// The first sample stays; the second one has a straight line before it.
    #[test]
    fn a_start_needs_no_earlier_sample() {
        let speed = |t: f64| 10.0 * t;
        let mut state = Delay::new();
        assert_eq!(state.shifted(&sample(1.0, speed), 0.1, 0.02), sample(1.0, speed));
        let second = state.shifted(&sample(1.1, speed), 0.1, 0.02);
        assert!((second.wheel_speed_rad_s[0] - 10.8).abs() < 1e-12);
    }
}
