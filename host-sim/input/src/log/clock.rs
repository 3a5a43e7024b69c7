//! Time of each row since the first, in microseconds.

use super::time::{TimeError, TimeStamp};
use crate::csv_problem::CsvProblem;
use crate::csv_source::{Column, CsvRow, CsvSource};
use crate::error::InputError;

/// Conversion of time stamps to microseconds since the first one; they must increase.
pub(super) struct Clock<'a> {
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
    pub(super) fn new(source: &'a CsvSource, column: &'a Column) -> Self {
        Self { source, column, first: None, previous: None }
    }

    /// Time of a row since the first, µs.
    pub(super) fn read(&mut self, row: &CsvRow) -> Result<u64, InputError> {
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
    /// The fault of a time stamp at or before this one.
    fn not_after(&self, stamp: TimeStamp, text: &str) -> CsvProblem {
        if stamp == self.stamp {
            CsvProblem::DuplicateTime { time: text.to_owned() }
        } else {
            CsvProblem::TimeBackwards { time: text.to_owned(), previous: self.text.clone() }
        }
    }
}
