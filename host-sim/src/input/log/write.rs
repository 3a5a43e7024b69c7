//! Writes a log as it is read: the simulator's samples, for replay.

use std::io;

use super::LogRow;
use super::time::seconds_text;

/// Writes `rows` as CSV with the columns that [`RecordedLog::load`](super::RecordedLog::load) reads.
///
/// Numbers are as short as they can be while reading back as the same `f64`. The first row says how
/// many wheels there are, and whether the attitude is known.
pub fn write_log<W: io::Write>(out: W, rows: &[LogRow]) -> io::Result<()> {
    let wheels = rows.first().map_or(0, |row| row.wheel_speed_rad_s.len());
    let mut header: Vec<String> = ["t_s", "gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"]
        .iter()
        .map(|name| (*name).to_owned())
        .collect();
    header.extend((1..=wheels).map(|wheel| format!("wheel_{wheel}_rad_s")));
    header.extend(["x", "y", "z"].iter().map(|axis| format!("torque_{axis}_n_m")));
    if rows.first().is_some_and(|row| row.attitude.is_some()) {
        header.extend((1..=4).map(|element| format!("attitude_q{element}")));
    }

    let mut out = csv::Writer::from_writer(out);
    out.write_record(&header)?;
    for row in rows {
        let values = (row.rate_rad_s.iter())
            .chain(&row.wheel_speed_rad_s)
            .chain(row.torque_n_m.iter())
            .chain(row.attitude.iter().flatten())
            .map(|value| format!("{value:?}")); // Debug: 1e-30, where Display writes out the zeros
        out.write_record(std::iter::once(seconds_text(row.time_us)).chain(values))?;
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::RecordedLog;
    use super::*;

    #[test]
    fn written_log_reads_back_the_same() {
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
    fn time_is_written_as_it_is_read() {
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
