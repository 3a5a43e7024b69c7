//! Files as UTF-8 text.

use std::borrow::Cow;
use std::fs;
use std::path::Path;

use crate::error::{InputError, Place, Problem};

/// The text of a file, without a byte-order mark.
///
/// # Errors
/// The file cannot be read, or is not UTF-8.
pub fn read_utf8(path: &Path) -> Result<String, InputError> {
    decode_utf8(&path.display().to_string(), &read_bytes(path)?).map(str::to_owned)
}

/// The bytes of a file.
///
/// # Errors
/// The file cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    fs::read(path).map_err(|error| InputError {
        place: Place { file: path.display().to_string(), line: None },
        problem: Problem::Unreadable(error),
    })
}

/// The text of `bytes`, without a byte-order mark, with `\u{fffd}` for bytes that are not UTF-8.
/// `file` is the name in errors.
///
/// # Errors
/// The first line is neither UTF-8 nor a comment: the file has another encoding.
pub fn decode_lossy<'a>(file: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>, InputError> {
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    if !first.starts_with(b"#") {
        decode_utf8(file, first)?;
    }
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    Ok(String::from_utf8_lossy(bytes))
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
    fn damaged_bytes_are_replaced_below_the_first_line() {
        assert_eq!(decode_lossy("x", b"\xef\xbb\xbft_s\n\xff\n").unwrap(), "t_s\n\u{fffd}\n");
        assert!(decode_lossy("x", b"# 5\xb0\nt_s\n").is_ok());
        assert!(decode_lossy("x", b"\xff\xfet\0_\0s\0\n").is_err());
    }

    #[test]
    fn byte_order_mark_is_dropped() {
        assert_eq!(decode_utf8("x", b"\xef\xbb\xbft_s").unwrap(), "t_s");
    }
}
