//! Whiteness: residuals that hold more than noise, by their size and by their correlation in time.
//!
//! Limits that every estimator shares, and the test of a filter's innovations.
//!
//! | statistic of n residuals of three axes | white up to | reason |
//! |---|---|---|
//! | RMS over the noise ([`largest_rms`]) | `1.05 + 5.4 / √(6 n)` | sampling error `1 / √(2 · 3 n)` |
//! | correlation with the one before ([`largest_correlation`]) | `0.1 + 4 / √(3 n)` | sampling error `1 / √(3 n)` |
//! | line in the correlations over 12 lags ([`largest_line`]) | `(χ² − n) / √(2 n) + 0.025 √(3 n)` | chi-square of n degrees of freedom that chance exceeds at one of all frequencies, once in 11,000 |
//! | RMS of n groups of residuals | `1.05 √(χ² / 3 n)` | chi-square of 3 n degrees of freedom that chance exceeds once in 1,000 |
//!
//! # Groups
//!
//! Input: values z of three axes, of unit variance if white: innovations of a filter, recursive residuals of a fit.
//! Output: white or not, from 30 values on, one axis each.
//!
//! A model error is slow beside the samples and small beside their noise. Sums of m values over √m have the variance 1
//! too, and a slow error grows by √m. Each level holds groups of four of the level before it: L levels reach groups of
//! `4^(L − 1)` values.
//!
//! | values | L | largest group |
//! |---|---|---|
//! | innovations of `joint-ekf` | 3 | 16 samples |
//! | blocks of `window` | 5 | 256 blocks, half of its storage |
//!
//! Innovations ν of variance S enter as `z = ν σ / S`, which has at most the variance 1: less while the filter's own
//! uncertainty is part of S ([`shift`](super::shift)).
//!
//! Means are exponential once they hold 4,096 values, `m ← m + (x − m) / n`, `n ≤ 4096`.
//!
//! Errors of the hardware, of variance `s² S` in an innovation ([`Whiteness::add`]), are correlated over
//! the whole flight. In groups of m their mean square is at most `m s²`, which both statistics may have
//! in addition.

use super::innovation::Innovation;
use crate::math::{Vec3, scalar::Real};

/// Excess of the residuals over the noise that is still called white, and the number of sigmas of
/// its sampling error.
const EXCESS: f64 = 0.05;
const EXCESS_SIGMA: f64 = 5.4;
/// The same of the correlation. A correlation of 0.1 makes the sigma 10 % too small.
const CORRELATED: f64 = 0.1;
const CORRELATED_SIGMA: f64 = 4.0;
/// Share of an oscillation in the variance of the residuals that is still called white, 0.01, times `√(12 / 2)`, the
/// length of its correlations over twelve lags: an amplitude of a seventh of the noise.
const LINE: f64 = 0.025;
/// Lines of white residuals, were their correlations normal, cross u from below `L / (2 √3) · exp(−u² / 2)` times on the
/// average, for L lags \[Davies1977\]: the length of the curve of unit vectors `cos kφ / √(Σ cos² kφ)`, φ from 0 to π, over 2 π.
/// For L = 12: once in 11,000.
const LINE_SIGMA: f64 = 4.6;
/// Fewest residuals, each of one axis, that are tested.
pub const ENOUGH_ROWS: u32 = 30;
/// Fewest groups of a level that are tested.
const ENOUGH_GROUPS: u16 = 2;
/// Normal variable that chance exceeds once in 1,000: a flight has four levels of groups at most, and with the margin of
/// [`EXCESS`] none of 300 ideal flights came closer than once in 100.
const GROUP_SIGMA: f64 = 3.09;

/// Members of a group of the next level; `GROUP_SCALE` is `1 / √GROUP`.
const GROUP: u8 = 4;
const GROUP_SCALE: f64 = 0.5;
/// Levels of a filter's innovations: groups of 1, 4 and 16.
const LEVELS: usize = 3;
/// Values in the memory of a mean: of the groups of 16, two hours at 10 Hz.
const MEMORY: u16 = 4096;

/// Largest RMS of `triples` white residuals of three axes, over the noise.
pub fn largest_rms<T: Real>(triples: u32) -> T {
    let share = T::lit(EXCESS_SIGMA) / (T::count(triples) * T::lit(6.0)).sqrt();
    T::lit(1.0 + EXCESS) + share
}

/// Largest correlation between `rows` white residuals, each of one axis, and those before, either sign.
pub fn largest_correlation<T: Real>(rows: u32) -> T {
    T::lit(CORRELATED) + T::lit(CORRELATED_SIGMA) / T::count(rows.max(1)).sqrt()
}

/// Largest line of the correlations of `rows` white residuals, each of one axis, over its sampling error
/// ([`Residuals::line_beyond`](super::residuals::Residuals::line_beyond)). A smoothed spectrum is skewed. Chi-square
/// with one degree of freedom for each triple has this skewness, as 4,000 white records in the test of `residuals` show.
pub fn largest_line<T: Real>(rows: u32) -> T {
    line_of::<T>(rows, LINE_SIGMA) + T::lit(LINE) * T::count(rows).sqrt()
}

/// Line of `rows` white residuals that chance exceeds as rarely as the crossing of `sigma` by normal ones.
pub(super) fn line_of<T: Real>(rows: u32, sigma: f64) -> T {
    let triples = (rows / 3).max(1);
    let degrees = T::count(triples);
    (chi_square::<T>(triples, sigma) - degrees) / (degrees + degrees).sqrt()
}

/// Chi-square of these degrees of freedom that chance exceeds as rarely as a normal variable `sigma`, by the cube of a
/// normal variable \[Wilson1931\]: `n (1 − 2/9n + sigma √(2/9n))³`, within 3 % from three degrees on.
pub fn chi_square<T: Real>(degrees: u32, sigma: f64) -> T {
    let n = T::count(degrees.max(1));
    let spread = T::lit(2.0 / 9.0) / n;
    let root = T::one() - spread + T::lit(sigma) * spread.sqrt();
    n * root * root * root
}

/// Statistics of one level. Values have the variance 1 if white.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level<T: Real> {
    /// Values, up to the memory.
    count: u16,
    /// Mean over the values of `z · z / 3`, and of the product with the value before.
    square: T,
    product: T,
    /// The last value, zero before the first.
    last: Vec3<T>,
    /// Present group: sum and number of its members.
    sum: Vec3<T>,
    members: u8,
}

crate::persist!([T: Real] Level<T> { count, square, product, last, sum, members }
    if |this| this.square >= T::zero());

impl<T: Real> Level<T> {
    fn nothing() -> Self {
        let (o, none) = (T::zero(), Vec3::zeros());
        Self { count: 0, square: o, product: o, last: none, sum: none, members: 0 }
    }

    /// Adds a value; the group that it completes, as a value of the next level.
    #[inline]
    fn add(&mut self, z: &Vec3<T>) -> Option<Vec3<T>> {
        let third = T::lit(1.0 / 3.0);
        self.count = (self.count + 1).min(MEMORY);
        let weight = T::one() / T::count(u32::from(self.count));
        self.square += (z.dot(z) * third - self.square) * weight;
        self.product += (z.dot(&self.last) * third - self.product) * weight;
        self.last = *z;
        self.sum += z;
        self.members += 1;
        if self.members < GROUP {
            return None;
        }
        let group = self.sum * T::lit(GROUP_SCALE);
        (self.sum, self.members) = (Vec3::zeros(), 0);
        Some(group)
    }

    /// True where size and correlation are those of white noise of this variance and of an explained mean square of
    /// `explained`; `None` with too few values.
    fn is_white(&self, variance: T, explained: T, is_grouped: bool) -> Option<bool> {
        let rows = u32::from(self.count) * 3;
        let is_enough = if is_grouped { self.count >= ENOUGH_GROUPS } else { rows >= ENOUGH_ROWS };
        if !is_enough {
            return None;
        }
        let most = if is_grouped {
            let margin = T::lit((1.0 + EXCESS) * (1.0 + EXCESS));
            chi_square::<T>(rows, GROUP_SIGMA) / T::count(rows) * margin
        } else {
            let rms: T = largest_rms(u32::from(self.count));
            rms * rms
        };
        let correlated = largest_correlation::<T>(rows) * self.square + explained;
        Some(self.square <= most * variance + explained && self.product.abs() <= correlated)
    }
}

/// Test of the innovations of a filter.
///
/// ```
/// use fsw_core::monitor::whiteness::Whiteness;
/// use fsw_core::{Innovation, Vec3};
///
/// // Alternating innovations of one sigma, and constant ones of a third.
/// let test = |rate_rad_s: fn(u32) -> f64| {
///     let mut test: Whiteness<f64> = Whiteness::default();
///     for k in 0..1000 {
///         let rate_rad_s = Vec3::repeat(rate_rad_s(k));
///         test.add(&Innovation { rate_rad_s, variance_rad2_s2: Vec3::repeat(1.0) }, 1.0, 0.0);
///     }
///     test.is_white()
/// };
/// assert_eq!(test(|k| if k % 2 == 0 { 1.0 } else { -1.0 }), Some(false));
/// assert_eq!(test(|_| 0.33), Some(false));
/// assert_eq!(<Whiteness<f32>>::default().is_white(), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whiteness<T: Real, const L: usize = LEVELS> {
    levels: [Level<T>; L],
    /// Mean square of an innovation, over S, that errors of the hardware explain.
    explained: T,
}

crate::persist!([T: Real, const L: usize] Whiteness<T, L> { levels, explained });

impl<T: Real, const L: usize> Default for Whiteness<T, L> {
    fn default() -> Self {
        Self { levels: [Level::nothing(); L], explained: T::zero() }
    }
}

impl<T: Real, const L: usize> Whiteness<T, L> {
    /// Discards all values, as after a restart of the filter.
    pub fn restart(&mut self) {
        for level in &mut self.levels {
            *level = Level::nothing();
        }
        self.explained = T::zero();
    }

    /// Adds an innovation that updated the filter, with its variance S by noise and covariance, for gyro
    /// noise of `noise_rad_s`. The mean square over S that errors of the hardware explain beside that is
    /// `explained`, zero for ideal hardware.
    #[inline]
    pub fn add(&mut self, innovation: &Innovation<T>, noise_rad_s: T, explained: T) {
        let share = |axis: usize| noise_rad_s / innovation.variance_rad2_s2[axis];
        let value = innovation.rate_rad_s.component_mul(&Vec3::new(share(0), share(1), share(2)));
        if !(value.dot(&value) + explained).is_finite() {
            return; // The filter is about to be reset.
        }
        self.add_value(&value);
        let weight = T::one() / T::count(u32::from(self.levels[0].count));
        self.explained += (explained - self.explained) * weight;
    }

    /// Adds a value of three axes, each of variance 1 if white.
    #[inline]
    pub fn add_value(&mut self, value: &Vec3<T>) {
        let mut value = *value;
        for level in &mut self.levels {
            let Some(group) = level.add(&value) else { break };
            value = group;
        }
    }

    /// True where the values are white at each level that has enough of them; `None` before the first level has 30, a
    /// value of one axis each.
    pub fn is_white(&self) -> Option<bool> {
        self.is_white_of(T::one())
    }

    /// The same for values of this variance instead of 1.
    pub fn is_white_of(&self, variance: T) -> Option<bool> {
        self.is_white_beside(variance, T::zero())
    }

    /// The same beside a mean square of `explained` in all values, by errors that last over the whole flight.
    pub fn is_white_beside(&self, variance: T, explained: T) -> Option<bool> {
        let mut explained = self.explained + explained;
        let mut is_white = None;
        for (index, level) in self.levels.iter().enumerate() {
            match (level.is_white(variance, explained, index > 0), index) {
                (None, 0) => return None,
                (None, _) => {}
                (Some(of_level), _) => is_white = Some(is_white.unwrap_or(true) && of_level),
            }
            explained *= T::count(u32::from(GROUP));
        }
        is_white
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White noise, uniform within ±√3, by a linear congruential generator (\[Knuth1997\]).
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f64 / (1u64 << 23) as f64 - 1.0) * 3f64.sqrt()
        }
    }

    /// Verdict on noise of sigma `scale` with a slow error of this amplitude, over `samples`, of which
    /// `explained` is explained.
    fn verdict(scale: f64, slow: f64, samples: u32, explained: f64, seed: u64) -> Option<bool> {
        let (mut test, mut noise) = (Whiteness::<f32>::default(), noise(seed));
        for k in 0..samples {
            let phase = f64::from(k) * 0.02;
            let rate_rad_s =
                Vec3::from_fn(|i, _| (scale * noise() + slow * (phase + i as f64).sin()) as f32);
            let innovation = Innovation { rate_rad_s, variance_rad2_s2: Vec3::repeat(1.0) };
            test.add(&innovation, 1.0, explained as f32);
        }
        test.is_white()
    }

    #[test]
    fn white_noise_is_white_at_any_length() {
        for seed in 0..200 {
            for samples in [10, 40, 160, 600, 6000] {
                assert_eq!(verdict(1.0, 0.0, samples, 0.0, seed), Some(true), "{seed} {samples}");
            }
        }
        assert_eq!(verdict(1.0, 0.0, 9, 0.0, 1), None);
    }

    /// A fifth of the noise in RMS, which single innovations do not show.
    #[test]
    fn a_slow_error_below_the_noise_is_found_in_groups() {
        for seed in 0..50 {
            assert_eq!(verdict(1.0, 0.28, 6000, 0.0, seed), Some(false), "{seed}");
        }
    }

    #[test]
    fn noise_beyond_the_stated_one_is_not_white() {
        assert_eq!(verdict(1.15, 0.0, 6000, 0.0, 7), Some(false));
        assert_eq!(verdict(0.9, 0.0, 6000, 0.0, 7), Some(true));
    }

    /// The same slow error within what is explained, and at three times that.
    #[test]
    fn an_explained_error_is_white() {
        assert_eq!(verdict(1.0, 0.28, 6000, 0.5 * 0.28 * 0.28, 3), Some(true));
        assert_eq!(verdict(1.0, 0.84, 6000, 0.5 * 0.28 * 0.28, 3), Some(false));
    }

    #[test]
    fn a_restart_discards_all_values() {
        let mut test = Whiteness::<f32>::default();
        let innovation =
            Innovation { rate_rad_s: Vec3::repeat(1.0), variance_rad2_s2: Vec3::repeat(1.0) };
        (0..100).for_each(|_| test.add(&innovation, 1.0, 0.5));
        assert_eq!(test.is_white(), Some(false));
        test.restart();
        assert_eq!(test, Whiteness::default());
    }

    #[test]
    fn numbers_that_are_not_finite_are_left_out() {
        let mut test = Whiteness::<f32>::default();
        for (rate, variance) in [(f32::NAN, 1.0), (1.0, 0.0), (f32::INFINITY, 1.0), (0.0, 0.0)] {
            let innovation = Innovation {
                rate_rad_s: Vec3::repeat(rate),
                variance_rad2_s2: Vec3::repeat(variance),
            };
            test.add(&innovation, 1.0, 0.0);
        }
        assert_eq!(test, Whiteness::default());
    }

    /// Values of the table, and quantiles of chi-square: 4 and 9 degrees of freedom that chance exceeds once in 100.
    #[test]
    fn limits_are_those_of_the_table() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b, "{a} {b}");
        near(largest_rms(150), 1.05 + 5.4 / 30.0);
        near(largest_correlation(400), 0.1 + 4.0 / 20.0);
        let skewed = (chi_square::<f64>(400, LINE_SIGMA) - 400.0) / 800f64.sqrt();
        near(largest_line(1200), skewed + 0.025 * 1200f64.sqrt());
        for (degrees, quantile) in [(4, 13.277), (9, 21.666), (100, 135.807)] {
            let ratio = chi_square::<f64>(degrees, 2.3263) / quantile;
            assert!((ratio - 1.0).abs() < 0.01, "{degrees}: {ratio}");
        }
    }

    /// Values of one size without correlation, `+ + − −`, and values that are all equal: what noise of the variance 4 and an
    /// explained mean square of 2 may have, to a percent.
    #[test]
    fn size_and_correlation_are_limited_beside_what_is_explained() {
        const COUNT: u16 = 400;
        let of = |square: f64, is_correlated: bool| {
            let mut level = Level::nothing();
            for k in 0..COUNT {
                let sign = if is_correlated || k / 2 % 2 == 0 { 1.0 } else { -1.0 };
                level.add(&Vec3::repeat(sign * square.sqrt()));
            }
            level
        };
        let rows = 3 * u32::from(COUNT);
        let single: f64 = largest_rms(COUNT.into());
        let grouped = chi_square::<f64>(rows, GROUP_SIGMA) / f64::from(rows) * (1.05 * 1.05);
        for (is_grouped, most) in [(false, single * single), (true, grouped)] {
            let is_white =
                |share: f64| of((most * 4.0 + 2.0) * share, false).is_white(4.0, 2.0, is_grouped);
            assert_eq!((is_white(0.99), is_white(1.01)), (Some(true), Some(false)));
        }
        // All of a square of 1 is correlated, less the first value: white up to its limit and what is explained.
        let explained = 1.0 - largest_correlation::<f64>(rows);
        let is_white = |explained: f64| of(1.0, true).is_white(4.0, explained, false);
        assert_eq!(
            (is_white(explained - 0.01), is_white(explained + 0.01)),
            (Some(false), Some(true))
        );
    }
}
