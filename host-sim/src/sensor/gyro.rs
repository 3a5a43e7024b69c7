//! Rate gyro: white noise, constant bias, bias random walk, quantisation, range, and the errors of
//! [`gyro_errors`](super::gyro_errors).
//!
//! ```text
//! bₖ = bₖ₋₁ + σ_b √(tₖ − tₖ₋₁) ηₖ,   b₀ = bias
//! zₖ = clamp(q · round((ωₖ + bₖ + σ νₖ) / q), ±range)
//! ```
//!
//! with `ω` the true body rate, `σ` the noise per sample and `q` the quantum, rad/s; `σ_b` the bias
//! random walk, rad/s/√s; `ν` and `η` independent standard normal variables per axis.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::gyro_errors::ErrorProcess;
use crate::input::scenario::SimulatedGyro;
use crate::input::scenario::hardware::GyroErrors;

/// Gyro with its own random generator: a seed gives the same noise on every machine.
pub struct Gyro {
    model: SimulatedGyro,
    bias_rad_s: Vector3<f64>,
    errors: ErrorProcess,
    last_time_us: Option<u64>,
    random: Pcg64,
}

impl Gyro {
    /// Gyro of this model, at its initial bias.
    pub fn new(model: &SimulatedGyro, seed: u64) -> Self {
        Self::with_errors(model, &GyroErrors::default(), seed)
    }

    /// Gyro of this model with these errors, at its initial bias. Delay, filter and averaging are those
    /// of the rate that it reads: see [`rate_filter`](super::rate_filter).
    pub fn with_errors(model: &SimulatedGyro, errors: &GyroErrors, seed: u64) -> Self {
        Self {
            bias_rad_s: model.bias_rad_s,
            model: model.clone(),
            errors: ErrorProcess::new(errors, model.noise_rad_s, seed),
            last_time_us: None,
            random: Pcg64::seed_from_u64(seed),
        }
    }

    /// Reading at this time for the true body rate `rate_rad_s`, rad/s. Times ascend.
    pub fn read(&mut self, time_us: u64, rate_rad_s: &Vector3<f64>) -> Vector3<f64> {
        let mut elapsed_s = 0.0;
        if let Some(last) = self.last_time_us.replace(time_us) {
            elapsed_s = time_us.saturating_sub(last) as f64 * 1e-6;
            if self.model.bias_walk_rad_s_sqrt_s > 0.0 {
                let step = self.model.bias_walk_rad_s_sqrt_s * elapsed_s.sqrt();
                let walked = self.normal() * step;
                self.bias_rad_s += walked;
            }
        }
        let white = self.normal() * self.model.noise_rad_s;
        let noise = self.errors.noise(white);
        let mut reading = self.errors.misaligned(rate_rad_s) + self.bias_rad_s + noise;
        if let Some(excess) = self.errors.excess(elapsed_s) {
            reading += excess;
        }
        reading.map(|x| self.digitise(x))
    }

    fn digitise(&self, rate_rad_s: f64) -> f64 {
        let quantised = match self.model.quantum_rad_s {
            Some(quantum) => (rate_rad_s / quantum).round() * quantum,
            None => rate_rad_s,
        };
        match self.model.range_rad_s {
            Some(range) => quantised.clamp(-range, range),
            None => quantised,
        }
    }

    fn normal(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| StandardNormal.sample(&mut self.random))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> SimulatedGyro {
        SimulatedGyro {
            rate_hz: 10.0,
            noise_rad_s: 1e-3,
            bias_rad_s: Vector3::new(0.1, 0.0, -0.2),
            quantum_rad_s: None,
            range_rad_s: None,
            bias_walk_rad_s_sqrt_s: 0.0,
        }
    }

    fn readings(model: &SimulatedGyro, seed: u64) -> Vec<Vector3<f64>> {
        let mut gyro = Gyro::new(model, seed);
        (0..10_000).map(|k| gyro.read(k * 100_000, &Vector3::zeros())).collect()
    }

    #[test]
    fn noise_and_bias_match_the_model() {
        let z = readings(&model(), 1);
        let mean = z.iter().sum::<Vector3<f64>>() / z.len() as f64;
        let variance =
            z.iter().map(|x| (x - mean).component_mul(&(x - mean))).sum::<Vector3<f64>>()
                / z.len() as f64;
        // Five sigma of a mean and of a variance over 10,000 readings.
        assert!((mean - model().bias_rad_s).abs().max() < 5.0 * 1e-3 / 100.0);
        assert!((variance / 1e-6 - Vector3::repeat(1.0)).abs().max() < 5.0 * (2.0f64 / 1e4).sqrt());
    }

    #[test]
    fn equal_seeds_give_equal_noise() {
        assert_eq!(readings(&model(), 7), readings(&model(), 7));
        assert_ne!(readings(&model(), 7), readings(&model(), 8));
    }

    #[test]
    fn readings_are_whole_counts_within_the_range() {
        let quantum = 2e-3;
        let m = SimulatedGyro { quantum_rad_s: Some(quantum), range_rad_s: Some(0.1), ..model() };
        for x in readings(&m, 1).iter().flatten() {
            let counts = x / quantum;
            assert!((counts - counts.round()).abs() < 1e-9 && x.abs() <= 0.1);
        }
    }

    #[test]
    fn bias_walk_grows_with_the_square_root_of_time() {
        let m = SimulatedGyro { noise_rad_s: 0.0, bias_walk_rad_s_sqrt_s: 1e-3, ..model() };
        let ends = (0..2000).map(|seed| {
            let mut gyro = Gyro::new(&m, seed);
            gyro.read(0, &Vector3::zeros());
            gyro.read(4_000_000, &Vector3::zeros()).x - 0.1
        });
        let spread = (ends.map(|x| x * x).sum::<f64>() / 2000.0).sqrt();
        // One step of 4 s: 2e-3, within five sigma of an estimate from 2,000.
        assert!((spread / 2e-3 - 1.0).abs() < 5.0 / 4000.0f64.sqrt());
    }
}
