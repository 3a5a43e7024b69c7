//! Readings of a sensor at instants of its own, and their interpolation at the instants of the gyro.
//!
//! Interpolation: cubic Hermite, with the slope at a sample of the parabola through it and its
//! neighbours. Between samples, a linear interpolation of a speed sin ωt errs by up to (ωT)²/8, with T
//! the period of the samples: 12 % at ωT = 1, the cubic one by 3 %.

/// Longest interval between samples that is interpolated across, typical intervals.
const MAX_INTERVAL: f64 = 3.5;
/// Error of the interpolation, RMS over an interval, as a share of the error at samples that are left
/// out. For a speed that is linear in time with a kink, as under a motor torque that is constant in
/// pieces: 0.288, over all positions of the kink. For sin ωt, ωT = 0.3 to 2: 0.13 to 0.25.
const ERROR_SHARE: f64 = 0.288;

/// Samples with increasing times.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// Time of each, µs, in the time scale of the rows.
    pub times_us: Vec<i64>,
    /// Values of each.
    pub values: Vec<Vec<f64>>,
}

/// How the values between samples are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Between {
    /// A smooth quantity.
    Cubic,
    /// A quantity that may jump.
    Linear,
}

impl Samples {
    /// Adds a sample. One that is not after the last is left out.
    pub(super) fn push(&mut self, time_us: i64, values: Vec<f64>) {
        if self.times_us.last().is_none_or(|last| time_us > *last) {
            self.times_us.push(time_us);
            self.values.push(values);
        }
    }

    /// Typical time between samples, µs; none for fewer than two.
    pub(super) fn period_us(&self) -> Option<i64> {
        let mut periods: Vec<i64> = self.times_us.windows(2).map(|w| w[1] - w[0]).collect();
        periods.sort_unstable();
        periods.get(periods.len() / 2).copied()
    }

    /// Interpolation of the samples.
    pub(super) fn interpolator(&self, between: Between) -> Interpolator<'_> {
        let longest_us = (self.period_us().unwrap_or(0) as f64 * MAX_INTERVAL) as i64;
        Interpolator { samples: self, longest_us, between }
    }

    fn between(&self, pair: [usize; 2], time_us: i64, between: Between) -> Vec<f64> {
        let outer = [pair[0].checked_sub(1), Some(pair[1] + 1)];
        let outer = outer.map(|index| index.filter(|index| *index < self.times_us.len()));
        let point = |index: usize, value: usize| {
            ((self.times_us[index] - self.times_us[pair[0]]) as f64, self.values[index][value])
        };
        let at = (time_us - self.times_us[pair[0]]) as f64;
        let interpolated = |value: usize| {
            let [a, b] = pair.map(|index| point(index, value));
            match between {
                Between::Linear => a.1 + (b.1 - a.1) * at / b.0,
                Between::Cubic => {
                    let [before, after] = outer.map(|index| index.map(|index| point(index, value)));
                    // At an end: the slope there of the parabola through the last three samples.
                    let at_end = |other: f64| 2.0 * secant(a, b) - other;
                    let slope_a = before.map(|before| slope(before, a, b));
                    let slope_b = after.map(|after| slope(a, b, after));
                    let (slope_a, slope_b) = match (slope_a, slope_b) {
                        (Some(slope_a), Some(slope_b)) => (slope_a, slope_b),
                        (None, Some(slope_b)) => (at_end(slope_b), slope_b),
                        (Some(slope_a), None) => (slope_a, at_end(slope_a)),
                        (None, None) => (secant(a, b), secant(a, b)),
                    };
                    hermite(a, b, slope_a, slope_b, at)
                }
            }
        };
        (0..self.values[pair[0]].len()).map(interpolated).collect()
    }

    /// One sigma of the interpolation of each value, by interpolation at each sample without it.
    pub(super) fn error(&self) -> Vec<f64> {
        let count = self.values.first().map_or(0, Vec::len);
        let mut squares = vec![0.0; count];
        let inner = 2..self.times_us.len().saturating_sub(2);
        for index in inner.clone() {
            let others =
                |list: &[i64]| [&list[index - 2..index], &list[index + 1..index + 3]].concat();
            let values =
                [&self.values[index - 2..index], &self.values[index + 1..index + 3]].concat();
            let without = Self { times_us: others(&self.times_us), values };
            let found = without.between([1, 2], self.times_us[index], Between::Cubic);
            for ((square, found), value) in squares.iter_mut().zip(found).zip(&self.values[index]) {
                *square += (found - value).powi(2);
            }
        }
        let mean = |square: f64| square / inner.len().max(1) as f64;
        squares.into_iter().map(|square| ERROR_SHARE * mean(square).sqrt()).collect()
    }
}

/// Interpolation of samples.
pub(super) struct Interpolator<'a> {
    samples: &'a Samples,
    /// Longest interval that is interpolated across, µs.
    longest_us: i64,
    between: Between,
}

impl Interpolator<'_> {
    /// The values at an instant; none outside the samples, or where they are too far apart.
    pub(super) fn at(&self, time_us: i64) -> Option<Vec<f64>> {
        let Samples { times_us, values } = self.samples;
        let after = times_us.partition_point(|time| *time <= time_us);
        let before = after.checked_sub(1)?;
        if times_us[before] == time_us {
            return Some(values[before].clone());
        }
        let interval = times_us.get(after)? - times_us[before];
        let is_near = interval <= self.longest_us;
        is_near.then(|| self.samples.between([before, after], time_us, self.between))
    }
}

/// Slope of the line through two points.
fn secant(a: (f64, f64), b: (f64, f64)) -> f64 {
    (b.1 - a.1) / (b.0 - a.0)
}

/// Slope at `b` of the parabola through three points.
fn slope(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> f64 {
    let (before, after) = (b.0 - a.0, c.0 - b.0);
    (secant(a, b) * after + secant(b, c) * before) / (before + after)
}

/// Cubic through two points with these slopes; the first point is at 0.
fn hermite(a: (f64, f64), b: (f64, f64), slope_a: f64, slope_b: f64, at: f64) -> f64 {
    let (length, u) = (b.0, at / b.0);
    let v = 1.0 - u;
    a.1 * v * v * (1.0 + 2.0 * u)
        + b.1 * u * u * (3.0 - 2.0 * u)
        + length * u * v * (slope_a * v - slope_b * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples once a second.
    fn samples(value: impl Fn(f64) -> f64, count: i64) -> Samples {
        let mut samples = Samples::default();
        (0..count).for_each(|second| samples.push(second * 1_000_000, vec![value(second as f64)]));
        samples
    }

    #[test]
    fn parabola_is_interpolated_exactly() {
        let parabola = |t: f64| 3.0 - 2.0 * t + 0.5 * t * t;
        let samples = samples(parabola, 10);
        for time_us in [100_000, 1_000_000, 2_500_000, 8_900_000] {
            let found = samples.interpolator(Between::Cubic).at(time_us).unwrap()[0];
            assert!((found - parabola(time_us as f64 / 1e6)).abs() < 1e-12, "{time_us}");
        }
        assert!(samples.error()[0] < 1e-12);
    }

    #[test]
    fn stated_error_is_that_of_a_kink_at_any_place() {
        let (mut squares, mut stated) = (0.0, 0.0);
        for kink in 0..50 {
            let speed = |t: f64| (t - 8.0 - (f64::from(kink) + 0.5) / 50.0).max(0.0);
            let samples = samples(speed, 18);
            // As many intervals as samples that are left out.
            let times = (0..140).map(|step| 2_050_000 + step * 100_000);
            let error = |time_us: i64| {
                samples.interpolator(Between::Cubic).at(time_us).unwrap()[0]
                    - speed(time_us as f64 / 1e6)
            };
            squares += times.map(|time_us| error(time_us).powi(2)).sum::<f64>() / 140.0;
            stated += samples.error()[0].powi(2);
        }
        assert!(((squares / stated).sqrt() - 1.0).abs() < 0.02, "{}", (squares / stated).sqrt());
    }

    #[test]
    fn stated_error_of_a_sine_is_above_the_true_one() {
        for omega in [0.3, 1.0, 2.0] {
            let sine = |t: f64| (omega * t).sin();
            let samples = samples(sine, 200);
            let error = |step: i64| {
                let time_us = 2_050_000 + step * 100_000;
                samples.interpolator(Between::Cubic).at(time_us).unwrap()[0]
                    - sine(time_us as f64 / 1e6)
            };
            let rms = ((0..1900).map(|step| error(step).powi(2)).sum::<f64>() / 1900.0).sqrt();
            let ratio = rms / samples.error()[0];
            assert!((0.4..1.0).contains(&ratio), "{omega}: {ratio}");
        }
    }

    #[test]
    fn no_value_outside_the_samples_or_across_a_gap() {
        let mut samples = samples(|t| t, 10);
        samples.push(20_000_000, vec![20.0]);
        samples.push(19_000_000, vec![19.0]);
        for (time_us, expected) in [
            (-1, None),
            (0, Some(0.0)),
            (500_000, Some(0.5)),
            (9_000_000, Some(9.0)),
            (9_500_000, None),
            (20_000_000, Some(20.0)),
            (20_000_001, None),
        ] {
            let found = samples.interpolator(Between::Linear).at(time_us).map(|values| values[0]);
            assert_eq!(found, expected, "{time_us}");
        }
        assert_eq!(samples.times_us.len(), 11);
    }
}
