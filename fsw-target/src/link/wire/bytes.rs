//! Bounded byte writer and reader, without panics: an overflow is kept as a state of the writer, and
//! a short input is an error of the reader.

use core::fmt;

/// Reason for bytes that cannot be read as a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// Fewer bytes than the record.
    TooShort,
    /// Bytes unread after the last field.
    TooLong(usize),
    /// No value of this type has this code.
    UnknownCode {
        /// Type of the field.
        of: &'static str,
        /// Code read.
        code: u8,
    },
}

impl fmt::Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort => f.write_str("ends before its last field"),
            Self::TooLong(bytes) => write!(f, "has {bytes} bytes after its last field"),
            Self::UnknownCode { of, code } => write!(f, "has the unknown code {code} of {of}"),
        }
    }
}

impl core::error::Error for Unreadable {}

/// Writer into a buffer.
#[derive(Debug)]
pub struct Writer<'a> {
    free: &'a mut [u8],
    written: usize,
    overflowed: bool,
}

impl<'a> Writer<'a> {
    /// A writer at the start of the buffer.
    pub fn new(buffer: &'a mut [u8]) -> Self {
        Self { free: buffer, written: 0, overflowed: false }
    }

    /// Appends all of the bytes, or none if they do not fit.
    pub fn put(&mut self, bytes: &[u8]) {
        match core::mem::take(&mut self.free).split_at_mut_checked(bytes.len()) {
            Some((here, free)) => {
                for (to, from) in here.iter_mut().zip(bytes) {
                    *to = *from;
                }
                self.free = free;
                self.written += bytes.len();
            }
            None => self.overflowed = true,
        }
    }

    /// Number of bytes written; `None` after an overflow.
    pub fn finish(self) -> Option<usize> {
        if self.overflowed { None } else { Some(self.written) }
    }
}

/// Reader from the front of a buffer.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    unread: &'a [u8],
}

impl<'a> Reader<'a> {
    /// A reader at the start of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { unread: bytes }
    }

    /// The next N bytes.
    ///
    /// # Errors
    /// [`Unreadable::TooShort`].
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], Unreadable> {
        let (bytes, unread) = self.unread.split_first_chunk::<N>().ok_or(Unreadable::TooShort)?;
        self.unread = unread;
        Ok(*bytes)
    }

    /// The unread bytes.
    pub fn rest(self) -> &'a [u8] {
        self.unread
    }

    /// Ends the reading; all bytes must have been read.
    ///
    /// # Errors
    /// [`Unreadable::TooLong`].
    pub fn end(self) -> Result<(), Unreadable> {
        match self.unread.len() {
            0 => Ok(()),
            bytes => Err(Unreadable::TooLong(bytes)),
        }
    }
}
