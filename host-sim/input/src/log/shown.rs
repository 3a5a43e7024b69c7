//! The tachometer that the readings of a wheel show, where none is stated.
//!
//! | readings | assumed |
//! |---|---|
//! | change at a regular number of rows only | output held for that time |
//! | are multiples of one number q | rounded to q |
//! | repeat where the wheel is slow; the angle between two changes is the same there | time between edges δ of that angle |
//! | have inverses that are multiples of one number s | time between edges, timer of the resolution `s δ` |
//!
//! Below one edge a sample, a reading Ω changes with each edge: the times between changes add up to `δ Σ 1/Ω`, to a third where
//! the wheel accelerates. Within that, or where a wheel is never that slow, δ is the angle of a whole number of edges a turn
//! for which `s δ` is a power of ten of a second. Without either it is that of the default.
//!
//! A latency and a mean leave no mark in the readings: they are part of the time offset. Readings without a mark are those
//! of an ideal tachometer.

use std::f64::consts::TAU;

use crate::craft::hardware::{Tachometer, TachometerKind};

/// Fewest different readings for a decision.
const MIN_READINGS: usize = 8;
/// Least share of changes in step with a hold.
const REGULAR_SHARE: f64 = 0.95;
/// Smallest step between numbers, share of the largest: that of a float of 24 bits is below it.
const LEAST_STEP: f64 = 1e-5;
/// Distance of a number from a multiple of the step, steps.
const OFF_STEP: f64 = 0.05;
/// Fewest changes of slow readings, and the samples between two edges that make a reading slow.
const MIN_SLOW: usize = 8;
const MIN_APART: f64 = 2.0;
/// Least factor between the slowest and the fastest of them. The same reading again at a constant speed is no sign of an
/// edge.
const LEAST_RANGE: f64 = 1.5;
/// Distance of the time between two changes from that between two edges, samples, and the least share of changes within
/// it. Both edges are late by up to one sample.
const MOST_OFF: f64 = 1.5;
const REGULAR_SLOW: f64 = 0.8;
/// Largest factor between the edges by a timer and those by slow readings.
const MOST_UNLIKE: f64 = 1.4;
/// Distance of a number of edges from a whole one, share.
const OFF_WHOLE: f64 = 1e-3;
/// Largest number of edges a turn.
const MOST_EDGES: f64 = 512.0;

/// Readings of one wheel, and the times of their rows.
pub(super) struct Shown<'a> {
    pub times_us: &'a [i64],
    pub rad_s: &'a [f64],
    pub period_s: f64,
}

impl Shown<'_> {
    /// The tachometer of these readings; none where they have no mark of one.
    pub(super) fn tachometer(&self) -> Option<Tachometer> {
        let ideal = Tachometer::default();
        let changes: Vec<usize> =
            (1..self.rad_s.len()).filter(|row| self.rad_s[*row] != self.rad_s[row - 1]).collect();
        let readings = distinct(self.rad_s.iter().copied());
        if readings.len() < MIN_READINGS {
            return None;
        }
        let hold_s = held_rows(&changes).map_or(0.0, |rows| rows as f64 * self.period_s);
        let quantum = step(&readings);
        if hold_s > 0.0 || quantum.is_some() {
            return Some(Tachometer { hold_s, quantum_rad_s: quantum.unwrap_or(0.0), ..ideal });
        }
        let fastest = self.rad_s.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()));
        // Of slow readings the digits of a log are too few.
        let fast = self.rad_s.iter().filter(|speed| speed.abs() > 0.5 * fastest);
        let inverses = distinct(fast.map(|speed| speed.abs().recip()));
        let timer = (inverses.len() >= MIN_READINGS).then(|| step(&inverses)).flatten();
        let slow = self.edges_when_slow(&changes);
        slow.or(timer)?;
        let of_timer = timer.and_then(|timer| edges_of_timer(timer, slow));
        let edges_per_turn = of_timer.or(slow).unwrap_or(ideal.edges_per_turn);
        let resolution_s = timer.map_or(0.0, |timer| timer * TAU / edges_per_turn);
        Some(Tachometer { kind: TachometerKind::Period { resolution_s }, edges_per_turn, ..ideal })
    }

    /// Edges per turn by the changes of slow readings; none without enough of them, or where their angles differ.
    fn edges_when_slow(&self, changes: &[usize]) -> Option<f64> {
        let since_last = |pair: &[usize]| Change {
            time_s: (self.times_us[pair[1]] - self.times_us[pair[0]]) as f64 * 1e-6,
            rad_s: self.rad_s[pair[1]].abs(),
        };
        let mut all: Vec<Change> = changes.windows(2).map(since_last).collect();
        all.retain(|change| change.rad_s > 0.0);
        all.sort_unstable_by(|a, b| a.rad_s.total_cmp(&b.rad_s));
        let edge_rad = edge_rad(all.get(..MIN_SLOW)?);
        let slow_rad_s = edge_rad / (MIN_APART * self.period_s);
        let slow = &all[..all.partition_point(|change| change.rad_s < slow_rad_s)];
        let (slowest, fastest) = (slow.first()?.rad_s, slow.last()?.rad_s);
        if slow.len() < MIN_SLOW || fastest < LEAST_RANGE * slowest {
            return None;
        }
        let edge_rad = self::edge_rad(slow);
        let off_s = |change: &Change| (change.time_s - edge_rad / change.rad_s).abs();
        let regular = slow.iter().filter(|change| off_s(change) < MOST_OFF * self.period_s).count();
        let edges = (TAU / edge_rad).round();
        let is_regular = regular as f64 >= REGULAR_SLOW * slow.len() as f64;
        (is_regular && (1.0..=MOST_EDGES).contains(&edges)).then_some(edges)
    }
}

/// A change of the reading.
struct Change {
    /// Time since the change before.
    time_s: f64,
    /// Size of the new reading.
    rad_s: f64,
}

/// Angle between edges, if each of the changes is one.
fn edge_rad(changes: &[Change]) -> f64 {
    let time_s: f64 = changes.iter().map(|change| change.time_s).sum();
    time_s / changes.iter().map(|change| change.rad_s.recip()).sum::<f64>()
}

/// Number of rows of a hold: that between most changes, if nearly all changes are in step with it.
fn held_rows(changes: &[usize]) -> Option<usize> {
    let mut apart: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    apart.sort_unstable();
    let rows = *apart.get(apart.len() / 2)?;
    let (first, count) = (*changes.first()?, changes.len());
    let in_step = changes.iter().filter(|row| (*row - first).is_multiple_of(rows)).count();
    let is_held = rows >= 2 && count >= MIN_READINGS;
    (is_held && in_step as f64 >= REGULAR_SHARE * count as f64).then_some(rows)
}

/// Different numbers, sorted.
fn distinct(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup();
    sorted
}

/// Largest number that all of these are multiples of; none below [`LEAST_STEP`].
fn step(sorted: &[f64]) -> Option<f64> {
    let largest = sorted.iter().fold(0.0, |most: f64, number| most.max(number.abs()));
    let least = LEAST_STEP * largest;
    let mut step = 0.0f64;
    for pair in sorted.windows(2) {
        let apart = pair[1] - pair[0];
        if apart < OFF_STEP * least {
            continue; // The same number, with a rounding error.
        }
        let (mut a, mut b) = (step.max(apart), step.min(apart));
        // Euclid's algorithm: the larger one falls by half or more every second time.
        while b > OFF_STEP * least {
            let rest = a % b;
            (a, b) = (b, rest.min(b - rest));
        }
        step = a;
        if step < least {
            return None;
        }
    }
    // Least squares over ascending distances: the step so far is exact enough to count the steps of the next one. Distances
    // from the first number come first, since those from zero begin with many steps.
    let first = *sorted.first()?;
    let outwards = sorted.iter().map(|number| number - first).chain(sorted.iter().copied());
    let mut sums = [0.0; 2];
    for number in outwards {
        let steps = (number / step).round();
        sums = [sums[0] + steps * number, sums[1] + steps * steps];
        if sums[1] > 0.0 {
            step = sums[0] / sums[1];
        }
    }
    let is_on = |number: &f64| {
        let steps = number / step;
        (steps - steps.round()).abs() < OFF_STEP
    };
    (step >= least && sorted.iter().all(is_on)).then_some(step)
}

/// Edges a turn of a timer whose resolution is a power of ten of a second, from the step of the inverses of its
/// speeds, s, and about as many as these, if any.
fn edges_of_timer(step_s: f64, about: Option<f64>) -> Option<f64> {
    let of_power = |power: i32| TAU * step_s / 10f64.powi(power);
    let is_whole = |edges: &f64| {
        let is_near = about
            .is_none_or(|about| (MOST_UNLIKE.recip()..=MOST_UNLIKE).contains(&(edges / about)));
        let off = (edges - edges.round()).abs();
        is_near && (1.0..=MOST_EDGES).contains(edges) && off < OFF_WHOLE * edges
    };
    (-9..=-3).rev().map(of_power).find(is_whole).map(f64::round)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.1;

    /// Tachometer that readings of 600 rows at 10 Hz show.
    fn shown(reading: impl FnMut(f64) -> f64) -> Option<Tachometer> {
        let times_us: Vec<i64> = (0..600).map(|row| row * 100_000).collect();
        let rad_s: Vec<f64> =
            times_us.iter().map(|time| *time as f64 * 1e-6).map(reading).collect();
        Shown { times_us: &times_us, rad_s: &rad_s, period_s: PERIOD_S }.tachometer()
    }

    /// Speed and angle of a wheel that swings about a mean speed.
    fn speed(mean: f64, t: f64) -> f64 {
        mean + 40.0 * (0.7 * t).sin()
    }

    fn angle(mean: f64, t: f64) -> f64 {
        mean * t - 40.0 / 0.7 * (0.7 * t).cos()
    }

    /// Reading of the time between the last two edges, by steps of 10 µs of the swing.
    fn of_edges(mean: f64, edges: f64, resolution_s: f64) -> impl FnMut(f64) -> f64 {
        let (edge, step_s) = (TAU / edges, 1e-5);
        let mut step = -200_000i64;
        let mut last = (angle(mean, step as f64 * step_s) / edge).floor();
        let (mut passed_s, mut reading) = (0.0, 0.0);
        move |t| {
            while (step as f64) * step_s < t {
                step += 1;
                let now_s = step as f64 * step_s;
                let number = (angle(mean, now_s) / edge).floor();
                if number != last {
                    let at_s = (now_s / resolution_s).round() * resolution_s;
                    reading = (number - last) * edge / (at_s - passed_s);
                    (last, passed_s) = (number, at_s);
                }
            }
            reading
        }
    }

    #[test]
    fn ideal_readings_show_nothing() {
        for mean in [0.0, 60.0, 300.0] {
            assert_eq!(shown(|t| speed(mean, t)), None);
            let mean_over_sample = |t: f64| (angle(mean, t) - angle(mean, t - PERIOD_S)) / PERIOD_S;
            assert_eq!(shown(mean_over_sample), None);
            // Six digits of a log, and the mantissa of a float.
            assert_eq!(shown(|t| f64::from(speed(mean, t) as f32)), None);
            assert_eq!(shown(|t| (speed(mean, t) * 1e4).round() * 1e-4), None);
        }
        assert_eq!(shown(|_| 300.0), None);
        // Stuck for five seconds, and in steps of a command.
        assert_eq!(shown(|t| speed(150.0, if (20.0..25.0).contains(&t) { 20.0 } else { t })), None);
        assert_eq!(shown(|t| (t / 20.0).floor() * 100.0), None);
    }

    #[test]
    fn hold_and_quantum_are_those_of_the_readings() {
        let rpm = TAU / 60.0;
        for quantum in [0.01, rpm, 10.0 * rpm, TAU / 6.0 / 0.1] {
            let found = shown(|t| (speed(150.0, t) / quantum).round() * quantum).unwrap();
            assert!((found.quantum_rad_s / quantum - 1.0).abs() < 1e-6, "{quantum} {found:?}");
            assert_eq!((found.hold_s, found.kind), (0.0, TachometerKind::Speed));
        }
        for rows in [2.0, 5.0, 10.0, 30.0] {
            let hold_s = rows * PERIOD_S;
            let found = shown(|t| speed(150.0, (t / hold_s + 1e-6).floor() * hold_s)).unwrap();
            assert!(
                (found.hold_s - hold_s).abs() < 1e-9 && found.quantum_rad_s == 0.0,
                "{found:?}"
            );
        }
    }

    /// A wheel that is always fast shows the timer, one that reverses the edges too.
    #[test]
    fn edges_are_those_of_the_readings() {
        for (mean, edges) in [(150.0, 6.0), (150.0, 24.0), (0.0, 6.0), (0.0, 12.0), (0.0, 1.0)] {
            let found = shown(of_edges(mean, edges, 1e-5)).unwrap();
            let TachometerKind::Period { resolution_s } = found.kind else { panic!("{found:?}") };
            assert_eq!(found.edges_per_turn, edges, "{mean} {edges}: {found:?}");
            assert!((resolution_s / 1e-5 - 1.0).abs() < 1e-9, "{mean} {edges}: {found:?}");
        }
    }
}
