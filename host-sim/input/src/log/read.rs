//! From a CSV file to a [`RecordedLog`].

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector3;

use super::clock::times;
use super::columns::Columns;
use super::fill::{Apart, Clock};
use super::held::Fresh;
use super::record::{LogRow, RecordedLog};
use crate::craft::LogFormat;
use crate::csv_dialect::CsvOptions;
use crate::csv_problem::CsvProblem;
use crate::csv_source::{CsvRow, CsvSource};
use crate::error::{InputError, Problem};

/// Reason of the rows that repeat a reading of the gyro.
const HELD: &str = "gyro_held";

/// The tables of one log.
#[derive(Debug)]
pub struct LogTables {
    /// The table with the gyro.
    pub log: CsvSource,
    /// Tables of sensors that the format of the logs states as files of their own.
    pub wheels: Option<CsvSource>,
    /// As `wheels`.
    pub torque: Option<CsvSource>,
    /// As `wheels`.
    pub attitude: Option<CsvSource>,
}

impl From<CsvSource> for LogTables {
    fn from(log: CsvSource) -> Self {
        Self { log, wheels: None, torque: None, attitude: None }
    }
}

impl RecordedLog {
    /// The log at `path`, in SI units, of a craft with `wheel_count` wheels.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing, the wheel columns do not match, no row is usable,
    /// or the order of time is lost.
    pub fn load(path: &Path, wheel_count: usize) -> Result<Self, InputError> {
        let tables = CsvSource::read_unchecked(path)?.into();
        Self::from_tables(&tables, &LogFormat::default(), wheel_count)
    }

    /// The log in the bytes of a file; `file` is the name in errors.
    ///
    /// # Errors
    /// As of [`Self::load`].
    pub fn decode(file: &str, bytes: &[u8], wheel_count: usize) -> Result<Self, InputError> {
        let tables = CsvSource::decode_unchecked(file, bytes, &CsvOptions::default())?.into();
        Self::from_tables(&tables, &LogFormat::default(), wheel_count)
    }

    /// The log in tables of this format.
    ///
    /// # Errors
    /// As of [`Self::load`], or no reading of a slower sensor at the times of the gyro.
    pub fn from_tables(
        tables: &LogTables,
        format: &LogFormat,
        wheel_count: usize,
    ) -> Result<Self, InputError> {
        let source = &tables.log;
        let columns = Columns::find(source, format, wheel_count)?;
        let apart = Apart::find(source, &columns);
        let complete: Vec<_> =
            source.rows().iter().map(|row| log_row(source, row, &columns, &apart)).collect();
        let times = times(source, &columns.time, &complete)?;
        let (mut rows, mut faults) = (Vec::new(), Vec::new());
        for ((row, complete), time_us) in source.rows().iter().zip(complete).zip(times.of_rows) {
            match complete.and_then(|row| Ok(LogRow { time_us: time_us?, ..row })) {
                Ok(row) => rows.push(row),
                Err(fault) => faults.push(source.error(Some(row.line), fault)),
            }
        }
        if rows.is_empty() && !faults.is_empty() {
            return Err(faults.swap_remove(0));
        }
        let mut log = Self {
            rows,
            start_s: 0.0,
            has_torque: columns.torque.is_some() || tables.torque.is_some(),
            skipped_rows: BTreeMap::new(),
            interpolation: None,
            notes: [&columns.notes[..], &times.notes].concat(),
        };
        log.note_skipped(source, &faults);
        let clock = Clock { start_us: times.start_us, is_set_back: times.is_set_back };
        log.fill(tables, format, &columns, &apart, &clock)?;
        log.start_s = times.start_us as f64 / 1e6;
        log.start_at_first_row();
        log.leave_out_held(source);
        log.interpolate_held_wheels(source);
        Ok(log)
    }

    /// Counts time from the first usable row.
    fn start_at_first_row(&mut self) {
        let first_us = self.rows.first().map_or(0, |row| row.time_us);
        self.rows.iter_mut().for_each(|row| row.time_us -= first_us);
        self.start_s += first_us as f64 / 1e6;
    }

    /// Counts the rows at fault, with a note on the first ones.
    fn note_skipped(&mut self, source: &CsvSource, faults: &[InputError]) {
        /// Largest number of rows in the note.
        const LISTED: usize = 3;
        let mut listed = Vec::new();
        let is_fault =
            |fault: &&InputError| !matches!(fault.problem, Problem::Csv(CsvProblem::NoGyro));
        let absent = faults.len() - faults.iter().filter(is_fault).count();
        if absent > 0 {
            self.skipped_rows.insert("no_gyro", absent as u64);
            self.notes.push(format!(
                "{}: {absent} of {} rows have no reading of the gyro; the gyro determines the samples",
                source.file(),
                source.rows().len()
            ));
        }
        let faults: Vec<&InputError> = faults.iter().filter(is_fault).collect();
        for fault in &faults {
            let Problem::Csv(problem) = &fault.problem else { continue };
            *self.skipped_rows.entry(problem.skip_reason().unwrap_or("other")).or_default() += 1;
            if listed.len() < LISTED {
                listed.push(format!("line {}: {}", fault.place.line.unwrap_or(0), problem.fault()));
            }
        }
        let rows = match faults.len() {
            0 => return,
            1 => "1 row".to_owned(),
            count => format!("{count} rows"),
        };
        let more = if faults.len() > LISTED { "; …" } else { "" };
        self.notes.push(format!("{}: {rows} skipped: {}{more}", source.file(), listed.join("; ")));
    }

    /// Leaves out the rows that repeat a reading of a gyro slower than the log.
    fn leave_out_held(&mut self, source: &CsvSource) {
        let Some(fresh) = Fresh::find(&self.rows) else { return };
        self.notes.push(format!("{}: {}", source.file(), fresh.note(&self.rows)));
        let rows = fresh.take(&self.rows);
        self.skipped_rows.insert(HELD, (self.rows.len() - rows.len()) as u64);
        self.rows = rows;
        self.start_at_first_row();
    }
}

/// The cells of a row, at time zero. Sensors apart are zero, to be filled in.
fn log_row(
    source: &CsvSource,
    row: &CsvRow,
    columns: &Columns,
    apart: &Apart,
) -> Result<LogRow, CsvProblem> {
    source.check_log_row(row)?;
    if apart.gyro && columns.gyro.is_absent(source, row) {
        return Err(CsvProblem::NoGyro);
    }
    let rate = columns.gyro.values(source, row)?;
    let wheels = columns.wheels.as_ref().filter(|_| !apart.wheels);
    let torque = columns.torque.as_ref().filter(|_| !apart.torque);
    // A row without attitude is usable, by most estimators.
    let attitude = columns.attitude.as_ref().filter(|_| !apart.attitude);
    let attitude = attitude.and_then(|attitude| attitude.values(source, row).ok());
    Ok(LogRow {
        line: row.line,
        time_us: 0,
        rate_rad_s: Vector3::from_column_slice(&rate),
        wheel_speed_rad_s: match wheels {
            Some(wheels) => wheels.values(source, row)?,
            None => Vec::new(),
        },
        torque_n_m: match torque {
            Some(torque) => Vector3::from_column_slice(&torque.values(source, row)?),
            None => Vector3::zeros(),
        },
        attitude: attitude.and_then(|values| values.try_into().ok()),
    })
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
        let log = read(&format!(",{HEADER}\n0,0,1,2,3\n"), 0).unwrap();
        assert_eq!(log.notes, ["a column without a name is ignored"]);
    }

    #[test]
    fn missing_column_is_reported_with_the_nearest() {
        let text = "t_s,gyro_x_rad_s,gyro_y,gyro_z_rad_s\n0,1,2,3\n";
        let message = read(text, 0).unwrap_err().to_string();
        assert!(
            message.starts_with("log.csv:1: no column `gyro_y_rad_s` (perhaps `gyro_y`;"),
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
            message.starts_with("log.csv:1: no column `attitude_q4` (perhaps `attitude_w`;"),
            "{message}"
        );
    }

    #[test]
    fn wheel_columns_must_match_the_craft() {
        let text = format!("{HEADER},wheel_1_rad_s\n0,1,2,3,4\n");
        let more = read(&text, 2).unwrap_err().to_string();
        assert_eq!(
            more,
            "log.csv:1: wheel columns of the log: 1, [[wheel]] tables of the craft file: 2; name \
             the columns wheel_1_rad_s to wheel_2_rad_s, or state them in [log.wheels]"
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
    fn log_without_a_usable_row_is_rejected_with_the_first_fault() {
        for (rows, fault) in [
            ("0,1,x,3\n1,1,x,3\n", "log.csv:2: column `gyro_y_rad_s`: \"x\" is not a number"),
            ("0,1,nan,3\n", "log.csv:2: column `gyro_y_rad_s`: nan is not a finite number"),
            ("inf,1,2,3\n", "log.csv:2: column `t_s`: inf is not"),
            (",1,2,3\n", "log.csv:2: column `t_s` is empty"),
            ("0,1,2\n1,1,2\n", "log.csv:2: 3 cells, but the header names 4 columns"),
            ("0,1,2", "log.csv:2: the file is cut in mid-row"),
        ] {
            assert!(message(rows).starts_with(fault), "{}", message(rows));
        }
    }

    /// Rows at 10 Hz, with the texts of `damage` in place of some of them.
    fn damaged(rows: usize, damage: &[(usize, &str)]) -> RecordedLog {
        let row = |index: usize| match damage.iter().find(|(at, _)| *at == index) {
            Some((_, text)) => format!("{text}\n"),
            None => format!("{}.{},{index},2,3\n", index / 10, index % 10),
        };
        let text: String = (0..rows).map(row).collect();
        read(&format!("{HEADER}\n{text}"), 0).unwrap()
    }

    #[test]
    fn rows_at_fault_are_left_out_and_counted() {
        let log =
            damaged(20, &[(3, "0.3,1,,3"), (5, "0.5,1,NaN,3"), (7, "0.7,1,2"), (19, "1.9,1,2,")]);
        assert_eq!(log.rows.len(), 16);
        assert_eq!(log.rows[15].time_us, 1_800_000);
        let counts = [("empty_cell", 1), ("incomplete", 2), ("not_finite", 1)];
        assert_eq!(log.skipped_rows, BTreeMap::from(counts));
        assert_eq!(
            log.notes,
            ["log.csv: 4 rows skipped: line 5: column `gyro_y_rad_s` is empty; line 7: column \
              `gyro_y_rad_s`: NaN is not a finite number; line 9: 3 cells, but the header names 4 \
              columns; …"]
        );
        assert!(damaged(20, &[]).notes.is_empty());
    }

    #[test]
    fn cut_last_row_is_left_out() {
        for end in ["0.1,1,2", "0.1,1,2,", "0.1,1,2,-", "0.", "0.1,1,2\0\0\0"] {
            let log = read(&format!("{HEADER}\n0,1,2,3\n{end}"), 0).unwrap();
            assert_eq!(log.rows.len(), 1, "{end:?}");
            assert!(log.notes[0].contains("line 3: the file is cut in mid-row"), "{:?}", log.notes);
        }
    }

    #[test]
    fn time_counts_from_the_first_usable_row() {
        let log = damaged(20, &[(0, "0,nan,2,3"), (1, "0.1,1,2,3,4")]);
        assert_eq!((log.start_s, log.rows[0].time_us, log.rows[1].time_us), (0.2, 0, 100_000));
        assert_eq!(log.skipped_rows, BTreeMap::from([("not_finite", 1), ("surplus_cells", 1)]));
    }

    #[test]
    fn row_without_attitude_is_used() {
        let header = format!("{HEADER},attitude_q1,attitude_q2,attitude_q3,attitude_q4");
        let log = read(&format!("{header}\n0,1,2,3,0,0,0,1\n1,1,2,3,,,,\n"), 0).unwrap();
        assert_eq!(log.rows[0].attitude, Some([0.0, 0.0, 0.0, 1.0]));
        assert_eq!(log.rows[1].attitude, None);
    }

    #[test]
    fn disordered_time_is_rejected() {
        for (rows, fault) in [
            ("0,1,2,3\n0.2,1,2,3\n0.1,1,2,3\n", "from 0.2 to 0.1; sort"),
            ("0.3,1,2,3\n0.2,1,2,3\n0.1,1,2,3\n0,1,2,3\n", "from 0.3 to 0.2; sort"),
        ] {
            let message = message(rows);
            assert!(message.contains(": column `t_s`: time runs backwards, from"), "{message}");
            assert!(message.contains(fault), "{message}");
        }
        assert!(
            message("0,1,2,3\n0.1,1,2,3\n1e-1,1,3,3\n")
                .starts_with("log.csv:4: column `t_s`: 1e-1 appears twice")
        );
        assert!(
            message("0,1,2,3\n0.1,1,2,3\n0.1000003,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: 0.1 and 0.1000003 fall on the same micro")
        );
    }

    #[test]
    fn stamps_with_too_few_digits_are_named() {
        let rows: String = (0..50).map(|index| format!("1.73234e+09,{index},2,3\n")).collect();
        assert_eq!(
            message(&rows),
            "log.csv:3: column `t_s`: time stamps have too few digits: 49 of 50 rows share the stamp \
             of the row before, as 1.73234e+09; export the column with all its digits"
        );
    }

    #[test]
    fn rows_of_another_sensor_do_not_count_as_repeated_stamps() {
        let rows: String = (0..20).map(|i| format!("{i},{i},2,3,\n{i},,,,7\n")).collect();
        let log = read(&format!("{HEADER},temperature_k\n{rows}"), 0).unwrap();
        assert_eq!(log.rows.len(), 20);
        assert_eq!(log.skipped_rows, BTreeMap::from([("no_gyro", 20)]));
    }

    #[test]
    fn single_false_stamps_and_repeated_rows_are_left_out() {
        for (stamp, reason) in [
            ("86400.5,1,2,3", "time_ahead"),
            ("0.2,1,2,3", "time_backwards"),
            ("0.4,1,2,3", "repeated_time"),
            ("0.4,4,2,3", "repeated_row"),
            ("t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s", "repeated_header"),
        ] {
            let log = damaged(20, &[(5, stamp)]);
            assert_eq!(log.skipped_rows, BTreeMap::from([(reason, 1)]), "{stamp}");
            assert_eq!((log.rows.len(), log.rows[18].time_us), (19, 1_900_000), "{stamp}");
        }
        // The first stamp, and the last one.
        assert_eq!(damaged(20, &[(0, "99,0,2,3")]).start_s, 0.1);
        assert_eq!(damaged(20, &[(19, "0.9,0,2,3")]).rows.len(), 19);
    }

    #[test]
    fn clock_set_back_is_a_gap_of_unknown_length() {
        let stamps = (0..40).map(|index| 100.0 + 0.5 * f64::from(index % 20));
        let rows: String = stamps.map(|time| format!("{time},1,2,3\n")).collect();
        let log = read(&format!("{HEADER}\n{rows}"), 0).unwrap();
        assert_eq!((log.rows.len(), log.skipped_rows.len()), (40, 0));
        assert_eq!(log.rows[20].time_us, log.rows[19].time_us + 3_600_000_000);
        assert_eq!(log.rows[21].time_us - log.rows[20].time_us, 500_000);
        assert!(
            log.notes[0]
                .starts_with("log.csv:22: column `t_s`: the clock is set back from 109.5 to"),
            "{:?}",
            log.notes
        );
    }

    #[test]
    fn nanoseconds_since_1970_are_read_without_loss() {
        let rows =
            "1700000000000000000,1,2,3\n1700000000100000000,1,2,3\n1700000000200001000,1,2,3\n";
        let log = read(&format!("{HEADER}\n{rows}"), 0).unwrap();
        assert_eq!(log.start_s, 1.7e9);
        assert_eq!(
            log.rows.iter().map(|row| row.time_us).collect::<Vec<_>>(),
            [0, 100_000, 200_001]
        );
        assert_eq!(
            log.notes,
            [
                "log.csv:2: column `t_s`: 1700000000000000000 is read as nanoseconds since 1970; state another \
             unit as log.time_unit in the craft file"
            ]
        );
    }

    #[test]
    fn clock_set_to_the_time_since_1970_in_flight_is_a_gap() {
        let rows: String = (0..30)
            .map(|i| match i {
                0 | 1 => format!("{i},{i},2,3\n"),
                _ => format!("17000000{i:02}000000000,{i},2,3\n"),
            })
            .collect();
        let log = read(&format!("{HEADER}\n{rows}"), 0).unwrap();
        let times: Vec<u64> = log.rows.iter().map(|row| row.time_us).collect();
        assert_eq!((times.len(), log.skipped_rows["repeated_time"]), (29, 1));
        assert_eq!(times[3] - times[2], 1_000_000);
        assert!(
            log.notes[0].starts_with("log.csv:4: column `t_s`: 1700000002000000000 is read as")
        );
    }

    #[test]
    fn dates_are_read_or_named() {
        let rows = "2024-05-01T12:00:00Z,1,2,3\n2024-05-01T12:00:01Z,1,2,3\n";
        let log = read(&format!("{HEADER}\n{rows}"), 0).unwrap();
        assert_eq!((log.start_s, log.rows[1].time_us), (1_714_564_800.0, 1_000_000));
        let american = rows.replace("2024-05-01T", "05/01/2024 ");
        assert_eq!(
            message(&american),
            "log.csv:2: column `t_s`: \"05/01/2024 12:00:00Z\" is not a known form of a date; state \
             time_format in [log] of the craft file, as %m/%d/%Y %H:%M:%S%.f, or write ISO 8601 as \
             2024-05-01T12:00:00Z"
        );
    }

    #[test]
    fn held_readings_are_left_out_with_a_note() {
        let rows: String = (0..400)
            .map(|row| {
                let rate = f64::from(row / 20).sin();
                format!("{},{rate},{},{}\n", f64::from(row) * 0.01, rate * 2.0, rate * 3.0)
            })
            .collect();
        let log = read(&format!("{HEADER}\n{rows}"), 0).unwrap();
        assert_eq!((log.rows.len(), log.rows[1].time_us), (20, 200_000));
        assert_eq!(log.skipped_rows, BTreeMap::from([("gyro_held", 380)]));
        assert!(log.notes[0].starts_with("log.csv: the gyro's rate is 5 Hz, the log's 100 Hz"));
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
