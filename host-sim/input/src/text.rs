//! Files as UTF-8 text.

use std::fs;
use std::path::Path;

use crate::error::{InputError, Place, Problem};

/// The text of a file, without a byte-order mark.
///
/// # Errors
/// The file cannot be read, or is not UTF-8.
pub fn read_utf8(path: &Path) -> Result<String, InputError> {
    let file = path.display().to_string();
    let bytes = fs::read(path).map_err(|error| InputError {
        place: Place { file: file.clone(), line: None },
        problem: Problem::Unreadable(error),
    })?;
    decode_utf8(&file, &bytes).map(str::to_owned)
}

/// The text of `bytes`, without a byte-order mark. `file` is the name in errors.
///
/// # Errors
/// The bytes are not UTF-8.
pub fn decode_utf8<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, InputError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_outside_utf8_are_reported_with_their_line() {
        let message = decode_utf8("x.csv", b"a\nb\xff\n").unwrap_err().to_string();
        assert_eq!(message, "x.csv:2: not UTF-8 text; save the file as UTF-8");
    }

    #[test]
    fn byte_order_mark_is_dropped() {
        assert_eq!(decode_utf8("x", b"\xef\xbb\xbft_s").unwrap(), "t_s");
    }
}
