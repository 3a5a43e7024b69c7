//! Residuals of a fit, block by block: size, correlation, outliers, and the instant of a change.
//!
//! # Robust weights
//!
//! With `u² = n |r|² / s²` of a block's three residuals and s the typical residual, a block has the weight
//! `min(1, K² / u²)`: an influence bounded by K. s is σ, or the median of the last pass where that is
//! larger: far from the solution all residuals are large, and none of them is an outlier.
//!
//! # Watch for a change
//!
//! The squared recursive residuals of a block over their variance have a mean of 3 as long as one tensor
//! and one motion explain all blocks. Their cumulative sum `c ← max(0, c + min(u², 16) − 3 − 1)` stays low
//! then. Noise alone lifts it above h once in `exp(θ h)` blocks, with θ = 0.24 the root of
//! `E exp(θ (min(u², 16) − 4)) = 1` for chi-square of three degrees of freedom: with h = 75 once in 7·10⁷. The
//! block at which it began to rise estimates the instant of the change.

use super::curvature::Curvature;
use super::whiteness::Whiteness;
use crate::math::scalar::Real;
use crate::math::square_root_information::RecursiveResidual;

/// K: u² of three normal residuals exceeds its square by chance once in 900 blocks (chi-square).
const ROBUST: f64 = 4.0;
/// Median of chi-square with three degrees of freedom.
const MEDIAN_CHI_SQUARE: f64 = 2.366;
/// Octaves of u² in the histogram, and the first one: 2⁻⁴ to 2²⁴.
const OCTAVES: usize = 28;
const FIRST_OCTAVE: i32 = -4;
/// Share of blocks at reduced weight above which the model is wrong rather than the blocks, and number
/// that chance alone may add.
const LOW_SHARE: f64 = 0.05;
const LOW_BY_CHANCE: f64 = 3.0;

/// Expected square of a block, and the drift of Page's test.
const EXPECTED: f64 = 4.0;
/// Largest contribution of a block: an outlier is not a change.
const MOST: f64 = 16.0;
/// h.
const CONTRADICTED: f64 = 75.0;
/// Sum above which the newest residuals are not called white: by chance at `exp(−0.24 · 40)`, one instant in
/// 15,000. Four blocks beyond [`MOST`] exceed it.
const ALARMED: f64 = 40.0;
/// Levels of groups: up to 256 blocks, which is half of a storage of 512.
const LEVELS: usize = 5;
/// Blocks over which residuals are tested for correlation: one and a half periods of a mode at the usual eight blocks, two at
/// six.
const LAGS: usize = 12;
/// Sampling error of the sum of that many independent correlations over that of one: `√12`.
pub const ROOT_OF_LAGS: f64 = 3.464_101_615_137_754;
/// Frequencies of the test up to half the rate of blocks, and cosine and sine of their spacing π/48: a quarter of the width
/// of a line that 12 lags resolve.
const FREQUENCIES: usize = 47;
const SPACING: [f64; 2] = [0.997_858_923_238_603_5, 0.065_403_129_230_143_06];
/// Statistics of the residuals of a fit. Squares are in rad²/s² of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals<T: Real> {
    /// Number of blocks.
    pub blocks: u32,
    /// Number of rows.
    pub rows: u32,
    /// Sum of squared recursive residuals at their weights.
    pub squares: T,
    /// Sums of products with those of the block before, of the one before that, …
    products: [T; LAGS],
    /// Robust cost `Σ min(u², K²) s²`.
    pub cost: T,
    /// Blocks at reduced weight.
    pub low: u32,
    run: Run,
    /// Longest run of them.
    pub longest: Run,
    /// Cumulative sum of Page's test.
    sum: T,
    /// Block at which the cumulative sum began to rise.
    pub rise: usize,
    /// True once the cumulative sum has exceeded its limit.
    pub is_contradicted: bool,
    /// Those of the last blocks, of unit weight, newest first.
    last: [[T; 3]; LAGS],
    histogram: [u16; OCTAVES],
    /// Groups of recursive residuals, over the unit of the histogram.
    pub whiteness: Whiteness<T, LEVELS>,
    /// Residuals at the solution along the curvature of the rate.
    pub curvature: Curvature<T>,
}

crate::persist!([T: Real] Residuals<T> {
    blocks, rows, squares, products, cost, low, run, longest, sum, rise, is_contradicted, last, histogram,
    whiteness, curvature
} if |this| this.squares >= T::zero());

/// Run of blocks at reduced weight, with gaps of up to three blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// First block.
    pub from: usize,
    /// Block after the last one.
    pub after: usize,
    /// Number of blocks at reduced weight.
    pub count: u32,
}

crate::persist!([] Run { from, after, count });

/// Blocks of full weight that end a run.
const RUN_GAP: usize = 4;

impl Run {
    fn none() -> Self {
        Self { from: 0, after: 0, count: 0 }
    }

    /// The run with one more block.
    fn with(self, block: usize) -> Self {
        if self.count > 0 && block < self.after.saturating_add(RUN_GAP) {
            Self { after: block + 1, count: self.count.saturating_add(1), ..self }
        } else {
            Self { from: block, after: block + 1, count: 1 }
        }
    }
}

impl<T: Real> Residuals<T> {
    /// No residuals yet, of blocks from this one on.
    pub fn from_block(from: usize) -> Self {
        Self {
            blocks: 0,
            rows: 0,
            squares: T::zero(),
            products: [T::zero(); LAGS],
            cost: T::zero(),
            low: 0,
            run: Run::none(),
            longest: Run::none(),
            sum: T::zero(),
            rise: from,
            is_contradicted: false,
            last: [[T::zero(); 3]; LAGS],
            histogram: [0; OCTAVES],
            whiteness: Whiteness::default(),
            curvature: Curvature::none(),
        }
    }

    /// Degrees of freedom of the sum of squares for U unknowns.
    pub fn degrees(&self, unknowns: u32) -> u32 {
        self.rows.saturating_sub(unknowns)
    }

    /// Residual of a sample as the median of the blocks has it, one axis, rad/s, for the unit in which
    /// the histogram was filled.
    #[inline(never)]
    pub fn typical(&self, unit_rad_s: T) -> T {
        let half = self.blocks / 2;
        let (mut below, mut octave) = (0, 0);
        while octave + 1 < OCTAVES && below + u32::from(self.histogram[octave]) <= half {
            below += u32::from(self.histogram[octave]);
            octave += 1;
        }
        let inside = T::count(half.saturating_sub(below)) + T::lit(0.5);
        let share = inside / T::count(u32::from(self.histogram[octave]).max(1));
        let mut bottom = T::lit(0.0625);
        for _ in 0..octave {
            bottom += bottom;
        }
        let u_square = bottom * (T::one() + share.min(T::one()));
        (u_square / T::lit(MEDIAN_CHI_SQUARE)).sqrt() * unit_rad_s
    }

    /// Correlation of residuals from block to block, −1 to 1, with a sum of products up to `explained` explained
    /// otherwise, rad²/s².
    pub fn correlation_beyond(&self, explained: T) -> T {
        let [products, ..] = self.products;
        let beyond = beyond(products, explained);
        if self.squares > T::zero() { beyond / self.squares } else { T::zero() }
    }

    /// Sum of the correlations of 1 to 12 blocks, with sums of products up to `explained` explained otherwise, rad²/s². Its
    /// sampling error is [`ROOT_OF_LAGS`] times that of one of them.
    #[inline(never)]
    pub fn slow_correlation_beyond(&self, explained: T) -> T {
        let of_each = self.products.iter().map(|products| beyond(*products, explained));
        let sum = of_each.fold(T::zero(), |sum, beyond| sum + beyond);
        if self.squares > T::zero() { sum / self.squares } else { T::zero() }
    }

    /// Largest line of the spectrum of correlations ρ of k = 1 to 12 blocks, over its sampling error, with sums of
    /// products up to `explained` explained otherwise, rad²/s²:
    ///
    /// ```text
    /// √rows · max over φ of Σ ρ_k cos kφ / √(Σ cos² kφ)
    /// ```
    ///
    /// An oscillation of the phase φ per block has `ρ_k ∝ cos kφ`. Limit: [`largest_line`](super::whiteness::largest_line).
    #[inline(never)]
    pub fn line_beyond(&self, explained: T) -> T {
        let beyond = self.products.map(|products| beyond(products, explained));
        let [cosine, sine] = SPACING.map(T::lit);
        let (mut cos, mut sin, mut largest) = (cosine, sine, T::zero());
        for _ in 0..FREQUENCIES {
            let (mut sum, mut squares) = (T::zero(), T::zero());
            let (mut before, mut of_lag) = (T::one(), cos);
            for beyond in &beyond {
                sum += *beyond * of_lag;
                squares += of_lag * of_lag;
                // cos (k + 1)φ = 2 cos φ cos kφ − cos (k − 1)φ.
                let next = (cos + cos) * of_lag - before;
                (before, of_lag) = (of_lag, next);
            }
            // The sum of squares is (L − 1) / 2 or more.
            largest = largest.max(sum / squares.sqrt());
            (cos, sin) = (cos * cosine - sin * sine, sin * cosine + cos * sine);
        }
        if self.squares > T::zero() {
            largest * T::count(self.rows).sqrt() / self.squares
        } else {
            T::zero()
        }
    }

    /// True where more blocks are at reduced weight than outliers explain.
    pub fn has_many_low(&self) -> bool {
        let most = T::count(self.blocks) * T::lit(LOW_SHARE) + T::lit(LOW_BY_CHANCE);
        T::count(self.low) > most
    }

    /// Takes in `n |r|²` of a block in units of the histogram; returns the block's weight.
    pub fn weigh(&mut self, block: usize, square: T, unit_rad_s: T, scale_rad_s: T) -> T {
        let of_unit = square / (unit_rad_s * unit_rad_s);
        let exponent = ((of_unit.to_f32().to_bits() >> 23) & 0xff) as i32 - 127;
        let octave = (exponent - FIRST_OCTAVE).clamp(0, OCTAVES as i32 - 1) as usize;
        self.histogram[octave] = self.histogram[octave].saturating_add(1);
        self.blocks = self.blocks.saturating_add(1);
        let most = scale_rad_s * scale_rad_s * T::lit(ROBUST * ROBUST);
        self.cost += square.min(most);
        if square > most {
            self.low = self.low.saturating_add(1);
            self.run = self.run.with(block);
            if self.run.count >= self.longest.count {
                self.longest = self.run;
            }
            most / square
        } else {
            T::one()
        }
    }

    /// Watches the squared residual of a block over its variance; `next` is the block after it.
    pub fn watch(&mut self, share: T, next: usize) {
        if self.is_contradicted {
            return;
        }
        let sum = self.sum + share.min(T::lit(MOST)) - T::lit(EXPECTED);
        if sum > T::zero() {
            self.sum = sum;
        } else {
            self.sum = T::zero();
            self.rise = next;
        }
        self.is_contradicted = self.sum > T::lit(CONTRADICTED);
    }

    /// Indices of blocks after the first `count` have been removed.
    pub fn drop_before(&mut self, count: usize) {
        self.rise = self.rise.saturating_sub(count);
        for run in [&mut self.run, &mut self.longest] {
            run.from = run.from.saturating_sub(count);
            run.after = run.after.saturating_sub(count);
        }
    }

    /// Indices of blocks are no longer valid, since blocks have been merged: that of the contradiction is unknown.
    pub fn forget_instant(&mut self) {
        // The largest index that a checkpoint holds.
        self.rise = u32::MAX as usize;
        (self.run, self.longest) = (Run::none(), Run::none());
    }

    /// True where the newest blocks are not explained.
    pub fn is_alarmed(&self) -> bool {
        self.sum > T::lit(ALARMED)
    }

    /// Takes in the recursive residual of a row. Returns it for unit weight.
    pub fn add(&mut self, axis: usize, left: RecursiveResidual<T>) -> T {
        self.squares += left.square();
        let residual = left.residual();
        let mut newer = residual;
        for (products, last) in self.products.iter_mut().zip(&mut self.last) {
            if let Some(last) = last.get_mut(axis) {
                *products += residual * *last;
                core::mem::swap(last, &mut newer);
            }
        }
        self.rows = self.rows.saturating_add(1);
        residual
    }
}

/// A sum of products less what may be explained otherwise, either sign.
#[inline(never)]
fn beyond<T: Real>(products: T, explained: T) -> T {
    products - products.max(-explained).min(explained)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::test_hardware::normal;
    use crate::monitor::whiteness::{largest_line, line_of};

    const SIGMA_RAD_S: f64 = 1e-3;

    /// Residuals of these squares over the variance, one a block.
    fn of(shares: impl IntoIterator<Item = f64>) -> Residuals<f64> {
        let mut residuals = Residuals::from_block(0);
        for (block, share) in shares.into_iter().enumerate() {
            let square = share * SIGMA_RAD_S * SIGMA_RAD_S;
            residuals.weigh(block, square, SIGMA_RAD_S, SIGMA_RAD_S);
            residuals.watch(share, block + 1);
        }
        residuals
    }

    /// Influence bounded by four sigmas: the weight is `min(1, 16 / u²)`.
    #[test]
    fn weight_bounds_the_influence_of_a_block() {
        let weight = |share: f64| {
            Residuals::from_block(0).weigh(0, share * SIGMA_RAD_S * SIGMA_RAD_S, 1.0, SIGMA_RAD_S)
        };
        assert_eq!((weight(3.0), weight(15.9)), (1.0, 1.0));
        assert!((weight(32.0) - 0.5).abs() < 1e-12);
        let cost = of([3.0, 32.0]).cost / (SIGMA_RAD_S * SIGMA_RAD_S);
        assert!((cost - 19.0).abs() < 1e-9, "{cost}");
    }

    /// Of 40 blocks three by chance and two by their share of 5 %.
    #[test]
    fn blocks_at_reduced_weight_are_many_beyond_chance_and_a_share() {
        let with = |low: usize| of((0..40).map(|k| if k < low { 100.0 } else { 3.0 }));
        assert_eq!((with(6).blocks, with(6).low), (40, 6));
        assert!(with(6).has_many_low());
        assert!(!with(5).has_many_low() && !with(0).has_many_low());
    }

    /// Blocks 10 to 13 and 17, 18 are one run; four blocks of full weight end it.
    #[test]
    fn a_run_has_gaps_of_up_to_three_blocks() {
        let low = [10, 11, 12, 13, 17, 18, 23, 24];
        let residuals = of((0..40).map(|k| if low.contains(&k) { 100.0 } else { 3.0 }));
        assert_eq!(residuals.longest, Run { from: 10, after: 19, count: 6 });
        assert_eq!(of([3.0, 3.0, 100.0]).longest, Run { from: 2, after: 3, count: 1 });
        let mut later = residuals;
        later.drop_before(12);
        assert_eq!(later.longest, Run { from: 0, after: 7, count: 6 });
    }

    /// Each block of any size adds twelve at most: the seventh exceeds 75, the fourth 40. The instant is that of the first.
    #[test]
    fn a_change_is_contradicted_from_its_instant() {
        let after = |large: usize| of((0..50 + large).map(|k| if k < 50 { 3.0 } else { 1e6 }));
        assert!(!after(6).is_contradicted && after(7).is_contradicted);
        assert!(!after(3).is_alarmed() && after(4).is_alarmed());
        assert_eq!(after(7).rise, 50);
        let mut dropped = after(7);
        dropped.drop_before(20);
        assert_eq!(dropped.rise, 30);
        let mut merged = after(7);
        merged.forget_instant();
        assert!(merged.is_contradicted && merged.rise > 1000 && merged.longest == Run::none());
        // A contradiction lasts.
        dropped.watch(0.0, 60);
        assert!(dropped.is_contradicted && dropped.rise == 30);
    }

    /// Normal residuals of three axes: the median of 4,000 blocks, whose octaves resolve it to a tenth.
    #[test]
    fn typical_residual_is_the_sigma_of_normal_ones() {
        for scale in [0.3, 1.0, 2.0, 50.0] {
            let mut normal = normal(1);
            let mut squares = || (0..3).map(|_| (normal() * scale).powi(2)).sum::<f64>();
            let residuals = of((0..4000).map(|_| squares()));
            let ratio = residuals.typical(SIGMA_RAD_S) / (scale * SIGMA_RAD_S);
            assert!((ratio - 1.0).abs() < 0.1, "{scale}: {ratio}");
        }
    }

    /// White noise of unit variance beside a slow part of a third of it: each correlation is a quarter, their sum 3. Thirty
    /// levels of a record know that variance to 0.26 of itself, the sum to 0.6, and its mean over 20 records to 0.13. Of white noise
    /// alone the sum has the stated sampling error.
    #[test]
    fn a_slow_part_beside_white_noise_is_correlated_over_all_lags() {
        let of = |seed: u64, slow: f64| {
            let (mut normal, mut residuals) = (normal(seed), Residuals::<f64>::from_block(0));
            let mut level = [0.0; 3];
            for block in 0..4000 {
                for (axis, level) in level.iter_mut().enumerate() {
                    if block % 400 == 0 {
                        *level = slow * normal();
                    }
                    residuals
                        .add(axis, RecursiveResidual { value: *level + normal(), weight: 1.0 });
                }
            }
            residuals
        };
        let slow =
            (1..=20).map(|seed| of(seed, (1.0f64 / 3.0).sqrt()).slow_correlation_beyond(0.0));
        let mean = slow.sum::<f64>() / 20.0;
        assert!((mean - 3.0).abs() < 0.4, "{mean}");
        let white = (1..=100).map(|seed| {
            let residuals = of(seed, 0.0);
            let sum = residuals.slow_correlation_beyond(0.0);
            (sum / ROOT_OF_LAGS).powi(2) * f64::from(residuals.rows)
        });
        let variance = white.sum::<f64>() / 100.0;
        assert!((variance - 1.0).abs() < 4.0 * (2.0f64 / 100.0).sqrt(), "{variance}");
    }

    /// Square wave of a period of four blocks on one axis: no correlation from block to block, −1 over two blocks, a line at
    /// `φ = π / 2`.
    #[test]
    fn correlation_is_that_of_each_number_of_blocks() {
        const BLOCKS: u32 = 400;
        let wave = |weight: f64| {
            let mut residuals = Residuals::from_block(0);
            for k in 0..BLOCKS {
                let value = if k % 4 < 2 { SIGMA_RAD_S } else { -SIGMA_RAD_S };
                for axis in 0..3 {
                    let value = if axis == 1 { value / weight.sqrt() } else { 0.0 };
                    residuals.add(axis, RecursiveResidual { value, weight });
                }
            }
            residuals
        };
        assert_eq!(Residuals::<f64>::from_block(0).correlation_beyond(0.0), 0.0);
        assert_eq!(Residuals::<f64>::from_block(0).line_beyond(0.0), 0.0);
        for residuals in [wave(1.0), wave(4.0)] {
            assert_eq!((residuals.rows, residuals.degrees(12)), (3 * BLOCKS, 3 * BLOCKS - 12));
            let total = f64::from(BLOCKS) * SIGMA_RAD_S * SIGMA_RAD_S;
            assert!((residuals.squares / total - 1.0).abs() < 1e-9);
            assert!(residuals.correlation_beyond(0.0).abs() < 0.01);
            // Lags 2, 4, … 12 are ±1, less the first blocks: Σ ρ cos / √Σ cos² = √6.
            let line = residuals.line_beyond(0.0) / f64::from(3 * BLOCKS).sqrt();
            assert!((line / 6f64.sqrt() - 1.0).abs() < 0.03, "{line}");
            // All of a correlation of 1, either sign, is explained by the sum of squares; half of it leaves half.
            assert_eq!(residuals.line_beyond(total), 0.0);
            let rest = residuals.line_beyond(0.5 * total) / f64::from(3 * BLOCKS).sqrt();
            assert!((rest / line - 0.5).abs() < 0.03, "{rest}");
        }
        let constant = |sign: f64| {
            let mut residuals = Residuals::from_block(0);
            for k in 0..BLOCKS {
                let value = if k % 2 == 0 { SIGMA_RAD_S } else { SIGMA_RAD_S * sign };
                residuals.add(0, RecursiveResidual { value, weight: 1.0 });
            }
            (
                residuals.correlation_beyond(0.0),
                residuals.correlation_beyond(residuals.squares / 2.0),
            )
        };
        for sign in [1.0, -1.0] {
            let (all, half) = constant(sign);
            assert!((all - sign).abs() < 0.01 && (half - sign / 2.0).abs() < 0.01, "{all} {half}");
        }
    }

    /// Residuals of unit variance and a sine of this amplitude on one axis, `phase` radians per block.
    fn with_sine(seed: u64, amplitude: f64, phase: f64) -> Residuals<f64> {
        let (mut residuals, mut noise) = (Residuals::from_block(0), normal(seed + 1));
        for k in 0..150 {
            for axis in 0..3 {
                let sine = amplitude * (phase * f64::from(k)).sin();
                let value = noise() + if axis == 0 { sine } else { 0.0 };
                residuals.add(axis, RecursiveResidual { value, weight: 1.0 });
            }
        }
        residuals
    }

    /// Twice the noise on one axis of three, at frequencies between those of the test and close to its ends; white residuals
    /// stay below the limit.
    #[test]
    fn an_oscillation_is_a_line() {
        let most = largest_line::<f64>(450);
        let found = |amplitude, phase| {
            (0..100)
                .filter(|seed| with_sine(*seed, amplitude, phase).line_beyond(0.0) > most)
                .count()
        };
        assert_eq!(found(0.0, 1.0), 0);
        for phase in [0.05, 0.3, 1.1, 1.6, 2.5, 3.09] {
            assert!(found(2.0, phase) >= 99, "{phase}: {}", found(2.0, phase));
        }
    }

    /// Of 4,000 records with 450 rows `12 / (2 √3) · exp(−u² / 2)` = 1 % exceed the line of u = 3.42, within four sampling
    /// errors.
    #[test]
    fn chance_exceeds_a_line_as_rarely_as_stated() {
        let lines = (0..4000).map(|seed| with_sine(seed, 0.0, 1.0).line_beyond(0.0));
        let share = lines.filter(|line| *line > line_of(450, 3.42)).count() as f64 / 4000.0;
        assert!((share - 0.01).abs() < 4.0 * (0.01f64 / 4000.0).sqrt(), "{share}");
    }
}
