//! Curvature: residuals in proportion to the second derivative of the rate, as an appendage, a liquid or a filter leaves
//! them.
//!
//! Input: mean rate ω of successive blocks by the model, residuals ν of the same blocks, white and of unit variance if the
//! model is right. Output: largest normal variable over a set of appendages.
//!
//! # Model error
//!
//! An oscillator on the body with the frequency Ω and the modal inertia M, driven below its frequency, has the relative
//! momentum `−M (ω + ω̈/Ω² + …)`. The first term is part of the inertia tensor. The second one adds `J⁻¹ M ω̈ / Ω²` to the rate.
//! A low-pass filter of time constant τ subtracts `τ ω̇` and adds `τ² ω̈`: the former is a time offset. So
//!
//! ```text
//! ν = K x + white,   x = ω̈ − B ω,   B = Σ ω̈ ωᵀ (Σ ω ωᵀ)⁻¹
//! ```
//!
//! with `K = J⁻¹ M / Ω²` or `τ² 1`. The part of ω̈ along ω is removed, since errors of the tensor take it up. Errors that are
//! slow and small beside the noise have little correlation from one residual to the next, and all of it with x.
//!
//! The derivative of a block's rate is that of the four blocks around it, `(ω₂ − ω₁ − ω₋₁ + ω₋₂) / 3 Δ²`. Noise of the wheels'
//! readings is part of the model's rate, and the residual of the same block contains it too.
//!
//! # Statistic
//!
//! For `A = Σ ν xᵀ`, `S = Σ x xᵀ` and an appendage that moves along one axis, `M ∝ a aᵀ`, the score of M = 0 over its sigma is
//!
//! ```text
//! z(a) = aᵀ J⁻¹ A a / √(|J⁻¹ a|² · aᵀ S a)
//! ```
//!
//! The statistic is the largest |z| of thirteen axes, the faces, edges and corners of a cube, at most 27° from any axis, and
//! of `K ∝ 1`: `tr A / √tr S`. z is negative for a motion above the frequency of the mode. All nine elements of K as unknowns
//! would have a limit of 5.8 for the same chance (chi-square of nine degrees of freedom), where z has 4.6.
//!
//! Residuals of a fit have no part along the columns of its unknowns. A part of x along these makes the statistic of a
//! correct model smaller. Where the motion is weak about an axis, `S + ε tr(S)` with a small ε takes the place of S, which
//! makes it smaller too.

use crate::math::{Entries, Mat, Vec3, inverse_symmetric, rotated, scalar::Real};

/// ε: rounding of the sums in single precision over some hundred blocks.
const LEAST: f64 = 1e-5;
/// Largest of fourteen normal variables, either sign, that chance exceeds once in 17,000 (sum of the probabilities). The
/// statistic changes with a fit, of which a window has eleven at most: from 8 to 512 blocks, each after growth by half. One
/// of them exceeds the limit by chance once in 1,500 windows.
const LARGEST: f64 = 4.6;
/// Size of an effect that is still called white, over the noise of a block.
const SMALL: f64 = 0.03;
/// Largest difference of the durations of successive blocks, as a share.
const UNEQUAL: f64 = 0.01;

/// Sums over blocks of equal duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature<T: Real> {
    /// Rates of the last four blocks and residuals of the last two, newest first.
    rate_rad_s: [Vec3<T>; 4],
    residual: [Vec3<T>; 2],
    duration_s: T,
    /// Number of successive blocks of this duration, at most four.
    blocks: u8,
    /// True where further blocks are not added.
    has_ended: bool,
    /// `Σ ω ωᵀ`, `Σ ω̈ ωᵀ`, `Σ ω̈ ω̈ᵀ`.
    of_rates: Mat<T, 3, 3>,
    mixed: Mat<T, 3, 3>,
    of_curvatures: Mat<T, 3, 3>,
    /// `Σ ν ωᵀ`, `Σ ν ω̈ᵀ`.
    with_rates: Mat<T, 3, 3>,
    with_curvatures: Mat<T, 3, 3>,
}

crate::persist!([T: Real] Curvature<T> {
    rate_rad_s, residual, duration_s, blocks, has_ended, of_rates, mixed, of_curvatures, with_rates, with_curvatures
} if |this| this.blocks <= 4);

impl<T: Real> Curvature<T> {
    /// No blocks.
    pub fn none() -> Self {
        let (vector, matrix) = (Vec3::zeros(), Mat::zeros());
        Self {
            rate_rad_s: [vector; 4],
            residual: [vector; 2],
            duration_s: T::zero(),
            blocks: 0,
            has_ended: false,
            of_rates: matrix,
            mixed: matrix,
            of_curvatures: matrix,
            with_rates: matrix,
            with_curvatures: matrix,
        }
    }

    /// Ends the statistic with the blocks of a fit: residuals of later blocks have a part along the columns of its unknowns,
    /// until these are fitted too.
    pub fn end(&mut self) {
        self.has_ended = true;
    }

    /// Adds a block: mean rate by the model, duration and residual of each axis over its sigma.
    #[inline(never)]
    pub fn add(&mut self, rate_rad_s: &Vec3<T>, duration_s: T, residual: &Vec3<T>) {
        if self.has_ended {
            return;
        }
        let is_equal = (duration_s - self.duration_s).abs() <= duration_s * T::lit(UNEQUAL);
        let [after, rate, before, second_before] = self.rate_rad_s;
        let [of_after, of_rate] = self.residual;
        if !is_equal {
            self.blocks = 0;
        }
        if self.blocks == 4 {
            let per = T::lit(1.0 / 3.0) / (duration_s * duration_s);
            let curvature = (rate_rad_s - after - (before - second_before)) * per;
            add_product(&mut self.of_rates, &rate, &rate);
            add_product(&mut self.mixed, &curvature, &rate);
            add_product(&mut self.of_curvatures, &curvature, &curvature);
            add_product(&mut self.with_rates, &of_rate, &rate);
            add_product(&mut self.with_curvatures, &of_rate, &curvature);
        }
        self.blocks = self.blocks.saturating_add(1).min(4);
        self.rate_rad_s = [*rate_rad_s, after, rate, before];
        (self.residual, self.duration_s) = ([*residual, of_after], duration_s);
    }

    /// Largest z² for residuals of unit variance and a body of this inverse tensor, in any unit; zero where the sums do not
    /// determine it.
    #[inline(never)]
    pub fn largest_square(&self, inverse_tensor: &Mat<T, 3, 3>) -> T {
        let Some(inverse) = inverse_symmetric(&with_floor(&self.of_rates)) else {
            return T::zero();
        };
        let by_rate = by_rows(&self.mixed, &inverse);
        let beside = with_floor(&self.of_curvatures) - by_rows(&by_rate, &self.mixed);
        let sums = self.with_curvatures - by_rows(&self.with_rates, &by_rate);
        let trace = |m: &Mat<T, 3, 3>| m.at(0, 0) + m.at(1, 1) + m.at(2, 2);
        let mut largest = square_over(trace(&sums), trace(&beside));
        // Digits of base three less one: 13 is the centre of the cube, and each axis has one sign above.
        let digit = |number: u32| T::count(number % 3) - T::one();
        for number in 14..27 {
            let axis = Vec3::new(digit(number / 9), digit(number / 3), digit(number));
            let response = rotated(inverse_tensor, &axis);
            let variance = response.dot(&response) * rotated(&beside, &axis).dot(&axis);
            let score = rotated(&sums, &axis).dot(&response);
            largest = largest.max(square_over(score, variance));
        }
        largest
    }

    /// True where the residuals of a body with this inverse tensor, of this variance, have no part along the curvature, beside
    /// a mean square of `explained` that lasts over all rows.
    pub fn is_white(
        &self,
        inverse_tensor: &Mat<T, 3, 3>,
        rows: u32,
        variance: T,
        explained: T,
    ) -> bool {
        let small = variance * T::lit(SMALL * SMALL) + explained;
        let most = variance * T::lit(LARGEST * LARGEST) + T::count(rows) * small;
        self.largest_square(inverse_tensor) <= most
    }
}

/// `x² / v`, zero for a variance v that is not positive.
fn square_over<T: Real>(x: T, variance: T) -> T {
    if variance > T::zero() { x * x / variance } else { T::zero() }
}

/// `m ← m + a bᵀ`. Not inlined, as the others: one function for all sums.
#[inline(never)]
fn add_product<T: Real>(m: &mut Mat<T, 3, 3>, a: &Vec3<T>, b: &Vec3<T>) {
    for (column, b) in m.as_mut_slice().chunks_exact_mut(3).zip(b.as_slice()) {
        for (element, a) in column.iter_mut().zip(a.as_slice()) {
            *element += *a * *b;
        }
    }
}

/// `A Bᵀ`.
#[inline(never)]
fn by_rows<T: Real>(a: &Mat<T, 3, 3>, b: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    let mut product = Mat::<T, 3, 3>::zeros();
    let columns = a.as_slice().chunks_exact(3).zip(b.as_slice().chunks_exact(3));
    for (a, b) in columns {
        for (column, b) in product.as_mut_slice().chunks_exact_mut(3).zip(b) {
            for (element, a) in column.iter_mut().zip(a) {
                *element += *a * *b;
            }
        }
    }
    product
}

/// The matrix with ε of its trace added to each diagonal element.
#[inline(never)]
fn with_floor<T: Real>(m: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    let floor = (m.at(0, 0) + m.at(1, 1) + m.at(2, 2)) * T::lit(LEAST);
    let mut sum = *m;
    for i in 0..3 {
        *sum.at_mut(i, i) += floor;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::test_hardware::normal;
    use std::vec::Vec;

    const BLOCKS: usize = 150;
    const PERIOD_S: f32 = 0.4;
    /// One sigma of a residual, rad/s.
    const SIGMA_RAD_S: f32 = 1e-4;

    /// Rate about three axes with two frequencies each.
    fn rate(k: usize) -> Vec3<f32> {
        let t = k as f32 * PERIOD_S;
        Vec3::from_fn(|axis, _| {
            let a = axis as f32;
            0.05 * (t * (0.3 + 0.05 * a)).sin() + 0.02 * (t * (1.1 - 0.1 * a) + a).cos()
        })
    }

    /// Flight with an effect of the curvature on the residuals, and wheels whose noise is part of rates and residuals, over
    /// that of a residual.
    fn of(seed: u64, gain: f32, of_wheels: f32) -> Curvature<f32> {
        let mut noise = normal(seed + 1);
        let mut sums = Curvature::none();
        for k in 1..=BLOCKS {
            let apart = rate(k + 1) + rate(k - 1) - rate(k) * 2.0;
            let mut any = || Vec3::from_fn(|_, _| noise() as f32);
            let (white, wheels) = (any(), any() * of_wheels);
            let residual = white + apart * (gain / (PERIOD_S * PERIOD_S)) - wheels;
            sums.add(&(rate(k) + wheels * SIGMA_RAD_S), PERIOD_S, &residual);
        }
        sums
    }

    /// A body whose moments differ by a factor of three.
    fn inverse_tensor() -> Mat<f32, 3, 3> {
        inverse_symmetric(&Mat::from([[1.0, 0.1, 0.0], [0.1, 2.0, -0.2], [0.0, -0.2, 3.0]]))
            .unwrap()
    }

    fn largest(sums: &Curvature<f32>) -> f32 {
        sums.largest_square(&inverse_tensor()).sqrt()
    }

    /// Noise alone: 3.2 is exceeded by at most fourteen times its chance of 1.4e-3 (sum of the probabilities) and three
    /// sampling errors, and the limit by none of 400 flights.
    #[test]
    fn noise_alone_stays_below_the_limit() {
        let all: Vec<f32> = (0..400).map(|seed| largest(&of(seed, 0.0, 0.0))).collect();
        let above = all.iter().filter(|z| **z > 3.2).count();
        assert!((1..=16).contains(&above), "{above}");
        assert!(all.iter().all(|z| *z < LARGEST as f32));
        let mean = all.iter().sum::<f32>() / 400.0;
        // Of fourteen correlated normal variables: between that of one, √(2/π), and of fourteen independent ones.
        assert!((0.8..2.1).contains(&mean), "{mean}");
    }

    /// An effect of half the noise, seen in 150 blocks.
    #[test]
    fn an_appendage_is_found() {
        let rows = 3 * BLOCKS as u32;
        let root_mean_square = 0.02 * 1.1 * 1.1 * 0.7;
        let is_found = |sums: &Curvature<f32>| !sums.is_white(&inverse_tensor(), rows, 1.0, 0.0);
        let found = |gain| (0..50).filter(|seed| is_found(&of(*seed, gain, 0.0))).count();
        assert_eq!(found(0.0), 0);
        assert!(found(0.5 / root_mean_square) >= 48);
    }

    /// Appendages along axes of the set and between them, below and above the frequency of the mode: z reaches a part of the
    /// length of the effect in sigmas. What lies along the rate is taken out of x (measured: 0.72 to 0.84 are left), and between
    /// axes the square of the cosine.
    #[test]
    fn an_appendage_is_found_along_any_axis() {
        let response = inverse_tensor();
        let along = |axis: [f32; 3], gain: f32| {
            let axis = Vec3::from(axis).normalize();
            let mut noise = normal(5);
            let (mut sums, mut squares) = (Curvature::none(), 0.0);
            for k in 1..=BLOCKS {
                let x = (rate(k + 1) + rate(k - 1) - rate(k) * 2.0) / (PERIOD_S * PERIOD_S);
                let effect = response * axis * (gain * axis.dot(&x));
                squares += effect.norm_squared();
                sums.add(&rate(k), PERIOD_S, &(effect + Vec3::from_fn(|_, _| noise() as f32)));
            }
            (largest(&sums), squares.sqrt())
        };
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [0.9, 0.4, 0.2]] {
            for gain in [-2e3, 2e3] {
                let (found, whole) = along(axis, gain);
                assert!(found > 0.65 * whole && found < 1.1 * whole, "{axis:?}: {found} {whole}");
            }
        }
    }

    /// Noise of wheels as large as that of the gyro makes residuals larger by √2, and adds no correlation.
    #[test]
    fn noise_of_wheels_is_no_curvature() {
        let mean = |of_wheels: f32| {
            (0..400).map(|seed| largest(&of(seed, 0.0, of_wheels))).sum::<f32>() / 400.0
        };
        let ratio = mean(1.0) / mean(0.0);
        // The scatter of z is below 1, that of the mean of 400 below 0.05, of 1.5.
        assert!((ratio - 2f32.sqrt()).abs() < 4.0 * 2f32.sqrt() * 0.05 / 1.5, "{ratio}");
    }

    /// Blocks after a fit, whose residuals follow the curvature, leave the statistic as it was.
    #[test]
    fn blocks_after_a_fit_are_not_counted() {
        let mut sums = of(0, 0.0, 0.0);
        let before = largest(&sums);
        sums.end();
        for k in 1..=BLOCKS {
            let apart = rate(k + 1) + rate(k - 1) - rate(k) * 2.0;
            sums.add(&rate(k), PERIOD_S, &(apart * 1e3));
        }
        assert_eq!(largest(&sums), before);
    }

    /// Motion about one axis, at rest and with unequal blocks: finite, and white.
    #[test]
    fn weak_motion_has_no_statistic() {
        let mut one_axis = Curvature::<f32>::none();
        let mut unequal = Curvature::<f32>::none();
        let mut rest = Curvature::<f32>::none();
        for k in 0..100 {
            let residual = Vec3::new(1.0, -1.0, 0.5);
            one_axis.add(&Vec3::new(rate(k)[0], 0.0, 0.0), PERIOD_S, &(residual * 0.1));
            unequal.add(&rate(k), PERIOD_S * (1 + k % 2) as f32, &residual);
            rest.add(&Vec3::zeros(), PERIOD_S, &residual);
        }
        assert!(largest(&one_axis).is_finite());
        assert!(one_axis.is_white(&inverse_tensor(), 300, 1.0, 0.0));
        assert_eq!((largest(&unequal), largest(&rest)), (0.0, 0.0));
    }

    /// Residuals over another unit, of this variance: the same verdict.
    #[test]
    fn verdict_is_independent_of_the_unit_of_the_residuals() {
        let scaled = |seed: u64, gain: f32, unit: f32| {
            let mut noise = normal(seed + 1);
            let mut sums = Curvature::none();
            for k in 1..=BLOCKS {
                let apart = rate(k + 1) + rate(k - 1) - rate(k) * 2.0;
                let white = Vec3::from_fn(|_, _| noise() as f32);
                let residual = white + apart * (gain / (PERIOD_S * PERIOD_S));
                sums.add(&rate(k), PERIOD_S, &(residual * unit));
            }
            sums.is_white(&inverse_tensor(), 3 * BLOCKS as u32, unit * unit, 0.0)
        };
        for unit in [0.25, 1.0, 4.0] {
            assert!((0..20).all(|seed| scaled(seed, 0.0, unit)), "{unit}");
            assert!((0..20).all(|seed| !scaled(seed, 50.0, unit)), "{unit}");
        }
    }

    /// Second derivative of a sine of 0.5 rad/s, within 3 % for blocks of 0.1 and 0.4 s.
    #[test]
    fn curvature_is_the_second_derivative_of_the_rate() {
        for period_s in [0.1, 0.4] {
            let mut sums = Curvature::<f32>::none();
            for k in 0..1000 {
                let rate = Vec3::new(0.05 * (0.5 * k as f32 * period_s).sin(), 0.0, 0.0);
                sums.add(&rate, period_s, &Vec3::zeros());
            }
            let per_s2 = sums.mixed[(0, 0)] / sums.of_rates[(0, 0)];
            assert!((per_s2 + 0.25).abs() < 0.03 * 0.25, "{period_s}: {per_s2}");
        }
    }
}
