//! A recorded log: gyro, wheel speeds and external torque over time, as CSV.
//!
//! | column | meaning | |
//! |---|---|---|
//! | `t_s` | time of the sample, from any origin, s | required |
//! | `gyro_x_rad_s`, `gyro_y_rad_s`, `gyro_z_rad_s` | body rate, body axes, rad/s | required |
//! | `wheel_1_rad_s`, `wheel_2_rad_s`, … | wheel speed relative to the body, rad/s | one per wheel |
//! | `torque_x_n_m`, `torque_y_n_m`, `torque_z_n_m` | external torque, body axes, N m | all or none |
//! | `attitude_q1` … `attitude_q4` | inertial to body axes, unit quaternion, scalar last | all or none |
//!
//! Other columns are ignored, and [`RecordedLog::notes`] says so.

mod read;
mod time;
mod write;

use nalgebra::Vector3;

pub use write::write_log;

/// A log that has been checked: at least one row, time strictly increasing, every value finite.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedLog {
    /// The rows, oldest first.
    pub rows: Vec<LogRow>,
    /// Time stamp of the first row in the log's own time scale, s.
    pub start_s: f64,
    /// Whether the log has columns for the external torque; without, the rows say zero.
    pub has_torque: bool,
    /// What the user may want to know, such as columns that were ignored; a sentence each.
    pub notes: Vec<String>,
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
    /// Attitude, if the log has it: inertial to body axes as in \[Kim2010\] Eq. (6), scalar last.
    /// Of any norm: the estimators that use it judge it sample by sample.
    pub attitude: Option<[f64; 4]>,
}
