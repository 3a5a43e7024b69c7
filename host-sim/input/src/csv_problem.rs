//! Faults of a CSV file.

use thiserror::Error;

use crate::words::list;

/// Fault of the columns or rows of a CSV file.
#[derive(Clone, Debug, Error)]
pub enum CsvProblem {
    /// An empty file.
    #[error("the file is empty; the first line must name the columns")]
    Empty,

    /// A header without rows.
    #[error("no row follows the header; is this the right file?")]
    NoRows,

    /// A separator other than the comma.
    #[error("the columns are not separated by commas; export the file as comma-separated CSV")]
    NotCommaSeparated,

    /// An absent required column.
    #[error("no column `{column}`{}; the columns are: {}", rename_hint(.nearest.as_deref()), list(.present))]
    MissingColumn {
        /// The missing column.
        column: String,
        /// The most similar column of the file.
        nearest: Option<String>,
        /// The columns of the file.
        present: Vec<String>,
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

    /// A date or a time of day in place of seconds.
    #[error("column `t_s`: \"{text}\" is a date or a time of day; write seconds, from any origin")]
    ClockTime {
        /// The cell.
        text: String,
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
        "column `t_s`: time runs backwards, from {previous} to {time}; sort the rows, or split the \
         log here if the clock was reset"
    )]
    TimeBackwards {
        /// The time stamp.
        time: String,
        /// The previous time stamp.
        previous: String,
    },

    /// A time stamp equal to the previous one.
    #[error("column `t_s`: {time} appears twice; remove the second row")]
    DuplicateTime {
        /// The time stamp.
        time: String,
    },

    /// A row equal to the previous one.
    #[error("the row is equal to the previous one; remove it")]
    RepeatedRow,

    /// A single time stamp far ahead of the following ones.
    #[error("column `t_s`: {time} is ahead of the following rows; correct or remove the row")]
    TimeAhead {
        /// The time stamp.
        time: String,
    },

    /// Many time stamps that are equal to the previous one.
    #[error(
        "column `t_s`: time stamps have too few digits: {shared} of {rows} rows share the stamp of \
         the row before, as {time}; export t_s with all its digits"
    )]
    FewDigits {
        /// Rows with the stamp of the row before.
        shared: usize,
        /// Rows of the log.
        rows: usize,
        /// The first such stamp.
        time: String,
    },

    /// Two time stamps that differ by less than the resolution of the flight software.
    #[error(
        "column `t_s`: {previous} and {time} fall on the same microsecond, the resolution of a \
         time stamp; remove one row, or check that the unit is the second"
    )]
    SameMicrosecond {
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
        "{found} cells, but the header names only {columns} columns; remove the extra cells (or \
         write decimals with a point)"
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
            Self::NotANumber { .. } | Self::ClockTime { .. } => "not_a_number",
            Self::NotFinite { .. } => "not_finite",
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

fn rename_hint(nearest: Option<&str>) -> String {
    nearest
        .map_or(String::new(), |name| format!(" (if it is `{name}`, rename that; check its unit)"))
}

fn wheel_advice(craft_wheels: usize) -> String {
    match craft_wheels {
        0 => "; add one [[wheel]] table per column to the craft file".to_owned(),
        1 => "; the log must have exactly the column wheel_1_rad_s".to_owned(),
        n => format!("; the log must have exactly the columns wheel_1_rad_s to wheel_{n}_rad_s"),
    }
}
