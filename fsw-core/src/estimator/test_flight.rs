//! Short noise-free flight for the tests of the estimators.
//!
//! Truth is integrated in double precision with [`runge_kutta_4`] at a twentieth of the sample
//! period, and rounded to single precision.

use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::DriveHistory;
use crate::dynamics::step::runge_kutta_4;
use crate::dynamics::wheels::WheelArray;
use crate::math::Vec3;
use crate::sample::Sample;
use crate::tensor::Inertia;
use std::vec::Vec;

/// Integration steps per sample: the integration error is then below single precision.
const STEPS_PER_SAMPLE: u64 = 20;

/// Body, wheels and sampling of a flight.
pub struct TestFlight<const W: usize> {
    /// Elements of the true inertia, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Rate at the first sample, rad/s.
    pub initial_rate_rad_s: Vec3<f64>,
    /// Wheels.
    pub wheels: WheelArray<f64, W>,
    /// Sample period, µs; a multiple of twenty.
    pub period_us: u64,
    /// Number of samples.
    pub samples: u64,
}

impl<const W: usize> TestFlight<W> {
    /// Samples in single precision, for wheel speeds (rad/s) and external torque (N m, body axes)
    /// as functions of time, s.
    pub fn fly(
        &self,
        wheel_speed_rad_s: impl Fn(f64) -> [f64; W],
        torque_n_m: impl Fn(f64) -> Vec3<f64>,
    ) -> Vec<Sample<f32, W>> {
        let body = Gyrostat::new(&Inertia::new(self.inertia_kg_m2)).unwrap();
        let mut drive = DriveHistory::default();
        let (mut rate_rad_s, mut samples) = (self.initial_rate_rad_s, Vec::new());
        let step_us = self.period_us / STEPS_PER_SAMPLE;
        for k in 0..self.samples * STEPS_PER_SAMPLE {
            let time_us = k * step_us;
            let t = time_us as f64 * 1e-6;
            let (speed, torque) = (wheel_speed_rad_s(t), torque_n_m(t));
            let exact = Sample {
                time_us,
                rate_rad_s,
                wheel_speed_rad_s: speed,
                torque_n_m: torque,
                attitude: None,
            };
            let interval = drive.advance(exact.drive(&self.wheels), step_us as f64 * 1e-6);
            if k > 0 {
                rate_rad_s = runge_kutta_4(&body, &rate_rad_s, &interval);
            }
            if k % STEPS_PER_SAMPLE == 0 {
                samples.push(Sample {
                    time_us,
                    rate_rad_s: rate_rad_s.map(|x| x as f32),
                    wheel_speed_rad_s: speed.map(|x| x as f32),
                    torque_n_m: torque.map(|x| x as f32),
                    attitude: None,
                });
            }
        }
        samples
    }
}

/// Torque, N m, that makes all six elements of a body of 1 to 2 kg m² observable within a minute.
pub fn tumbling_torque_n_m(t: f64) -> Vec3<f64> {
    Vec3::new(0.02 * (0.9 * t).sin(), 0.03 * (0.6 * t).cos(), 0.02 * (0.4 * t + 1.0).sin())
}
