//! A TOML file with its text: the source of the line numbers in errors.
//!
//! Files are read into plain serde structs with `deny_unknown_fields` and
//! [`Spanned`] values. Serde's tagged enums are avoided: they lose the spans.

use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{InputError, Place, Problem};
use crate::key::{Key, Table};
use crate::nearest::nearest;
use crate::text::read_utf8;

/// A TOML text and its name in errors.
pub struct TomlSource {
    file: String,
    text: String,
    /// Errors of values outside their ranges, in the order of reading.
    faults: RefCell<Vec<InputError>>,
}

impl TomlSource {
    /// A text in memory; `file` is the name in errors.
    pub fn new(file: &str, text: &str) -> Self {
        Self { file: file.to_owned(), text: text.to_owned(), faults: RefCell::default() }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = read_utf8(path)?;
        Ok(Self { file: path.display().to_string(), text, faults: RefCell::default() })
    }

    /// The text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The values of the file.
    ///
    /// # Errors
    /// Invalid TOML, an unknown or missing key, or a value of the wrong type.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, InputError> {
        toml::from_str(&self.text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let problem = self.problem(error.message(), &span);
            self.error(span, problem)
        })
    }

    /// Keys that the tables of the file do not have, and required keys that they lack: all of them in one
    /// error. Tables without a row in `known` are not checked, nor are the required keys of the root.
    ///
    /// # Errors
    /// Any such key. A file that is not TOML passes: [`Self::parse`] names its fault.
    pub fn check_keys(&self, known: &[Table]) -> Result<(), InputError> {
        let Ok(root) = DeTable::parse(&self.text) else { return Ok(()) };
        let mut faults = Vec::new();
        self.check_table("", &root, known, &mut faults);
        InputError::of_several(faults).map_or(Ok(()), Err)
    }

    fn check_table(
        &self,
        path: &str,
        table: &Spanned<DeTable<'_>>,
        known: &[Table],
        faults: &mut Vec<InputError>,
    ) {
        let row = known.iter().find(|row| row.header.trim_matches(['[', ']']) == path);
        let Some(row) = row else { return };
        let names = row.names();
        let mut misspelled = Vec::new();
        for (key, value) in table.get_ref() {
            let name = key.get_ref().as_ref();
            if !names.contains(&name) {
                let known = names.iter().map(|name| (*name).to_owned()).collect();
                let nearest = nearest(name, &names).map(str::to_owned);
                misspelled.extend(nearest.clone());
                let problem = Problem::UnknownKey { key: name.to_owned(), nearest, known };
                faults.push(self.error(key.span(), problem));
                continue;
            }
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            let tables: Vec<Spanned<DeTable<'_>>> = match value.get_ref() {
                DeValue::Table(inner) => vec![Spanned::new(value.span(), inner.clone())],
                DeValue::Array(list) => (list.iter())
                    .filter_map(|entry| match entry.get_ref() {
                        DeValue::Table(inner) => Some(Spanned::new(entry.span(), inner.clone())),
                        _ => None,
                    })
                    .collect(),
                _ => Vec::new(),
            };
            tables.iter().for_each(|table| self.check_table(&path, table, known, faults));
        }
        // A key that is there under a wrong name is reported once.
        let is_missing = |key: &&Key| {
            key.default.is_none()
                && !table.get_ref().contains_key(key.name)
                && !misspelled.iter().any(|name| name == key.name)
        };
        if !path.is_empty() {
            for key in row.keys.iter().filter(is_missing) {
                let problem = Problem::MissingKey { key: key.name.to_owned() };
                faults.push(self.error(table.span(), problem));
            }
        }
    }

    /// Keeps the fault of a value, so that the reading of the file goes on.
    pub(crate) fn keep(&self, fault: InputError) {
        self.faults.borrow_mut().push(fault);
    }

    /// The result of reading the file, or all faults of its values in one error. A failure after such
    /// faults may be their consequence and is left out.
    ///
    /// # Errors
    /// As of `read`, or the faults.
    pub fn read_all<T>(
        &self,
        read: impl FnOnce() -> Result<T, InputError>,
    ) -> Result<T, InputError> {
        let result = read();
        InputError::of_several(self.faults.take()).map_or(result, Err)
    }

    /// Returns all faults found until now in one error, if there are any.
    pub(crate) fn checked(&self) -> Result<(), InputError> {
        InputError::of_several(self.faults.take()).map_or(Ok(()), Err)
    }

    /// An error at `span` of the text; an empty span stands for the whole file.
    pub fn error(&self, span: Range<usize>, problem: Problem) -> InputError {
        let line = if span == (0..0) { None } else { Some(line_of(&self.text, span.start)) };
        InputError { place: Place { file: self.file.clone(), line }, problem }
    }

    /// The parser's message, sorted by kind.
    ///
    /// The message is the only information of the parser. Serde words its standard errors in one
    /// way (`unknown field `x`, expected …`), names in backquotes; the tests below depend on it. Any
    /// other message is passed on.
    fn problem(&self, message: &str, span: &Range<usize>) -> Problem {
        let names = backquoted(message);
        let first = || names.first().cloned().unwrap_or_default();
        let others = || names.iter().skip(1).cloned().collect::<Vec<_>>();

        if message.starts_with("unknown field") {
            let (key, known) = (first(), others());
            Problem::UnknownKey { nearest: nearest(&key, &known).map(str::to_owned), key, known }
        } else if message.starts_with("unknown variant") {
            let (word, allowed) = (first(), others());
            let nearest = nearest(&word, &allowed).map(str::to_owned);
            Problem::UnknownWord { nearest, word, allowed }
        } else if message.starts_with("missing field") {
            Problem::MissingKey { key: first() }
        } else if message.starts_with("invalid")
            && toml::from_str::<toml::Table>(&self.text).is_ok()
        {
            Problem::WrongType {
                message: plain_words(message),
                source_line: source_line(&self.text, span.start),
            }
        } else {
            Problem::TomlSyntax {
                message: message.trim().replace('\n', "; "),
                source_line: source_line(&self.text, span.start),
            }
        }
    }
}

fn line_of(text: &str, byte: usize) -> u64 {
    1 + text.bytes().take(byte).filter(|byte| *byte == b'\n').count() as u64
}

fn source_line(text: &str, byte: usize) -> String {
    let index = line_of(text, byte) as usize - 1;
    text.lines().nth(index).unwrap_or_default().trim().to_owned()
}

/// The pieces of `message` between backquotes.
fn backquoted(message: &str) -> Vec<String> {
    message.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Serde's `expected f64` and `expected struct GyroFile` in terms of TOML.
fn plain_words(message: &str) -> String {
    let (found, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let found = found.trim_start_matches("invalid type: ").trim_start_matches("invalid value: ");
    match expected {
        "" => found.to_owned(),
        "f64" => format!("{found}, expected a number"),
        "a boolean" => format!("{found}, expected true or false"),
        "a sequence" => format!("{found}, expected a list"),
        _ if expected.starts_with("struct ") => format!("{found}, expected a table"),
        _ => format!("{found}, expected {expected}"),
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Example {
        name: String,
        #[serde(default)]
        wheel: Vec<ExampleWheel>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct ExampleWheel {
        axis: Spanned<Vec<f64>>,
        torque: Option<ExampleTorque>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct ExampleTorque {
        kind: ExampleKind,
        value_n_m: Option<f64>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum ExampleKind {
        Constant,
        Multisine,
    }

    fn message(text: &str) -> String {
        TomlSource::new("x.toml", text).parse::<Example>().unwrap_err().to_string()
    }

    #[test]
    fn unknown_key_is_reported_with_line_and_nearest_key() {
        let message = message("name = 'a'\n[[wheel]]\naxis = [1, 0, 0]\n[[wheel]]\naxes = [1]\n");
        assert_eq!(
            message,
            "x.toml:5: unknown key `axes` (did you mean `axis`?); known keys here: axis, torque"
        );
    }

    #[test]
    fn unknown_key_beside_kind_is_reported_with_line() {
        let message =
            message("name = 'a'\n[[wheel]]\naxis = [1]\ntorque = { kind = 'constant', value = 1 }");
        assert!(message.starts_with("x.toml:4: unknown key `value` (did you mean `value_n_m`?)"));
    }

    #[test]
    fn unknown_kind_is_reported_with_all_kinds() {
        let message = message("name = 'a'\n[[wheel]]\naxis = [1]\ntorque = { kind = 'multi' }");
        assert_eq!(
            message,
            "x.toml:4: unknown word \"multi\" (did you mean `multisine`?); \
             allowed here: constant, multisine"
        );
    }

    #[test]
    fn missing_key_is_reported_at_its_table() {
        assert_eq!(
            message("name = 'a'\n[[wheel]]\n"),
            "x.toml:2: missing key `axis`; add it to this table"
        );
    }

    #[test]
    fn missing_root_key_is_reported_without_line() {
        assert_eq!(message(""), "x.toml: missing key `name`; add it to this table");
    }

    #[test]
    fn wrong_type_is_reported_with_the_line() {
        assert_eq!(
            message("name = 'a'\n[[wheel]]\naxis = ['x']\n"),
            "x.toml:3: wrong type of value: string \"x\", expected a number; correct the line\n    \
             axis = ['x']"
        );
    }

    #[test]
    fn single_table_in_place_of_a_list_is_a_wrong_type() {
        let message = message("name = 'a'\n[wheel]\naxis = [1]\n");
        assert!(message.starts_with("x.toml:2: wrong type of value: map, expected a list"));
    }

    #[test]
    fn syntax_error_is_reported_with_the_line() {
        let message = message("name = 'a'\n[[wheel]\n");
        assert!(message.starts_with("x.toml:2: not valid TOML: "), "{message}");
        assert!(message.ends_with("correct the line\n    [[wheel]"), "{message}");
    }

    #[test]
    fn duplicate_key_is_invalid_toml() {
        let message = message("name = 'a'\nname = 'b'\n");
        assert!(message.starts_with("x.toml:2: not valid TOML: duplicate key"), "{message}");
    }

    #[test]
    fn missing_file_is_reported_by_name() {
        let message = TomlSource::read(Path::new("no/such.toml")).err().unwrap().to_string();
        assert!(message.starts_with("no/such.toml: cannot be read: "), "{message}");
    }
}
