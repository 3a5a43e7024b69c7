//! Dialect of a CSV text: separator, decimal comma, comments, lines above and below the header.

use std::borrow::Cow;

use csv::StringRecord;

use crate::units::is_unit;

/// Lines from which the separator is found.
const SAMPLED_LINES: usize = 200;
/// Weight of a separator without a line of names.
const WITHOUT_NAMES: f64 = 0.1;
/// Starts of comment lines.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Separator of the cells of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// Tab.
    Tab,
    /// `|`
    Bar,
    /// Any number of spaces and tabs.
    Spaces,
}

impl Separator {
    /// All of them, in the order of preference among equals.
    pub const ALL: [Self; 5] = [Self::Comma, Self::Semicolon, Self::Tab, Self::Bar, Self::Spaces];

    /// Name in a craft file and in notes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Comma => "comma",
            Self::Semicolon => "semicolon",
            Self::Tab => "tab",
            Self::Bar => "bar",
            Self::Spaces => "spaces",
        }
    }

    /// The separator of this name, or with this character.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|separator| {
                separator.name() == name || name == (separator.byte() as char).to_string()
            })
            .or_else(|| (!name.is_empty() && name.trim().is_empty()).then_some(Self::Spaces))
    }

    /// The byte between two cells of a [`plain`] text.
    pub(crate) fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab | Self::Spaces => b'\t',
            Self::Bar => b'|',
        }
    }

    /// The cells of a line. Quotes protect separators.
    fn split(self, line: &str) -> Vec<&str> {
        let mut is_quoted = false;
        let pieces = line.split(move |c: char| {
            is_quoted ^= c == '"';
            let is_separator = match self {
                Self::Spaces => c == ' ' || c == '\t',
                _ => c == char::from(self.byte()),
            };
            is_separator && !is_quoted
        });
        let cells = pieces.map(str::trim);
        match self {
            Self::Spaces => cells.filter(|cell| !cell.is_empty()).collect(),
            _ => cells.collect(),
        }
    }
}

/// The part of a dialect that a craft file may state; the rest is found from the text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CsvOptions {
    /// Separator of the cells.
    pub separator: Option<Separator>,
    /// Decimals are written with a comma.
    pub decimal_comma: Option<bool>,
}

/// A text as the CSV reader takes it: comments blank, one separator. Its lines are those of the file.
pub(crate) struct PlainText<'a> {
    pub text: Cow<'a, str>,
    pub separator: Separator,
}

/// The text in one dialect.
pub(crate) fn plain<'a>(text: &'a str, options: &CsvOptions) -> PlainText<'a> {
    let (stated_line, stated) = separator_line(text);
    let found = || stated.unwrap_or_else(|| separator_of(text));
    let separator = options.separator.unwrap_or_else(found);
    let is_unchanged =
        separator != Separator::Spaces && stated_line.is_none() && !text.lines().any(is_comment);
    if is_unchanged {
        return PlainText { text: text.into(), separator };
    }
    let mut plain = String::with_capacity(text.len());
    for (index, line) in text.split_inclusive('\n').enumerate() {
        let content = line.trim_end_matches(['\n', '\r']);
        if is_comment(content) || stated_line == Some(index) {
            // Blank: skipped by the reader.
        } else if separator == Separator::Spaces {
            plain += &separator.split(content).join("\t");
        } else {
            plain += content;
        }
        plain += &line[content.len()..];
    }
    PlainText { text: plain.into(), separator }
}

/// True for a line that is a comment.
pub(crate) fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    COMMENTS.iter().any(|start| line.starts_with(start))
}

/// Index of a first line `sep=;`, by which spreadsheets state the separator, and that separator.
fn separator_line(text: &str) -> (Option<usize>, Option<Separator>) {
    let first = text.lines().enumerate().find(|(_, line)| !line.trim().is_empty());
    let stated = first.and_then(|(index, line)| {
        let line = line.trim_matches(['"', '\r', ' ']);
        let start = line.get(..4)?;
        start.eq_ignore_ascii_case("sep=").then(|| (index, Separator::find(&line[4..])))
    });
    stated.map_or((None, None), |(index, separator)| (Some(index), separator))
}

/// The separator with the most cells per line, weighted by the share of lines with that number of
/// cells. One of these lines must have names: decimal commas separate numbers only.
fn separator_of(text: &str) -> Separator {
    let lines: Vec<&str> = (text.lines().map(str::trim))
        .filter(|line| !line.is_empty() && !is_comment(line))
        .take(SAMPLED_LINES)
        .collect();
    let weight = |separator: Separator| {
        let rows: Vec<Vec<&str>> = lines.iter().map(|line| separator.split(line)).collect();
        let cells = usual_length(rows.iter().map(Vec::len));
        let usual = rows.iter().filter(|row| row.len() == cells);
        let share = usual.clone().count() as f64 / rows.len().max(1) as f64;
        let has_names = usual.clone().any(|row| has_names(row.iter().copied()));
        let named = if has_names { 1.0 } else { WITHOUT_NAMES };
        (cells.saturating_sub(1)) as f64 * share * named
    };
    let weights = Separator::ALL.map(|separator| (separator, weight(separator)));
    // The first of equals: `max_by` takes the last.
    let best = weights.iter().rev().max_by(|a, b| a.1.total_cmp(&b.1));
    best.filter(|(_, weight)| *weight > 0.0).map_or(Separator::Comma, |(best, _)| *best)
}

/// The most frequent number of cells, the largest of equals; 0 without rows.
pub(crate) fn usual_length(lengths: impl Iterator<Item = usize>) -> usize {
    let mut counts = std::collections::BTreeMap::new();
    lengths.for_each(|length| *counts.entry(length).or_insert(0usize) += 1);
    counts.into_iter().max_by_key(|(_, count)| *count).map_or(0, |(length, _)| length)
}

/// True if more than half of the cells are names.
fn has_names<'a>(cells: impl Iterator<Item = &'a str>) -> bool {
    let filled: Vec<&str> = cells.filter(|cell| !cell.is_empty()).collect();
    2 * filled.iter().filter(|cell| is_name(cell)).count() > filled.len()
}

/// A text with letters that neither is a number nor starts as one, as a date or `0,5E0;1` do.
fn is_name(cell: &str) -> bool {
    let starts_as_number = cell.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    cell.chars().any(char::is_alphabetic) && !starts_as_number && cell.parse::<f64>().is_err()
}

/// Index of the record with the names of the columns: the first of names with the usual number of
/// cells, above all rows of that number. Records before it are a preamble.
pub(crate) fn header_index<'a>(records: impl Iterator<Item = &'a StringRecord> + Clone) -> usize {
    let usual = usual_length(records.clone().take(SAMPLED_LINES).map(StringRecord::len));
    let first = records.enumerate().find(|(_, record)| record.len() == usual);
    first.filter(|(_, record)| has_names(record.iter())).map_or(0, |(index, _)| index)
}

/// True for a row of units, as below the header of some exports: no number, and at least half of the
/// cells are known units.
pub(crate) fn is_units(cells: &StringRecord) -> bool {
    let filled: Vec<&str> = cells.iter().filter(|cell| !cell.is_empty()).collect();
    let units = filled.iter().filter(|cell| is_unit(cell)).count();
    let is_number = |cell: &&str| cell.parse::<f64>().is_ok();
    units > 0 && 2 * units >= filled.len() && !filled.iter().any(is_number)
}

/// True if the cells of these rows write decimals with a comma: some number has one, and none has a
/// point.
pub(crate) fn has_decimal_commas<'a>(rows: impl Iterator<Item = &'a StringRecord>) -> bool {
    let mut has_comma = false;
    for cell in rows.take(SAMPLED_LINES).flat_map(StringRecord::iter) {
        if cell.contains('.') && cell.parse::<f64>().is_ok() {
            return false;
        }
        has_comma |= with_point(cell).is_some();
    }
    has_comma
}

/// A number with a decimal comma, written with a point.
pub(crate) fn with_point(cell: &str) -> Option<String> {
    let is_one = cell.matches(',').count() == 1 && !cell.contains('.');
    let number = is_one.then(|| cell.replace(',', "."))?;
    number.parse::<f64>().is_ok().then_some(number)
}

/// A number with separated thousands, as `-1,234.5` or `1'234.5`, without the separators; `point` is its decimal sign.
pub(crate) fn without_thousands(cell: &str, point: char) -> Option<String> {
    let separator =
        cell.chars().find(|c| [',', '.', '\'', '’', '\u{a0}', '\u{202f}'].contains(c))?;
    if separator == point {
        return None;
    }
    let (whole, _) = cell.split_once(point).unwrap_or((cell, ""));
    let mut groups = whole.trim_start_matches(['+', '-']).split(separator);
    let is_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let first = groups.next().is_some_and(|g| (1..=3).contains(&g.len()) && is_digits(g));
    let is_grouped = first && groups.all(|group| group.len() == 3 && is_digits(group));
    let plain = || cell.replace(separator, "").replace(point, ".");
    is_grouped.then(plain).filter(|number| number.parse::<f64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separator_is_found() {
        for (text, expected) in [
            ("a,b\n1,2\n", Separator::Comma),
            ("a;b\n0,1;2,5\n3,4;5,6\n", Separator::Semicolon),
            ("\"a\";\"b\"\n0,1E0;2,5E-1\n3,4E0;5,6E0\n", Separator::Semicolon),
            ("a\tb\n1\t2\n", Separator::Tab),
            ("a|b\n1|2\n", Separator::Bar),
            ("  a   b\n 1.0  2\n", Separator::Spaces),
            ("\"Time (s)\",\"x, y\"\n1,2\n", Separator::Comma),
            ("time,a,b\n2024-01-01 00:00:00,1,2\n2024-01-01 00:00:01,1,2\n", Separator::Comma),
            ("one line of words\n", Separator::Spaces),
            ("word\n1\n", Separator::Comma),
            ("", Separator::Comma),
        ] {
            assert_eq!(separator_of(text), expected, "{text:?}");
        }
    }

    #[test]
    fn text_keeps_its_lines() {
        let of = |text| plain(text, &CsvOptions::default()).text.into_owned();
        assert_eq!(of("sep=;\r\na;b\r\n% note\r\n1;2"), "\r\na;b\r\n\r\n1;2");
        assert_eq!(of("a  b\n 1\t 2\n"), "a\tb\n1\t2\n");
        assert_eq!(of("a,b\n//,\n#1\n1,2\n"), "a,b\n\n\n1,2\n");
    }

    #[test]
    fn decimal_commas_are_found() {
        let of = |rows: &[&str]| {
            let rows: Vec<_> =
                rows.iter().map(|r| r.split(';').collect::<StringRecord>()).collect();
            has_decimal_commas(rows.iter())
        };
        assert!(of(&["0,5;1", "1;-2,5E-3"]));
        assert!(!of(&["0,5;1.5"]) && !of(&["1;2"]) && !of(&["1,234.5;1,000,000"]));
    }

    #[test]
    fn separated_thousands_are_removed() {
        for (cell, point, expected) in [
            ("1,234.5", '.', Some("1234.5")),
            ("-12,345,678", '.', Some("-12345678")),
            ("1.234,5", ',', Some("1234.5")),
            ("1'234.5", '.', Some("1234.5")),
            ("1,23", '.', None),
            ("1234,567.0", '.', None),
            ("1.5", '.', None),
            ("12", '.', None),
            (",123", '.', None),
            ("1,234,5", '.', None),
        ] {
            assert_eq!(without_thousands(cell, point).as_deref(), expected, "{cell}");
        }
    }

    #[test]
    fn separator_has_a_name_and_a_character() {
        assert_eq!(Separator::find(";"), Some(Separator::Semicolon));
        assert_eq!(Separator::find("\t"), Some(Separator::Tab));
        assert_eq!(Separator::find(" "), Some(Separator::Spaces));
        assert_eq!(Separator::find("tab"), Some(Separator::Tab));
        assert_eq!(Separator::find("x"), None);
    }
}
