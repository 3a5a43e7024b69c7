//! A CSV file with named columns: the source of line and column in errors.
//!
//! Columns are found by name, in any order. Line ends are LF or CRLF. A byte-order mark, spaces
//! around a cell and empty lines are ignored.

use std::path::Path;

use csv::StringRecord;

use crate::csv_problem::CsvProblem;
use crate::error::{InputError, Place, Problem};
use crate::nearest::nearest;
use crate::text::{decode_utf8, read_utf8};

/// The header and the rows of a CSV file.
#[derive(Debug)]
pub struct CsvSource {
    file: String,
    columns: Vec<String>,
    rows: Vec<CsvRow>,
}

/// One row, with one cell per column of the header.
#[derive(Debug)]
pub struct CsvRow {
    /// Line in the file, from 1.
    pub line: u64,
    cells: StringRecord,
    is_last: bool,
}

/// A column of a [`CsvSource`].
#[derive(Clone, Debug)]
pub struct Column {
    /// Name in the header.
    pub name: String,
    index: usize,
}

impl CsvSource {
    /// Reads a file.
    ///
    /// # Errors
    /// As of [`Self::decode`], or the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(&path.display().to_string(), &read_utf8(path)?)
    }

    /// Reads the bytes of a file; `file` is the name in errors.
    ///
    /// # Errors
    /// Not UTF-8, no rows, a repeated column, or a row of another length than the header.
    pub fn decode(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        Self::parse(file, decode_utf8(file, bytes)?)
    }

    fn parse(file: &str, text: &str) -> Result<Self, InputError> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .flexible(true) // check_lengths reports the length of a row with its remedy
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

    /// The column called `name`.
    ///
    /// # Errors
    /// The column is absent. The error names the most similar column, except the columns that
    /// `is_known` recognises.
    pub fn column(
        &self,
        name: &str,
        is_known: impl Fn(&str) -> bool,
    ) -> Result<Column, InputError> {
        let index = self.columns.iter().position(|column| column == name).ok_or_else(|| {
            let free: Vec<&String> = self.columns.iter().filter(|c| !is_known(c)).collect();
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
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows, top to bottom; at least one.
    pub fn rows(&self) -> &[CsvRow] {
        &self.rows
    }

    /// The cell of `row` in `column` as text.
    pub fn text<'row>(&self, row: &'row CsvRow, column: &Column) -> &'row str {
        row.cells.get(column.index).unwrap_or_default()
    }

    /// The cell of `row` in `column` as a finite number.
    ///
    /// # Errors
    /// The cell is not a number, or not finite.
    pub fn number(&self, row: &CsvRow, column: &Column) -> Result<f64, InputError> {
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
    /// In the last cell of the file it is reported as a cut: a log interrupted by loss of power ends
    /// in `1.0e-` or after the comma.
    pub fn not_a_number(&self, row: &CsvRow, column: &Column) -> InputError {
        let is_last_cell = column.index + 1 == self.columns.len();
        if row.is_last && is_last_cell {
            return self.cut_row(row);
        }
        let text = self.text(row, column).to_owned();
        self.error(Some(row.line), CsvProblem::NotANumber { column: column.name.clone(), text })
    }

    /// An error at a line of this file, or of the whole file.
    pub fn error(&self, line: Option<u64>, problem: CsvProblem) -> InputError {
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

/// Line numbers of byte offsets, ascending.
///
/// The CSV reader reports the offset at which its search for a record started. That offset precedes
/// skipped empty lines and the second half of a CRLF, so the reader's own line numbers are too small.
struct LineCounter<'a> {
    text: &'a [u8],
    counted: usize,
    line: u64,
}

impl<'a> LineCounter<'a> {
    fn new(text: &'a str) -> Self {
        Self { text: text.as_bytes(), counted: 0, line: 1 }
    }

    /// The line of the first cell at or after `byte`. The offsets of successive calls must ascend.
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

    /// The error of column `b`.
    fn message_in_b(text: &str) -> String {
        let source = parse(text).unwrap();
        let b = source.column("b", |_| false).unwrap();
        let numbers: Result<Vec<f64>, _> =
            source.rows().iter().map(|row| source.number(row, &b)).collect();
        numbers.unwrap_err().to_string()
    }

    #[test]
    fn columns_are_found_in_any_order_with_any_line_end() {
        for text in ["b,a\n2,1\n", "\u{feff}b,a\r\n2,1\r\n", "b , a\n\n 2, 1", "b,a\n2,1\n  \n"] {
            let source = parse(text).unwrap();
            let a = source.column("a", |_| false).unwrap();
            assert_eq!(source.number(&source.rows()[0], &a).unwrap(), 1.0, "{text:?}");
        }
    }

    #[test]
    fn line_numbers_include_empty_lines() {
        for end in ["\n", "\r\n"] {
            let text = ["a", "1", "", "\"2\"", "3", "", "4"].join(end);
            let lines: Vec<u64> = parse(&text).unwrap().rows().iter().map(|row| row.line).collect();
            assert_eq!(lines, [2, 4, 5, 7]);
        }
    }

    #[test]
    fn empty_file_is_rejected() {
        let expected = "x.csv: the file is empty; the first line must name the columns";
        assert_eq!(message(""), expected);
        assert_eq!(message("\u{feff}\r\n \n"), expected);
    }

    #[test]
    fn header_without_rows_is_rejected() {
        assert_eq!(message("a,b\n"), "x.csv: no row follows the header; is this the right file?");
    }

    #[test]
    fn other_separators_are_reported() {
        for text in ["a;b\n1;2\n", "a\tb\n1\t2\n"] {
            assert!(message(text).contains("not separated by commas"), "{text:?}");
        }
    }

    #[test]
    fn missing_column_is_reported_with_the_nearest() {
        let message =
            parse("t,rate_x\n0,1\n").unwrap().column("rate_x_rad_s", |_| false).unwrap_err();
        assert_eq!(
            message.to_string(),
            "x.csv:1: no column `rate_x_rad_s` (if it is `rate_x`, rename that; check its unit); \
             the columns are: t, rate_x"
        );
    }

    #[test]
    fn repeated_column_is_rejected() {
        assert!(message("a,b,a\n1,2,3\n").contains("column `a` appears twice"));
    }

    #[test]
    fn cell_that_is_not_a_number_is_reported() {
        assert_eq!(
            message_in_b("a,b,c\n1,2,3\n1,x2,3\n1,2,3\n"),
            "x.csv:3: column `b`: \"x2\" is not a number; correct or remove the row"
        );
        assert!(message_in_b("a,b,c\n1,,3\n").contains("column `b`: \"\" is not a number"));
    }

    #[test]
    fn cell_that_is_not_finite_is_reported() {
        for bad in ["nan", "NaN", "inf", "-Infinity", "1e999"] {
            let message = message_in_b(&format!("a,b\n1,2\n1,{bad}\n"));
            assert!(message.starts_with("x.csv:3: column `b`: "), "{message}");
            assert!(message.contains("is not a finite number"), "{message}");
        }
    }

    #[test]
    fn row_of_the_wrong_length_is_reported() {
        assert_eq!(
            message("a,b\n1\n1,2\n"),
            "x.csv:2: 1 cells, but the header names 2 columns; complete or remove the row"
        );
        assert!(message("a,b\n1,2,3\n1,2\n").starts_with("x.csv:2: 3 cells, but the header"));
        assert!(message("a,b\n1,2\n1,2,3\n").starts_with("x.csv:3: 3 cells, but the header"));
    }

    #[test]
    fn short_last_row_is_reported_as_cut() {
        for text in ["a,b,c\n1,2,3\n1,2.", "a,b,c\n1,2,3\n1,2.\n", "a,b,c\r\n1,2,3\r\n1,2.\r\n\r\n"]
        {
            let message = message(text);
            assert!(
                message.starts_with(
                    "x.csv:3: the file is cut in mid-row: the last row ends at \"2.\", 2 of 3"
                ),
                "{message}"
            );
        }
    }

    #[test]
    fn last_cell_that_is_not_a_number_is_reported_as_cut() {
        for end in ["", "-", "1.5e-"] {
            let message = message_in_b(&format!("a,b\n1,2\n1,{end}"));
            assert!(message.starts_with("x.csv:3: the file is cut in mid-row"), "{message}");
        }
    }

    #[test]
    fn bytes_outside_utf8_are_reported_with_their_line() {
        let message = CsvSource::decode("x.csv", b"a,b\n1,2\n\xff\xfe,3\n").unwrap_err();
        assert!(message.to_string().starts_with("x.csv:3: not UTF-8 text"));
    }

    #[test]
    fn missing_file_is_reported_by_name() {
        let message = CsvSource::read(Path::new("no/such.csv")).unwrap_err().to_string();
        assert!(message.starts_with("no/such.csv: cannot be read: "), "{message}");
    }
}
