//! Running scale of a prediction error: its median by a recursive tracker, one for each axis.

use super::predictor::{Offset, Reading};
use super::queue::PLACES;
use crate::math::{Vec3, scalar::Real};

/// Squared sigma over squared median of a normal distribution's magnitude, `1 / 0.6745²`.
const SQUARED_SIGMA_OVER_MEDIAN: f64 = 2.198;

/// Steps of the tracker, up and down, first after a start and later.
///
/// The squared median m moves by the factor `1 + η` where the squared error is larger, `1 / (1 + η)`
/// where it is smaller: the median is where both are equally frequent. With the density of `ln e²`
/// at the median, f = 0.214 for normal errors, the relative standard deviation of √m is
/// `½ √(η / 4f)`, the time constant `1 / 2ηf`, the fastest change of √m `η / 2` a sample.
///
/// | η | deviation | time constant | change of ten |
/// |---|---|---|---|
/// | 1/16 | 13 % | 37 samples | 76 samples |
/// | 1/4 | 27 % | 9 samples | 21 samples |
///
/// At three deviations below its mean the limit of six scales is still 3.6 sigmas. Errors that are
/// wrong in a share p of the samples raise the scale by the factor `1 + p / 4f`: 12 % for one in
/// ten.
const STEP: [[f64; 2]; 2] = [[1.25, 0.8], [1.0625, 1.0 / 1.0625]];

/// Samples after a start with the larger step: eight e-foldings of m, which correct a first scale
/// that is fifty times too large.
const START_SAMPLES: u8 = 32;

/// Second differences that one bad sample enters.
const SPOILT: usize = 3;

/// Squared median of the error on each axis, rad²/s². Zero is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale<T: Real> {
    squared_median: Vec3<T>,
}

crate::persist!([T: Real] Scale<T> { squared_median }
    if |this| this.squared_median.iter().all(|m| *m >= T::zero()));

impl<T: Real> Scale<T> {
    /// Same scale on each axis, from a variance, rad²/s².
    pub(super) fn of_variance(variance: T) -> Self {
        Self { squared_median: Vec3::repeat(variance / T::lit(SQUARED_SIGMA_OVER_MEDIAN)) }
    }

    /// Variance of a normal error of this scale, rad²/s².
    pub(super) fn variance(&self, axis: usize) -> T {
        self.squared_median[axis] * T::lit(SQUARED_SIGMA_OVER_MEDIAN)
    }

    /// Follows the squared error on each axis, rad²/s².
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn follow(&mut self, squared_error: &Vec3<T>, samples: u8) {
        for axis in 0..3 {
            let median = self.squared_median[axis];
            self.squared_median[axis] = followed(median, squared_error[axis], samples);
        }
    }
}

/// Next squared median of one axis.
///
/// An error of exactly zero is a repeated reading and not a measure of the noise: it is left out, so
/// that the scale of quantised readings stays at a quantum.
#[cfg_attr(target_os = "none", inline(never))]
fn followed<T: Real>(median: T, squared_error: T, samples: u8) -> T {
    let is_positive = |x: T| x > T::zero() && x < T::MAX;
    if !is_positive(squared_error) {
        return median;
    }
    if !is_positive(median) {
        return squared_error;
    }
    // Literals of both steps: a conversion of the chosen one would be a library call.
    let [[up_at_first, down_at_first], [up, down]] = STEP;
    median
        * match (samples < START_SAMPLES, squared_error > median) {
            (true, true) => T::lit(up_at_first),
            (true, false) => T::lit(down_at_first),
            (false, true) => T::lit(up),
            (false, false) => T::lit(down),
        }
}

/// Next count of samples since the start, up to the change of the step.
pub(super) fn count_of_start(samples: u8) -> u8 {
    samples.saturating_add(1).min(START_SAMPLES)
}

/// Variance of the noise by the first readings, rad²/s², in the presence of one bad one.
///
/// Second differences, normalised to the noise of a reading, without the three consecutive ones of
/// the largest sum: a bad reading enters three. Least over the three left out, of the mean over the
/// others and the axes. Eight good readings give 0.6 of the variance, eight with a bad one the
/// variance. Curvature of the motion counts as noise. Fewer than six readings are too few to leave
/// any out; fewer than three give zero.
pub(super) fn first_variance<T: Real>(readings: &[Reading<T>]) -> T {
    let mut squares = [T::zero(); PLACES - 2];
    for (square, three) in squares.iter_mut().zip(readings.windows(3)) {
        *square = squared_second_difference(three);
    }
    let count = readings.len().saturating_sub(2);
    let left_out = if count > SPOILT { SPOILT } else { 0 };
    let mut least = T::MAX;
    for spoilt in 0..count - left_out + 1 {
        let sum = sum_without(&squares, count, spoilt, left_out);
        least = if sum < least { sum } else { least };
    }
    least / (T::lit(3.0) * T::count((count - left_out).max(1) as u32))
}

/// Sum of the first `count` squares without `left_out` from `spoilt` on.
#[cfg_attr(target_os = "none", inline(never))]
fn sum_without<T: Real>(squares: &[T], count: usize, spoilt: usize, left_out: usize) -> T {
    let mut sum = T::zero();
    for (i, square) in squares.iter().enumerate().take(count) {
        if i < spoilt || i >= spoilt + left_out {
            sum += *square;
        }
    }
    sum
}

/// Reading minus the line through its two neighbours, squared and normalised to the variance of a
/// reading, sum of the axes, rad²/s². Zero where two times are equal.
#[cfg_attr(target_os = "none", inline(never))]
fn squared_second_difference<T: Real>(three: &[Reading<T>]) -> T {
    let [before, at, after] = three else {
        return T::zero();
    };
    let relative = |r: &Reading<T>| Reading { time_s: r.time_s - at.time_s, ..*r };
    let line = Offset::of_line([&relative(before), &relative(after)], &at.rate_rad_s);
    line.map_or(T::zero(), |line| line.rate_rad_s.dot(&line.rate_rad_s) / line.squared_gain)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two alternating errors, 1 and 4: their median lies between.
    #[test]
    fn the_scale_follows_the_level() {
        let mut scale = Scale::of_variance(1e6f32);
        let mut samples = 0;
        for k in 0..400 {
            scale.follow(&Vec3::repeat(if k % 2 == 0 { 1.0 } else { 4.0 }), samples);
            samples = count_of_start(samples);
        }
        let median = scale.variance(0) / SQUARED_SIGMA_OVER_MEDIAN as f32;
        assert!((0.9..4.5).contains(&median), "{median}");
    }

    /// An infinite error, an exact zero and a scale that is not a number.
    #[test]
    fn a_scale_recovers_from_any_value() {
        for broken in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            let mut scale = Scale::of_variance(broken);
            for error in [f32::INFINITY, f32::NAN, 0.0, 0.25] {
                scale.follow(&Vec3::repeat(error), 0);
            }
            assert_eq!(scale.squared_median[1], 0.25);
        }
    }

    /// A step of one reading by 1000 in otherwise alternating readings.
    #[test]
    fn one_bad_reading_leaves_the_first_variance() {
        let clean: std::vec::Vec<Reading<f32>> = (0..9)
            .map(|k| Reading { time_s: 0.1 * k as f32, rate_rad_s: Vec3::repeat((k % 2) as f32) })
            .collect();
        let expected = first_variance(&clean);
        assert!((expected - 4.0 / 6.0 * 4.0 / 4.0).abs() < 0.7, "{expected}");
        for bad in 0..9 {
            let mut readings = clean.clone();
            readings[bad].rate_rad_s.y += 1000.0;
            assert!(first_variance(&readings) <= 1.01 * expected, "{bad}");
        }
    }

    /// Second differences of 2 in an alternating sequence of three axes, gain 1.5: no matter how many readings.
    #[test]
    fn few_readings_give_the_first_variance_too() {
        let readings: std::vec::Vec<Reading<f64>> = (0..9)
            .map(|k| Reading { time_s: f64::from(k), rate_rad_s: Vec3::repeat(f64::from(k % 2)) })
            .collect();
        for few in 3..=9 {
            let variance = first_variance(&readings[..few]);
            assert!((variance - 1.0 / 1.5).abs() < 1e-12, "{few}: {variance}");
        }
        assert_eq!(first_variance(&readings[..2]), 0.0);
    }
}
