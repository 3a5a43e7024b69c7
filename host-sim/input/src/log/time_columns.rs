//! The columns of time of a table, and the time stamp of each row.

use super::date;
use super::time::{TimeError, TimeStamp, unit_of};
use crate::craft::TimeFormat;
use crate::csv_problem::CsvProblem;
use crate::csv_source::{Column, CsvRow, CsvSource};
use crate::error::InputError;
use crate::units::TimeUnit;

/// Columns of time in one table.
#[derive(Debug)]
pub(super) struct TimeColumns {
    /// The columns with their units; their times are added.
    columns: Vec<(Column, Option<TimeUnit>)>,
    /// Form of dates, where stated.
    form: Option<String>,
    /// Units per count.
    scale: f64,
}

impl TimeColumns {
    /// The columns of `format` in the table. `is_known` recognises columns of another meaning.
    pub(super) fn find(
        source: &CsvSource,
        format: &TimeFormat,
        is_known: impl Fn(&str) -> bool,
    ) -> Result<Self, InputError> {
        let units = format.units.iter().map(|unit| Some(*unit)).chain(std::iter::repeat(None));
        let columns = (format.columns.iter().zip(units))
            .map(|(name, unit)| Ok((source.column(name, &is_known)?, unit)))
            .collect::<Result<_, InputError>>()?;
        Ok(Self { columns, form: format.form.clone(), scale: format.scale })
    }

    /// Name in messages.
    pub(super) fn name(&self) -> String {
        let names: Vec<&str> =
            self.columns.iter().map(|(column, _)| column.name.as_str()).collect();
        names.join("` + `")
    }

    /// True if the stamps are in seconds: the unit is stated. Otherwise their unit is found from the
    /// last stamp.
    pub(super) fn is_stated(&self) -> bool {
        let has_units = self.columns.iter().all(|(_, unit)| unit.is_some());
        has_units || self.form.is_some() || self.columns.len() > 1
    }

    /// Text of a row's stamp.
    pub(super) fn text(&self, source: &CsvSource, row: &CsvRow) -> String {
        let texts: Vec<&str> =
            self.columns.iter().map(|(column, _)| source.text(row, column)).collect();
        texts.join(" + ")
    }

    /// Stamp of a row, in seconds if the unit is stated.
    ///
    /// # Errors
    /// The fault of a cell.
    pub(super) fn stamp(&self, source: &CsvSource, row: &CsvRow) -> Result<TimeStamp, CsvProblem> {
        let mut picoseconds = 0;
        for (column, unit) in &self.columns {
            let text = source.number_text(row, column);
            let stamp = self.parse(&text, *unit).map_err(|error| match error {
                TimeError::NotANumber if self.form.is_some() => CsvProblem::OtherDateForm {
                    column: column.name.clone(),
                    text: text.into_owned(),
                    form: self.form.clone().unwrap_or_default(),
                },
                TimeError::NotANumber if text.contains(':') => {
                    CsvProblem::ClockTime { column: column.name.clone(), text: text.into_owned() }
                }
                TimeError::NotANumber => source.not_a_number(row, column),
                TimeError::NotFinite => source.not_finite(row, column),
            });
            picoseconds += stamp?.picoseconds;
        }
        if self.scale != 1.0 {
            picoseconds = (picoseconds as f64 * self.scale).round() as i128;
        }
        Ok(TimeStamp { picoseconds })
    }

    /// The stamp of a cell.
    fn parse(&self, text: &str, unit: Option<TimeUnit>) -> Result<TimeStamp, TimeError> {
        match &self.form {
            Some(form) if unit.is_none_or(|unit| unit == TimeUnit::Date) => {
                date::parse_as(text, form).ok_or(TimeError::NotANumber)
            }
            _ => parse(text, unit),
        }
    }

    /// Unit of the stamps, the last of which is `last`.
    pub(super) fn unit(&self, last: Option<TimeStamp>) -> TimeUnit {
        if self.is_stated() { TimeUnit::Second } else { last.map_or(TimeUnit::Second, unit_of) }
    }
}

/// A number in the unit, a number with its unit as of MATLAB, or a date.
fn parse(text: &str, unit: Option<TimeUnit>) -> Result<TimeStamp, TimeError> {
    let number = TimeStamp::parse_in(text, unit.unwrap_or(TimeUnit::Second));
    if number != Err(TimeError::NotANumber) {
        return number;
    }
    let with_unit = text
        .rsplit_once(' ')
        .and_then(|(number, unit)| TimeStamp::parse_in(number.trim(), TimeUnit::find(unit)?).ok());
    with_unit.or_else(|| date::parse(text)).ok_or(TimeError::NotANumber)
}
