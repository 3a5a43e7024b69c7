//! Levels of pairs of thrusters rounded to pulses.
//!
//! Time is divided into cells of the shortest pulse. In each cell `k` a pair has its first thruster on, `q = 1`, its
//! second, `q = −1`, or neither. The pulses follow the mean levels `u` by feedback of the sums of the error,
//!
//! ```text
//! q_k = round(u_k + e_k + β f_k),   e_{k+1} = e_k + u_k − q_k,   f_{k+1} = f_k + e_{k+1},   β = 0.03
//! ```
//!
//! whose poles are 0 and 1 − β. Rate and attitude, the sums `Σ q` and `ΣΣ q`, stay within a few pulses of those of the
//! levels.
//!
//! Levels that are symmetric about their middle are rounded in the first half and mirrored, and `Σ q` of the half is
//! made zero: from rest the body then retraces its path in the second half. Otherwise `Σ q` and `Σ k q` of the whole
//! are made zero, by which rate and attitude return to first order.
//!
//! A thruster is switched halfway between two samples. Torque that is linear between the samples then has the same
//! impulse between any two, and the estimator reads the rates that it expects.

use super::command::Table;
use super::problem::{Problem, pairs};
use crate::input::Scenario;

/// Feedback `β` of the second sum. At 0.1 a small level has ten times the pulses, for a third of the error.
const FEEDBACK: f64 = 0.03;
/// Largest sum fed back, in pulses: the loop recovers from a level that three values cannot follow.
const MOST_ERROR: f64 = 10.0;
/// Difference of mirrored levels below which they are symmetric: rounding.
const SYMMETRY: f64 = 1e-9;

impl Problem {
    /// The table with the levels rounded to pulses; without thrusters unchanged.
    pub(super) fn in_pulses(&self, table: &Table) -> Table {
        let mut rounded = table.clone();
        for (index, pair) in self.pairs.iter().enumerate() {
            let level: Vec<f64> = table.level.iter().map(|row| row[index]).collect();
            let rows = rounded.level.iter_mut().zip(in_pulses(&level, pair.pulse_samples));
            rows.for_each(|(row, pulse)| row[index] = pulse);
        }
        rounded
    }
}

/// Level of each sample: 1, 0 or −1.
fn in_pulses(level: &[f64], pulse_samples: usize) -> Vec<f64> {
    let mut rounded = vec![0.0; level.len()];
    let mut fill = |first: usize, cells: &[i32], mirror: Option<usize>| {
        for (cell, q) in cells.iter().enumerate() {
            for sample in (first + cell * pulse_samples..).take(pulse_samples) {
                rounded[sample] = f64::from(*q);
                if let Some(sum) = mirror {
                    rounded[sum - sample] = f64::from(*q);
                }
            }
        }
    };
    if let Some(sum) = mirror(level) {
        // The samples before the middle, of which the last cell ends with the last.
        let before = sum.div_ceil(2) - 1;
        let first = 1 + before % pulse_samples;
        let lead = level[..first].iter().sum::<f64>() / pulse_samples as f64;
        let mut cells = cells(&level[first..=before], pulse_samples, lead);
        close_sum(&mut cells, |_, k| -(k as i64));
        fill(first, &cells, Some(sum));
    } else {
        // The last sample is in no cell: all thrusters are off at the end.
        let mut cells = cells(&level[1..level.len() - 1], pulse_samples, 0.0);
        close(&mut cells);
        fill(1, &cells, None);
    }
    rounded
}

/// Sum of the places of two samples of equal level, if the levels are symmetric about their middle.
fn mirror(level: &[f64]) -> Option<usize> {
    let first = level.iter().position(|level| *level != 0.0)?;
    let last = level.iter().rposition(|level| *level != 0.0)?;
    let largest = level.iter().fold(0.0f64, |most, level| most.max(level.abs()));
    let is_even = |i: usize| (level[first + i] - level[last - i]).abs() <= SYMMETRY * largest;
    (last > first + 1 && (0..=last - first).all(is_even)).then_some(first + last)
}

/// Value of each cell; `error` is the sum of the levels before the first, in pulses.
fn cells(level: &[f64], pulse_samples: usize, mut error: f64) -> Vec<i32> {
    let mut sum = 0.0;
    let value = |own: &[f64]| {
        let mean = own.iter().sum::<f64>() / pulse_samples as f64;
        let pulse = (mean + error + FEEDBACK * sum).round().clamp(-1.0, 1.0);
        error = (error + mean - pulse).clamp(-MOST_ERROR, MOST_ERROR);
        sum = (sum + error).clamp(-MOST_ERROR, MOST_ERROR);
        pulse as i32
    };
    level.chunks_exact(pulse_samples).map(value).collect()
}

/// True if a cell has a value after this change.
fn may_change(cells: &[i32], cell: usize, change: i32) -> bool {
    (cells[cell] + change).abs() <= 1
}

/// Makes `Σ q` zero by changes of one pulse each, each at the cell of the smallest cost, of its change and place.
fn close_sum(cells: &mut [i32], cost: impl Fn(&[i32], usize) -> i64) {
    while let sum = cells.iter().sum::<i32>()
        && sum != 0
    {
        let change = -sum.signum();
        let free = (0..cells.len()).filter(|cell| may_change(cells, *cell, change));
        let Some(cell) = free.min_by_key(|cell| cost(cells, *cell)) else { return };
        cells[cell] += change;
    }
}

/// Makes `Σ q` and `Σ k q` zero by changes of one pulse each, as near to the end as possible.
fn close(cells: &mut [i32]) {
    let moment = |cells: &[i32]| -> i64 { (0..).zip(cells).map(|(k, q)| k * i64::from(*q)).sum() };
    close_sum(cells, |cells, cell| {
        let change = -i64::from(cells.iter().sum::<i32>().signum());
        (moment(cells) + cell as i64 * change).abs()
    });
    // A pulse moved by one cell changes the moment by one.
    while let moment = moment(cells)
        && moment != 0
    {
        let most = (moment.unsigned_abs() as usize).min(cells.len() - 1);
        let sign = if moment > 0 { -1 } else { 1 };
        let moved = (1..=most).rev().find_map(|distance| {
            let fits = |late: &usize| {
                may_change(cells, *late, sign) && may_change(cells, late - distance, -sign)
            };
            (distance..cells.len()).rev().find(fits).map(|late| (late - distance, late))
        });
        let Some((early, late)) = moved else { return };
        cells[late] += sign;
        cells[early] -= sign;
    }
}

impl Table {
    /// Pulses of each thruster of the scenario: times on and off, s.
    pub fn thruster_pulses_s(&self, scenario: &Scenario) -> Vec<Vec<[f64; 2]>> {
        let mut pulses = vec![Vec::new(); scenario.torque.thrusters.len()];
        let duration_s = self.step_s * self.level.len() as f64;
        for (index, pair) in pairs(scenario, duration_s).unwrap_or_default().iter().enumerate() {
            let [first, second] = self.pulses_s(index);
            pulses[pair.thrusters[0]] = first;
            pulses[pair.thrusters[1]] = second;
        }
        pulses
    }

    /// Pulses of the two thrusters of a pair: times on and off, s.
    fn pulses_s(&self, pair: usize) -> [Vec<[f64; 2]>; 2] {
        [1.0, -1.0].map(|on| {
            let is_on = |row: &usize| self.level.get(*row).is_some_and(|row| row[pair] == on);
            let starts = (0..self.level.len()).filter(|row| {
                is_on(row) && !row.checked_sub(1).is_some_and(|before| is_on(&before))
            });
            let halfway = |row: usize| (((row as f64 - 0.5) * self.step_s) * 1e7).round() / 1e7;
            let pulse = |start: usize| {
                let end = (start..).find(|row| !is_on(row)).unwrap_or(start);
                [halfway(start), halfway(end)]
            };
            starts.map(pulse).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cosine without its mean and its slope, so that rate and attitude return; zero at both ends.
    fn level(size: f64, phase: f64, cycles: f64) -> Vec<f64> {
        let lever = |k: usize| k as f64 - 300.0;
        let turns = |k: usize| cycles * lever(k) / 600.0 + phase;
        let cosine = |k: usize| size * (std::f64::consts::TAU * turns(k)).cos();
        let mean = (1..600).map(cosine).sum::<f64>() / 599.0;
        let moment: f64 = (1..600).map(|k| cosine(k) * lever(k)).sum();
        let slope = moment / (1..600).map(|k| lever(k).powi(2)).sum::<f64>();
        let level = |k: usize| cosine(k) - mean - slope * lever(k);
        (0..=600).map(|k| if k == 0 || k == 600 { 0.0 } else { level(k) }).collect()
    }

    /// Largest difference of the double sums, in pulses of 4 samples, and the final sums of the pulses.
    fn followed(level: &[f64], pulses: &[f64]) -> (f64, f64, f64) {
        let (mut error, mut angle, mut largest) = (0.0, 0.0f64, 0.0f64);
        let (mut sum, mut sums) = (0.0, 0.0);
        for (level, pulse) in level.iter().zip(pulses) {
            error += (level - pulse) / 4.0;
            angle += error / 4.0;
            largest = largest.max(angle.abs());
            sum += pulse;
            sums += sum;
            assert!([-1.0, 0.0, 1.0].contains(pulse));
        }
        (largest, sum, sums)
    }

    #[test]
    fn pulses_follow_rate_and_attitude_of_the_levels_and_return_both() {
        for (size, cycles) in [(0.7, 2.0), (0.5, 3.0), (0.1, 1.0), (0.03, 4.0)] {
            for phase in [0.0, 0.13] {
                let level = level(size, phase, cycles);
                assert_eq!(mirror(&level), (phase == 0.0).then_some(600));
                let pulses = in_pulses(&level, 4);
                let (largest, sum, sums) = followed(&level, &pulses);
                assert_eq!((sum, sums), (0.0, 0.0), "{size} {phase}");
                assert!(largest < 10.0, "{size} {phase}: {largest}");
                let mut runs = pulses.chunk_by(|a, b| a == b);
                assert!(runs.all(|run| run[0] == 0.0 || run.len() % 4 == 0));
            }
        }
    }

    #[test]
    fn pulses_are_switched_halfway_between_samples() {
        let level = [0.0, 1.0, 1.0, 0.0, -1.0, 0.0].map(|level| vec![level]).to_vec();
        let table = Table { step_s: 0.1, torque_n_m: vec![Vec::new(); 6], level };
        let [first, second] = table.pulses_s(0);
        assert_eq!((first, second), (vec![[0.05, 0.25]], vec![[0.35, 0.45]]));
    }
}
