//! Reads and checks a log.

use std::path::Path;

use nalgebra::Vector3;

use super::super::csv_source::{Column, CsvRow, CsvSource};
use super::super::error::{CsvProblem, InputError};
use super::super::nearest::{likeness, nearest};
use super::time::{TimeError, TimeStamp};
use super::{LogRow, RecordedLog};

const TIME: &str = "t_s";
const GYRO: [&str; 3] = ["gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"];
const TORQUE: [&str; 3] = ["torque_x_n_m", "torque_y_n_m", "torque_z_n_m"];
const ATTITUDE: [&str; 4] = ["attitude_q1", "attitude_q2", "attitude_q3", "attitude_q4"];

impl RecordedLog {
    /// Reads and checks the log at `path` of a craft with `wheel_count` wheels.
    pub fn load(path: &Path, wheel_count: usize) -> Result<Self, InputError> {
        Self::from_source(&CsvSource::read(path)?, wheel_count)
    }

    /// Reads and checks the bytes of a log file; `file` is what errors call it.
    pub fn decode(file: &str, bytes: &[u8], wheel_count: usize) -> Result<Self, InputError> {
        Self::from_source(&CsvSource::decode(file, bytes)?, wheel_count)
    }

    fn from_source(source: &CsvSource, wheel_count: usize) -> Result<Self, InputError> {
        let columns = Columns::find(source, wheel_count)?;
        let mut clock = Clock::new(source, &columns.time);
        let mut rows = Vec::with_capacity(source.rows().len());
        for row in source.rows() {
            rows.push(LogRow {
                line: row.line,
                time_us: clock.read(row)?,
                rate_rad_s: Vector3::from(numbers::<3>(source, row, &columns.gyro)?),
                wheel_speed_rad_s: columns
                    .wheels
                    .iter()
                    .map(|column| source.number(row, column))
                    .collect::<Result<_, _>>()?,
                torque_n_m: match &columns.torque {
                    Some(torque) => Vector3::from(numbers::<3>(source, row, torque)?),
                    None => Vector3::zeros(),
                },
                attitude: columns
                    .attitude
                    .as_ref()
                    .map(|attitude| numbers(source, row, attitude))
                    .transpose()?,
            });
        }
        let start_s = match source.rows().first() {
            Some(row) => source.number(row, &columns.time)?,
            None => 0.0,
        };
        let has_torque = columns.torque.is_some();
        Ok(Self { rows, start_s, has_torque, notes: columns.notes })
    }
}

/// Where in the file each quantity is.
struct Columns {
    time: Column,
    gyro: Vec<Column>,
    wheels: Vec<Column>,
    torque: Option<Vec<Column>>,
    attitude: Option<Vec<Column>>,
    notes: Vec<String>,
}

impl Columns {
    fn find(source: &CsvSource, wheel_count: usize) -> Result<Self, InputError> {
        let time = source.column(TIME, is_ours)?;
        let gyro = all(source, &GYRO)?;

        let wheel_columns = source.columns().iter().filter(|name| is_wheel(name)).count();
        if wheel_columns != wheel_count {
            let problem = CsvProblem::WheelColumns { log: wheel_columns, craft: wheel_count };
            return Err(source.error(Some(1), problem));
        }
        let wheel_names: Vec<String> =
            (1..=wheel_count).map(|wheel| format!("wheel_{wheel}_rad_s")).collect();
        let wheels = wheel_names
            .iter()
            .map(|name| source.column(name, is_ours))
            .collect::<Result<Vec<_>, _>>()?;

        let torque = all_or_none(source, &TORQUE)?;
        let attitude = all_or_none(source, &ATTITUDE)?;

        let mut known = vec![TIME.to_owned()];
        known.extend(GYRO.iter().chain(&TORQUE).chain(&ATTITUDE).map(|name| (*name).to_owned()));
        known.extend(wheel_names);
        let notes = notes_on_ignored(source.columns(), &known);
        Ok(Self { time, gyro, wheels, torque, attitude, notes })
    }
}

/// Whether a column has a meaning in a log.
fn is_ours(name: &str) -> bool {
    name == TIME
        || GYRO.contains(&name)
        || TORQUE.contains(&name)
        || ATTITUDE.contains(&name)
        || is_wheel(name)
}

/// Whether a column is called `wheel_1_rad_s` or the like, with any number.
fn is_wheel(name: &str) -> bool {
    name.strip_prefix("wheel_")
        .and_then(|rest| rest.strip_suffix("_rad_s"))
        .is_some_and(|number| number.parse::<u32>().is_ok())
}

fn all(source: &CsvSource, names: &[&str]) -> Result<Vec<Column>, InputError> {
    names.iter().map(|name| source.column(name, is_ours)).collect()
}

/// One of these columns asks for all: a torque with an axis left out is a mistake.
fn all_or_none(source: &CsvSource, names: &[&str]) -> Result<Option<Vec<Column>>, InputError> {
    let is_there = |name: &&str| source.columns().iter().any(|column| column == name);
    if names.iter().any(is_there) { all(source, names).map(Some) } else { Ok(None) }
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

fn notes_on_ignored(columns: &[String], known: &[String]) -> Vec<String> {
    // Only what is nearly one of our names is worth a hint; a temperature is simply not ours.
    const NEARLY: f64 = 0.9;
    columns
        .iter()
        .filter(|column| !known.contains(column))
        .map(|column| match nearest(column, known) {
            Some(name) if likeness(column, name) > NEARLY => {
                format!("column `{column}` is ignored (did you mean `{name}`?)")
            }
            _ => format!("column `{column}` is ignored"),
        })
        .collect()
}

/// Turns time stamps into microseconds since the first, and sees that they increase.
struct Clock<'a> {
    source: &'a CsvSource,
    column: &'a Column,
    first: Option<TimeStamp>,
    previous: Option<Tick>,
}

struct Tick {
    stamp: TimeStamp,
    time_us: u64,
    text: String,
}

impl<'a> Clock<'a> {
    fn new(source: &'a CsvSource, column: &'a Column) -> Self {
        Self { source, column, first: None, previous: None }
    }

    fn read(&mut self, row: &CsvRow) -> Result<u64, InputError> {
        let text = self.source.text(row, self.column);
        let stamp = TimeStamp::parse(text).map_err(|error| match error {
            TimeError::NotANumber => self.source.not_a_number(row, self.column),
            TimeError::NotFinite => self.not_finite(row),
        })?;
        if let Some(previous) = &self.previous
            && stamp <= previous.stamp
        {
            return Err(self.source.error(Some(row.line), previous.not_after(stamp, text)));
        }
        let first = *self.first.get_or_insert(stamp);
        let time_us = stamp.microseconds_since(first).ok_or_else(|| self.not_finite(row))?;
        if let Some(previous) = &self.previous
            && time_us == previous.time_us
        {
            let problem = CsvProblem::SameMicrosecond {
                time: text.to_owned(),
                previous: previous.text.clone(),
            };
            return Err(self.source.error(Some(row.line), problem));
        }
        self.previous = Some(Tick { stamp, time_us, text: text.to_owned() });
        Ok(time_us)
    }

    fn not_finite(&self, row: &CsvRow) -> InputError {
        let problem = CsvProblem::NotFinite {
            column: self.column.name.clone(),
            text: self.source.text(row, self.column).to_owned(),
        };
        self.source.error(Some(row.line), problem)
    }
}

impl Tick {
    /// What is wrong with a time stamp that doesn't come after this one.
    fn not_after(&self, stamp: TimeStamp, text: &str) -> CsvProblem {
        if stamp == self.stamp {
            CsvProblem::DuplicateTime { time: text.to_owned() }
        } else {
            CsvProblem::TimeBackwards { time: text.to_owned(), previous: self.text.clone() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s";

    fn read(text: &str, wheels: usize) -> Result<RecordedLog, InputError> {
        RecordedLog::decode("log.csv", text.as_bytes(), wheels)
    }

    /// The error of a wheel-free log with these rows.
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
    fn missing_column_is_named_with_the_nearest() {
        let text = "t_s,gyro_x_rad_s,gyro_y,gyro_z_rad_s\n0,1,2,3\n";
        let message = read(text, 0).unwrap_err().to_string();
        assert!(
            message.starts_with("log.csv:1: no column `gyro_y_rad_s` (is it `gyro_y`?"),
            "{message}"
        );
    }

    #[test]
    fn torque_with_an_axis_left_out_is_refused() {
        let text = format!("{HEADER},torque_x_n_m,torque_z_n_m\n0,1,2,3,4,5\n");
        let message = read(&text, 0).unwrap_err().to_string();
        assert!(message.starts_with("log.csv:1: no column `torque_y_n_m`"), "{message}");
    }

    #[test]
    fn attitude_is_read_scalar_last_and_all_or_none() {
        let text = format!(
            "{HEADER},attitude_q4,attitude_q1,attitude_q2,attitude_q3\n0,1,2,3,0.4,0.1,0.2,0.3\n"
        );
        assert_eq!(read(&text, 0).unwrap().rows[0].attitude, Some([0.1, 0.2, 0.3, 0.4]));
        let message = read(&text.replace("attitude_q4", "attitude_w"), 0).unwrap_err().to_string();
        assert!(
            message.starts_with("log.csv:1: no column `attitude_q4` (is it `attitude_w`?"),
            "{message}"
        );
    }

    #[test]
    fn wheels_must_be_as_many_as_the_craft_has() {
        let text = format!("{HEADER},wheel_1_rad_s\n0,1,2,3,4\n");
        let more = read(&text, 2).unwrap_err().to_string();
        assert_eq!(
            more,
            "log.csv:1: the log has 1 wheel columns, but the craft has 2 wheels; the log needs \
             the columns wheel_1_rad_s to wheel_2_rad_s, no more"
        );
        let none = read(&text, 0).unwrap_err().to_string();
        assert!(none.ends_with("add a [[wheel]] table for each to the craft file"), "{none}");
        assert!(read(&text, 1).is_ok());
    }

    #[test]
    fn wheels_must_be_numbered_without_a_gap() {
        let text = format!("{HEADER},wheel_1_rad_s,wheel_3_rad_s\n0,1,2,3,4,5\n");
        let message = read(&text, 2).unwrap_err().to_string();
        assert!(message.starts_with("log.csv:1: no column `wheel_2_rad_s`"), "{message}");
    }

    #[test]
    fn bad_cells_are_named() {
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
    fn time_running_backwards_is_refused() {
        assert!(
            message("0,1,2,3\n0.2,1,2,3\n0.1,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: time runs backwards, from 0.2 to 0.1; sort")
        );
    }

    #[test]
    fn duplicate_time_is_refused() {
        assert!(
            message("0,1,2,3\n0.1,1,2,3\n1e-1,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: 1e-1 is there twice")
        );
    }

    #[test]
    fn two_times_in_one_microsecond_are_refused() {
        assert!(
            message("0,1,2,3\n0.1,1,2,3\n0.1000003,1,2,3\n")
                .starts_with("log.csv:4: column `t_s`: 0.1 and 0.1000003 fall on the same micro")
        );
    }

    #[test]
    fn file_cut_in_mid_row_is_recognised() {
        for end in ["0.1,1,2", "0.1,1,2,", "0.1,1,2,-", "0."] {
            let message = message(&format!("0,1,2,3\n{end}"));
            assert!(message.starts_with("log.csv:3: the file was cut in mid-row"), "{message}");
        }
    }

    #[test]
    fn empty_file_and_header_alone_are_refused() {
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
