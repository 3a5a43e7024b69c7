//! Log lines of the bench image: `KIND key=value key=value …`.

use super::{Count, OutcomeCount, SliceCount, WorkCount};
use anyhow::{Context, Result};

/// Values of a log line.
#[derive(Clone, Copy)]
pub(super) struct Words<'a>(&'a str);

impl<'a> Words<'a> {
    /// Values of a line of this kind; `None` for another line.
    pub fn of(line: &'a str, kind: &str) -> Option<Self> {
        line.strip_prefix(kind)?.strip_prefix(' ').map(Self)
    }

    fn value(self, key: &str) -> Result<&'a str> {
        self.0
            .split_whitespace()
            .find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
            .with_context(|| format!("no {key}= in the log line {:?}", self.0))
    }

    fn number(self, key: &str) -> Result<u32> {
        self.value(key)?
            .parse()
            .with_context(|| format!("{key}= is not a number in the log line {:?}", self.0))
    }

    /// Counts of one estimator on one flight.
    pub fn count(self) -> Result<Count> {
        Ok(Count {
            name: self.value("name")?.into(),
            flight: self.value("flight")?.into(),
            steps: self.number("steps")?,
            worst: self.number("worst")?,
            at: self.number("at")?,
            median: self.number("median")?,
            status: self.value("status")?.into(),
        })
    }

    /// Counts of the slices of one kind.
    pub fn slice(self) -> Result<SliceCount> {
        Ok(SliceCount {
            name: self.value("name")?.into(),
            flight: self.value("flight")?.into(),
            kind: self.value("kind")?.into(),
            slices: self.number("slices")?,
            worst: self.number("worst")?,
            median: self.number("median")?,
        })
    }

    /// Samples with work left.
    pub fn work(self) -> Result<WorkCount> {
        Ok(WorkCount {
            name: self.value("name")?.into(),
            flight: self.value("flight")?.into(),
            busy: self.number("busy")?,
            longest: self.number("longest")?,
        })
    }

    /// Counts of one outcome.
    pub fn outcome(self) -> Result<OutcomeCount> {
        Ok(OutcomeCount {
            name: self.value("name")?.into(),
            flight: self.value("flight")?.into(),
            outcome: self.value("outcome")?.into(),
            steps: self.number("steps")?,
            worst: self.number("worst")?,
        })
    }
}
