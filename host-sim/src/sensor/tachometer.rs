//! Tachometer: wheel speed as instantaneous value, mean, edge count or edge period, with latency,
//! rounding, hold and noise.
//!
//! With the angle `θ` of a wheel, the angle `δ = 2π/n` between two edges, and the true time `t` of a
//! sample less the latency:
//!
//! | principle | reading |
//! |---|---|
//! | speed | `θ̇(t)` |
//! | mean | `(θ(t) − θ(t − T))/T`, sample period `T` |
//! | count | `δ (⌊θ(t)/δ⌋ − ⌊θ(t − W)/δ⌋)/W`, window `W` |
//! | period | `± δ/(t₂ − t₁)` of the last two edges, times rounded to the timer's resolution |
//!
//! Assumption of the period: the wheel does not reverse between the two edges. Without two edges within
//! [`EDGE_TIME_S`] the reading is zero.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::input::craft::hardware::{Tachometer, TachometerKind};
use crate::truth::Trajectory;
use crate::truth::trajectory::EDGE_TIME_S;

/// Offset into the random sequence of a seed, beyond the parts that gyro, initial estimate and hardware
/// use.
const TACHOMETER_OFFSET: u128 = 4 << 64;
/// Bisections for the time of an edge: 2⁻⁴⁰ s is far below any timer's resolution.
const BISECTIONS: usize = 40;

/// Angles of the wheels along a trajectory.
pub struct Angles<'a> {
    trajectory: &'a Trajectory,
    /// Angle of each wheel at the start of each piece, rad: wheel by wheel within a piece.
    start_rad: Vec<f64>,
}

impl<'a> Angles<'a> {
    /// Angles from zero at the start of the trajectory.
    pub fn new(trajectory: &'a Trajectory) -> Self {
        let wheels = trajectory.wheels();
        let mut angles = vec![0.0; wheels];
        let mut start_rad = Vec::with_capacity(wheels * trajectory.pieces().len());
        for (index, piece) in trajectory.pieces().iter().enumerate() {
            start_rad.extend_from_slice(&angles);
            for (wheel, angle) in angles.iter_mut().enumerate() {
                *angle += trajectory.speed_rad_s(index, wheel).integral(piece.duration_s);
            }
        }
        Self { trajectory, start_rad }
    }

    fn speed_rad_s(&self, wheel: usize, time_s: f64) -> f64 {
        let (piece, s) = self.trajectory.locate(time_s);
        self.trajectory.speed_rad_s(piece, wheel).at(s)
    }

    fn angle_rad(&self, wheel: usize, time_s: f64) -> f64 {
        let (piece, s) = self.trajectory.locate(time_s);
        let turned = self.trajectory.speed_rad_s(piece, wheel).integral(s);
        self.start_rad[piece * self.trajectory.wheels() + wheel] + turned
    }

    /// Time at which a wheel passed an angle, within [`EDGE_TIME_S`] before `until_s`, s; none if it
    /// did not.
    fn passing_s(&self, wheel: usize, angle_rad: f64, until_s: f64) -> Option<f64> {
        let (mut before_s, mut after_s) = (until_s - EDGE_TIME_S, until_s);
        let is_beyond = |time_s: f64| self.angle_rad(wheel, time_s) > angle_rad;
        let end = is_beyond(after_s);
        if is_beyond(before_s) == end {
            return None;
        }
        for _ in 0..BISECTIONS {
            let middle_s = 0.5 * (before_s + after_s);
            if is_beyond(middle_s) == end {
                after_s = middle_s;
            } else {
                before_s = middle_s;
            }
        }
        Some(after_s)
    }
}

/// Tachometers of all wheels, with their own random generator.
pub struct Tachometers {
    of_wheels: Vec<Tachometer>,
    period_s: f64,
    /// Angle of each wheel from its last edge at the start, rad.
    offset_rad: Vec<f64>,
    sample: u64,
    held_rad_s: Vec<f64>,
    random: Pcg64,
}

impl Tachometers {
    /// The tachometer of each wheel, read with this period, s.
    pub fn new(of_wheels: Vec<Tachometer>, period_s: f64, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        random.advance(TACHOMETER_OFFSET);
        let offset_rad =
            of_wheels.iter().map(|it| it.edge_rad() * random.random::<f64>()).collect();
        let held_rad_s = vec![0.0; of_wheels.len()];
        Self { of_wheels, period_s, offset_rad, sample: 0, held_rad_s, random }
    }

    /// Readings of the next sample, rad/s, from the true speeds at its time. With a trajectory, the
    /// speeds are those of the measuring principle at the true time of the sample, s.
    pub fn read(&mut self, true_rad_s: &[f64], along: Option<(&Angles<'_>, f64)>) -> Vec<f64> {
        for (wheel, true_rad_s) in true_rad_s.iter().enumerate() {
            let tachometer = self.of_wheels[wheel];
            let held_samples = ((tachometer.hold_s / self.period_s).round() as u64).max(1);
            if self.sample.is_multiple_of(held_samples) {
                let measured = match along {
                    Some((angles, time_s)) => {
                        self.measure(angles, wheel, time_s - tachometer.latency_s)
                    }
                    None => *true_rad_s,
                };
                self.held_rad_s[wheel] = self.digitise(&tachometer, measured);
            }
        }
        self.sample += 1;
        self.held_rad_s.clone()
    }

    fn measure(&self, angles: &Angles<'_>, wheel: usize, time_s: f64) -> f64 {
        let edge_rad = self.of_wheels[wheel].edge_rad();
        match self.of_wheels[wheel].kind {
            TachometerKind::Speed => angles.speed_rad_s(wheel, time_s),
            TachometerKind::Mean => {
                let turned = angles.angle_rad(wheel, time_s)
                    - angles.angle_rad(wheel, time_s - self.period_s);
                turned / self.period_s
            }
            TachometerKind::Count { window_s } => {
                let window_s = window_s.unwrap_or(self.period_s);
                let edges = |time_s: f64| {
                    let angle = angles.angle_rad(wheel, time_s) + self.offset_rad[wheel];
                    (angle / edge_rad).floor()
                };
                (edges(time_s) - edges(time_s - window_s)) * edge_rad / window_s
            }
            TachometerKind::Period { resolution_s } => {
                self.of_period(angles, wheel, time_s, resolution_s).unwrap_or(0.0)
            }
        }
    }

    fn of_period(
        &self,
        angles: &Angles<'_>,
        wheel: usize,
        time_s: f64,
        resolution_s: f64,
    ) -> Option<f64> {
        let direction = angles.speed_rad_s(wheel, time_s).signum();
        let (edge_rad, offset_rad) = (self.of_wheels[wheel].edge_rad(), self.offset_rad[wheel]);
        let passed =
            (direction * (angles.angle_rad(wheel, time_s) + offset_rad) / edge_rad).floor();
        let edge = |number: f64| {
            let angle_rad = direction * number * edge_rad - offset_rad;
            let passing_s = angles.passing_s(wheel, angle_rad, time_s)?;
            Some((passing_s / resolution_s).round() * resolution_s)
        };
        let between_s = edge(passed)? - edge(passed - 1.0)?;
        (between_s > 0.0).then(|| direction * edge_rad / between_s)
    }

    fn digitise(&mut self, tachometer: &Tachometer, speed_rad_s: f64) -> f64 {
        let Tachometer { quantum_rad_s, noise_rad_s, .. } = *tachometer;
        let mut reading = speed_rad_s;
        if noise_rad_s > 0.0 {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            reading += noise_rad_s * normal;
        }
        if quantum_rad_s > 0.0 {
            reading = (reading / quantum_rad_s).round() * quantum_rad_s;
        }
        reading
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::path::Path;

    use super::*;
    use crate::input::Scenario;

    /// A wheel that speeds up from 200 rad/s by 3 rad/s², in a body so heavy that it stays at rest.
    fn accelerating() -> Trajectory {
        let text = "name = 'wheel'\nduration_s = 20\n[spacecraft]\n\
                    inertia_kg_m2 = [1e9, 1e9, 1e9, 0, 0, 0]\n[gyro]\nrate_hz = 10\n\
                    noise_rad_s = 1e-4\n[[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1e-3\n\
                    speed_rad_s = 200\ntorque = { kind = 'constant', value_n_m = 3e-3 }\n\
                    [hardware.tachometer]\nkind = 'period'\n";
        let scenario = Scenario::from_toml("s.toml", text, Path::new("")).unwrap();
        Trajectory::simulate(&scenario).unwrap()
    }

    fn speed(time_s: f64) -> f64 {
        200.0 + 3.0 * time_s
    }

    /// Reading less true speed at these times.
    fn errors(errors: Tachometer, late_s: f64) -> Vec<f64> {
        let trajectory = accelerating();
        let angles = Angles::new(&trajectory);
        let mut tachometers = Tachometers::new(vec![errors], 0.1, 3);
        (0..100u64)
            .map(|k| {
                let time_s = k as f64 * 0.1;
                tachometers.read(&[0.0], Some((&angles, time_s)))[0] - speed(time_s - late_s)
            })
            .collect()
    }

    fn largest(errors: &[f64]) -> f64 {
        errors.iter().map(|error| error.abs()).fold(0.0, f64::max)
    }

    #[test]
    fn latency_and_mean_are_late() {
        let late = Tachometer { latency_s: 0.03, ..Tachometer::default() };
        assert!(largest(&errors(late, 0.03)) < 1e-6);
        let mean = Tachometer { kind: TachometerKind::Mean, ..Tachometer::default() };
        assert!(largest(&errors(mean, 0.05)) < 1e-6);
    }

    #[test]
    fn count_is_whole_edges_of_the_window() {
        let kind = TachometerKind::Count { window_s: Some(0.5) };
        let found = errors(Tachometer { kind, ..Tachometer::default() }, 0.25);
        let edge = TAU / 6.0 / 0.5;
        // A count is off by less than one edge, and off by half of one somewhere.
        assert!(largest(&found) < edge && largest(&found) > 0.5 * edge, "{}", largest(&found));
        for (k, error) in found.iter().enumerate() {
            let counts = (error + speed(k as f64 * 0.1 - 0.25)) / edge;
            assert!((counts - counts.round()).abs() < 1e-6, "{counts}");
        }
    }

    #[test]
    fn period_is_the_mean_speed_between_two_edges() {
        let kind = TachometerKind::Period { resolution_s: 1e-6 };
        let found = errors(Tachometer { kind, ..Tachometer::default() }, 0.0);
        // An edge takes 5.2 ms: the reading is 2.6 to 7.9 ms late, 0.008 to 0.024 rad/s; the resolution
        // is 1 µs of 5.2 ms, 0.04 rad/s.
        assert!(largest(&found) < 0.07, "{}", largest(&found));
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        assert!((-0.024..-0.008).contains(&mean), "{mean}");
    }

    #[test]
    fn output_is_held_and_rounded() {
        let held = Tachometer { hold_s: 1.0, ..Tachometer::default() };
        for (k, error) in errors(held, 0.0).iter().enumerate() {
            assert!((error + 3.0 * 0.1 * (k % 10) as f64).abs() < 1e-6, "{k}: {error}");
        }
        let rounded = Tachometer { quantum_rad_s: 0.1, ..Tachometer::default() };
        let found = errors(rounded, 0.0);
        assert!(largest(&found) < 0.0501, "{}", largest(&found));
    }

    #[test]
    fn noise_has_its_sigma() {
        let noisy = Tachometer { noise_rad_s: 0.5, ..Tachometer::default() };
        let mut tachometers = Tachometers::new(vec![noisy], 0.1, 3);
        let squares = (0..10_000).map(|_| tachometers.read(&[7.0], None)[0] - 7.0);
        let variance = squares.map(|x| x * x).sum::<f64>() / 1e4;
        assert!((variance / 0.25 - 1.0).abs() < 5.0 * (2.0f64 / 1e4).sqrt(), "{variance}");
    }
}
