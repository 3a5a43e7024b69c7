//! Motion at any instant: cubic Hermite polynomials of body rate and wheel speeds between points of a
//! grid, from before the first sample to after the last.
//!
//! ```text
//! x(t₀ + s) = x₀ + ẋ₀ s + (3 Δ − 2 ẋ₀ − ẋ₁) s²/h + (ẋ₀ + ẋ₁ − 2 Δ) s³/h²,   Δ = (x₁ − x₀)/h
//! ```
//!
//! with both ends from the equation of motion. A sine of frequency `f` has an error of `(2π f h)⁴/384`
//! of its amplitude: 4e-8 at 0.5 Hz, 1e-5 at 2 Hz. Grid points lie on every kink of a torque and
//! sudden change of the inertia.
//!
//! The motion before the start of the flight follows from the equations of motion in reversed time.

use nalgebra::Vector3;

use super::flight::{advance_past_kinks, kinks_s};
use super::integrate::{Equations, IntegrationFailed, advance};
use super::spacecraft::Spacecraft;
use crate::input::craft::hardware::{Tachometer, TachometerKind};
use crate::input::scenario::Scenario;

/// Largest distance of two grid points, s.
const MAX_STEP_S: f64 = 0.02;
/// Largest turn of an unbalanced wheel between two grid points, rad: an error of `0.25⁴/384 = 1e-5` of
/// the vibration.
const MAX_WHEEL_TURN_RAD: f64 = 0.25;
/// Sigmas of a drawn delay that the trajectory covers.
const DELAY_SIGMAS: f64 = 6.0;
/// Time constants of the gyro's filter before the first sample: its initial error falls by e⁻⁶.
const LAG_CONSTANTS: f64 = 6.0;
/// Time before the first sample for two edges of a tachometer, s.
pub const EDGE_TIME_S: f64 = 1.0;

/// A cubic polynomial of the time since the start of its piece, by its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic<V>(pub [V; 4]);

impl<V> Cubic<V>
where
    V: Copy
        + std::ops::Add<Output = V>
        + std::ops::Sub<Output = V>
        + std::ops::Mul<f64, Output = V>,
{
    /// Polynomial with these values and slopes at both ends of a piece.
    fn hermite(duration_s: f64, value: [V; 2], slope: [V; 2]) -> Self {
        let h = duration_s;
        let delta = (value[1] - value[0]) * (1.0 / h);
        let square = (delta * 3.0 - slope[0] * 2.0 - slope[1]) * (1.0 / h);
        let cube = (slope[0] + slope[1] - delta * 2.0) * (1.0 / (h * h));
        Self([value[0], slope[0], square, cube])
    }

    /// Value at this time since the start, s.
    pub fn at(&self, s: f64) -> V {
        let [a, b, c, d] = self.0;
        a + (b + (c + d * s) * s) * s
    }

    /// Integral from the start, s times the unit of the value.
    pub fn integral(&self, s: f64) -> V {
        let [a, b, c, d] = self.0;
        (a + (b * 0.5 + (c * (1.0 / 3.0) + d * (0.25 * s)) * s) * s) * s
    }
}

/// Motion from one grid point to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Start, s.
    pub from_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Body rate, rad/s.
    pub rate_rad_s: Cubic<Vector3<f64>>,
}

/// Motion of a flight at any instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    wheels: usize,
    pieces: Vec<Piece>,
    /// Speed of each wheel in each piece, rad/s: wheel by wheel within a piece.
    speeds: Vec<Cubic<f64>>,
}

/// Values and slopes at one end of a piece.
struct End {
    rate: Vector3<f64>,
    acceleration: Vector3<f64>,
    speeds: Vec<f64>,
    speed_slopes: Vec<f64>,
}

impl End {
    fn of(craft: &Spacecraft<'_>, time_s: f64, state: &[f64]) -> Self {
        let motion = craft.motion(state);
        let (acceleration, speed_slopes) = craft.slopes(time_s, state);
        Self {
            rate: motion.rate_rad_s,
            acceleration,
            speeds: motion.wheel_speed_rad_s,
            speed_slopes,
        }
    }
}

/// Equations of motion in reversed time: `dy/ds = −f(−s, y)`.
struct Reversed<'a>(&'a Spacecraft<'a>);

impl Equations for Reversed<'_> {
    fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
        self.0.derivative(-time_s, state, derivative);
        derivative.iter_mut().for_each(|slope| *slope = -*slope);
    }
}

impl Trajectory {
    /// Trajectory of a scenario, over all instants that its sensors use.
    ///
    /// # Errors
    /// [`IntegrationFailed`] if the motion cannot be integrated.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let (before_s, after_s) = margins_s(scenario);
        let step_s = step_s(scenario);
        let mut trajectory =
            Self { wheels: scenario.wheels.len(), pieces: Vec::new(), speeds: Vec::new() };
        let mut craft = Spacecraft::new(scenario);
        let mut state = craft.initial_state();
        trajectory.add_before(&craft, &state, step_s, before_s)?;
        let kinks_s = kinks_s(scenario);
        let end_s = scenario.duration_s + after_s;
        for (index, stretch) in scenario.stretches().enumerate() {
            if index > 0 {
                let next = Spacecraft::of_stretch(scenario, &stretch);
                state = craft.becomes(&next, &state);
                craft = next;
            }
            let to_s = stretch.to_s.unwrap_or(end_s);
            let stops = stops_s(stretch.from_s, to_s, step_s, &kinks_s);
            state = trajectory.add(&craft, stretch.from_s, &stops, state)?;
        }
        Ok(trajectory)
    }

    /// Adds the pieces between the stops, the last of which is the end of the stretch.
    fn add(
        &mut self,
        craft: &Spacecraft<'_>,
        from_s: f64,
        stops_s: &[f64],
        mut state: Vec<f64>,
    ) -> Result<Vec<f64>, IntegrationFailed> {
        let mut now_s = from_s;
        for to_s in stops_s {
            let start = End::of(craft, now_s, &state);
            state = advance(craft, now_s, *to_s, state)?;
            let end = End::of(craft, to_s.next_down(), &state);
            self.push(now_s, to_s - now_s, &start, &end);
            now_s = *to_s;
        }
        Ok(state)
    }

    /// Adds the pieces before the start of the flight, oldest first.
    fn add_before(
        &mut self,
        craft: &Spacecraft<'_>,
        state: &[f64],
        step_s: f64,
        before_s: f64,
    ) -> Result<(), IntegrationFailed> {
        let steps = (before_s / step_s).ceil() as u64;
        let (mut state, mut ends) = (state.to_vec(), vec![End::of(craft, 0.0, state)]);
        for k in 0..steps {
            let (from_s, to_s) = (k as f64 * step_s, (k + 1) as f64 * step_s);
            state = advance_past_kinks(&Reversed(craft), &[], from_s, to_s, state)?;
            ends.push(End::of(craft, -to_s, &state));
        }
        for k in (0..ends.len() - 1).rev() {
            let from_s = -((k + 1) as f64) * step_s;
            self.push(from_s, step_s, &ends[k + 1], &ends[k]);
        }
        Ok(())
    }

    fn push(&mut self, from_s: f64, duration_s: f64, start: &End, end: &End) {
        let slopes = [start.acceleration, end.acceleration];
        let rate_rad_s = Cubic::hermite(duration_s, [start.rate, end.rate], slopes);
        self.pieces.push(Piece { from_s, duration_s, rate_rad_s });
        for i in 0..self.wheels {
            let speeds = [start.speeds[i], end.speeds[i]];
            let slopes = [start.speed_slopes[i], end.speed_slopes[i]];
            self.speeds.push(Cubic::hermite(duration_s, speeds, slopes));
        }
    }

    /// The pieces, oldest first.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Number of wheels.
    pub fn wheels(&self) -> usize {
        self.wheels
    }

    /// Speed of a wheel within a piece, rad/s.
    pub fn speed_rad_s(&self, piece: usize, wheel: usize) -> &Cubic<f64> {
        &self.speeds[piece * self.wheels + wheel]
    }

    /// Index of the piece at a time, and the time since its start, s. Times outside the trajectory
    /// belong to its first and last piece.
    pub fn locate(&self, time_s: f64) -> (usize, f64) {
        let begun = self.pieces.partition_point(|piece| piece.from_s <= time_s);
        let index = begun.saturating_sub(1);
        (index, time_s - self.pieces[index].from_s)
    }
}

/// Ends of the pieces of a stretch: multiples of the step and kinks of a torque, ascending, s.
fn stops_s(from_s: f64, to_s: f64, step_s: f64, kinks_s: &[f64]) -> Vec<f64> {
    let first = (from_s / step_s).floor() as u64 + 1;
    let last = (to_s / step_s).ceil() as u64;
    let grid = (first..last).map(|k| k as f64 * step_s);
    let inside = |stop_s: &f64| from_s < *stop_s && *stop_s < to_s;
    let mut stops_s: Vec<f64> = grid.chain(kinks_s.iter().copied()).filter(inside).collect();
    stops_s.push(to_s);
    stops_s.sort_by(f64::total_cmp);
    stops_s.dedup();
    stops_s
}

/// Distance of two grid points: a whole fraction of the sample period, at most [`MAX_STEP_S`], s.
fn step_s(scenario: &Scenario) -> f64 {
    let period_s = 1.0 / scenario.gyro.rate_hz;
    let mut most_s = MAX_STEP_S;
    if scenario.true_hardware.has_imbalance() {
        let fastest = scenario.wheels.iter().map(|wheel| wheel.speed_rad_s.abs());
        most_s = most_s.min(MAX_WHEEL_TURN_RAD / fastest.fold(1.0, f64::max));
    }
    period_s / (period_s / most_s).ceil()
}

/// Time before the first sample and after the last that the sensors of any run use, s.
fn margins_s(scenario: &Scenario) -> (f64, f64) {
    let period_s = 1.0 / scenario.gyro.rate_hz;
    let (stated, hardware) = (&scenario.hardware, &scenario.true_hardware);
    let delay_s = stated.gyro_delay_s.abs()
        + DELAY_SIGMAS * stated.gyro_delay_sigma_s
        + hardware.gyro.delay_s.abs();
    let clock = &hardware.clock;
    let drift_s = clock.drift.abs() * scenario.duration_s;
    let reach_s = |tachometer: Tachometer| {
        let window_s = match tachometer.kind {
            TachometerKind::Count { window_s } => window_s.unwrap_or(period_s),
            TachometerKind::Period { .. } => EDGE_TIME_S,
            TachometerKind::Speed | TachometerKind::Mean => period_s,
        };
        period_s.max(window_s) + tachometer.latency_s
    };
    let before_s = scenario.tachometers().map(reach_s).fold(period_s, f64::max);
    let filter_s = LAG_CONSTANTS * hardware.gyro.lag_s;
    (delay_s + filter_s + before_s + period_s, delay_s + drift_s + period_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::Flight;

    /// Largest distance of trajectory and flight at the samples, rad/s of the body and of the wheels.
    fn distance(scenario: &Scenario) -> (f64, f64) {
        let trajectory = Trajectory::simulate(scenario).unwrap();
        let flight = Flight::simulate(scenario).unwrap();
        let (mut rate, mut speed) = (0.0f64, 0.0f64);
        for instant in &flight.instants {
            let (piece, s) = trajectory.locate(instant.time_us as f64 * 1e-6);
            let found = trajectory.pieces()[piece].rate_rad_s.at(s);
            rate = rate.max((found - instant.rate_rad_s).norm());
            for (wheel, expected) in instant.wheel_speed_rad_s.iter().enumerate() {
                let found = trajectory.speed_rad_s(piece, wheel).at(s);
                speed = speed.max((found - expected).abs());
            }
        }
        (rate, speed)
    }

    #[test]
    fn trajectory_passes_through_the_samples_of_the_flight() {
        for name in ["cubesat-pyramid", "microsat-slew", "break-off"] {
            let (rate, speed) = distance(&Scenario::load(name).unwrap());
            assert!(rate < 1e-11 && speed < 1e-7, "{name} {rate:e} {speed:e}");
        }
    }

    #[test]
    fn trajectory_between_grid_points_is_that_of_a_finer_grid() {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let coarse = Trajectory::simulate(&scenario).unwrap();
        let mut fast = scenario.clone();
        fast.gyro.rate_hz = 400.0;
        let fine = Trajectory::simulate(&fast).unwrap();
        for k in 0..2000 {
            let time_s = f64::from(k) * 0.029_3;
            let at = |trajectory: &Trajectory| {
                let (piece, s) = trajectory.locate(time_s);
                trajectory.pieces()[piece].rate_rad_s.at(s)
            };
            // The gyro noise is 1e-4 rad/s.
            assert!((at(&coarse) - at(&fine)).norm() < 1e-8, "{time_s}");
        }
    }

    #[test]
    fn motion_before_the_start_leads_to_the_start() {
        let mut scenario = Scenario::load("cubesat-pyramid").unwrap();
        scenario.hardware.gyro_delay_s = 0.5;
        let trajectory = Trajectory::simulate(&scenario).unwrap();
        assert!(trajectory.pieces()[0].from_s <= -0.6);
        // The pieces join.
        for pair in trajectory.pieces().windows(2) {
            let gap_s = pair[1].from_s - pair[0].from_s - pair[0].duration_s;
            let step = pair[1].rate_rad_s.at(0.0) - pair[0].rate_rad_s.at(pair[0].duration_s);
            assert!(gap_s.abs() < 1e-12 && step.norm() < 1e-11, "{} {step}", pair[0].from_s);
        }
    }

    #[test]
    fn cubic_has_the_values_slopes_and_integral_of_its_ends() {
        let cubic = Cubic::hermite(0.5, [1.0, 3.0], [-2.0, 4.0]);
        let slope = |s: f64| (cubic.at(s + 1e-6) - cubic.at(s - 1e-6)) / 2e-6;
        assert!((cubic.at(0.0) - 1.0).abs() < 1e-15 && (cubic.at(0.5) - 3.0).abs() < 1e-14);
        assert!((slope(0.0) + 2.0).abs() < 1e-8 && (slope(0.5) - 4.0).abs() < 1e-8);
        let expected = 0.5 * (1.0 + 3.0) / 2.0 + 0.25 * (-2.0 - 4.0) / 12.0;
        assert!((cubic.integral(0.5) - expected).abs() < 1e-15);
    }
}
