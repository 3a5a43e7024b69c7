//! From samples to a CSV file that [`RecordedLog::load`](super::RecordedLog::load) reads.

use std::io;

use super::columns::{ATTITUDE, GYRO, TIME, TORQUE, wheel};
use super::record::LogRow;
use super::time::seconds_text;

/// Writes `rows` as CSV.
///
/// Each number has the shortest decimal form that reads back as the same `f64`. The first row
/// determines the wheel columns, and whether there are attitude columns.
///
/// # Errors
/// As of the writer.
pub fn write_log<W: io::Write>(out: W, rows: &[LogRow]) -> io::Result<()> {
    let wheels = rows.first().map_or(0, |row| row.wheel_speed_rad_s.len());
    let has_attitude = rows.first().is_some_and(|row| row.attitude.is_some());
    let mut header: Vec<String> = [TIME].iter().chain(&GYRO).map(|name| (*name).into()).collect();
    header.extend((1..=wheels).map(wheel));
    header.extend(TORQUE.map(String::from));
    if has_attitude {
        header.extend(ATTITUDE.map(String::from));
    }

    let mut out = csv::Writer::from_writer(out);
    out.write_record(&header)?;
    for row in rows {
        let values = (row.rate_rad_s.iter())
            .chain(&row.wheel_speed_rad_s)
            .chain(row.torque_n_m.iter())
            .chain(row.attitude.iter().flatten())
            .map(|value| format!("{value:?}")); // Debug: 1e-30; Display writes all zeros
        out.write_record(std::iter::once(seconds_text(row.time_us)).chain(values))?;
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::record::RecordedLog;
    use super::*;

    #[test]
    fn written_log_reads_back_exactly() {
        let row = |line: u64, time_us| LogRow {
            line,
            time_us,
            rate_rad_s: Vector3::new(0.1 + 0.2, -1e-30, 1.0 / 3.0),
            wheel_speed_rad_s: vec![700.0 / 3.0, -0.0],
            torque_n_m: Vector3::new(1e-3, 0.0, -2e-3 / 7.0),
            attitude: Some([0.5, -0.5, 1.0 / 3.0, 0.6]),
        };
        let rows = vec![row(2, 0), row(3, 247), row(4, 100_000)];
        let mut bytes = Vec::new();
        write_log(&mut bytes, &rows).unwrap();
        let log = RecordedLog::decode("x.csv", &bytes, 2).unwrap();
        assert_eq!(log.rows, rows);
        assert!(log.notes.is_empty());
    }

    #[test]
    fn columns_and_numbers_are_written_in_log_format() {
        let row = LogRow {
            line: 2,
            time_us: 100_000,
            rate_rad_s: Vector3::zeros(),
            wheel_speed_rad_s: Vec::new(),
            torque_n_m: Vector3::zeros(),
            attitude: None,
        };
        let mut bytes = Vec::new();
        write_log(&mut bytes, &[row]).unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,torque_x_n_m,torque_y_n_m,torque_z_n_m\n\
             0.1,0.0,0.0,0.0,0.0,0.0,0.0\n"
        );
    }
}
