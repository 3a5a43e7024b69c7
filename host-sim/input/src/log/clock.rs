//! Time of each row since the first, in microseconds.
//!
//! A log is a sequence of time stamps with faults: repeated and late rows, single stamps far ahead, a
//! clock that is set back in flight. Rows at fault are left out; a clock set back is a gap of unknown
//! length. A log in which the order of time is lost is rejected.

use super::record::LogRow;
use super::time::TimeStamp;
use super::time_columns::TimeColumns;
use crate::csv_problem::CsvProblem;
use crate::csv_source::{CsvRow, CsvSource};
use crate::error::InputError;
use crate::units::TimeUnit;

/// Most stamps ahead of the following ones that are left out as false.
const MAX_AHEAD: usize = 5;
/// Step into a false stamp, in steps of the rows after it.
const AHEAD_STEPS: i128 = 3;
/// Time that stands for a gap of unknown length, µs: one hour, above any gap that is predicted across.
const UNKNOWN_GAP_US: u64 = 3_600_000_000;
/// Rows of which at most one may be at fault.
const MAX_FAULTY: usize = 10;
/// Most times that the clock may be set back.
const MAX_SET_BACK: usize = 10;

/// Times of the rows of a log.
pub(super) struct Times {
    /// For each row of the source: time since the first usable row, µs, or the fault of the row.
    pub of_rows: Vec<Result<u64, CsvProblem>>,
    /// Time stamp of the first usable row, µs.
    pub start_us: i64,
    /// The clock was set back.
    pub is_set_back: bool,
    /// Notes to the user.
    pub notes: Vec<String>,
}

/// Times of all rows of `source` with a valid stamp in `column`. `complete` has the faults of the other
/// cells of each row: a row with one has no time.
///
/// # Errors
/// The order of time is lost, or most stamps are equal.
pub(super) fn times(
    source: &CsvSource,
    column: &TimeColumns,
    complete: &[Result<LogRow, CsvProblem>],
) -> Result<Times, InputError> {
    let mut clock = Clock::new(source, column, complete);
    for index in 0..clock.stamps.len() {
        if let Some(stamp) = clock.stamp(index) {
            clock.place(index, stamp);
        }
    }
    clock.check()?;
    clock.finish()
}

/// Rows in the order of the file, and which of them are usable.
struct Clock<'a> {
    source: &'a CsvSource,
    column: &'a TimeColumns,
    /// Stamp of each row, or its fault.
    stamps: Vec<Result<TimeStamp, CsvProblem>>,
    /// Usable rows, by index.
    usable: Vec<usize>,
    /// Usable rows at which the clock was set back, by index.
    set_back: Vec<usize>,
    /// Faulty stamps, by kind.
    repeated: Vec<usize>,
    disordered: Vec<usize>,
}

impl<'a> Clock<'a> {
    fn new(
        source: &'a CsvSource,
        column: &'a TimeColumns,
        complete: &[Result<LogRow, CsvProblem>],
    ) -> Self {
        let stamp = |(row, complete): (&CsvRow, &Result<LogRow, CsvProblem>)| match complete {
            Ok(_) => column.stamp(source, row),
            Err(fault) => Err(fault.clone()),
        };
        let stamps = source.rows().iter().zip(complete).map(stamp).collect();
        let (usable, set_back, repeated, disordered) = Default::default();
        Self { source, column, stamps, usable, set_back, repeated, disordered }
    }

    fn stamp(&self, index: usize) -> Option<TimeStamp> {
        self.stamps.get(index).and_then(|stamp| stamp.as_ref().ok()).copied()
    }

    /// Text of a row's stamp.
    fn text(&self, index: usize) -> String {
        let row = self.source.rows().get(index);
        row.map_or(String::new(), |row| self.column.text(self.source, row))
    }

    /// Takes the row into the usable ones, or marks the rows at fault.
    fn place(&mut self, index: usize, stamp: TimeStamp) {
        let previous = self.usable.last().and_then(|last| Some((*last, self.stamp(*last)?)));
        let Some((last, previous)) = previous else {
            self.usable.push(index);
            return;
        };
        if stamp > previous {
            self.usable.push(index);
        } else if stamp == previous {
            self.mark_repeated(last, index);
        } else {
            self.place_before(index, stamp, last, previous);
        }
    }

    fn mark_repeated(&mut self, last: usize, index: usize) {
        let rows = self.source.rows();
        let is_whole_row = rows.get(last).map(CsvRow::cells) == rows.get(index).map(CsvRow::cells);
        let problem = match is_whole_row {
            true => CsvProblem::RepeatedRow,
            false => {
                CsvProblem::DuplicateTime { column: self.column.name(), time: self.text(index) }
            }
        };
        if !is_whole_row {
            self.repeated.push(index);
        }
        self.stamps[index] = Err(problem);
    }

    /// A stamp before the previous one: this one is false, or those before it, or the clock was set
    /// back.
    fn place_before(&mut self, index: usize, stamp: TimeStamp, last: usize, previous: TimeStamp) {
        let next = (index + 1..self.stamps.len()).find_map(|later| self.stamp(later));
        let Some(next) = next.filter(|next| *next < previous) else {
            let (time, previous) = (self.text(index), self.text(last));
            self.disordered.push(index);
            let column = self.column.name();
            self.stamps[index] = Err(CsvProblem::TimeBackwards { column, time, previous });
            return;
        };
        let origin = self.set_back.last().copied().unwrap_or(0);
        let is_ahead = |row: &&usize| **row >= origin && self.stamp(**row) >= Some(stamp);
        let recent = self.usable.iter().rev().take(MAX_AHEAD + 1);
        let ahead = recent.take_while(is_ahead).count();
        let first_ahead = self.usable.len() - ahead;
        let step = next.since(stamp);
        let is_jump = match first_ahead.checked_sub(1).map(|before| self.usable[before]) {
            Some(before) => {
                let (from, to) = (self.stamp(before), self.stamp(self.usable[first_ahead]));
                from.zip(to).is_some_and(|(from, to)| to.since(from) > AHEAD_STEPS * step)
            }
            None => true,
        };
        if ahead <= MAX_AHEAD && is_jump && step > 0 {
            for false_row in self.usable.split_off(first_ahead) {
                let time = self.text(false_row);
                self.disordered.push(false_row);
                let column = self.column.name();
                self.stamps[false_row] = Err(CsvProblem::TimeAhead { column, time });
            }
        } else {
            self.set_back.push(index);
        }
        self.usable.push(index);
    }

    /// Rejects a log whose order of time is lost.
    fn check(&mut self) -> Result<(), InputError> {
        let rows = self.usable.len() + self.repeated.len() + self.disordered.len();
        let is_lost = |faulty: usize| faulty * MAX_FAULTY > rows;
        let unsorted = self.disordered.len() + self.set_back.len();
        if is_lost(self.repeated.len() + unsorted) && self.repeated.len() > unsorted {
            let first = self.repeated[0];
            let (column, time) = (self.column.name(), self.text(first));
            let problem = match self.repeated.len() {
                1 => CsvProblem::DuplicateTime { column, time },
                shared => CsvProblem::FewDigits { column, shared, rows, time },
            };
            return Err(self.source.error(self.line(first), problem));
        }
        if is_lost(unsorted) || self.set_back.len() > MAX_SET_BACK {
            let stamp = |index: usize| {
                let row = self.source.rows().get(index)?;
                self.column.stamp(self.source, row).ok()
            };
            let backwards = (1..self.stamps.len()).find_map(|i| {
                let (previous, time, column) = (self.text(i - 1), self.text(i), self.column.name());
                let is_before = stamp(i)? < stamp(i - 1)?;
                is_before.then_some((i, CsvProblem::TimeBackwards { column, time, previous }))
            });
            if let Some((index, problem)) = backwards {
                return Err(self.source.error(self.line(index), problem));
            }
        }
        Ok(())
    }

    fn line(&self, index: usize) -> Option<u64> {
        self.source.rows().get(index).map(|row| row.line)
    }

    /// Times of the usable rows.
    fn finish(self) -> Result<Times, InputError> {
        let first = self.usable.first().copied();
        let unit = self.unit();
        let mut of_rows: Vec<Result<u64, CsvProblem>> =
            self.stamps.iter().map(|stamp| stamp.clone().map(|_| 0)).collect();
        let mut scale = Scale { unit, start: None, offset_us: 0, last: None };
        let mut same = Vec::new();
        for &index in &self.usable {
            let Some(stamp) = self.stamp(index) else { continue };
            let previous = scale.last.map(|(last, _)| last);
            of_rows[index] = match scale.time_us(index, stamp, self.set_back.contains(&index)) {
                Ok(time_us) => Ok(time_us),
                Err(NoTime::SameMicrosecond) => {
                    same.push(index);
                    let previous = previous.map_or(String::new(), |previous| self.text(previous));
                    let (column, time) = (self.column.name(), self.text(index));
                    Err(CsvProblem::SameMicrosecond { column, time, previous })
                }
                Err(NoTime::TooLarge) => Err(CsvProblem::NotFinite {
                    column: self.column.name(),
                    text: self.text(index),
                }),
            };
        }
        if let Some(&first) = same.first()
            && same.len() * MAX_FAULTY > self.usable.len()
            && let Err(problem) = &of_rows[first]
        {
            return Err(self.source.error(self.line(first), problem.clone()));
        }
        let start = first.and_then(|first| self.stamp(first));
        let start_us = start.and_then(|start| start.microseconds(unit)).unwrap_or(0);
        let is_set_back = !self.set_back.is_empty();
        Ok(Times { of_rows, start_us, is_set_back, notes: self.notes(unit) })
    }

    /// Unit of the last usable stamp: a clock may be set to the time since 1970 in flight.
    fn unit(&self) -> TimeUnit {
        let last = self.usable.last().and_then(|last| self.stamp(*last));
        self.column.unit(last)
    }

    fn notes(&self, unit: TimeUnit) -> Vec<String> {
        let mut notes = Vec::new();
        let place =
            |index: usize| format!("{}:{}", self.source.file(), self.line(index).unwrap_or(0));
        let is_since_1970 = |index: &&usize| self.column.unit(self.stamp(**index)) == unit;
        let column = self.column.name();
        if unit != TimeUnit::Second
            && let Some(&first) = self.usable.iter().find(is_since_1970)
        {
            let (name, text) = (unit.name(), self.text(first));
            notes.push(format!(
                "{}: column `{column}`: {text} is read as {name} since 1970; state another unit as \
                 log.time_unit in the craft file",
                place(first)
            ));
        }
        for &index in &self.set_back {
            let at = self.usable.partition_point(|usable| *usable < index);
            let before = at.checked_sub(1).map_or(String::new(), |at| self.text(self.usable[at]));
            notes.push(format!(
                "{}: column `{column}`: the clock is set back from {before} to {}; taken as a gap of \
                 unknown length, one hour in the times of the result",
                place(index),
                self.text(index)
            ));
        }
        notes
    }
}

/// Conversion of time stamps to microseconds since the first one.
struct Scale {
    unit: TimeUnit,
    /// Stamp from which time counts: the first one, or the first after the clock was set back.
    start: Option<TimeStamp>,
    /// Time of that stamp, µs.
    offset_us: u64,
    /// Row and time of the last stamp.
    last: Option<(usize, u64)>,
}

/// Why a time stamp has no time in microseconds.
enum NoTime {
    /// Beyond 64 bits.
    TooLarge,
    /// In the microsecond of the previous row.
    SameMicrosecond,
}

impl Scale {
    /// Time of a row, µs, or why it has none.
    fn time_us(&mut self, row: usize, stamp: TimeStamp, is_set_back: bool) -> Result<u64, NoTime> {
        if is_set_back {
            self.start = Some(stamp);
            self.offset_us =
                self.last.map_or(0, |(_, last_us)| last_us.saturating_add(UNKNOWN_GAP_US));
        }
        let start = *self.start.get_or_insert(stamp);
        let elapsed_us = stamp.microseconds_since(start, self.unit);
        let time_us = elapsed_us.and_then(|us| us.checked_add(self.offset_us));
        let time_us = time_us.ok_or(NoTime::TooLarge)?;
        if self.last.is_some_and(|(_, last_us)| time_us <= last_us) {
            return Err(NoTime::SameMicrosecond);
        }
        self.last = Some((row, time_us));
        Ok(time_us)
    }
}
