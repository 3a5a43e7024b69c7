//! From a CSV file to a [`RecordedLog`].

use std::path::Path;

use nalgebra::Vector3;

use super::clock::Clock;
use super::columns::Columns;
use super::record::{LogRow, RecordedLog};
use crate::csv_source::{Column, CsvRow, CsvSource};
use crate::error::InputError;

impl RecordedLog {
    /// The log at `path` of a craft with `wheel_count` wheels.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing, the wheel columns do not match, a cell is not a
    /// finite number, or the microsecond of a row is not later than that of the previous row.
    pub fn load(path: &Path, wheel_count: usize) -> Result<Self, InputError> {
        Self::from_source(&CsvSource::read(path)?, wheel_count)
    }

    /// The log in the bytes of a file; `file` is the name in errors.
    ///
    /// # Errors
    /// As of [`Self::load`].
    pub fn decode(file: &str, bytes: &[u8], wheel_count: usize) -> Result<Self, InputError> {
        Self::from_source(&CsvSource::decode(file, bytes)?, wheel_count)
    }

    fn from_source(source: &CsvSource, wheel_count: usize) -> Result<Self, InputError> {
        let columns = Columns::find(source, wheel_count)?;
        let mut clock = Clock::new(source, &columns.time);
        let rows = (source.rows().iter())
            .map(|row| log_row(source, row, &columns, clock.read(row)?))
            .collect::<Result<_, _>>()?;
        let start_s = match source.rows().first() {
            Some(row) => source.number(row, &columns.time)?,
            None => 0.0,
        };
        let has_torque = columns.torque.is_some();
        Ok(Self { rows, start_s, has_torque, notes: columns.notes })
    }
}

fn log_row(
    source: &CsvSource,
    row: &CsvRow,
    columns: &Columns,
    time_us: u64,
) -> Result<LogRow, InputError> {
    Ok(LogRow {
        line: row.line,
        time_us,
        rate_rad_s: Vector3::from(numbers::<3>(source, row, &columns.gyro)?),
        wheel_speed_rad_s: (columns.wheels.iter())
            .map(|column| source.number(row, column))
            .collect::<Result<_, _>>()?,
        torque_n_m: match &columns.torque {
            Some(torque) => Vector3::from(numbers::<3>(source, row, torque)?),
            None => Vector3::zeros(),
        },
        attitude: (columns.attitude.as_ref())
            .map(|attitude| numbers(source, row, attitude))
            .transpose()?,
    })
}

fn numbers<const N: usize>(
    source: &CsvSource,
    row: &CsvRow,
    columns: &[Column],
) -> Result<[f64; N], InputError> {
    let mut numbers = [0.0; N];
    for (number, column) in numbers.iter_mut().zip(columns) {
        *number = source.number(row, column)?;
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s";

    fn read(text: &str, wheels: usize) -> Result<RecordedLog, InputError> {
        RecordedLog::decode("log.csv", text.as_bytes(), wheels)
    }

    /// The error of a log with these rows and no wheel.
    fn message(rows: &str) -> String {
        read(&format!("{HEADER}\n{rows}"), 0).unwrap_err().to_string()
    }

    #[test]
    fn log_without_wheels_and_torque_is_read() {
        let log = read(&format!("{HEADER}\n10.5,1,2,3\n10.500247,4,5,6\n"), 0).unwrap();
        assert_eq!(log.start_s, 10.5);
        assert!(!log.has_torque && log.notes.is_empty());
        assert_eq!((log.rows[1].line, log.rows[1].time_us), (3, 247));
        assert_eq!(log.rows[1].rate_rad_s, Vector3::new(4.0, 5.0, 6.0));
        assert_eq!(log.rows[1].torque_n_m, Vector3::zeros());
        assert_eq!(log.rows[1].attitude, None);
    }

    #[test]
    fn columns_may_come_in_any_order() {
        let text = "wheel_2_rad_s,torque_z_n_m,gyro_z_rad_s,t_s,gyro_x_rad_s,torque_x_n_m,\
                    gyro_y_rad_s,wheel_1_rad_s,torque_y_n_m\r\n\
                    20,6,3,0,1,4,2,10,5\r\n";
        let log = read(text, 2).unwrap();
        assert!(log.has_torque);
        assert_eq!(log.rows[0].rate_rad_s, Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(log.rows[0].torque_n_m, Vector3::new(4.0, 5.0, 6.0));
        assert_eq!(log.rows[0].wheel_speed_rad_s, [10.0, 20.0]);
    }

    #[test]
    fn ignored_columns_are_noted() {
        let log = read(&format!("{HEADER},temperature_k,torque_x_nm\n0,1,2,3,300,0\n"), 0).unwrap();
        assert_eq!(
            log.notes,
            [
                "column `temperature_k` is ignored",
                "column `torque_x_nm` is ignored (did you mean `torque_x_n_m`?)"
            ]
        );
    }

    #[test]
    fn missing_column_is_reported_with_the_nearest() {
        let text = "t_s,gyro_x_rad_s,gyro_y,gyro_z_rad_s\n0,1,2,3\n";
        let message = read(text, 0).unwrap_err().to_string();
        assert!(
            message.starts_with("log.csv:1: no column `gyro_y_rad_s` (if it is `gyro_y`,"),
            "{message}"
        );
    }

    #[test]
    fn torque_without_one_axis_is_rejected() {
        let text = format!("{HEADER},torque_x_n_m,torque_z_n_m\n0,1,2,3,4,5\n");
        let message = read(&text, 0).unwrap_err().to_string();
        assert!(message.starts_with("log.csv:1: no column `torque_y_n_m`"), "{message}");
    }

    #[test]
    fn attitude_is_scalar_last_and_complete() {
        let text = format!(
            "{HEADER},attitude_q4,attitude_q1,attitude_q2,attitude_q3\n0,1,2,3,0.4,0.1,0.2,0.3\n"
        );
        assert_eq!(read(&text, 0).unwrap().rows[0].attitude, Some([0.1, 0.2, 0.3, 0.4]));
        let message = read(&text.replace("attitude_q4", "attitude_w"), 0).unwrap_err().to_string();
        assert!(
            message.starts_with("log.csv:1: no column `attitude_q4` (if it is `attitude_w`,"),
            "{message}"
        );
    }

    #[test]
    fn wheel_columns_must_match_the_craft() {
        let text = format!("{HEADER},wheel_1_rad_s\n0,1,2,3,4\n");
        let more = read(&text, 2).unwrap_err().to_string();
        assert_eq!(
            more,
            "log.csv:1: wheel columns of the log: 1, [[wheel]] tables of the craft file: 2; the log \
             must have exactly the columns wheel_1_rad_s to wheel_2_rad_s"
        );
        let none = read(&text, 0).unwrap_err().to_string();
        assert!(none.ends_with("add one [[wheel]] table per column to the craft file"), "{none}");
        assert!(read(&text, 1).is_ok());
    }

    #[test]
    fn wheel_numbers_must_have_no_gap() {
        let text = format!("{HEADER},wheel_1_rad_s,wheel_3_rad_s\n0,1,2,3,4,5\n");
        let message = read(&text, 2).unwrap_err().to_string();
        assert!(message.starts_with("log.csv:1: no column `wheel_2_rad_s`"), "{message}");
    }

    #[test]
    fn bad_cells_are_reported() {
        assert!(
            message("0,1,x,3\n1,1,2,3\n").starts_with("log.csv:2: column `gyro_y_rad_s`: \"x\"")
        );
        assert!(
            message("0,1,2,3\n1,1,nan,3\n").starts_with("log.csv:3: column `gyro_y_rad_s`: nan")
        );
        assert!(message("0,1,2,3\ninf,1,2,3\n").starts_with("log.csv:3: column `t_s`: inf is not"));
        assert!(message("0,1,2,3\n,1,2,3\n").starts_with("log.csv:3: column `t_s`: \"\" is not"));
        assert!(
            message("0,1,2,3\n9e17,1,2,3\n").starts_with("log.csv:3: column `t_s`: 9e17 is not")
        );
    }

    #[test]
    fn decreasing_time_is_rejected() {
        assert!(
            message("0,1,2,3\n0.2,1,2,3\n0.1,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: time runs backwards, from 0.2 to 0.1; sort")
        );
    }

    #[test]
    fn repeated_time_is_rejected() {
        assert!(
            message("0,1,2,3\n0.1,1,2,3\n1e-1,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: 1e-1 appears twice")
        );
    }

    #[test]
    fn two_times_in_one_microsecond_are_rejected() {
        assert!(
            message("0,1,2,3\n0.1,1,2,3\n0.1000003,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: 0.1 and 0.1000003 fall on the same micro")
        );
    }

    #[test]
    fn file_cut_in_mid_row_is_reported() {
        for end in ["0.1,1,2", "0.1,1,2,", "0.1,1,2,-", "0."] {
            let message = message(&format!("0,1,2,3\n{end}"));
            assert!(message.starts_with("log.csv:3: the file is cut in mid-row"), "{message}");
        }
    }

    #[test]
    fn empty_file_and_header_alone_are_rejected() {
        assert!(read("", 0).unwrap_err().to_string().starts_with("log.csv: the file is empty"));
        assert!(message("").starts_with("log.csv: no row follows the header"));
    }

    #[test]
    fn log_is_read_from_a_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log.csv");
        std::fs::write(&path, format!("{HEADER}\n0,1,2,3\n")).unwrap();
        assert_eq!(RecordedLog::load(&path, 0).unwrap().rows.len(), 1);
        let missing = RecordedLog::load(&dir.path().join("gone.csv"), 0).unwrap_err().to_string();
        assert!(missing.contains("gone.csv: cannot be read: "), "{missing}");
    }
}
