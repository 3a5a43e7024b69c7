//! What can be wrong with a CSV file.

use thiserror::Error;

use super::error::list;

/// What is wrong with the columns or rows of a CSV file.
#[derive(Debug, Error)]
pub enum CsvProblem {
    /// Nothing in the file.
    #[error("the file is empty; the first line must name the columns")]
    Empty,

    /// A header, and then nothing.
    #[error("no row follows the header; is this the right file?")]
    NoRows,

    /// Some other separator.
    #[error("the columns are not separated by commas; export the file as comma-separated CSV")]
    NotCommaSeparated,

    /// A column that must be there is not.
    #[error("no column `{column}`{}; the columns are: {}", rename_hint(.nearest.as_deref()), list(.present))]
    MissingColumn {
        /// The missing column.
        column: String,
        /// The column of the file most like it.
        nearest: Option<String>,
        /// The columns of the file.
        present: Vec<String>,
    },

    /// Two columns of one name.
    #[error("column `{column}` is there twice; remove or rename one")]
    DuplicateColumn {
        /// The name that is there twice.
        column: String,
    },

    /// Wheel speeds for another number of wheels than the craft has.
    #[error(
        "the log has {log} wheel columns, but the craft has {craft} wheels{}",
        wheel_advice(*.craft)
    )]
    WheelColumns {
        /// Columns `wheel_…_rad_s` of the log.
        log: usize,
        /// `[[wheel]]` tables of the craft.
        craft: usize,
    },

    /// A cell that is not a number.
    #[error("column `{column}`: \"{text}\" is not a number; correct or remove the row")]
    NotANumber {
        /// The cell's column.
        column: String,
        /// The cell.
        text: String,
    },

    /// A cell that is a number, but NaN, infinite or too large.
    #[error("column `{column}`: {text} is not a finite number; correct or remove the row")]
    NotFinite {
        /// The cell's column.
        column: String,
        /// The cell.
        text: String,
    },

    /// A time stamp before the one above it.
    #[error(
        "column `t_s`: time runs backwards, from {previous} to {time}; sort the rows, or split the \
         log there if the clock was reset"
    )]
    TimeBackwards {
        /// The time stamp.
        time: String,
        /// The one above it.
        previous: String,
    },

    /// A time stamp equal to the one above it.
    #[error("column `t_s`: {time} is there twice; remove the second row")]
    DuplicateTime {
        /// The time stamp.
        time: String,
    },

    /// Two different time stamps that are the same to the resolution of the flight software.
    #[error(
        "column `t_s`: {previous} and {time} fall on the same microsecond, the resolution of a \
         sample's time; remove one of the rows, or check that the unit is the second"
    )]
    SameMicrosecond {
        /// The time stamp.
        time: String,
        /// The one above it.
        previous: String,
    },

    /// A row with cells missing.
    #[error("{found} cells, but the header names {columns} columns; complete or remove the row")]
    ShortRow {
        /// Cells of the row.
        found: usize,
        /// Columns of the header.
        columns: usize,
    },

    /// A row with cells too many.
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

    /// The last row stops before its end.
    #[error(
        "the file was cut in mid-row: the last row ends at \"{end}\", {found} of {columns} cells; \
         remove that row, or copy the file again"
    )]
    CutLastRow {
        /// The last cell as far as it goes.
        end: String,
        /// Cells of the row, the cut one included.
        found: usize,
        /// Columns of the header.
        columns: usize,
    },
}

fn rename_hint(nearest: Option<&str>) -> String {
    nearest
        .map_or(String::new(), |name| format!(" (is it `{name}`? then rename it, mind its unit)"))
}

fn wheel_advice(craft_wheels: usize) -> String {
    match craft_wheels {
        0 => "; add a [[wheel]] table for each to the craft file".to_owned(),
        1 => "; the log needs the column wheel_1_rad_s, no more".to_owned(),
        n => format!("; the log needs the columns wheel_1_rad_s to wheel_{n}_rad_s, no more"),
    }
}
