//! Wheel speeds at the instants of a log's rows, from readings of tachometers that are stated, or that the readings show.
//!
//! A reading is a mean speed over some time before it, and the middle of that time is its instant. With the sample
//! interval `T`, the angle δ between edges and a reading Ω stamped t, less the latency:
//!
//! | principle | mean over | instant before t | error, one sigma |
//! |---|---|---|---|
//! | speed | – | 0 | – |
//! | mean | `T` | `T/2` | – |
//! | count in a window `W` | `W` | `W/2` | `δ / (√6 W)`: both ends are rounded to an edge |
//! | period | `P = δ/Ω` | `P/2 + A/2` | `Ω̇ A / √12`, and `Ω² r / (√6 δ)` of the timer's resolution `r` |
//!
//! The last edge before t is of an age that is uniform from 0 to `A`: to `P`, or to `T` where edges come more slowly,
//! since an older one would have been read before. Its mean is corrected, the rest is the error. A quantum adds
//! `q / √12`, noise its sigma.
//!
//! Speeds at the rows' instants are interpolated. A mean m over the time w becomes the speed in its middle by
//! `Ω = m − w²/24 m̈`, with the second difference at the distance w or of one reading for the derivative.
//!
//! Assumption: a wheel measured by edges does not reverse between two of them. A reading that is the same in all rows is
//! that of a wheel at rest or at constant speed: it has no instant to correct, and the error of quantum and noise alone.

use super::record::{Interpolation, LogRow};
use super::samples::{Between, Samples};
use super::shown::Shown;
use crate::craft::hardware::{StatedHardware, Tachometer, TachometerKind};

/// Longest time between two edges with a speed, sample periods. About a reversal the edges say too little.
pub(super) const MOST_BETWEEN: f64 = 3.5;

/// Corrects the wheel speeds of the rows, and leaves out rows beyond the last reading's instant, before a gap, and
/// where a wheel is too slow for its edges. The error of the corrected speeds; none where all tachometers are ideal.
///
/// A tachometer that is not stated is the one that the readings show.
pub(super) fn correct(rows: &mut Vec<LogRow>, hardware: &StatedHardware) -> Option<Interpolation> {
    let ideal = Tachometer::default();
    let wheels = rows.first()?.wheel_speed_rad_s.len();
    let times_us: Vec<i64> = rows.iter().map(|row| row.time_us as i64).collect();
    let period_s = median(times_us.windows(2).map(|pair| (pair[1] - pair[0]) as f64 * 1e-6))?;
    let readings = |wheel: usize| rows.iter().map(|row| row.wheel_speed_rad_s[wheel]).collect();
    let readings: Vec<Vec<f64>> = (0..wheels).map(readings).collect();
    let mut assumed = Vec::new();
    let mut tachometer = |(wheel, rad_s): (usize, &Vec<f64>)| {
        let stated = hardware.tachometers.get(wheel).copied().unwrap_or_default();
        if stated != ideal {
            return stated;
        }
        let shown = Shown { times_us: &times_us, rad_s, period_s }.tachometer();
        assumed.extend(shown.map(|tachometer| (wheel, tachometer)));
        shown.unwrap_or(ideal)
    };
    let tachometers: Vec<Tachometer> = readings.iter().enumerate().map(&mut tachometer).collect();
    if tachometers.iter().all(|tachometer| *tachometer == ideal) {
        return None;
    }
    let mut interpolation =
        Interpolation { sigma_rad_s: Vec::new(), period_s, left_out: vec![0; wheels], assumed };
    let mut is_covered = vec![true; rows.len()];
    for (wheel, (tachometer, readings)) in tachometers.into_iter().zip(readings).enumerate() {
        if tachometer == ideal || readings.windows(2).all(|pair| pair[0] == pair[1]) {
            interpolation.sigma_rad_s.push(tachometer.resolution_sigma_rad_s());
            continue;
        }
        let readings = Readings { tachometer, times_us: &times_us, rad_s: readings, period_s };
        let means = readings.means();
        interpolation.sigma_rad_s.push(means.sigma_rad_s(&tachometer));
        interpolation.period_s = interpolation.period_s.max(tachometer.hold_s);
        let speeds = means.speeds_rad_s(&times_us);
        for ((row, is_covered), speed) in rows.iter_mut().zip(&mut is_covered).zip(speeds) {
            match speed {
                Some(speed) => row.wheel_speed_rad_s[wheel] = speed,
                None => {
                    interpolation.left_out[wheel] += 1;
                    *is_covered = false;
                }
            }
        }
    }
    let mut is_covered = is_covered.into_iter();
    rows.retain(|_| is_covered.next().unwrap_or(false));
    Some(interpolation)
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Readings of one wheel.
struct Readings<'a> {
    tachometer: Tachometer,
    times_us: &'a [i64],
    rad_s: Vec<f64>,
    period_s: f64,
}

/// Mean speeds by the instants of their middles.
#[derive(Default)]
struct Means {
    samples: Samples,
    /// Typical duration of a mean, s.
    mean_s: f64,
    /// Distance of the second difference, µs.
    distance_us: i64,
    /// Mean square of the error that depends on speed and acceleration, (rad/s)².
    square: f64,
}

impl Readings<'_> {
    /// Rows with a reading of their own: all, or one each time that the output is renewed.
    fn fresh(&self) -> Vec<usize> {
        let rows = 0..self.rad_s.len();
        let hold_us = self.tachometer.hold_s * 1e6;
        let first_change = rows.clone().skip(1).find(|row| self.rad_s[*row] != self.rad_s[row - 1]);
        let Some(first) = first_change.filter(|_| hold_us > 0.0) else { return rows.collect() };
        let is_renewed = |row: &usize| {
            let holds = (self.times_us[*row] - self.times_us[first]) as f64 / hold_us;
            (holds - holds.round()).abs() * hold_us < 0.5e6 * self.period_s
        };
        rows.filter(is_renewed).collect()
    }

    fn means(&self) -> Means {
        let edge_rad = self.tachometer.edge_rad();
        let mut means = Means::default();
        let (mut durations, mut squares) = (Vec::new(), Vec::new());
        let mut before: Option<usize> = None;
        for row in self.fresh() {
            let (time_us, speed) = (self.times_us[row], self.rad_s[row]);
            let since = before.replace(row).map(|before| {
                ((time_us - self.times_us[before]) as f64 * 1e-6, speed - self.rad_s[before])
            });
            let (since_s, change) = since.unwrap_or((self.period_s, 0.0));
            let (mean_s, age_s, rounding_rad_s) = match self.tachometer.kind {
                TachometerKind::Speed => (0.0, 0.0, 0.0),
                TachometerKind::Mean => (self.period_s, 0.0, 0.0),
                TachometerKind::Count { window_s } => {
                    let window_s = window_s.unwrap_or(self.period_s);
                    (window_s, 0.0, edge_rad / window_s)
                }
                TachometerKind::Period { resolution_s } => {
                    let between_s = edge_rad / speed.abs();
                    // Of a wheel this slow, the same reading again is the old one: no edge has come since.
                    let is_repeated = change == 0.0 && between_s > 0.5 * since_s;
                    if is_repeated || between_s > MOST_BETWEEN * self.period_s {
                        continue;
                    }
                    let rounding_rad_s = speed * speed * resolution_s / edge_rad;
                    (between_s, between_s.min(since_s), rounding_rad_s)
                }
            };
            let delay_s = self.tachometer.latency_s + 0.5 * (mean_s + age_s);
            means.samples.push(time_us - (delay_s * 1e6).round() as i64, vec![speed]);
            let of_age = change / since_s * age_s;
            squares.push(of_age * of_age / 12.0 + rounding_rad_s * rounding_rad_s / 6.0);
            durations.push(mean_s);
        }
        means.square = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        means.mean_s = median(durations.into_iter()).unwrap_or(0.0);
        let apart_s = self.period_s.max(self.tachometer.hold_s).max(means.mean_s);
        means.distance_us = (apart_s * 1e6).round() as i64;
        means
    }
}

impl Means {
    /// Speeds at these instants, rad/s; none outside those of the readings.
    fn speeds_rad_s(&self, times_us: &[i64]) -> Vec<Option<f64>> {
        let interpolator = self.samples.interpolator(Between::Cubic);
        let mean = |time_us: i64| Some(*interpolator.at(time_us)?.first()?);
        let distance_us = self.distance_us;
        let share = self.mean_s * 1e6 / distance_us.max(1) as f64;
        let speed = |time_us: &i64| {
            let middle = mean(*time_us)?;
            // At an end the difference about the nearest instant that has one.
            let around = [*time_us, time_us + distance_us, time_us - distance_us];
            let difference = around.into_iter().filter(|_| share > 0.0).find_map(|centre_us| {
                let ends = mean(centre_us - distance_us)? + mean(centre_us + distance_us)?;
                Some(ends - 2.0 * mean(centre_us)?)
            });
            Some(middle - difference.unwrap_or(0.0) * share * share / 24.0)
        };
        times_us.iter().map(speed).collect()
    }

    /// Error of a speed, one sigma, rad/s.
    fn sigma_rad_s(&self, tachometer: &Tachometer) -> f64 {
        let held = self.samples.error().first().copied().filter(|_| tachometer.hold_s > 0.0);
        let held = held.unwrap_or(0.0);
        (self.square + tachometer.resolution_sigma_rad_s().powi(2) + held * held).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// Speed, and angle, of a wheel that swings without reversal.
    fn speed(t: f64) -> f64 {
        150.0 + 40.0 * (0.7 * t).sin()
    }

    fn angle(t: f64) -> f64 {
        150.0 * t - 40.0 / 0.7 * (0.7 * t).cos()
    }

    /// Largest error of the corrected speeds, their stated sigma, and the number of rows, of 200 rows at 10 Hz.
    fn corrected(tachometer: Tachometer, reading: impl Fn(f64) -> f64) -> (f64, f64, usize) {
        let row = |k: u64| LogRow {
            line: k + 2,
            time_us: k * 100_000,
            rate_rad_s: Vector3::zeros(),
            wheel_speed_rad_s: vec![reading(k as f64 * 0.1)],
            torque_n_m: Vector3::zeros(),
            attitude: None,
        };
        let mut rows: Vec<LogRow> = (0..200).map(row).collect();
        let hardware =
            StatedHardware { tachometers: vec![tachometer], ..StatedHardware::default() };
        let sigma = correct(&mut rows, &hardware).unwrap().sigma_rad_s[0];
        let error = |row: &LogRow| row.wheel_speed_rad_s[0] - speed(row.time_us as f64 * 1e-6);
        // Without the ends, where a parabola is extrapolated.
        let inner = rows[3..rows.len() - 3].iter().map(|row| error(row).abs());
        (inner.fold(0.0, f64::max), sigma, rows.len())
    }

    #[test]
    fn ideal_tachometer_is_not_corrected() {
        let mut rows = Vec::new();
        assert_eq!(correct(&mut rows, &StatedHardware::ideal(1)), None);
    }

    #[test]
    fn latency_and_mean_are_corrected() {
        let late = Tachometer { latency_s: 0.03, ..Tachometer::default() };
        let (error, sigma, rows) = corrected(late, |t| speed(t - 0.03));
        // An uncorrected latency has an error of 0.84 rad/s.
        assert!(error < 2e-3 && sigma == 0.0, "{error} {sigma}");
        assert_eq!(rows, 199);
        let mean = Tachometer { kind: TachometerKind::Mean, ..Tachometer::default() };
        let (error, ..) = corrected(mean, |t| (angle(t) - angle(t - 0.1)) / 0.1);
        assert!(error < 2e-3, "{error}");
    }

    #[test]
    fn error_of_a_period_is_that_of_the_age_of_its_edge() {
        let resolution_s = 1e-9;
        let period =
            Tachometer { kind: TachometerKind::Period { resolution_s }, ..Tachometer::default() };
        let edge = period.edge_rad();
        // Time at which the angle was passed, by Newton's method.
        let passed =
            |angle_rad: f64, t: f64| (0..20).fold(t, |s, _| s - (angle(s) - angle_rad) / speed(s));
        let reading = |t: f64| {
            let last = (angle(t) / edge).floor() * edge;
            edge / (passed(last, t) - passed(last - edge, t))
        };
        let (error, sigma, _) = corrected(period, reading);
        // Acceleration 28 rad/s² at most, 20 RMS; 7 ms between edges: uniform within half of that.
        let expected = 20.0 * 7e-3 / 12f64.sqrt();
        assert!((0.8..1.25).contains(&(sigma / expected)), "{sigma} {expected}");
        assert!(error > sigma && error < 28.0 * 10e-3 * 0.55, "{error} {sigma}");
    }

    /// A spare wheel at rest, and one at a speed below an edge for each sample: without an edge they do not differ from a stale reading.
    #[test]
    fn wheel_with_a_constant_reading_loses_no_row() {
        let period = Tachometer {
            kind: TachometerKind::Period { resolution_s: 1e-6 },
            ..Tachometer::default()
        };
        for constant in [0.0, 2.0, 20.0, 300.0] {
            let (_, sigma, rows) = corrected(period, |_| constant);
            assert_eq!((sigma, rows), (0.0, 200), "{constant}");
        }
        let (_, sigma, rows) = corrected(Tachometer { quantum_rad_s: 1.0, ..period }, |_| 300.0);
        assert!((sigma - 1.0 / 12f64.sqrt()).abs() < 1e-12 && rows == 200, "{sigma} {rows}");
    }

    /// Half a minute of a wheel with an edge a second among samples at 10 Hz.
    #[test]
    fn rows_of_a_wheel_that_is_too_slow_are_left_out_and_told() {
        let kind = TachometerKind::Period { resolution_s: 1e-6 };
        let hardware = StatedHardware {
            tachometers: vec![Tachometer { kind, ..Tachometer::default() }],
            ..StatedHardware::default()
        };
        let mut rows: Vec<LogRow> = (0..300)
            .map(|k| LogRow {
                line: k + 2,
                time_us: k * 100_000,
                rate_rad_s: Vector3::zeros(),
                wheel_speed_rad_s: vec![1.0 + 1e-3 * k as f64],
                torque_n_m: Vector3::zeros(),
                attitude: None,
            })
            .collect();
        let error = correct(&mut rows, &hardware).unwrap();
        assert_eq!((rows.len(), &error.left_out[..]), (0, &[300][..]));
        assert!(error.notes()[0].starts_with("300 rows are left out: wheel 1 has no speed"));
    }
}
