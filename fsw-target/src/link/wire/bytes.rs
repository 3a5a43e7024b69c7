//! Bytes one after the other: a writer that is full remembers it, a reader that finds too little
//! says so.

use core::fmt;

/// Why bytes aren't what they should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// The bytes end before the last field.
    TooShort,
    /// So many bytes after the last field.
    TooLong(usize),
    /// No value of this type has this number.
    UnknownCode {
        /// The type of the field.
        of: &'static str,
        /// The number found.
        code: u8,
    },
}

impl fmt::Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort => f.write_str("ends before its last field"),
            Self::TooLong(bytes) => write!(f, "has {bytes} bytes after its last field"),
            Self::UnknownCode { of, code } => write!(f, "{code} is no code of {of}"),
        }
    }
}

impl core::error::Error for Unreadable {}

/// Fills a buffer from its start.
#[derive(Debug)]
pub struct Writer<'a> {
    room: &'a mut [u8],
    written: usize,
    overflowed: bool,
}

impl<'a> Writer<'a> {
    /// A writer that has written nothing.
    pub fn new(buffer: &'a mut [u8]) -> Self {
        Self { room: buffer, written: 0, overflowed: false }
    }

    /// Adds bytes, all or none of them.
    pub fn put(&mut self, bytes: &[u8]) {
        match core::mem::take(&mut self.room).split_at_mut_checked(bytes.len()) {
            Some((here, room)) => {
                for (to, from) in here.iter_mut().zip(bytes) {
                    *to = *from;
                }
                self.room = room;
                self.written += bytes.len();
            }
            None => self.overflowed = true,
        }
    }

    /// How many bytes were written, or `None` if they didn't fit.
    pub fn finish(self) -> Option<usize> {
        if self.overflowed { None } else { Some(self.written) }
    }
}

/// Takes bytes from the front.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    left: &'a [u8],
}

impl<'a> Reader<'a> {
    /// A reader of all of these.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes }
    }

    /// The next N bytes.
    ///
    /// # Errors
    /// [`Unreadable::TooShort`].
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], Unreadable> {
        let (bytes, left) = self.left.split_first_chunk::<N>().ok_or(Unreadable::TooShort)?;
        self.left = left;
        Ok(*bytes)
    }

    /// All that is left.
    pub fn rest(self) -> &'a [u8] {
        self.left
    }

    /// That nothing is left.
    ///
    /// # Errors
    /// [`Unreadable::TooLong`].
    pub fn end(self) -> Result<(), Unreadable> {
        match self.left.len() {
            0 => Ok(()),
            bytes => Err(Unreadable::TooLong(bytes)),
        }
    }
}
