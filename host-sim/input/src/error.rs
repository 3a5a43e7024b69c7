//! Rejections of input files.
//!
//! [`InputError`] prints as `file:line: fault; remedy`, in one or two lines.

use std::error::Error as StdError;
use std::fmt;
use std::io;

use thiserror::Error;

pub use crate::csv_problem::CsvProblem;
use crate::inertia::ELEMENT_NAMES;
use crate::words::{list, numbers, suggestion};

/// A rejected input: its place and its fault.
#[derive(Debug, Error)]
#[error("{place}: {problem}")]
pub struct InputError {
    /// The file, and the line of the fault if there is one.
    pub place: Place,
    /// The fault and the remedy.
    pub problem: Problem,
}

/// Place of a fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it, or the name of a built-in scenario.
    pub file: String,
    /// The line, from 1; none for the whole file.
    pub line: Option<u64>,
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(out, "{}:{line}", self.file),
            None => write!(out, "{}", self.file),
        }
    }
}

/// Fault of a file, of its keys and values, or of its columns and rows.
#[derive(Debug, Error)]
pub enum Problem {
    /// The file is missing, or its permissions forbid reading.
    #[error("cannot be read: {0}; check the path and the permissions")]
    Unreadable(io::Error),

    /// More bytes than a reader takes.
    #[error("more than {limit} bytes after decompression, the most that is read; split the file")]
    TooLarge {
        /// Most bytes.
        limit: u64,
    },

    /// The bytes are not text.
    #[error("not UTF-8 text; save the file as UTF-8")]
    NotUtf8,

    /// The bytes are neither text nor another kind of file that is read.
    #[error("not text; give a log as CSV or Parquet, plain or compressed by gzip")]
    NotText,

    /// A folder without a log.
    #[error("no log in this folder; wanted: {wanted}")]
    NoLogs {
        /// Names of logs.
        wanted: String,
    },

    /// The text breaks the grammar of TOML.
    #[error("not valid TOML: {message}; correct the line\n    {source_line}")]
    TomlSyntax {
        /// Message of the parser.
        message: String,
        /// The line of the file.
        source_line: String,
    },

    /// A key that the table does not have.
    #[error(
        "unknown key `{key}`{}; known keys here: {}",
        suggestion(.nearest.as_deref()),
        list(.known)
    )]
    UnknownKey {
        /// The key as written.
        key: String,
        /// The most similar known key.
        nearest: Option<String>,
        /// All keys of the table.
        known: Vec<String>,
    },

    /// A word outside the fixed set of a key, as `kind = "sine"`.
    #[error(
        "unknown word \"{word}\"{}; allowed here: {}",
        suggestion(.nearest.as_deref()),
        list(.allowed)
    )]
    UnknownWord {
        /// The word as written.
        word: String,
        /// The most similar allowed word.
        nearest: Option<String>,
        /// All allowed words.
        allowed: Vec<String>,
    },

    /// An absent required key.
    #[error("missing key `{key}`; add it to this table")]
    MissingKey {
        /// The missing key.
        key: String,
    },

    /// A value of another type than the key's.
    #[error("wrong type of value: {message}; correct the line\n    {source_line}")]
    WrongType {
        /// The type found and the type expected.
        message: String,
        /// The line of the file.
        source_line: String,
    },

    /// A list of another length than the key's.
    #[error("`{key}` has {found} entries, but takes {required}; give {required}")]
    WrongLength {
        /// The full key, as `wheel[2].axis`; wheels are counted from 1.
        key: String,
        /// Entries found.
        found: usize,
        /// Entries required.
        required: usize,
    },

    /// A value outside the range of its key.
    #[error("`{key}` is {found}; it must be {required}")]
    BadValue {
        /// The full key, as `wheel[2].axis`; wheels are counted from 1.
        key: String,
        /// The value found.
        found: String,
        /// The range.
        required: String,
    },

    /// An inertia tensor outside the range of rigid bodies.
    #[error(
        "`{key}` ({}) is not the inertia of a rigid body: its principal moments are {}, but each \
         must be positive and at most the sum of the other two; check signs, unit (kg m²) and order",
        ELEMENT_NAMES.join(" "),
        numbers(.principal_moments_kg_m2)
    )]
    NotPhysical {
        /// The full key.
        key: String,
        /// Eigenvalues of the tensor, ascending, kg m².
        principal_moments_kg_m2: [f64; 3],
    },

    /// More wheels than the estimators support.
    #[error("{found} [[wheel]] tables, but at most {most} are supported; remove some")]
    TooManyWheels {
        /// Tables found.
        found: usize,
        /// Tables supported.
        most: usize,
    },

    /// Several faults of a file.
    #[error("{first}{}", further(.others))]
    Several {
        /// The first fault, at the place of the error.
        first: Box<Problem>,
        /// The others, in the order of the file.
        others: Vec<InputError>,
    },

    /// Fault of the columns or rows of a CSV file.
    #[error(transparent)]
    Csv(#[from] CsvProblem),

    /// Fault of a kind of file that is read outside this crate.
    #[error(transparent)]
    Other(#[from] Box<dyn StdError + Send + Sync>),
}

impl InputError {
    /// One error for several, in the order of the file; none for an empty list.
    pub fn of_several(mut errors: Vec<Self>) -> Option<Self> {
        errors.sort_by_key(|error| error.place.line);
        let mut errors = errors.into_iter();
        let first = errors.next()?;
        let others: Vec<Self> = errors.collect();
        if others.is_empty() {
            return Some(first);
        }
        let problem = Problem::Several { first: Box::new(first.problem), others };
        Some(Self { place: first.place, problem })
    }
}

/// Further errors, a line each, as the first one is printed.
fn further(errors: &[InputError]) -> String {
    errors.iter().map(|error| format!("\nerror: {error}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_begins_with_file_and_line() {
        let place = Place { file: "a.toml".to_owned(), line: Some(3) };
        let error = InputError { place, problem: Problem::TooManyWheels { found: 9, most: 8 } };
        assert_eq!(
            error.to_string(),
            "a.toml:3: 9 [[wheel]] tables, but at most 8 are supported; remove some"
        );
    }
}
