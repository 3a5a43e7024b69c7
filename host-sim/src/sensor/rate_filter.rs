//! Rate that a gyro with delay, low-pass filter and averaging observes, along a trajectory.
//!
//! ```text
//! τ ẏ = ω − y                       first-order low-pass filter of time constant τ
//! z(t) = y(t − d)                   delay d
//! z(t) = 1/T ∫ y(s − d) ds          mean over the interval of duration T that ends at t
//! ```
//!
//! Between two grid points `ω` is a cubic `p`, for which the solution is exact:
//! `y = p̃ + (y₀ − p̃₀) e^(−t/τ)` with `p̃ = p − τ ṗ + τ² p̈ − τ³ p⃛`, and `∫ y = ∫ ω − τ (y − y₀)`.

use nalgebra::Vector3;

use crate::truth::Trajectory;
use crate::truth::trajectory::Cubic;

/// Filtered rate along a trajectory.
pub struct RateFilter<'a> {
    trajectory: &'a Trajectory,
    lag_s: f64,
    /// `y` at the start of each piece, rad/s.
    start_rad_s: Vec<Vector3<f64>>,
    /// `∫ y` up to the start of each piece, rad.
    angle_rad: Vec<Vector3<f64>>,
}

impl<'a> RateFilter<'a> {
    /// Filter of time constant `lag_s`, s, zero for none. It starts without its transient.
    pub fn new(trajectory: &'a Trajectory, lag_s: f64) -> Self {
        let pieces = trajectory.pieces();
        let mut filter = Self {
            trajectory,
            lag_s,
            start_rad_s: Vec::with_capacity(pieces.len()),
            angle_rad: Vec::with_capacity(pieces.len()),
        };
        let mut angle = Vector3::zeros();
        let mut filtered =
            pieces.first().map_or(angle, |piece| settled(&piece.rate_rad_s, lag_s, 0.0));
        for (index, piece) in pieces.iter().enumerate() {
            filter.start_rad_s.push(filtered);
            filter.angle_rad.push(angle);
            angle = filter.angle(index, piece.duration_s);
            filtered = filter.value(index, piece.duration_s);
        }
        filter
    }

    /// Filtered rate at a time, rad/s.
    pub fn at(&self, time_s: f64) -> Vector3<f64> {
        let (piece, s) = self.trajectory.locate(time_s);
        self.value(piece, s)
    }

    /// Mean of the filtered rate over an interval, rad/s.
    pub fn mean(&self, from_s: f64, to_s: f64) -> Vector3<f64> {
        let angle = |time_s: f64| {
            let (piece, s) = self.trajectory.locate(time_s);
            self.angle(piece, s)
        };
        (angle(to_s) - angle(from_s)) / (to_s - from_s)
    }

    fn value(&self, piece: usize, s: f64) -> Vector3<f64> {
        let cubic = &self.trajectory.pieces()[piece].rate_rad_s;
        if self.lag_s == 0.0 {
            return cubic.at(s);
        }
        let transient = self.start_rad_s[piece] - settled(cubic, self.lag_s, 0.0);
        settled(cubic, self.lag_s, s) + transient * (-s / self.lag_s).exp()
    }

    fn angle(&self, piece: usize, s: f64) -> Vector3<f64> {
        let cubic = &self.trajectory.pieces()[piece].rate_rad_s;
        let change = self.value(piece, s) - self.start_rad_s[piece];
        self.angle_rad[piece] + cubic.integral(s) - change * self.lag_s
    }
}

/// Particular solution `p − τ ṗ + τ² p̈ − τ³ p⃛` for a cubic input.
fn settled(cubic: &Cubic<Vector3<f64>>, lag_s: f64, s: f64) -> Vector3<f64> {
    let [_, b, c, d] = cubic.0;
    let first = b + (c * 2.0 + d * (3.0 * s)) * s;
    let second = c * 2.0 + d * (6.0 * s);
    cubic.at(s) - (first - (second - d * (6.0 * lag_s)) * lag_s) * lag_s
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::path::Path;

    use super::*;
    use crate::input::Scenario;

    /// Amplitude of the rate about z, rad/s, and its frequency, Hz.
    const SINE: (f64, f64) = (0.05, 1.5);

    /// A body whose rate about z is `A (1 − cos 2π f t)/…`: torque `J 2π f A sin 2π f t` about z.
    fn swinging() -> Trajectory {
        let (amplitude, frequency_hz) = SINE;
        let torque_n_m = 5.0 * TAU * frequency_hz * amplitude;
        let text = format!(
            "name = 'swing'\nduration_s = 20\n[spacecraft]\ninertia_kg_m2 = [3, 4, 5, 0, 0, 0]\n\
             [gyro]\nrate_hz = 10\nnoise_rad_s = 1e-4\n[torque]\nkind = 'multisine'\n\
             amplitude_n_m = [[], [], [{torque_n_m}]]\nfrequency_hz = [[], [], [{frequency_hz}]]\n\
             phase_rad = [[], [], [0]]\n[hardware.gyro]\nlag_s = 0.05\n"
        );
        let scenario = Scenario::from_toml("s.toml", &text, Path::new("")).unwrap();
        Trajectory::simulate(&scenario).unwrap()
    }

    /// Largest distance of `observed` from `A − A G cos(2π f (t − T))` over the flight.
    fn distance(observed: impl Fn(f64) -> f64, gain: f64, late_s: f64) -> f64 {
        let (amplitude, frequency_hz) = SINE;
        let times_s = (0..400).map(|k| 1.0 + 0.041 * f64::from(k));
        let error = |t: f64| {
            let phase = TAU * frequency_hz * (t - late_s);
            observed(t) - amplitude * (1.0 - gain * phase.cos())
        };
        times_s.map(|t| error(t).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn lag_has_amplitude_and_phase_of_a_first_order_filter() {
        let trajectory = swinging();
        for lag_s in [0.0, 0.005, 0.02, 0.05] {
            let filter = RateFilter::new(&trajectory, lag_s);
            let angular = TAU * SINE.1;
            let gain = 1.0 / (1.0 + (angular * lag_s).powi(2)).sqrt();
            let late_s = (angular * lag_s).atan() / angular;
            let error = distance(|t| filter.at(t).z, gain, late_s);
            // Between grid points the sine is a cubic: (2π 1.5 · 0.02)⁴/384 = 3e-6 of it.
            assert!(error < 5e-6 * SINE.0, "{lag_s}: {error:e}");
        }
    }

    #[test]
    fn mean_has_the_gain_of_a_sinc_and_half_the_interval_of_delay() {
        let trajectory = swinging();
        let (filter, mean_s) = (RateFilter::new(&trajectory, 0.0), 0.1);
        let half = 0.5 * TAU * SINE.1 * mean_s;
        let error = distance(|t| filter.mean(t - mean_s, t).z, half.sin() / half, mean_s / 2.0);
        assert!(error < 5e-6 * SINE.0, "{error:e}");
    }

    #[test]
    fn mean_of_the_filtered_rate_is_its_quadrature() {
        let trajectory = swinging();
        let filter = RateFilter::new(&trajectory, 0.05);
        let (from_s, to_s, steps) = (3.013, 3.094, 2000);
        let step_s = (to_s - from_s) / f64::from(steps);
        let middle = |k: i32| filter.at(from_s + (f64::from(k) + 0.5) * step_s);
        let mean = (0..steps).map(middle).sum::<Vector3<f64>>() / f64::from(steps);
        // The midpoint rule is off by step²/24 of the curvature: (4e-5 · 2π 1.5)²/24 = 6e-9.
        assert!((filter.mean(from_s, to_s) - mean).norm() < 1e-8 * SINE.0);
    }
}
