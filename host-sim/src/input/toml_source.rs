//! A TOML file with its text, so that every complaint about it can name the line.
//!
//! The file types that are read from it are plain serde structs with `deny_unknown_fields`, all
//! of whose values are [`Spanned`](toml::Spanned). They avoid serde's tagged enums, which forget
//! where a key stood.

use std::fs;
use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::error::{InputError, Place, Problem};
use super::nearest::nearest;

/// A TOML text and the name to call it by.
pub(super) struct TomlSource {
    file: String,
    text: String,
}

impl TomlSource {
    /// Takes a text that is already in memory; `file` is what errors call it.
    pub(super) fn new(file: &str, text: &str) -> Self {
        Self { file: file.to_owned(), text: text.to_owned() }
    }

    /// Reads a file.
    pub(super) fn read(path: &Path) -> Result<Self, InputError> {
        let text = read_utf8(path)?;
        Ok(Self { file: path.display().to_string(), text })
    }

    /// Reads the text into `T`; an unknown key is an error.
    pub(super) fn parse<T: DeserializeOwned>(&self) -> Result<T, InputError> {
        toml::from_str(&self.text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let problem = self.problem(error.message(), &span);
            self.error(span, problem)
        })
    }

    /// An error about the piece of text at `span`; an empty span means the whole file.
    pub(super) fn error(&self, span: Range<usize>, problem: Problem) -> InputError {
        let line = if span == (0..0) { None } else { Some(line_of(&self.text, span.start)) };
        InputError { place: Place { file: self.file.clone(), line }, problem }
    }

    /// Sorts out the parser's message, which is all it tells.
    ///
    /// Serde words its standard complaints in one way only (`unknown field `x`, expected …`), with
    /// the names in backquotes; the tests below hold it to that. Any other message is passed on.
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

/// Reads a whole file as text. A byte-order mark is dropped.
pub(super) fn read_utf8(path: &Path) -> Result<String, InputError> {
    let file = path.display().to_string();
    let bytes = fs::read(path).map_err(|error| InputError {
        place: Place { file: file.clone(), line: None },
        problem: Problem::Unreadable(error),
    })?;
    decode_utf8(&file, &bytes).map(str::to_owned)
}

/// The text of `bytes`. A byte-order mark is dropped.
pub(super) fn decode_utf8<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, InputError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let good = bytes.get(..error.valid_up_to()).unwrap_or_default();
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count() as u64;
        InputError {
            place: Place { file: file.to_owned(), line: Some(line) },
            problem: Problem::NotUtf8,
        }
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
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

/// Serde's `expected f64` and `expected struct GyroFile` in words for people who don't write Rust.
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
    fn unknown_key_is_named_with_its_line_and_the_nearest_key() {
        let message = message("name = 'a'\n[[wheel]]\naxis = [1, 0, 0]\n[[wheel]]\naxes = [1]\n");
        assert_eq!(
            message,
            "x.toml:5: unknown key `axes` (did you mean `axis`?); known here: axis, torque"
        );
    }

    #[test]
    fn unknown_key_beside_kind_is_named_with_its_line() {
        let message =
            message("name = 'a'\n[[wheel]]\naxis = [1]\ntorque = { kind = 'constant', value = 1 }");
        assert!(message.starts_with("x.toml:4: unknown key `value` (did you mean `value_n_m`?)"));
    }

    #[test]
    fn unknown_kind_lists_the_kinds() {
        let message = message("name = 'a'\n[[wheel]]\naxis = [1]\ntorque = { kind = 'multi' }");
        assert_eq!(
            message,
            "x.toml:4: unknown word \"multi\" (did you mean `multisine`?); \
             allowed here: constant, multisine"
        );
    }

    #[test]
    fn missing_key_names_the_line_of_its_table() {
        assert_eq!(message("name = 'a'\n[[wheel]]\n"), "x.toml:2: missing key `axis`; add it here");
    }

    #[test]
    fn missing_key_of_the_whole_file_names_no_line() {
        assert_eq!(message(""), "x.toml: missing key `name`; add it here");
    }

    #[test]
    fn wrong_type_shows_the_line() {
        assert_eq!(
            message("name = 'a'\n[[wheel]]\naxis = ['x']\n"),
            "x.toml:3: wrong type of value: string \"x\", expected a number\n    \
             in the line `axis = ['x']`"
        );
    }

    #[test]
    fn table_instead_of_list_of_tables_is_a_wrong_type() {
        let message = message("name = 'a'\n[wheel]\naxis = [1]\n");
        assert!(message.starts_with("x.toml:2: wrong type of value: map, expected a list"));
    }

    #[test]
    fn broken_syntax_shows_the_line() {
        let message = message("name = 'a'\n[[wheel]\n");
        assert!(message.starts_with("x.toml:2: not valid TOML: "), "{message}");
        assert!(message.ends_with("in the line `[[wheel]`"), "{message}");
    }

    #[test]
    fn key_given_twice_is_not_valid_toml() {
        let message = message("name = 'a'\nname = 'b'\n");
        assert!(message.starts_with("x.toml:2: not valid TOML: duplicate key"), "{message}");
    }

    #[test]
    fn missing_file_is_named() {
        let message = TomlSource::read(Path::new("no/such.toml")).err().unwrap().to_string();
        assert!(message.starts_with("no/such.toml: cannot be read: "), "{message}");
    }

    #[test]
    fn bytes_that_are_not_text_are_found_by_line() {
        let message = decode_utf8("x.csv", b"a\nb\xff\n").unwrap_err().to_string();
        assert_eq!(message, "x.csv:2: not UTF-8 text; save the file as UTF-8");
    }

    #[test]
    fn byte_order_mark_is_dropped() {
        assert_eq!(decode_utf8("x", b"\xef\xbb\xbft_s").unwrap(), "t_s");
    }
}
