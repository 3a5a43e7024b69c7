//! State as a stream of words: the form in which a checkpoint keeps it.
//!
//! ```text
//!  state ── Persist::persist ──► Archive ──► Words (flash, a slice)
//!        ◄──────────────────────         ◄──
//! ```
//!
//! One method serves both directions, so that writer and reader cannot disagree: [`Persist::persist`]
//! hands each word of the state to an [`Archive`], which writes it to the [`Words`] or replaces it by
//! the word read from there. The transfer works in place. A second copy of a window of 38 KiB would
//! not fit into the memory of a microcontroller, nor onto its stack.
//!
//! * **State** is all that a step changes, and the prior, which a telecommand may change.
//! * **Configuration** is written with the state and compared when the state is read: a covariance
//!   found with other wheels is meaningless.
//! * **Validation** on reading: an unknown tag, a number that is not finite, an index beyond its array
//!   and a failed condition of a type are rejected with the place. The state is then partly
//!   overwritten, and the caller must construct it again.
//!
//! The first rejection is stored; later calls have no effect. `persist` returns no result, which
//! saves a branch per field.
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
///
/// Implemented by [`persist!`](crate::persist!) for nearly all types. By hand where a part of the
/// state is left out of the stream, for instance unused places of a buffer:
///
/// ```
/// use fsw_core::persist::{Archive, Persist, mix, name};
///
/// /// Up to eight values, of which `len` are in use.
/// struct Buffer {
///     len: usize,
///     values: [f32; 8],
/// }
///
/// impl Persist for Buffer {
///     fn layout() -> u32 {
///         mix(name("Buffer"), <[f32; 8]>::layout())
///     }
///
///     fn persist(&mut self, archive: &mut Archive<'_>) {
///         self.len.persist(archive);
///         let Some(used) = self.values.get_mut(..self.len) else {
///             self.len = 0;
///             return archive.refuse("Buffer");
///         };
///         used.iter_mut().for_each(|value| value.persist(archive));
///     }
/// }
/// ```
pub trait Persist {
    /// Hash of the type's layout in the stream: names and types of its fields, in their order.
    fn layout() -> u32
    where
        Self: Sized;

    /// Transfers the whole state through an archive, in the archive's direction.
    fn persist(&mut self, archive: &mut Archive<'_>);
}

/// A value to be overwritten: the place into which an optional part or a variant is read.
///
/// Zero for numbers, `None` for an option, the first variant of an enum.
pub trait Blank {
    /// A value without meaning.
    fn blank() -> Self;
}

/// Medium of the words: memory that is written to, or read from.
///
/// The two directions are two implementations. A third one may count the words of a state:
///
/// ```
/// use fsw_core::checkpoint::{Words, transfer};
///
/// struct Count(u32);
///
/// impl Words for Count {
///     fn transfer(&mut self, _: &mut u32) -> bool {
///         self.0 += 1;
///         true
///     }
/// }
/// let mut count = Count(0);
/// transfer(&mut [1.0f64, 2.0], &mut count).unwrap();
/// assert_eq!(count.0, 4);
/// ```
pub trait Words {
    /// Writes `word`, or replaces it by the word read at this place. False at the end of the medium.
    fn transfer(&mut self, word: &mut u32) -> bool;
}

/// Rejection of a word, with its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InvalidWord {
    /// Name of the type that rejected its value; `configuration` where a configured value differs;
    /// `end` where the medium holds fewer words than the state.
    pub place: &'static str,
}

/// Connects a state with its words.
///
/// | situation | effect of [`word`](Self::word) |
/// |---|---|
/// | state, medium is written to | the word is stored |
/// | state, medium is read from | the word is replaced by the stored one |
/// | configuration | the word is compared with the stored one, or stored |
/// | after a rejection | none |
pub struct Archive<'a> {
    words: &'a mut dyn Words,
    is_configuration: bool,
    refused: Option<InvalidWord>,
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
        self.refused.get_or_insert(InvalidWord { place });
    }

    /// Declares the following words as configuration or as state. Returns the previous setting.
    pub fn set_configuration(&mut self, is_configuration: bool) -> bool {
        core::mem::replace(&mut self.is_configuration, is_configuration)
    }

    /// Result of the transfer.
    ///
    /// # Errors
    /// The first rejection.
    pub fn finish(self) -> Result<(), InvalidWord> {
        self.refused.map_or(Ok(()), Err)
    }
}

/// 32-bit FNV-1a hash of a name: offset basis 0x811c9dc5, prime 0x01000193.
pub const fn name(text: &str) -> u32 {
    let bytes = text.as_bytes();
    let (mut hash, mut i) = (0x811c_9dc5_u32, 0);
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u32).wrapping_mul(0x0100_0193);
        i += 1;
    }
    hash
}

/// Hash of two hashes, in this order: `(rotl(a, 5) xor b) · 0x9e3779b1`, modulo 2³².
pub const fn mix(a: u32, b: u32) -> u32 {
    (a.rotate_left(5) ^ b).wrapping_mul(0x9e37_79b1)
}

/// Replaces a value by a new one. Not inlined: the new one takes a copy on the stack, and its parts are
/// transferred afterwards.
#[doc(hidden)]
#[inline(never)]
pub fn replace<P>(place: &mut P, new: impl FnOnce() -> P) {
    *place = new();
}

/// Layout of the type that a field accessor returns: for [`persist!`](crate::persist!).
#[doc(hidden)]
pub fn layout_of<S, P: Persist>(_: fn(&S) -> &P) -> u32 {
    P::layout()
}
