//! The values of a log.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::tachometer::{self, MOST_BETWEEN};
use crate::craft::StatedHardware;
use crate::craft::hardware::Tachometer;

/// Reason of the rows beyond the instants of the wheels' readings.
const NO_WHEELS: &str = "no_wheels";

/// A checked log: at least one row, time strictly increasing, every value finite.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedLog {
    /// The rows, oldest first.
    pub rows: Vec<LogRow>,
    /// Time stamp of the first row in the log's own time scale, s.
    pub start_s: f64,
    /// True if the log has torque columns; otherwise the torque of each row is zero.
    pub has_torque: bool,
    /// Rows of the file that are not in `rows`, by reason.
    pub skipped_rows: BTreeMap<&'static str, u64>,
    /// Error of wheel speeds that are interpolated; none if every row has readings of its own.
    pub interpolation: Option<Interpolation>,
    /// Notes to the user, one sentence each: ignored columns, rows left out, corrections of time.
    pub notes: Vec<String>,
}

impl RecordedLog {
    /// Removes the known scale error and misalignment of the gyro from the readings, and the delay of stated
    /// tachometers. A known delay of the gyro remains: it is the mean of the estimator's time offset.
    pub fn correct(&mut self, hardware: &StatedHardware) {
        for row in &mut self.rows {
            row.rate_rad_s = hardware.corrected_rate_rad_s(&row.rate_rad_s);
        }
        let rows = self.rows.len();
        let Some(corrected) = correct_wheels(&mut self.rows, hardware) else { return };
        let left_out = rows - self.rows.len();
        if left_out > 0 {
            self.skipped_rows.insert(NO_WHEELS, left_out as u64);
        }
        self.interpolation = Some(match &self.interpolation {
            Some(held) => held.with(&corrected),
            None => corrected,
        });
    }
}

/// Corrects the wheel speeds of the rows by what is stated of the tachometers, and leaves out rows beyond the instant of
/// the last reading or before a gap. Returns the error that remains; none if nothing is stated.
pub fn correct_wheels(rows: &mut Vec<LogRow>, hardware: &StatedHardware) -> Option<Interpolation> {
    tachometer::correct(rows, hardware)
}

/// Rows at the end of a log that no reading of a mean speed follows: half the mean and a latency of a sample.
const BEYOND_READINGS: usize = 2;

/// Error of interpolated wheel speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolation {
    /// One sigma of the speed of each wheel between its readings, rad/s.
    pub sigma_rad_s: Vec<f64>,
    /// Typical time between readings, s.
    pub period_s: f64,
    /// Rows that each wheel has no speed for. They are left out.
    pub left_out: Vec<usize>,
    /// Tachometers that are not stated and that the readings show, with the index of their wheel.
    pub assumed: Vec<(usize, Tachometer)>,
}

impl Interpolation {
    /// This error and another one of the same wheels.
    fn with(&self, other: &Self) -> Self {
        let pairs = self.sigma_rad_s.iter().zip(&other.sigma_rad_s);
        Self {
            sigma_rad_s: pairs.map(|(a, b)| a.hypot(*b)).collect(),
            period_s: self.period_s.max(other.period_s),
            left_out: self.left_out.iter().zip(&other.left_out).map(|(a, b)| a + b).collect(),
            assumed: self.assumed.iter().chain(&other.assumed).copied().collect(),
        }
    }

    /// Notes on assumed tachometers, and on rows that are left out.
    pub fn notes(&self) -> Vec<String> {
        self.assumed_note().into_iter().chain(self.left_out_note()).collect()
    }

    /// Note on the tachometers that are assumed.
    fn assumed_note(&self) -> Option<String> {
        let of_wheel = |(wheel, tachometer): &(usize, Tachometer)| {
            format!("wheel {}: {}", wheel + 1, tachometer.in_words())
        };
        let wheels: Vec<String> = self.assumed.iter().map(of_wheel).collect();
        (!wheels.is_empty()).then(|| {
            format!(
                "assumed from the readings: tachometer of {}; state [wheels.tachometer] in the craft file",
                wheels.join(", ")
            )
        })
    }

    /// Note on the wheel that most rows are left out for; none where no more are than those beyond its last reading.
    fn left_out_note(&self) -> Option<String> {
        let (wheel, rows) = self.left_out.iter().enumerate().max_by_key(|(_, rows)| **rows)?;
        (*rows > BEYOND_READINGS).then(|| {
            format!(
                "{rows} rows are left out: wheel {} has no speed there; its edges are more than {MOST_BETWEEN} \
                 samples apart, or no reading follows",
                wheel + 1
            )
        })
    }
}

/// One sample.
#[derive(Clone, Debug, PartialEq)]
pub struct LogRow {
    /// Line in the file, from 1.
    pub line: u64,
    /// Time since the first row, µs.
    pub time_us: u64,
    /// Measured body rate, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Speed of each wheel relative to the body, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// External torque, body axes, N m.
    pub torque_n_m: Vector3<f64>,
    /// Attitude, if the log has it: inertial to body axes as in \[Kim2010\] Eq. (6), scalar last, of
    /// any norm. The estimators that use it check it sample by sample.
    pub attitude: Option<[f64; 4]>,
}
