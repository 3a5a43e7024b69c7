//! Curvature: residuals in proportion to the second derivative of the rate, as an appendage, a liquid or a filter leaves
//! them.
//!
//! Input: mean rate ω of successive blocks by the model, residuals ν of the same blocks, white and of unit variance if the
//! model is right. Output: chi-square of nine degrees of freedom.
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
//! with an unknown matrix K. The part of ω̈ along ω is removed, since errors of the tensor take it up. Errors that are
//! slow and small beside the noise have little correlation from one residual to the next, and all of it with x.
//!
//! The derivative of a block's rate is that of the four blocks around it, `(ω₂ − ω₁ − ω₋₁ + ω₋₂) / 3 Δ²`. Noise of the wheels'
//! readings is part of the model's rate, and the residual of the same block contains it too.
//!
//! # Statistic
//!
//! For `A = Σ ν xᵀ` and `S = Σ x xᵀ`
//!
//! ```text
//! χ² = tr(A S⁻¹ Aᵀ)
//! ```
//!
//! is chi-square of nine degrees of freedom: the score of K = 0. Residuals of a fit have no part along the columns of its
//! unknowns. A part of x along these makes the statistic of a correct model smaller. Where the motion is weak about an axis, `S + ε tr(S)` with a small ε
//! takes the place of S, which makes the statistic smaller.

use super::whiteness::chi_square;
use crate::math::{Entries, Mat, Vec3, inverse_symmetric, scalar::Real};

/// ε: rounding of the sums in single precision over some hundred blocks.
const LEAST: f64 = 1e-5;
/// Normal variable that chance exceeds once in 11,000. The statistic changes with a fit, of which a window has eleven at
/// most: from 8 to 512 blocks, each after growth by half. One of them exceeds the limit by chance once in 1,000 windows,
/// by the sum of the probabilities.
const RARE: f64 = 3.75;
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

    /// χ² for residuals of unit variance; zero where the sums do not determine it.
    #[inline(never)]
    pub fn chi_square(&self) -> T {
        let Some(inverse) = inverse_symmetric(&with_floor(&self.of_rates)) else {
            return T::zero();
        };
        let by_rate = by_rows(&self.mixed, &inverse);
        let beside = with_floor(&self.of_curvatures) - by_rows(&by_rate, &self.mixed);
        let sums = self.with_curvatures - by_rows(&self.with_rates, &by_rate);
        let Some(inverse) = inverse_symmetric(&beside) else { return T::zero() };
        let over = by_rows(&sums, &inverse);
        let square = over.iter().zip(sums.iter()).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
        if square > T::zero() { square } else { T::zero() }
    }

    /// True where the residuals, of this variance, have no part along the curvature, beside a mean square of `explained` that
    /// lasts over all rows.
    pub fn is_white(&self, rows: u32, variance: T, explained: T) -> bool {
        let small = variance * T::lit(SMALL * SMALL) + explained;
        self.chi_square() <= chi_square::<T>(9, RARE) * variance + T::count(rows) * small
    }
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

    /// Mean and variance of chi-square of nine degrees of freedom, within four sampling errors of 400 flights.
    #[test]
    fn noise_alone_has_nine_degrees_of_freedom() {
        let all: Vec<f32> = (0..400).map(|seed| of(seed, 0.0, 0.0).chi_square()).collect();
        let mean = all.iter().sum::<f32>() / 400.0;
        let variance = all.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / 400.0;
        assert!((mean - 9.0).abs() < 4.0 * (18.0f32 / 400.0).sqrt(), "{mean}");
        // The variance of 2 · 9 has a sampling error of √(2/n + κ/n) with the excess kurtosis κ = 12/9.
        assert!((variance - 18.0).abs() < 4.0 * 18.0 * (3.33f32 / 400.0).sqrt(), "{variance}");
    }

    /// An effect of half the noise, seen in 150 blocks.
    #[test]
    fn an_appendage_is_found() {
        let rows = 3 * BLOCKS as u32;
        let root_mean_square = 0.02 * 1.1 * 1.1 * 0.7;
        let found =
            |gain| (0..50).filter(|seed| !of(*seed, gain, 0.0).is_white(rows, 1.0, 0.0)).count();
        assert_eq!(found(0.0), 0);
        assert!(found(0.5 / root_mean_square) >= 48);
    }

    /// Noise of wheels as large as that of the gyro doubles the variance, and adds no correlation.
    #[test]
    fn noise_of_wheels_is_no_curvature() {
        let mean = (0..400).map(|seed| of(seed, 0.0, 1.0).chi_square()).sum::<f32>() / 400.0;
        assert!((mean - 18.0).abs() < 4.0 * 2.0 * (18.0f32 / 400.0).sqrt(), "{mean}");
    }

    /// Blocks after a fit, whose residuals follow the curvature, leave the statistic as it was.
    #[test]
    fn blocks_after_a_fit_are_not_counted() {
        let mut sums = of(0, 0.0, 0.0);
        let before = sums.chi_square();
        sums.end();
        for k in 1..=BLOCKS {
            let apart = rate(k + 1) + rate(k - 1) - rate(k) * 2.0;
            sums.add(&rate(k), PERIOD_S, &(apart * 1e3));
        }
        assert_eq!(sums.chi_square(), before);
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
        assert!(one_axis.chi_square().is_finite() && one_axis.is_white(300, 1.0, 0.0));
        assert_eq!((unequal.chi_square(), rest.chi_square()), (0.0, 0.0));
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
            sums.is_white(3 * BLOCKS as u32, unit * unit, 0.0)
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
