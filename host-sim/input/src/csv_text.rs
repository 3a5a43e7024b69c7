//! Parts of a CSV text: cells, a header in a comment, line numbers.

use csv::StringRecord;

use crate::csv_dialect::is_comment;

/// The cells without quotes around them, without empty ones beyond the last column, and without those
/// from a NUL on: a file that loses power ends in zeros.
pub(crate) fn cells_of(cells: &StringRecord, columns: usize) -> StringRecord {
    let whole = cells.iter().take_while(|cell| !cell.contains('\0'));
    let mut kept: Vec<&str> = whole.map(unquoted).collect();
    while kept.len() > columns && kept.last().is_some_and(|cell| cell.is_empty()) {
        kept.pop();
    }
    StringRecord::from(kept)
}

/// A cell without quotes around it.
pub(crate) fn unquoted(cell: &str) -> &str {
    let inner = cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"'));
    inner.map_or(cell, str::trim)
}

/// True for cells that are all numbers.
pub(crate) fn is_numbers(cells: &StringRecord) -> bool {
    let mut filled = cells.iter().filter(|cell| !cell.is_empty()).peekable();
    filled.peek().is_some() && filled.all(|cell| cell.parse::<f64>().is_ok())
}

/// Line and names of the last comment before `line`, if it has as many names as there are columns, after a title as
/// `columns:` or not.
pub(crate) fn header_comment(text: &str, line: u64, columns: usize) -> Option<(u64, Vec<String>)> {
    let before = (1..line).zip(text.lines());
    let comments = before.filter(|(_, text)| is_comment(text));
    let (line, comment) = comments.last()?;
    let comment = comment.trim_start().trim_start_matches(['#', '%', '/']);
    let untitled = comment.split_once(':').map(|(_, names)| names);
    let is_header = |names: &Vec<String>| names.len() == columns && columns > 1;
    let names = [Some(comment), untitled].into_iter().flatten().find_map(|comment| {
        let split = |separator| comment.split(separator).map(|name: &str| name.trim().to_owned());
        let names = [',', ';', '\t', '|'].map(|separator| split(separator).collect::<Vec<_>>());
        let words = comment.split_whitespace().map(str::to_owned).collect();
        names.into_iter().chain([words]).find(is_header)
    });
    names.map(|names| (line, names))
}

/// Line numbers of byte offsets, ascending.
///
/// The CSV reader reports the offset at which its search for a record started. That offset precedes
/// skipped empty lines and the second half of a CRLF, so the reader's own line numbers are
/// too small.
pub(crate) struct LineCounter<'a> {
    text: &'a [u8],
    counted: usize,
    line: u64,
}

impl<'a> LineCounter<'a> {
    /// The first line.
    pub(crate) fn new(text: &'a str) -> Self {
        Self { text: text.as_bytes(), counted: 0, line: 1 }
    }

    /// The line of the first cell at or after `byte`. The offsets of successive calls must ascend.
    pub(crate) fn line_at(&mut self, byte: u64) -> u64 {
        while let Some(&character) = self.text.get(self.counted) {
            let is_line_end = matches!(character, b'\n' | b'\r');
            let is_searched = self.counted as u64 >= byte;
            if is_searched && !is_line_end {
                break;
            }
            self.counted += 1;
            self.line += u64::from(character == b'\n');
        }
        self.line
    }
}
