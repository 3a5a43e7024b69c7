//! Errors of a rate gyro beyond white noise and bias: axes, flicker, coloured noise, outliers.
//!
//! ```text
//! zₖ = M ωₖ + cₖ + nₖ + oₖ
//! ```
//!
//! - `M = 1 + E`: scale and misalignment (see [`flight_input::craft::hardware`]).
//! - `c`, flicker of Allan deviation `B`: a sum of first-order Gauss-Markov processes whose time
//!   constants have the ratio `r = √10`. Each of variance `s²` and time constant `τ` has the one-sided
//!   spectral density `4 s² τ/(1 + (2π f τ)²)`; over all `τ` the sum is `s²/(f ln r)`. A density of
//!   `h/f` has the Allan variance `2 ln 2 h` (IEEE Std 952-1997, annex C), hence `s² = B² ln r/(2 ln 2)`.
//! - `n`, noise: `nₖ = ρ nₖ₋₁ + √(1 − ρ²) σ νₖ`, of standard deviation `σ` for any correlation `ρ`.
//! - `o`, outliers: on each axis with the probability of `outlier_share`, uniform in size, of either
//!   sign.

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::input::scenario::hardware::GyroErrors;

/// Offset into the random sequence of a seed, beyond the parts that noise, initial estimate and
/// hardware use: the white noise of a seed is the same whichever errors are present.
const ERRORS_OFFSET: u128 = 3 << 64;
/// Shortest time constant of the flicker, s: below the shortest time of a flat Allan deviation, 0.3 s.
const SHORTEST_S: f64 = 0.1;
/// Number of processes: up to 1000 s.
const PROCESSES: usize = 9;

/// Errors with their own random generator.
pub struct ErrorProcess {
    errors: GyroErrors,
    /// `M`; none if it is the identity.
    matrix: Option<Matrix3<f64>>,
    /// Stated noise, one sigma, rad/s: unit of outliers.
    noise_rad_s: f64,
    flicker: Option<[Vector3<f64>; PROCESSES]>,
    noise: Option<Vector3<f64>>,
    random: Pcg64,
}

impl ErrorProcess {
    /// Errors of a gyro of this stated noise, rad/s. The flicker starts in its stationary state.
    pub fn new(errors: &GyroErrors, noise_rad_s: f64, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        random.advance(ERRORS_OFFSET);
        let ideal = GyroErrors::default();
        let is_aligned = errors.scale == ideal.scale && errors.axes_rad == ideal.axes_rad;
        let mut process = Self {
            errors: errors.clone(),
            matrix: (!is_aligned).then(|| errors.matrix()),
            noise_rad_s,
            flicker: None,
            noise: None,
            random,
        };
        if errors.flicker_rad_s > 0.0 {
            process.flicker = Some(std::array::from_fn(|_| process.normal()));
        }
        process
    }

    /// Rate in the gyro's axes, `M ω`, rad/s.
    pub fn misaligned(&self, rate_rad_s: &Vector3<f64>) -> Vector3<f64> {
        self.matrix.map_or(*rate_rad_s, |matrix| matrix * rate_rad_s)
    }

    /// Noise of the next sample from its white noise, both rad/s.
    pub fn noise(&mut self, white_rad_s: Vector3<f64>) -> Vector3<f64> {
        let correlation = self.errors.noise_correlation;
        let scaled = white_rad_s * self.errors.noise_factor;
        let noise = match self.noise {
            Some(last) if correlation > 0.0 => {
                last * correlation + scaled * (1.0 - correlation * correlation).sqrt()
            }
            _ => scaled,
        };
        self.noise = Some(noise);
        noise
    }

    /// Flicker and outliers of the next sample, `elapsed_s` seconds after the last, rad/s; none without
    /// either.
    pub fn excess(&mut self, elapsed_s: f64) -> Option<Vector3<f64>> {
        let flicker = self.next_flicker(elapsed_s);
        let outliers = (self.errors.outlier_share > 0.0).then(|| self.next_outliers());
        match (flicker, outliers) {
            (None, None) => None,
            (flicker, outliers) => Some(flicker.unwrap_or_default() + outliers.unwrap_or_default()),
        }
    }

    fn next_flicker(&mut self, elapsed_s: f64) -> Option<Vector3<f64>> {
        let mut processes = self.flicker?;
        let ratio = 10f64.sqrt();
        let mut time_constant_s = SHORTEST_S;
        for process in &mut processes {
            let kept = (-elapsed_s / time_constant_s).exp();
            let innovation = self.normal();
            *process = *process * kept + innovation * (1.0 - kept * kept).sqrt();
            time_constant_s *= ratio;
        }
        self.flicker = Some(processes);
        let sigma = self.errors.flicker_rad_s * (ratio.ln() / (2.0 * 2f64.ln())).sqrt();
        Some(processes.iter().sum::<Vector3<f64>>() * sigma)
    }

    fn next_outliers(&mut self) -> Vector3<f64> {
        let [least, most] = self.errors.outlier_sigma;
        Vector3::from_fn(|_, _| {
            let [hit, size, sign]: [f64; 3] = std::array::from_fn(|_| self.random.random());
            if hit >= self.errors.outlier_share {
                return 0.0;
            }
            let sigmas = least + (most - least) * size;
            if sign < 0.5 { -sigmas * self.noise_rad_s } else { sigmas * self.noise_rad_s }
        })
    }

    fn normal(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| StandardNormal.sample(&mut self.random))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time between samples, s.
    const PERIOD_S: f64 = 0.1;

    fn excess(errors: &GyroErrors, samples: usize) -> Vec<Vector3<f64>> {
        let mut process = ErrorProcess::new(errors, 1e-3, 5);
        (0..samples).map(|_| process.excess(PERIOD_S).unwrap()).collect()
    }

    /// Allan deviation of a record over clusters of this many samples, mean over the axes.
    fn allan_deviation(record: &[Vector3<f64>], cluster: usize) -> f64 {
        let means: Vec<Vector3<f64>> = record
            .chunks_exact(cluster)
            .map(|samples| samples.iter().sum::<Vector3<f64>>() / cluster as f64)
            .collect();
        let squares = means.windows(2).map(|pair| (pair[1] - pair[0]).norm_squared());
        (squares.sum::<f64>() / (2.0 * 3.0 * (means.len() - 1) as f64)).sqrt()
    }

    #[test]
    fn allan_deviation_of_flicker_is_flat() {
        let errors = GyroErrors { flicker_rad_s: 1e-4, ..GyroErrors::default() };
        let record = excess(&errors, 400_000);
        for cluster in [5, 10, 30, 100, 300, 1000] {
            let ratio = allan_deviation(&record, cluster) / 1e-4;
            // 133 clusters of 100 s per axis: 5 sigma of their Allan deviation are 18 %.
            assert!((0.82..1.18).contains(&ratio), "{cluster}: {ratio}");
        }
    }

    #[test]
    fn coloured_noise_keeps_its_variance_and_has_its_correlation() {
        let errors =
            GyroErrors { noise_correlation: 0.7, noise_factor: 2.0, ..GyroErrors::default() };
        let mut process = ErrorProcess::new(&errors, 1e-3, 5);
        let mut random = Pcg64::seed_from_u64(9);
        let mut white =
            || Vector3::from_fn(|_, _| 1e-3 * f64::from(random.random_range(-1i32..=1)));
        let record: Vec<f64> = (0..100_000).map(|_| process.noise(white()).x).collect();
        let variance = record.iter().map(|x| x * x).sum::<f64>() / 1e5;
        let product = record.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 1e5;
        // The white input has the variance 2/3 · 1e-6, the noise four times as much.
        assert!((variance / (4.0 * 2.0 / 3.0 * 1e-6) - 1.0).abs() < 0.03, "{variance}");
        assert!((product / variance - 0.7).abs() < 0.02, "{}", product / variance);
    }

    #[test]
    fn outliers_have_their_share_size_and_both_signs() {
        let errors =
            GyroErrors { outlier_share: 0.01, outlier_sigma: [3.0, 6.0], ..GyroErrors::default() };
        let record = excess(&errors, 100_000);
        let hits: Vec<f64> = record.iter().flatten().copied().filter(|x| *x != 0.0).collect();
        assert!(hits.iter().all(|x| (2.999e-3..6.001e-3).contains(&x.abs())));
        // 3,000 expected, standard deviation 55; half of them positive.
        assert!((2_750..3_250).contains(&hits.len()), "{}", hits.len());
        let positive = hits.iter().filter(|x| **x > 0.0).count();
        assert!((1_300..1_700).contains(&positive), "{positive}");
    }

    #[test]
    fn axes_of_the_gyro_are_those_of_its_matrix() {
        let errors = GyroErrors {
            scale: Vector3::new(0.01, -0.02, 0.03),
            axes_rad: [1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3],
            ..GyroErrors::default()
        };
        let process = ErrorProcess::new(&errors, 1e-3, 5);
        let seen = process.misaligned(&Vector3::new(0.1, 0.2, 0.3));
        let expected = Vector3::new(
            1.01 * 0.1 + 1e-3 * 0.2 + 2e-3 * 0.3,
            3e-3 * 0.1 + 0.98 * 0.2 + 4e-3 * 0.3,
            5e-3 * 0.1 + 6e-3 * 0.2 + 1.03 * 0.3,
        );
        assert!((seen - expected).norm() < 1e-16);
        let ideal = ErrorProcess::new(&GyroErrors::default(), 1e-3, 5);
        assert_eq!(ideal.misaligned(&expected), expected);
    }
}
