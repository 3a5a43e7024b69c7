//! Faults of a CSV file.

use thiserror::Error;

use crate::words::list;

/// Fault of the columns or rows of a CSV file.
#[derive(Clone, Debug, Error)]
pub enum CsvProblem {
    /// An empty file.
    #[error("the file is empty; the first line must name the columns")]
    Empty,

    /// A line longer than a reader takes.
    #[error(
        "a line of {bytes} bytes, but at most {limit} are read; is a line end or a quote missing?"
    )]
    LongLine {
        /// Bytes of the line.
        bytes: usize,
        /// Most bytes.
        limit: usize,
    },

    /// More rows than a reader takes.
    #[error("more than {limit} rows, the most that are read; split the log")]
    TooManyRows {
        /// Most rows.
        limit: usize,
    },

    /// A header without rows.
    #[error("no row follows the header; is this the right file?")]
    NoRows,

    /// An absent required column.
    #[error(
        "no column `{column}`{}; rename it, or name the columns in [log] of the craft file, which \
         `host-sim init --from` drafts; the columns are: {}",
        nearest_hint(.nearest.as_deref()),
        some_of(.present)
    )]
    MissingColumn {
        /// The missing column.
        column: String,
        /// The most similar column of the file.
        nearest: Option<String>,
        /// The columns of the file.
        present: Vec<String>,
    },

    /// A clock set back in a log with a sensor at instants of its own.
    #[error(
        "the clock is set back, and {sensor} have time stamps of their own: which of them belong to which \
         part is unknown; split the log there"
    )]
    SplitAtSetBack {
        /// The sensor.
        sensor: &'static str,
    },

    /// No reading of a slower sensor at the instants of the gyro.
    #[error(
        "no reading of {sensor} at the times of the gyro; check that both have the same clock, and the \
         unit of each"
    )]
    NoOverlap {
        /// The sensor.
        sensor: &'static str,
    },

    /// Two columns of one name.
    #[error("column `{column}` appears twice; remove or rename one")]
    DuplicateColumn {
        /// The repeated name.
        column: String,
    },

    /// Wheel speeds of another number of wheels than the craft file describes.
    #[error(
        "wheel columns of the log: {log}, [[wheel]] tables of the craft file: {craft}{}",
        wheel_advice(*.craft)
    )]
    WheelColumns {
        /// Columns `wheel_…_rad_s` of the log.
        log: usize,
        /// `[[wheel]]` tables of the craft.
        craft: usize,
    },

    /// A first line of numbers.
    #[error(
        "the first row has numbers only; the first line must name the columns, as t_s,gyro_x_rad_s,…"
    )]
    NoHeader,

    /// An empty cell.
    #[error("column `{column}` is empty; complete or remove the row")]
    EmptyCell {
        /// The cell's column.
        column: String,
    },

    /// The names of the columns again, as by a restarted logger.
    #[error("the names of the columns again; remove the row")]
    RepeatedHeader,

    /// A cell that is not a number.
    #[error("column `{column}`: \"{text}\" is not a number; correct or remove the row")]
    NotANumber {
        /// The cell's column.
        column: String,
        /// The cell.
        text: String,
    },

    /// A date of an unknown form.
    #[error(
        "column `{column}`: \"{text}\" is not a known form of a date; state time_format in [log] of the craft file, as \
         %m/%d/%Y %H:%M:%S%.f, or write ISO 8601 as 2024-05-01T12:00:00Z"
    )]
    ClockTime {
        /// The column of time.
        column: String,
        /// The cell.
        text: String,
    },

    /// A date in another form than stated.
    #[error(
        "column `{column}`: `{text}` has not the form `{form}` of the dates; correct time_format of [log] in the craft \
         file"
    )]
    OtherDateForm {
        /// The column of time.
        column: String,
        /// The cell.
        text: String,
        /// The form, as of strftime.
        form: String,
    },

    /// A number that is NaN, infinite or too large.
    #[error("column `{column}`: {text} is not a finite number; correct or remove the row")]
    NotFinite {
        /// The cell's column.
        column: String,
        /// The cell.
        text: String,
    },

    /// A time stamp before the previous one.
    #[error(
        "column `{column}`: time runs backwards, from {previous} to {time}; sort the rows, or split the \
         log here if the clock was reset"
    )]
    TimeBackwards {
        /// The column of time.
        column: String,
        /// The time stamp.
        time: String,
        /// The previous time stamp.
        previous: String,
    },

    /// A time stamp equal to the previous one.
    #[error("column `{column}`: {time} appears twice; remove the second row")]
    DuplicateTime {
        /// The column of time.
        column: String,
        /// The time stamp.
        time: String,
    },

    /// A row without a reading of the gyro, among readings of slower sensors.
    #[error("no reading of the gyro")]
    NoGyro,

    /// A row without a reading of a slower sensor before and after it, or too long after it.
    #[error("no reading of {sensor} near this instant")]
    NoReading {
        /// The sensor.
        sensor: &'static str,
    },

    /// A row equal to the previous one.
    #[error("the row is equal to the previous one; remove it")]
    RepeatedRow,

    /// A single time stamp far ahead of the following ones.
    #[error("column `{column}`: {time} is ahead of the following rows; correct or remove the row")]
    TimeAhead {
        /// The column of time.
        column: String,
        /// The time stamp.
        time: String,
    },

    /// Many time stamps that are equal to the previous one.
    #[error(
        "column `{column}`: time stamps have too few digits: {shared} of {rows} rows share the stamp of \
         the row before, as {time}; export the column with all its digits"
    )]
    FewDigits {
        /// The column of time.
        column: String,
        /// Rows with the stamp of the row before.
        shared: usize,
        /// Rows of the log.
        rows: usize,
        /// The first such stamp.
        time: String,
    },

    /// Two time stamps that differ by less than the resolution of the flight software.
    #[error(
        "column `{column}`: {previous} and {time} fall on the same microsecond, the resolution of a \
         time stamp; remove one row, or check that the unit is the second"
    )]
    SameMicrosecond {
        /// The column of time.
        column: String,
        /// The time stamp.
        time: String,
        /// The previous time stamp.
        previous: String,
    },

    /// A row with fewer cells than the header.
    #[error("{found} cells, but the header names {columns} columns; complete or remove the row")]
    ShortRow {
        /// Cells of the row.
        found: usize,
        /// Columns of the header.
        columns: usize,
    },

    /// A row with more cells than the header.
    #[error(
        "{found} cells, but the header names only {columns} columns; remove the extra cells (decimal \
         commas require semicolons or tabs between the cells)"
    )]
    LongRow {
        /// Cells of the row.
        found: usize,
        /// Columns of the header.
        columns: usize,
    },

    /// An incomplete last row.
    #[error(
        "the file is cut in mid-row: the last row ends at \"{end}\", {found} of {columns} cells; \
         remove that row, or copy the file again"
    )]
    CutLastRow {
        /// The last cell.
        end: String,
        /// Cells of the row, the incomplete one included.
        found: usize,
        /// Columns of the header.
        columns: usize,
    },
}

impl CsvProblem {
    /// Reason under which a row with this fault is counted if the others are used; none for the
    /// faults of a whole file.
    pub fn skip_reason(&self) -> Option<&'static str> {
        Some(match self {
            Self::ShortRow { .. } | Self::CutLastRow { .. } => "incomplete",
            Self::LongRow { .. } => "surplus_cells",
            Self::EmptyCell { .. } => "empty_cell",
            Self::NotANumber { .. } | Self::ClockTime { .. } | Self::OtherDateForm { .. } => {
                "not_a_number"
            }
            Self::NotFinite { .. } => "not_finite",
            Self::NoGyro => "no_gyro",
            Self::NoReading { .. } => "no_reading",
            Self::RepeatedHeader => "repeated_header",
            Self::RepeatedRow => "repeated_row",
            Self::DuplicateTime { .. } | Self::SameMicrosecond { .. } => "repeated_time",
            Self::TimeBackwards { .. } => "time_backwards",
            Self::TimeAhead { .. } => "time_ahead",
            _ => return None,
        })
    }

    /// The fault without the remedy.
    pub fn fault(&self) -> String {
        let message = self.to_string();
        message.split_once("; ").map_or(message.clone(), |(fault, _)| fault.to_owned())
    }
}

fn nearest_hint(nearest: Option<&str>) -> String {
    nearest.map_or(String::new(), |name| format!(" (perhaps `{name}`; check its unit)"))
}

/// The first names of a list that may be long.
fn some_of(names: &[String]) -> String {
    /// Most names.
    const LISTED: usize = 24;
    match names.len().checked_sub(LISTED) {
        Some(more) if more > 0 => format!("{}, and {more} more", list(&names[..LISTED])),
        _ => list(names),
    }
}

fn wheel_advice(craft_wheels: usize) -> String {
    match craft_wheels {
        0 => "; add one [[wheel]] table per column to the craft file".to_owned(),
        1 => "; name the column wheel_1_rad_s, or state it in [log.wheels]".to_owned(),
        n => format!(
            "; name the columns wheel_1_rad_s to wheel_{n}_rad_s, or state them in [log.wheels]"
        ),
    }
}
