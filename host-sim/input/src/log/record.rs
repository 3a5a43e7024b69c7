//! The values of a log.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::craft::StatedHardware;

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
    /// Removes the known scale error and misalignment of the gyro from the readings. A known delay
    /// remains: it is the mean of the estimator's time offset.
    pub fn correct(&mut self, hardware: &StatedHardware) {
        for row in &mut self.rows {
            row.rate_rad_s = hardware.corrected_rate_rad_s(&row.rate_rad_s);
        }
    }
}

/// Error of interpolated wheel speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolation {
    /// One sigma of the speed of each wheel between its readings, rad/s.
    pub sigma_rad_s: Vec<f64>,
    /// Typical time between readings, s.
    pub period_s: f64,
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
