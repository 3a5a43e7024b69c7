//! Gyro readings that a log holds for several rows, because the log is faster than the gyro.
//!
//! A held reading is a measurement at the first of its rows only. The other rows are left out: as
//! measurements they would be wrong by the motion since. Criterion, so that neither a coarse quantum
//! nor a stuck gyro is taken for it: the runs of equal readings are regular in length, and two axes or
//! more change from run to run.

use nalgebra::Vector3;

use super::record::LogRow;
use crate::words::short;

/// Fewest complete runs for a decision.
const MIN_RUNS: usize = 8;
/// Least share of runs of the typical length.
const REGULAR_SHARE: f64 = 0.9;
/// Least share of changes on two axes or more. A slow rotation with a coarse quantum changes one axis
/// at a time.
const JOINT_SHARE: f64 = 0.8;

/// Rows of a log whose gyro readings are new.
pub(super) struct Fresh {
    /// Rows, by index.
    rows: Vec<usize>,
    /// Mean number of rows per reading.
    rows_per_reading: f64,
}

impl Fresh {
    /// The fresh rows, if the log holds its readings.
    pub(super) fn find(rows: &[LogRow]) -> Option<Self> {
        let starts = run_starts(rows.len(), |row| changed_axes(rows, row));
        let Runs { median, mean } = Runs::of(&starts)?;
        let joint = starts.iter().skip(1).filter(|start| changed_axes(rows, **start) >= 2).count();
        let is_held = joint as f64 / (starts.len() - 1) as f64 >= JOINT_SHARE;
        let is_first_whole = starts[1] - starts[0] >= median;
        let rows = starts[usize::from(!is_first_whole)..].to_vec();
        is_held.then_some(Self { rows, rows_per_reading: mean })
    }

    /// The fresh rows. Wheel speeds are those of the row; the torque is the mean over one period of
    /// the gyro about it, so that pulses between two readings are kept.
    pub(super) fn take(&self, rows: &[LogRow]) -> Vec<LogRow> {
        let half = (self.rows_per_reading / 2.0) as usize;
        let mean_torque = |row: usize| {
            // The same number of rows on both sides: exact for a torque linear in time.
            let side = half.min(row).min(rows.len() - 1 - row);
            let period = &rows[row - side..=row + side];
            period.iter().map(|row| row.torque_n_m).sum::<Vector3<f64>>() / period.len() as f64
        };
        let fresh = |&row: &usize| LogRow { torque_n_m: mean_torque(row), ..rows[row].clone() };
        self.rows.iter().map(fresh).collect()
    }

    /// Rates of gyro and log, in words.
    pub(super) fn note(&self, rows: &[LogRow]) -> String {
        let mut periods: Vec<u64> =
            rows.windows(2).map(|pair| pair[1].time_us - pair[0].time_us).collect();
        periods.sort_unstable();
        let log_hz = 1e6 / periods.get(periods.len() / 2).map_or(1.0, |us| *us as f64);
        format!(
            "the gyro's rate is {} Hz, the log's {} Hz: the {} rows that repeat a reading are left out",
            short(log_hz / self.rows_per_reading),
            short(log_hz),
            rows.len() - self.rows.len()
        )
    }
}

/// Rows at which the wheels have a new reading, if the log holds their readings for a regular number of
/// rows. The first is the start of a whole run.
pub(super) fn fresh_wheel_rows(rows: &[LogRow]) -> Option<Vec<usize>> {
    let changed = |row: usize| {
        let (new, old) = (&rows[row].wheel_speed_rad_s, &rows[row - 1].wheel_speed_rad_s);
        usize::from(new != old)
    };
    let mut starts = run_starts(rows.len(), changed);
    let runs = Runs::of(&starts)?;
    if starts[1] - starts[0] < runs.median {
        starts.remove(0);
    }
    Some(starts)
}

/// Length of the runs of equal readings.
struct Runs {
    median: usize,
    mean: f64,
}

impl Runs {
    /// The typical run; none for readings that are not held, or held irregularly.
    fn of(starts: &[usize]) -> Option<Self> {
        // The first run may have begun before the log, the last may end after it.
        let lengths: Vec<usize> = starts.windows(2).skip(1).map(|pair| pair[1] - pair[0]).collect();
        if lengths.len() < MIN_RUNS {
            return None;
        }
        let mut sorted = lengths.clone();
        sorted.sort_unstable();
        let median = sorted[sorted.len() / 2];
        let near: Vec<usize> =
            lengths.iter().copied().filter(|length| length.abs_diff(median) <= 1).collect();
        let mean = near.iter().sum::<usize>() as f64 / near.len() as f64;
        // Two rows per reading: an exact length, since a run of one row is no repetition.
        let is_regular = |length: &&usize| median >= 3 || (**length as f64 - mean).abs() < 1.0;
        let regular = near.iter().filter(is_regular).count() as f64 / lengths.len() as f64;
        (median >= 2 && regular >= REGULAR_SHARE).then_some(Self { median, mean })
    }
}

/// First rows of the runs of equal readings; `changed` is the number of values with another reading than
/// in the previous row.
fn run_starts(rows: usize, changed: impl Fn(usize) -> usize) -> Vec<usize> {
    (0..rows).filter(|row| *row == 0 || changed(*row) > 0).collect()
}

/// Number of axes with another reading than in the previous row.
fn changed_axes(rows: &[LogRow], row: usize) -> usize {
    let (new, old) = (&rows[row].rate_rad_s, &rows[row - 1].rate_rad_s);
    new.iter().zip(old.iter()).filter(|(new, old)| new != old).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows at 100 Hz; `reading` gives the rate of a row, the torque rises with time.
    fn log(rows: usize, reading: impl Fn(usize) -> [f64; 3]) -> Vec<LogRow> {
        let row = |index: usize| LogRow {
            line: index as u64 + 2,
            time_us: index as u64 * 10_000,
            rate_rad_s: Vector3::from(reading(index)),
            wheel_speed_rad_s: vec![index as f64],
            torque_n_m: Vector3::repeat(index as f64),
            attitude: None,
        };
        (0..rows).map(row).collect()
    }

    /// A rate that differs on all axes from instant to instant.
    fn moving(instant: usize) -> [f64; 3] {
        [1.0, 1.7, 2.9].map(|frequency| (frequency * instant as f64).sin())
    }

    #[test]
    fn held_readings_are_reduced_to_their_first_rows() {
        // The first reading is held for 13 more rows: its instant is unknown.
        let rows = log(400, |row| moving((row + 7) / 20));
        let fresh = Fresh::find(&rows).unwrap();
        let taken = fresh.take(&rows);
        assert_eq!(taken.len(), 20);
        for (row, index) in taken.iter().zip(0..) {
            let start = 13 + 20 * index;
            assert_eq!((row.time_us, row.wheel_speed_rad_s[0]), (start * 10_000, start as f64));
            assert_eq!(row.torque_n_m, Vector3::repeat(start as f64));
        }
        assert_eq!(
            fresh.note(&rows),
            "the gyro's rate is 5 Hz, the log's 100 Hz: the 380 rows that repeat a reading are left out"
        );
    }

    #[test]
    fn torque_pulse_between_two_readings_is_kept() {
        let mut rows = log(400, |row| moving(row / 20));
        rows.iter_mut().for_each(|row| row.torque_n_m = Vector3::zeros());
        rows[107].torque_n_m = Vector3::repeat(21.0);
        let taken = Fresh::find(&rows).unwrap().take(&rows);
        let impulse: Vector3<f64> = taken.iter().map(|row| row.torque_n_m).sum();
        assert_eq!(impulse, Vector3::repeat(1.0));
    }

    #[test]
    fn readings_held_for_two_or_three_rows_in_turn_are_found() {
        let rows = log(500, |row| moving(row * 2 / 5));
        let fresh = Fresh::find(&rows).unwrap();
        assert!((fresh.rows_per_reading - 2.5).abs() < 0.05, "{}", fresh.rows_per_reading);
    }

    #[test]
    fn other_repetitions_are_not_held_readings() {
        let every_row = |row| moving(row);
        let stuck_once = |row: usize| moving(row.clamp(100, 150));
        let slow_and_coarse = |row: usize| [(row / 20) as f64 * 1e-3, 0.0, 0.0];
        let noisy_and_coarse = |row: usize| moving(row).map(|rate| (rate * 0.8).round());
        for rows in [
            log(400, every_row),
            log(400, stuck_once),
            log(400, slow_and_coarse),
            log(400, noisy_and_coarse),
            log(400, |_| [0.0; 3]),
            log(3, |row| moving(row / 2)),
            Vec::new(),
        ] {
            assert!(Fresh::find(&rows).is_none());
        }
    }
}
