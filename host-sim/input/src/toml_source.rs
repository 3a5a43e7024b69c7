//! A TOML file with its text: the source of the line numbers in errors.
//!
//! Files are read into plain serde structs with `deny_unknown_fields` and
//! [`Spanned`](toml::Spanned) values. Serde's tagged enums are avoided: they lose the spans.

use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{InputError, Place, Problem};
use crate::nearest::nearest;
use crate::text::read_utf8;

/// A TOML text and its name in errors.
pub struct TomlSource {
    file: String,
    text: String,
}

impl TomlSource {
    /// A text in memory; `file` is the name in errors.
    pub fn new(file: &str, text: &str) -> Self {
        Self { file: file.to_owned(), text: text.to_owned() }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = read_utf8(path)?;
        Ok(Self { file: path.display().to_string(), text })
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
    use toml::Spanned;

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
