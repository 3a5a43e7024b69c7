//! State as a stream of words: the form in which a checkpoint keeps it.
//!
//! ```text
//!  state ── Persist::persist ──► Archive ──► Words (flash, a slice)
//!        ◄──────────────────────         ◄──
//! ```
//!
//! One method serves both directions, so that writer and reader cannot disagree: [`Persist::persist`]
//! hands each word of the state to an [`Archive`], which writes it to the [`Words`] or replaces it by
//! the word read from there. The transfer works in place. A second copy of a window of 16 KiB would
//! not fit into the memory of a microcontroller, nor onto its stack.
//!
//! * **State** is all that a step changes, and the prior, which a telecommand may change.
//! * **Configuration** is written with the state and compared when the state is read: a covariance
//!   found with other wheels is meaningless.
//! * **Validation** on reading: an unknown tag, a number that is not finite, an index beyond its array
//!   and a failed condition of a type are rejected with the place. The state is then partly
//!   overwritten, and the caller must start it afresh.
//!
//! An archive remembers the first rejection and transfers nothing after it. No call returns an error,
//! so that in an image a state is a list of calls.
//!
//! [`persist!`](crate::persist!) implements [`Persist`] for a struct or an enum. Types of
//! [`math`](crate::math), which does not depend on this module, are implemented in `algebra`.
//!
//! Reasons against serde with postcard or another format: it builds each value on the stack before it
//! is moved to its place, has no arrays of more than 32 elements or of generic length, and separates
//! neither finite numbers nor configuration.

mod algebra;
mod macros;
mod values;

/// State that can be transferred to and from a stream of words.
pub trait Persist {
    /// Hash of the type's layout in the stream: names and types of its fields, in their order.
    fn layout() -> u32
    where
        Self: Sized;

    /// Transfers the whole state through an archive, in the archive's direction.
    fn persist(&mut self, archive: &mut Archive<'_>);
}

/// A value to be overwritten: the place into which an optional part or a variant is read.
pub trait Blank {
    /// A value without meaning.
    fn blank() -> Self;
}

/// Medium of the words: memory that is written to, or read from.
pub trait Words {
    /// Writes `word`, or replaces it by the word read at this place. False at the end of the medium.
    fn transfer(&mut self, word: &mut u32) -> bool;
}

/// Rejection of a word, with its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Invalid {
    /// Name of the type that rejected its value; `configuration` where a configured value differs;
    /// `end` where the medium holds fewer words than the state.
    pub place: &'static str,
}

/// Connects a state with its words.
pub struct Archive<'a> {
    words: &'a mut dyn Words,
    is_configuration: bool,
    refused: Option<Invalid>,
}

impl<'a> Archive<'a> {
    /// An archive at the first word of a medium.
    pub fn new(words: &'a mut dyn Words) -> Self {
        Self { words, is_configuration: false, refused: None }
    }

    /// Transfers one word of state. A word of configuration is compared instead.
    #[inline(never)]
    pub fn word(&mut self, word: &mut u32) {
        if self.refused.is_some() {
            return;
        }
        let mut stored = *word;
        if !self.words.transfer(&mut stored) {
            self.refuse("end");
        } else if !self.is_configuration {
            *word = stored;
        } else if stored != *word {
            self.refuse("configuration");
        }
    }

    /// Rejects the last word. The first rejection counts, and ends the transfer.
    #[inline(never)]
    pub fn refuse(&mut self, place: &'static str) {
        self.refused.get_or_insert(Invalid { place });
    }

    /// Declares the following words as configuration or as state. Returns the previous setting.
    pub fn set_configuration(&mut self, is_configuration: bool) -> bool {
        core::mem::replace(&mut self.is_configuration, is_configuration)
    }

    /// Result of the transfer.
    ///
    /// # Errors
    /// The first rejection.
    pub fn finish(self) -> Result<(), Invalid> {
        self.refused.map_or(Ok(()), Err)
    }
}

/// 32-bit FNV-1a hash of a name.
pub const fn name(text: &str) -> u32 {
    let bytes = text.as_bytes();
    let (mut hash, mut i) = (0x811c_9dc5_u32, 0);
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u32).wrapping_mul(0x0100_0193);
        i += 1;
    }
    hash
}

/// Hash of two hashes, in this order.
pub const fn mix(a: u32, b: u32) -> u32 {
    (a.rotate_left(5) ^ b).wrapping_mul(0x9e37_79b1)
}

/// Layout of the type that a field accessor returns: for [`persist!`](crate::persist!).
#[doc(hidden)]
pub fn layout_of<S, P: Persist>(_: fn(&S) -> &P) -> u32 {
    P::layout()
}
