//! A CSV file with named columns, row by row, so that every complaint about it can name the line
//! and the column.
//!
//! Columns are found by name, in any order. Line ends may be LF or CRLF, a byte-order mark is
//! dropped, spaces around a cell don't count, and empty lines are skipped.

use std::path::Path;

use csv::StringRecord;

use super::error::{CsvProblem, InputError, Place, Problem};
use super::nearest::nearest;
use super::toml_source::{decode_utf8, read_utf8};

/// The header and the rows of a CSV file.
#[derive(Debug)]
pub(super) struct CsvSource {
    file: String,
    columns: Vec<String>,
    rows: Vec<CsvRow>,
}

/// One row: as many cells as the header has columns.
#[derive(Debug)]
pub(super) struct CsvRow {
    /// Its line in the file, from 1.
    pub line: u64,
    cells: StringRecord,
    is_last: bool,
}

/// A column of a [`CsvSource`].
#[derive(Clone, Debug)]
pub(super) struct Column {
    /// Its name in the header.
    pub name: String,
    index: usize,
}

impl CsvSource {
    /// Reads a file.
    pub(super) fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(&path.display().to_string(), &read_utf8(path)?)
    }

    /// Reads the bytes of a file already in memory; `file` is what errors call it.
    pub(super) fn decode(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        Self::parse(file, decode_utf8(file, bytes)?)
    }

    fn parse(file: &str, text: &str) -> Result<Self, InputError> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .flexible(true) // the length of each row is checked below, with better words
            .from_reader(text.as_bytes());
        let mut source = Self { file: file.to_owned(), columns: Vec::new(), rows: Vec::new() };
        let end = text.trim_end().len() as u64;
        if end == 0 {
            return Err(source.error(None, CsvProblem::Empty));
        }

        let unreadable = |error: csv::Error| InputError {
            place: Place { file: file.to_owned(), line: error.position().map(csv::Position::line) },
            problem: Problem::Unreadable(error.into()),
        };
        let header = reader.headers().map_err(unreadable)?.clone();
        source.columns = header.iter().map(str::to_owned).collect();
        source.check_header()?;

        let mut lines = LineCounter::new(text);
        let mut cells = StringRecord::new();
        while reader.read_record(&mut cells).map_err(unreadable)? {
            let line = lines.line_at(cells.position().map_or(0, csv::Position::byte));
            let is_last = reader.position().byte() >= end;
            let is_blank = cells.len() == 1 && cells[0].is_empty();
            if !is_blank {
                source.rows.push(CsvRow { line, cells: cells.clone(), is_last });
            }
        }
        if source.rows.is_empty() {
            return Err(source.error(None, CsvProblem::NoRows));
        }
        source.check_lengths()?;
        Ok(source)
    }

    /// The column called `name`. Where there is none, the error points to the one most like it,
    /// but never to one that `has_a_meaning` of its own.
    pub(super) fn column(
        &self,
        name: &str,
        has_a_meaning: impl Fn(&str) -> bool,
    ) -> Result<Column, InputError> {
        let index = self.columns.iter().position(|column| column == name).ok_or_else(|| {
            let free: Vec<&String> = self.columns.iter().filter(|c| !has_a_meaning(c)).collect();
            let problem = CsvProblem::MissingColumn {
                column: name.to_owned(),
                nearest: nearest(name, &free).map(str::to_owned),
                present: self.columns.clone(),
            };
            self.error(Some(1), problem)
        })?;
        Ok(Column { name: name.to_owned(), index })
    }

    /// The names of the columns, in the order of the file.
    pub(super) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows, top to bottom; at least one.
    pub(super) fn rows(&self) -> &[CsvRow] {
        &self.rows
    }

    /// The cell of `row` in `column` as text.
    pub(super) fn text<'row>(&self, row: &'row CsvRow, column: &Column) -> &'row str {
        row.cells.get(column.index).unwrap_or_default()
    }

    /// The cell of `row` in `column` as a finite number.
    pub(super) fn number(&self, row: &CsvRow, column: &Column) -> Result<f64, InputError> {
        let text = self.text(row, column);
        let number: f64 = text.parse().map_err(|_| self.not_a_number(row, column))?;
        if number.is_finite() {
            return Ok(number);
        }
        let problem = CsvProblem::NotFinite { column: column.name.clone(), text: text.to_owned() };
        Err(self.error(Some(row.line), problem))
    }

    /// The error for a cell that is not a number.
    ///
    /// The last cell of the last row is usually not wrong but cut: a log whose power went away ends
    /// in `1.0e-` or in nothing after the comma.
    pub(super) fn not_a_number(&self, row: &CsvRow, column: &Column) -> InputError {
        let is_last_cell = column.index + 1 == self.columns.len();
        if row.is_last && is_last_cell {
            return self.cut_row(row);
        }
        let text = self.text(row, column).to_owned();
        self.error(Some(row.line), CsvProblem::NotANumber { column: column.name.clone(), text })
    }

    /// An error about a line of this file, or about the whole of it.
    pub(super) fn error(&self, line: Option<u64>, problem: CsvProblem) -> InputError {
        InputError { place: Place { file: self.file.clone(), line }, problem: problem.into() }
    }

    fn check_header(&self) -> Result<(), InputError> {
        if let [only] = self.columns.as_slice()
            && only.contains([';', '\t', ' '])
        {
            return Err(self.error(Some(1), CsvProblem::NotCommaSeparated));
        }
        for (index, column) in self.columns.iter().enumerate() {
            let is_twice = self.columns.iter().take(index).any(|earlier| earlier == column);
            if is_twice && !column.is_empty() {
                let problem = CsvProblem::DuplicateColumn { column: column.clone() };
                return Err(self.error(Some(1), problem));
            }
        }
        Ok(())
    }

    fn check_lengths(&self) -> Result<(), InputError> {
        let columns = self.columns.len();
        for row in &self.rows {
            let found = row.cells.len();
            if found > columns {
                return Err(self.error(Some(row.line), CsvProblem::LongRow { found, columns }));
            }
            if found < columns && row.is_last {
                return Err(self.cut_row(row));
            }
            if found < columns {
                return Err(self.error(Some(row.line), CsvProblem::ShortRow { found, columns }));
            }
        }
        Ok(())
    }

    fn cut_row(&self, row: &CsvRow) -> InputError {
        let problem = CsvProblem::CutLastRow {
            end: row.cells.iter().next_back().unwrap_or_default().to_owned(),
            found: row.cells.len(),
            columns: self.columns.len(),
        };
        self.error(Some(row.line), problem)
    }
}

/// Counts lines along a text.
///
/// The CSV reader says where it started to look for a record, which is before the empty lines and
/// the second half of a CRLF that it then skips; its own line numbers are too small there.
struct LineCounter<'a> {
    text: &'a [u8],
    counted: usize,
    line: u64,
}

impl<'a> LineCounter<'a> {
    fn new(text: &'a str) -> Self {
        Self { text: text.as_bytes(), counted: 0, line: 1 }
    }

    /// The line of the first cell at or after `byte`, which must not be less than the time before.
    fn line_at(&mut self, byte: u64) -> u64 {
        let rest = self.text.iter().enumerate().skip(self.counted);
        for (index, character) in rest {
            let is_line_end = matches!(character, b'\n' | b'\r');
            if index as u64 >= byte && !is_line_end {
                break;
            }
            self.counted = index + 1;
            self.line += u64::from(*character == b'\n');
        }
        self.line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<CsvSource, InputError> {
        CsvSource::decode("x.csv", text.as_bytes())
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    /// The error of reading column `b` of every row.
    fn message_in_b(text: &str) -> String {
        let source = parse(text).unwrap();
        let b = source.column("b", |_| false).unwrap();
        let numbers: Result<Vec<f64>, _> =
            source.rows().iter().map(|row| source.number(row, &b)).collect();
        numbers.unwrap_err().to_string()
    }

    #[test]
    fn columns_are_found_in_any_order_whatever_the_line_ends() {
        for text in ["b,a\n2,1\n", "\u{feff}b,a\r\n2,1\r\n", "b , a\n\n 2, 1", "b,a\n2,1\n  \n"] {
            let source = parse(text).unwrap();
            let a = source.column("a", |_| false).unwrap();
            assert_eq!(source.number(&source.rows()[0], &a).unwrap(), 1.0, "{text:?}");
        }
    }

    #[test]
    fn lines_are_counted_as_an_editor_does() {
        for end in ["\n", "\r\n"] {
            let text = ["a", "1", "", "\"2\"", "3", "", "4"].join(end);
            let lines: Vec<u64> = parse(&text).unwrap().rows().iter().map(|row| row.line).collect();
            assert_eq!(lines, [2, 4, 5, 7]);
        }
    }

    #[test]
    fn empty_file_is_refused() {
        let expected = "x.csv: the file is empty; the first line must name the columns";
        assert_eq!(message(""), expected);
        assert_eq!(message("\u{feff}\r\n \n"), expected);
    }

    #[test]
    fn header_alone_is_refused() {
        assert_eq!(message("a,b\n"), "x.csv: no row follows the header; is this the right file?");
    }

    #[test]
    fn other_separators_are_recognised() {
        for text in ["a;b\n1;2\n", "a\tb\n1\t2\n"] {
            assert!(message(text).contains("not separated by commas"), "{text:?}");
        }
    }

    #[test]
    fn missing_column_names_the_nearest() {
        let message =
            parse("t,rate_x\n0,1\n").unwrap().column("rate_x_rad_s", |_| false).unwrap_err();
        assert_eq!(
            message.to_string(),
            "x.csv:1: no column `rate_x_rad_s` (is it `rate_x`? then rename it, mind its unit); \
             the columns are: t, rate_x"
        );
    }

    #[test]
    fn column_given_twice_is_refused() {
        assert!(message("a,b,a\n1,2,3\n").contains("column `a` is there twice"));
    }

    #[test]
    fn cell_that_is_not_a_number_is_named() {
        assert_eq!(
            message_in_b("a,b,c\n1,2,3\n1,x2,3\n1,2,3\n"),
            "x.csv:3: column `b`: \"x2\" is not a number; correct or remove the row"
        );
        assert!(message_in_b("a,b,c\n1,,3\n").contains("column `b`: \"\" is not a number"));
    }

    #[test]
    fn cell_that_is_not_finite_is_named() {
        for bad in ["nan", "NaN", "inf", "-Infinity", "1e999"] {
            let message = message_in_b(&format!("a,b\n1,2\n1,{bad}\n"));
            assert!(message.starts_with("x.csv:3: column `b`: "), "{message}");
            assert!(message.contains("is not a finite number"), "{message}");
        }
    }

    #[test]
    fn row_of_the_wrong_length_is_named() {
        assert_eq!(
            message("a,b\n1\n1,2\n"),
            "x.csv:2: 1 cells, but the header names 2 columns; complete or remove the row"
        );
        assert!(message("a,b\n1,2,3\n1,2\n").starts_with("x.csv:2: 3 cells, but the header"));
        assert!(message("a,b\n1,2\n1,2,3\n").starts_with("x.csv:3: 3 cells, but the header"));
    }

    #[test]
    fn last_row_too_short_was_cut() {
        for text in ["a,b,c\n1,2,3\n1,2.", "a,b,c\n1,2,3\n1,2.\n", "a,b,c\r\n1,2,3\r\n1,2.\r\n\r\n"]
        {
            let message = message(text);
            assert!(
                message.starts_with(
                    "x.csv:3: the file was cut in mid-row: the last row ends at \"2.\", 2 of 3"
                ),
                "{message}"
            );
        }
    }

    #[test]
    fn last_cell_that_is_not_a_number_was_cut() {
        for end in ["", "-", "1.5e-"] {
            let message = message_in_b(&format!("a,b\n1,2\n1,{end}"));
            assert!(message.starts_with("x.csv:3: the file was cut in mid-row"), "{message}");
        }
    }

    #[test]
    fn text_that_is_not_utf8_is_found_by_line() {
        let message = CsvSource::decode("x.csv", b"a,b\n1,2\n\xff\xfe,3\n").unwrap_err();
        assert!(message.to_string().starts_with("x.csv:3: not UTF-8 text"));
    }

    #[test]
    fn missing_file_is_named() {
        let message = CsvSource::read(Path::new("no/such.csv")).unwrap_err().to_string();
        assert!(message.starts_with("no/such.csv: cannot be read: "), "{message}");
    }
}
