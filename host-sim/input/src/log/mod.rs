//! A recorded log: gyro, wheel speeds, external torque and attitude over time, as a table.
//!
//! Columns, units and clock are those of `[log]` in the craft file. Without it, required columns are `t_s`, `gyro_x_rad_s`, `gyro_y_rad_s`, `gyro_z_rad_s`, and one
//! `wheel_N_rad_s` per wheel of the craft file. Optional groups: `torque_x_n_m` to `torque_z_n_m`,
//! and `attitude_q1` to `attitude_q4`. [`COLUMNS`] has unit and meaning of each. Other columns are
//! ignored, with a line in [`RecordedLog::notes`].
//!
//! A log is as a flight left it: its last row may be cut, a cell empty, a time stamp false. Such rows
//! are left out and counted in [`RecordedLog::skipped_rows`]. A log is rejected where no row is usable,
//! or where the order of time is lost.

mod clock;
mod columns;
mod date;
mod fill;
mod held;
mod read;
mod record;
mod samples;
mod shown;
mod tachometer;
mod time;
mod time_columns;
mod write;

pub use columns::COLUMNS;
pub use date::{is_date, is_date_form};
pub use read::LogTables;
pub use record::{Interpolation, LogRow, RecordedLog, correct_wheels};
pub use write::write_log;
