//! A CSV file with named columns: the source of line and column in errors.
//!
//! Columns are found by name, in any order. Line ends are LF or CRLF. A byte-order mark, spaces
//! around a cell, empty lines, lines that start with `#`, `%` or `//`, a line `sep=;` before the
//! header, and a separator at the end of a line are ignored. A header may be a comment, as
//! `numpy.savetxt` writes it. Separator and decimal comma are found from the text, unless stated. Lines
//! of another length above the header, and a row of units below it, are not rows.

use std::borrow::Cow;
use std::path::Path;

use csv::StringRecord;

use crate::csv_dialect::{
    CsvOptions, has_decimal_commas, header_index, is_units, plain, with_point, without_thousands,
};
use crate::csv_problem::CsvProblem;
use crate::csv_text::{LineCounter, cells_of, header_comment, is_numbers, unquoted};
use crate::error::{InputError, Place, Problem};
use crate::nearest::nearest;
use crate::text::{decode_lossy, read_bytes, read_utf8};

/// Longest text of a cell in an error, characters.
const MAX_SHOWN: usize = 40;

/// Most bytes of a line: a header of 200,000 columns with names of 80 letters.
const MAX_LINE_BYTES: usize = 16 << 20;
/// Most rows, as of samples that are simulated: 28 hours at 100 Hz. A row takes about 200 bytes of memory.
pub const MAX_ROWS: usize = 10_000_000;

/// The header and the rows of a CSV file.
#[derive(Debug)]
pub struct CsvSource {
    file: String,
    header_line: Option<u64>,
    columns: Vec<String>,
    units: Vec<String>,
    rows: Vec<CsvRow>,
    decimal_comma: bool,
    ends_with_line_end: bool,
}

/// One row.
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

impl CsvRow {
    /// The cells, left to right.
    pub fn cells(&self) -> &StringRecord {
        &self.cells
    }
}

impl CsvSource {
    /// Reads a file in which every row has one cell per column.
    ///
    /// # Errors
    /// The file cannot be read, is not UTF-8, has no rows, a repeated column, or a row of another
    /// length than the header.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let options = CsvOptions::default();
        let source = Self::parse(&path.display().to_string(), &read_utf8(path)?, &options)?;
        source.rows.iter().try_for_each(|row| {
            let check = source.check_length(row);
            check.map_err(|problem| source.error(Some(row.line), problem))
        })?;
        Ok(source)
    }

    /// Reads a file whose rows are checked one by one, by [`Self::check_log_row`] and
    /// [`Self::number`]. Bytes outside UTF-8 spoil their cell only.
    ///
    /// # Errors
    /// The file cannot be read, its first line is not text, or it has no rows.
    pub fn read_unchecked(path: &Path) -> Result<Self, InputError> {
        let bytes = read_bytes(path)?;
        Self::decode_unchecked(&path.display().to_string(), &bytes, &CsvOptions::default())
    }

    /// Reads the bytes of a file; `file` is the name in errors.
    ///
    /// # Errors
    /// As of [`Self::read_unchecked`].
    pub fn decode_unchecked(
        file: &str,
        bytes: &[u8],
        options: &CsvOptions,
    ) -> Result<Self, InputError> {
        Self::parse(file, &decode_lossy(file, bytes)?, options)
    }

    /// A table from another kind of file, as text: one record per row, rows counted from 1 in errors.
    ///
    /// # Errors
    /// No rows.
    pub fn from_records(
        file: &str,
        columns: Vec<String>,
        records: Vec<StringRecord>,
    ) -> Result<Self, InputError> {
        let mut source = Self { columns, ..Self::empty(file) };
        let rows = (1..).zip(records);
        source
            .set_rows(rows.map(|(line, cells)| CsvRow { line, cells, is_last: false }).collect())?;
        Ok(source)
    }

    fn empty(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            header_line: None,
            columns: Vec::new(),
            units: Vec::new(),
            rows: Vec::new(),
            decimal_comma: false,
            ends_with_line_end: true,
        }
    }

    fn parse(file: &str, text: &str, options: &CsvOptions) -> Result<Self, InputError> {
        let mut source = Self::empty(file);
        source.ends_with_line_end = text.ends_with(['\n', '\r']);
        if text.trim().is_empty() {
            return Err(source.error(None, CsvProblem::Empty));
        }
        source.check_lines(text)?;
        let plain = plain(text, options);
        let separator = plain.separator.byte();
        let mut records = source.records(&plain.text, separator)?;
        records.drain(..header_index(records.iter().map(|row| &row.cells)));
        if records.is_empty() {
            return Err(source.error(None, CsvProblem::NoRows));
        }
        source.take_header(text, &mut records)?;
        source.take_units(&mut records);
        let columns = source.columns.len();
        records.iter_mut().for_each(|row| row.cells = cells_of(&row.cells, columns));
        let found =
            || separator != b',' && has_decimal_commas(records.iter().map(|row| &row.cells));
        source.decimal_comma = options.decimal_comma.unwrap_or_else(found);
        source.set_rows(records)?;
        Ok(source)
    }

    /// Refuses a line that is too long, before any part of the text is copied.
    fn check_lines(&self, text: &str) -> Result<(), InputError> {
        let bytes = text.split(['\n', '\r']).map(str::len);
        match (1..).zip(bytes).find(|(_, bytes)| *bytes > MAX_LINE_BYTES) {
            Some((line, bytes)) => {
                let problem = CsvProblem::LongLine { bytes, limit: MAX_LINE_BYTES };
                Err(self.error(Some(line), problem))
            }
            None => Ok(()),
        }
    }

    fn set_rows(&mut self, rows: Vec<CsvRow>) -> Result<(), InputError> {
        self.rows = rows;
        match self.rows.last_mut() {
            Some(last) => last.is_last = true,
            None => return Err(self.error(None, CsvProblem::NoRows)),
        }
        Ok(())
    }

    /// The records of the text, without empty lines. A quote that is not closed within its line is
    /// damage: quotes are then taken as ordinary characters, so that one line is lost.
    fn records(&self, text: &str, separator: u8) -> Result<Vec<CsvRow>, InputError> {
        let records = self.records_with(text, separator, true)?;
        let spans_lines = |row: &CsvRow| row.cells.iter().any(|cell| cell.contains(['\n', '\r']));
        if records.iter().any(spans_lines) {
            return self.records_with(text, separator, false);
        }
        Ok(records)
    }

    fn records_with(
        &self,
        text: &str,
        separator: u8,
        quoting: bool,
    ) -> Result<Vec<CsvRow>, InputError> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .delimiter(separator)
            .quoting(quoting)
            .trim(csv::Trim::All)
            .flexible(true) // check_length reports the length of a row with its remedy
            .from_reader(text.as_bytes());
        let unreadable = |error: csv::Error| InputError {
            place: Place {
                file: self.file.clone(),
                line: error.position().map(csv::Position::line),
            },
            problem: Problem::Unreadable(error.into()),
        };
        let (mut lines, mut records) = (LineCounter::new(text), Vec::new());
        let mut cells = StringRecord::new();
        while reader.read_record(&mut cells).map_err(unreadable)? {
            let line = lines.line_at(cells.position().map_or(0, csv::Position::byte));
            let is_blank = cells.len() == 1 && cells[0].is_empty();
            if records.len() == MAX_ROWS {
                return Err(self.error(Some(line), CsvProblem::TooManyRows { limit: MAX_ROWS }));
            }
            if !is_blank {
                records.push(CsvRow { line, cells: cells.clone(), is_last: false });
            }
        }
        Ok(records)
    }

    /// Takes the names of the columns: the first record, or the comment before a first record of
    /// numbers.
    fn take_header(&mut self, text: &str, records: &mut Vec<CsvRow>) -> Result<(), InputError> {
        let first = records.remove(0);
        self.header_line = Some(first.line);
        if is_numbers(&first.cells) {
            let comment = header_comment(text, first.line, first.cells.len());
            let Some((line, names)) = comment else {
                return Err(self.header_error(CsvProblem::NoHeader));
            };
            (self.header_line, self.columns) = (Some(line), names);
            records.insert(0, first);
        } else {
            self.columns = first.cells.iter().map(|name| unquoted(name).to_owned()).collect();
        }
        while self.columns.len() > 1 && self.columns.last().is_some_and(String::is_empty) {
            self.columns.pop();
        }
        Ok(())
    }

    /// Takes a row of units below the header.
    fn take_units(&mut self, records: &mut Vec<CsvRow>) {
        if records.first().is_some_and(|row| is_units(&row.cells)) {
            self.units = records.remove(0).cells.iter().map(str::to_owned).collect();
        }
    }

    /// The column called `name`.
    ///
    /// # Errors
    /// The column is absent, or there twice. The error names the most similar column, except the
    /// columns that `is_known` recognises.
    pub fn column(
        &self,
        name: &str,
        is_known: impl Fn(&str) -> bool,
    ) -> Result<Column, InputError> {
        let mut places = (0..self.columns.len()).filter(|index| self.columns[*index] == name);
        let index = places.next().ok_or_else(|| {
            let free: Vec<&String> = self.columns.iter().filter(|c| !is_known(c)).collect();
            let nearest = nearest(name, &free);
            let problem = CsvProblem::MissingColumn {
                column: name.to_owned(),
                nearest: nearest.map(str::to_owned),
                present: self.columns.clone(),
            };
            self.header_error(problem)
        })?;
        if places.next().is_some() {
            return Err(self.header_error(CsvProblem::DuplicateColumn { column: name.to_owned() }));
        }
        Ok(Column { name: name.to_owned(), index })
    }

    /// The name of the file in errors.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The names of the columns, in the order of the file.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The units of the columns, from a row of units below the header; empty without one.
    pub fn units(&self) -> &[String] {
        &self.units
    }

    /// The rows, top to bottom; at least one.
    pub fn rows(&self) -> &[CsvRow] {
        &self.rows
    }

    /// The cell of `row` in `column` as text.
    pub fn text<'row>(&self, row: &'row CsvRow, column: &Column) -> &'row str {
        row.cells.get(column.index).unwrap_or_default()
    }

    /// The cell of `row` in `column` as text, a number with a decimal point and without separated thousands.
    pub fn number_text<'row>(&self, row: &'row CsvRow, column: &Column) -> Cow<'row, str> {
        let text = self.text(row, column);
        if text.parse::<f64>().is_ok() && !self.decimal_comma {
            return Cow::Borrowed(text);
        }
        let point = if self.decimal_comma { ',' } else { '.' };
        let pointed = if self.decimal_comma { with_point(text) } else { None };
        pointed.or_else(|| without_thousands(text, point)).map_or(Cow::Borrowed(text), Cow::Owned)
    }

    /// The cell of `row` in `column` as a finite number.
    ///
    /// # Errors
    /// The cell is empty, not a number, or not finite.
    pub fn number(&self, row: &CsvRow, column: &Column) -> Result<f64, InputError> {
        self.finite_number(row, column).map_err(|problem| self.error(Some(row.line), problem))
    }

    /// The cell of `row` in `column` as a finite number.
    ///
    /// # Errors
    /// The fault of the cell, as of [`Self::number`].
    pub fn finite_number(&self, row: &CsvRow, column: &Column) -> Result<f64, CsvProblem> {
        let text = self.number_text(row, column);
        let number: f64 = text.parse().map_err(|_| self.not_a_number(row, column))?;
        if number.is_finite() { Ok(number) } else { Err(self.not_finite(row, column)) }
    }

    /// The fault of a cell that is not a number.
    ///
    /// In the last cell of the file it is reported as a cut: a log interrupted by loss of power ends
    /// in `1.0e-` or after the comma.
    pub fn not_a_number(&self, row: &CsvRow, column: &Column) -> CsvProblem {
        let is_last_cell = column.index + 1 == self.columns.len();
        if row.is_last && is_last_cell {
            return self.cut_row(row);
        }
        let column = column.name.clone();
        match self.shown(row, &column) {
            text if text.is_empty() => CsvProblem::EmptyCell { column },
            text => CsvProblem::NotANumber { column, text },
        }
    }

    /// The fault of a number that is NaN, infinite or too large.
    pub fn not_finite(&self, row: &CsvRow, column: &Column) -> CsvProblem {
        let column = column.name.clone();
        CsvProblem::NotFinite { text: self.shown(row, &column), column }
    }

    /// The text of a cell, cut to a length for errors.
    fn shown(&self, row: &CsvRow, column: &str) -> String {
        let index = self.columns.iter().position(|name| name == column);
        let text = index.and_then(|index| row.cells.get(index)).unwrap_or_default();
        text.chars().take(MAX_SHOWN).collect()
    }

    /// Requires one cell per column.
    ///
    /// # Errors
    /// Another number of cells.
    pub fn check_length(&self, row: &CsvRow) -> Result<(), CsvProblem> {
        let (found, columns) = (row.cells.len(), self.columns.len());
        if found > columns {
            Err(CsvProblem::LongRow { found, columns })
        } else if found < columns && row.is_last {
            Err(self.cut_row(row))
        } else if found < columns {
            Err(CsvProblem::ShortRow { found, columns })
        } else {
            Ok(())
        }
    }

    /// Requires a row of a log: one cell per column, no header again, no cut in the last cell of the
    /// file.
    ///
    /// The last cell may be cut where the last line has no line end, and the cell has fewer characters
    /// than those of all rows above: `-17` below `-17.25` may be a part of `-17.31`.
    ///
    /// # Errors
    /// Any of these.
    pub fn check_log_row(&self, row: &CsvRow) -> Result<(), CsvProblem> {
        /// Fewest rows above for a comparison.
        const MIN_ROWS: usize = 3;
        self.check_length(row)?;
        if row.cells.iter().eq(self.columns.iter().map(String::as_str)) {
            return Err(CsvProblem::RepeatedHeader);
        }
        let length = |row: &CsvRow| row.cells.iter().next_back().map_or(0, str::len);
        let above = &self.rows[..self.rows.len().saturating_sub(1)];
        let is_cut = row.is_last
            && !self.ends_with_line_end
            && above.len() >= MIN_ROWS
            && above.iter().all(|other| length(other) > length(row));
        if is_cut { Err(self.cut_row(row)) } else { Ok(()) }
    }

    /// An error at a line of this file, or of the whole file.
    pub fn error(&self, line: Option<u64>, problem: CsvProblem) -> InputError {
        InputError { place: Place { file: self.file.clone(), line }, problem: problem.into() }
    }

    /// An error of the header.
    pub fn header_error(&self, problem: CsvProblem) -> InputError {
        self.error(self.header_line, problem)
    }

    fn cut_row(&self, row: &CsvRow) -> CsvProblem {
        let end = row.cells.iter().next_back().unwrap_or_default();
        CsvProblem::CutLastRow {
            end: end.chars().take(MAX_SHOWN).collect(),
            found: row.cells.len(),
            columns: self.columns.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<CsvSource, InputError> {
        CsvSource::decode_unchecked("x.csv", text.as_bytes(), &CsvOptions::default())
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    /// The faults of the rows of a log.
    fn faults(text: &str) -> Vec<String> {
        let source = parse(text).unwrap();
        let faults = source.rows().iter().filter_map(|row| {
            let problem = source.check_log_row(row).err()?;
            Some(source.error(Some(row.line), problem).to_string())
        });
        faults.collect()
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
    fn other_dialects_are_read() {
        for text in [
            "a;b\n1;2,5\n",
            "a\tb\n1\t2.5\n",
            "a b\n 1   2.5\n",
            "a|b\n1|2.5\n",
            "sep=;\na;b\n1;2,5\n",
            "Product,Recorder\nDate,2024-05-01\na,x,b\n1,0,2.5\n2,0,3.5\n3,0,4.5\n",
            "a,b\n(s),[deg/s]\n1,2.5\n",
            "% a, b\n1,2.5\n",
        ] {
            let source = parse(text).unwrap();
            let b = source.column("b", |_| false).unwrap();
            assert_eq!(source.number(&source.rows()[0], &b).unwrap(), 2.5, "{text:?}");
        }
        assert_eq!(parse("a,b\ns,deg/s\n1,2\n").unwrap().units(), ["s", "deg/s"]);
        let stated = CsvOptions { decimal_comma: Some(true), ..CsvOptions::default() };
        let source = CsvSource::decode_unchecked("x", b"a\tb\n1\t2,5\n", &stated).unwrap();
        let b = source.column("b", |_| false).unwrap();
        assert_eq!(source.number(&source.rows()[0], &b).unwrap(), 2.5);
    }

    #[test]
    fn missing_column_is_reported_with_the_nearest() {
        let message =
            parse("t,rate_x\n0,1\n").unwrap().column("rate_x_rad_s", |_| false).unwrap_err();
        assert_eq!(
            message.to_string(),
            "x.csv:1: no column `rate_x_rad_s` (perhaps `rate_x`; check its unit); rename it, or \
             name the columns in [log] of the craft file, which `host-sim init --from` drafts; the \
             columns are: t, rate_x"
        );
    }

    #[test]
    fn repeated_column_is_rejected() {
        let source = parse("a,b,a\n1,2,3\n").unwrap();
        let message = source.column("a", |_| false).unwrap_err().to_string();
        assert!(message.contains("column `a` appears twice"), "{message}");
        assert!(source.column("b", |_| false).is_ok());
    }

    #[test]
    fn cell_that_is_not_a_number_is_reported() {
        assert_eq!(
            message_in_b("a,b,c\n1,2,3\n1,x2,3\n1,2,3\n"),
            "x.csv:3: column `b`: \"x2\" is not a number; correct or remove the row"
        );
        assert_eq!(
            message_in_b("a,b,c\n1,,3\n"),
            "x.csv:2: column `b` is empty; complete or remove the row"
        );
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
            faults("a,b\n1\n1,2\n1,2,3\n1,2\n"),
            [
                "x.csv:2: 1 cells, but the header names 2 columns; complete or remove the row",
                "x.csv:4: 3 cells, but the header names only 2 columns; remove the extra cells \
                 (decimal commas require semicolons or tabs between the cells)"
            ]
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, "a,b\n1\n1,2\n").unwrap();
        let message = CsvSource::read(&path).unwrap_err().to_string();
        assert!(message.contains("table.csv:2: 1 cells, but the header names 2"), "{message}");
    }

    #[test]
    fn comments_separator_line_and_trailing_commas_are_ignored() {
        for text in [
            "# of the logger\na,b\n1,2\n",
            "a,b\n# note\n1,2\n#1,2,3\n",
            "sep=,\na,b\n1,2\n",
            "\"sep=,\"\r\na,b\r\n1,2\r\n",
            "a,b,\n1,2,\n",
            "a,b,\n1,2\n",
            "a,b\n1,2,,\n",
            "# columns:\n# a, b\n1,2\n",
        ] {
            let source = parse(text).unwrap();
            assert_eq!((source.columns().join(" "), source.rows().len()), ("a b".to_owned(), 1));
            let b = source.column("b", |_| false).unwrap();
            assert_eq!(source.number(&source.rows()[0], &b).unwrap(), 2.0, "{text:?}");
            assert!(faults(text).is_empty(), "{text:?}");
        }
        let line = parse("# one\n\n# two\na,b\n# three\n\n1,2\n").unwrap().rows()[0].line;
        assert_eq!(line, 7);
    }

    #[test]
    fn quote_that_is_not_closed_spoils_its_row_only() {
        let source = parse("\"a\",b\n\"1\",2\n3,\"4\n5,6\n7,8\n");
        let source = source.unwrap();
        assert_eq!(source.rows().iter().map(|row| row.line).collect::<Vec<_>>(), [2, 3, 4, 5]);
        let b = source.column("b", |_| false).unwrap();
        let numbers = source.rows().iter().filter(|row| source.number(row, &b).is_ok()).count();
        assert_eq!(numbers, 3);
    }

    #[test]
    fn file_without_header_is_reported() {
        for text in ["0.1,2\n0.2,3\n", "# a\n0.1,2\n", "0,0\n0,1\n"] {
            assert!(
                message(text).contains(": the first row has numbers only; the first line must")
            );
        }
    }

    #[test]
    fn repeated_header_is_a_fault_of_its_row() {
        assert_eq!(
            faults("a,b\n1,2\na,b\n3,4\n"),
            ["x.csv:3: the names of the columns again; remove the row"]
        );
    }

    #[test]
    fn short_last_row_is_reported_as_cut() {
        let cut = "x.csv:3: the file is cut in mid-row: the last row ends at \"2.\", 2 of 3 cells; \
                   remove that row, or copy the file again";
        for end in ["", "\n", "\r\n\r\n"] {
            assert_eq!(faults(&format!("a,b,c\n1,2,3\n1,2.{end}")), [cut]);
        }
        let zeros = faults("a,b\n1,2\n3,4\n\0\0\0\0");
        assert!(zeros[0].starts_with("x.csv:4: the file is cut in mid-row"), "{zeros:?}");
    }

    #[test]
    fn last_cell_shorter_than_all_above_is_cut_without_a_line_end() {
        let text = "a,b\n1,-17.25\n2,-17.3\n3,-17.4\n4,-17";
        assert!(faults(text)[0].starts_with("x.csv:5: the file is cut in mid-row"));
        assert!(faults(&format!("{text}\n")).is_empty());
        assert!(faults(&text.replace("-17.3", "-17")).is_empty());
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
        let decode = |bytes| CsvSource::decode_unchecked("x.csv", bytes, &CsvOptions::default());
        let source = decode(b"a,b\n1,2\n3,\xff\n4,5\n").unwrap();
        let b = source.column("b", |_| false).unwrap();
        let message = source.number(&source.rows()[1], &b).unwrap_err().to_string();
        assert!(message.starts_with("x.csv:3: column `b`: \"\u{fffd}\" is not a"), "{message}");
    }

    #[test]
    fn missing_file_is_reported_by_name() {
        let message = CsvSource::read(Path::new("no/such.csv")).unwrap_err().to_string();
        assert!(message.starts_with("no/such.csv: cannot be read: "), "{message}");
    }
}
