//! Standard manoeuvres for comparison, within the same limits.
//!
//! | family | torque on the body |
//! |---|---|
//! | fourteen profiles | those of \[ElHariry2026\]: constant, sines, multisine, chirp, two-level, random |
//! | sequential slews | about x, then y, then z: accelerate, brake and return, the torque ±1 |
//! | single axis | the slew about one axis, for the whole duration |
//! | tuned cosines | about each axis a cosine of another frequency: of the torque, or of the rotation with smooth ends |
//!
//! The first three are the standard manoeuvres. The frequency of the cosines is the best of a sweep for the very
//! limits, a one-parameter design of its own, and is compared apart.
//!
//! The profiles of the paper last 60 s; in a longer manoeuvre they repeat, in a shorter one they are cut.
//! Each is tapered over 2 s at both ends and made drift-free: terms `w` and `w (t − T/2)` of the taper `w` are
//! subtracted, so that `∫ u dt = ∫∫ u dt² = 0`. It is then scaled to the limits. A rotation left at the end, of
//! second order in the excursion, is permitted.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2, Vector3};

use super::command::Table;
use super::problem::Problem;
use crate::input::Scenario;
use crate::papers::elhariry_2026::{FAMILY, PROFILES};

/// Duration of the profiles of the paper, s.
const PAPER_S: f64 = 60.0;
/// Duration of the taper, s, and most of it, share of the manoeuvre.
const TAPER_S: f64 = 2.0;
const MOST_TAPER: f64 = 0.1;
/// Name of the family of cosines with the best number of cycles.
pub const COSINES: &str = "cosines";
/// Name of the slews about the three axes in turn.
pub(super) const SEQUENTIAL_SLEWS: &str = "sequential-slews";

/// A manoeuvre of a fixed shape.
pub(super) struct Fixed {
    pub name: String,
    pub table: Table,
}

/// All fixed manoeuvres of a problem, not yet scaled.
pub(super) fn all(problem: &Problem) -> Vec<Fixed> {
    let duration_s = problem.duration_s;
    let mut all = Vec::new();
    let mut add = |name: String, torque: &dyn Fn(f64) -> Vector3<f64>| {
        all.push(Fixed { name, table: table(problem, torque) });
    };
    for name in PROFILES {
        if let Ok(scenario) = Scenario::load(&format!("{FAMILY}{name}")) {
            add(name.to_owned(), &|t| scenario.torque.at(t % PAPER_S));
        }
    }
    for (axis, name) in ["single-axis-x", "single-axis-y", "single-axis-z"].into_iter().enumerate()
    {
        add(name.to_owned(), &|t| Vector3::ith(axis, slew(t / duration_s)));
    }
    add(SEQUENTIAL_SLEWS.to_owned(), &|t| {
        let third = 3.0 * t / duration_s;
        Vector3::ith((third as usize).min(2), slew(third.fract()))
    });
    for cycles in cycles(problem) {
        let turns = |axis: usize, t: f64| f64::from(cycles) * RATIOS[axis] * t / duration_s;
        let moments = problem.prior.inertia_kg_m2;
        add(format!("{COSINES}-of-torque-{cycles}"), &|t| {
            Vector3::from_fn(|axis, _| moments[axis] * (TAU * turns(axis, t)).cos())
        });
    }
    all.extend(cycles(problem).into_iter().map(|cycles| Fixed {
        name: format!("{COSINES}-{cycles}"),
        table: cosines(problem, cycles),
    }));
    all
}

/// Slew from rest to rest and back over the share of its duration: torque +1, −1, −1, +1.
fn slew(share: f64) -> f64 {
    if (0.25..0.75).contains(&share) { -1.0 } else { 1.0 }
}

/// Numbers of cycles of the slowest cosine: each about a quarter more than the last, to the highest that the
/// estimator resolves.
fn cycles(problem: &Problem) -> Vec<u32> {
    /// Samples per cycle of the fastest cosine.
    const FEWEST_SAMPLES: f64 = 32.0;
    let most = problem.duration_s * problem.rate_hz / FEWEST_SAMPLES / RATIOS[2];
    let mut all = vec![1];
    while let Some(last) = all.last().copied()
        && f64::from(last) * 1.25 < most
    {
        all.push((f64::from(last) * 1.25).ceil() as u32);
    }
    all
}

/// Frequencies about the three axes over that of the slowest: the motions are nearly orthogonal.
const RATIOS: [f64; 3] = [1.0, 4.0 / 3.0, 5.0 / 3.0];

/// Table of rotations `θ(t) = w(t) cos(2π f (t − T/2))` of equal amplitude, `w` a sine squared over one cycle of the
/// slowest at both ends. The torque is `J θ̈` by second differences, whose sums `Σ u` and `Σ t u` are zero.
fn cosines(problem: &Problem, cycles: u32) -> Table {
    let step_s = 1.0 / problem.rate_hz;
    let last = (problem.duration_s * problem.rate_hz).round() as i64;
    let ramp = (last as f64 / f64::from(cycles)).min(last as f64 / 2.0);
    let moments = problem.prior.inertia_kg_m2;
    let angle = |row: i64| -> Vector3<f64> {
        let end = row.min(last - row).max(0) as f64;
        let window = (TAU / 4.0 * (end / ramp).min(1.0)).sin().powi(2);
        let middle = row as f64 / last as f64 - 0.5;
        Vector3::from_fn(|axis, _| {
            let turns = f64::from(cycles) * RATIOS[axis] * middle;
            moments[axis] * window * (TAU * turns).cos()
        })
    };
    let body: Vec<Vector3<f64>> =
        (0..=last).map(|row| angle(row - 1) - angle(row) * 2.0 + angle(row + 1)).collect();
    of_channels(problem, &body, step_s)
}

/// The drift-free table of a torque on the body.
fn table(problem: &Problem, torque: &dyn Fn(f64) -> Vector3<f64>) -> Table {
    let step_s = 1.0 / problem.rate_hz;
    let rows = (problem.duration_s * problem.rate_hz).round() as usize + 1;
    let end_s = (rows - 1) as f64 * step_s;
    let taper_s = TAPER_S.min(MOST_TAPER * end_s);
    let time = |row: usize| row as f64 * step_s;
    let taper = |row: usize| (time(row).min(end_s - time(row)) / taper_s).clamp(0.0, 1.0);
    let lever = |row: usize| time(row) / end_s - 0.5;
    let mut body: Vec<Vector3<f64>> = (0..rows).map(|row| torque(time(row)) * taper(row)).collect();
    let sums = (0..rows).fold([0.0; 3], |[a, b, c], row| {
        let (w, x) = (taper(row), lever(row));
        [a + w, b + w * x, c + w * x * x]
    });
    let normal = Matrix2::new(sums[0], sums[1], sums[1], sums[2]);
    if let Some(inverse) = normal.try_inverse() {
        for axis in 0..3 {
            let moments = body.iter().enumerate().fold(Vector2::zeros(), |sum, (row, v)| {
                sum + Vector2::new(v[axis], v[axis] * lever(row))
            });
            let terms = inverse * moments;
            for (row, v) in body.iter_mut().enumerate() {
                v[axis] -= taper(row) * (terms[0] + terms[1] * lever(row));
            }
        }
    }
    of_channels(problem, &body, step_s)
}

/// Table of wheels and pairs for a torque on the body, the channel of largest share at its limit.
fn of_channels(problem: &Problem, body: &[Vector3<f64>], step_s: f64) -> Table {
    let distribution = problem.distribution();
    let (wheels, pairs) = distribution.split_at(problem.wheels.len());
    let of = |channels: &[Vector3<f64>]| -> Vec<Vec<f64>> {
        body.iter().map(|v| channels.iter().map(|row| row.dot(v)).collect()).collect()
    };
    let table = Table { step_s, torque_n_m: of(wheels), level: of(pairs) };
    let share = |row: &Vec<f64>| {
        let shares = row.iter().zip(&problem.wheels).map(|(u, w)| u.abs() / w.max_torque_n_m);
        shares.fold(0.0, f64::max)
    };
    let largest = table.torque_n_m.iter().map(share).fold(0.0, f64::max);
    let levels = table.level.iter().flatten();
    let largest = levels.fold(largest, |most, level| most.max(level.abs()));
    table.scaled(if largest > 0.0 { 1.0 / largest } else { 0.0 })
}
