//! Files as UTF-8 text.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::error::{InputError, Place, Problem};

/// Most bytes of a file, after decompression: 1 GiB, ten times a log of 10⁷ samples of 100 bytes in gzip. Text and table
/// of a file are in memory.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

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
/// The file cannot be read, or has more than [`MAX_FILE_BYTES`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    let file = path.display().to_string();
    match File::open(path) {
        Ok(source) => read_all(&file, source),
        Err(error) => Err(at_file(&file, Problem::Unreadable(error))),
    }
}

/// The bytes of any source; `file` is the name in errors.
///
/// # Errors
/// The source cannot be read, or has more than [`MAX_FILE_BYTES`].
pub fn read_all(file: &str, source: impl Read) -> Result<Vec<u8>, InputError> {
    let mut bytes = Vec::new();
    match read_up_to(source, &mut bytes) {
        Err(error) => Err(at_file(file, Problem::Unreadable(error))),
        Ok(()) => checked_size(file, bytes),
    }
}

/// Reads a source as far as a check of its size needs. After an error `bytes` has what there is.
///
/// # Errors
/// The source cannot be read.
pub fn read_up_to(source: impl Read, bytes: &mut Vec<u8>) -> io::Result<()> {
    source.take(MAX_FILE_BYTES + 1).read_to_end(bytes).map(|_| ())
}

/// These bytes.
///
/// # Errors
/// More than [`MAX_FILE_BYTES`].
pub fn checked_size(file: &str, bytes: Vec<u8>) -> Result<Vec<u8>, InputError> {
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(at_file(file, Problem::TooLarge { limit: MAX_FILE_BYTES }));
    }
    Ok(bytes)
}

fn at_file(file: &str, problem: Problem) -> InputError {
    InputError { place: Place { file: file.to_owned(), line: None }, problem }
}

/// The text of `bytes`, without a byte-order mark: UTF-8 with `\u{fffd}` for bytes that are not, UTF-16
/// after its byte-order mark, or Latin-1 where a byte of the first line is not UTF-8, as `°/s` of an
/// older spreadsheet. `file` is the name in errors.
///
/// # Errors
/// The first line has control characters: the file is not text.
pub fn decode_lossy<'a>(file: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>, InputError> {
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes).into(),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes).into(),
        _ => decode_bytes(bytes),
    };
    let first = text.lines().next().unwrap_or_default();
    let is_binary = |c: char| c.is_control() && c != '\t';
    if first.trim_end_matches('\0').contains(is_binary) {
        let place = Place { file: file.to_owned(), line: Some(1) };
        return Err(InputError { place, problem: Problem::NotText });
    }
    Ok(text)
}

fn decode_bytes(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    match std::str::from_utf8(first) {
        Ok(_) => String::from_utf8_lossy(bytes),
        Err(_) => bytes.iter().copied().map(char::from).collect::<String>().into(),
    }
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
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
        assert_eq!(decode_lossy("x", b"# 5\xb0\nt_s\n").unwrap(), "# 5°\nt_s\n");
    }

    #[test]
    fn other_encodings_are_read() {
        assert_eq!(decode_lossy("x", b"\xff\xfet\0_\0s\0\n\0").unwrap(), "t_s\n");
        assert_eq!(decode_lossy("x", b"\xfe\xff\0t\0\n").unwrap(), "t\n");
        assert_eq!(decode_lossy("x", b"a (\xb0/s)\n1\n").unwrap(), "a (°/s)\n1\n");
        let message = decode_lossy("x.bin", b"\x7fELF\x02\x01\0").unwrap_err().to_string();
        assert!(message.starts_with("x.bin:1: not text; "), "{message}");
    }

    #[test]
    fn byte_order_mark_is_dropped() {
        assert_eq!(decode_utf8("x", b"\xef\xbb\xbft_s").unwrap(), "t_s");
    }
}
