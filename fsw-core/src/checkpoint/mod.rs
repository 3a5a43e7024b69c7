//! 5. An estimator's state to and from non-volatile memory, bit for bit.
//!
//! ```text
//!  estimator ◄─► persist(): one method for both ways ◄─► Archive ◄─► Words: flash, or a slice
//! ```
//!
//! [`Persist::persist`] hands its fields one after the other to an [`Archive`], which either notes each
//! word or replaces it by the one that was noted before. So writer and reader can't disagree. It works
//! in place: there is never a second copy of the state, since a window of 16 KiB has none on a
//! microcontroller, and its stack has less than that.
//!
//! What is kept is state: all that a step changes, a prior included, which a command may change. What
//! is configured stays as it is, but is noted with the rest, and must be the same when the state comes
//! back: a covariance that was found with other wheels is worth nothing.
//!
//! Nothing that comes back is believed blindly. A tag that stands for nothing, a number that isn't
//! finite, an index beyond its array are refused, with the place. Then the state is half old and half
//! new: whoever called must start it afresh. [`fingerprint`] tells builds apart whose state is laid out
//! otherwise.
//!
//! An archive remembers what it refused, and passes nothing more by. So no field's passing can fail, and
//! in an image a state is little more than a list of calls.
//!
//! Written here because serde, with postcard or another format, builds each value before it is moved to
//! its place, on the stack; has no arrays of more than 32 elements or of generic length; and knows
//! neither which numbers are finite nor what is configured.

mod persist;
#[cfg(test)]
mod tests;
mod values;

/// State that can be kept.
pub trait Persist {
    /// Tells this type's layout in the stream from another.
    fn layout() -> u32
    where
        Self: Sized;

    /// Passes all of the state by an archive, in both directions.
    fn persist(&mut self, archive: &mut Archive<'_>);
}

/// Words that state goes into, or comes out of.
pub trait Words {
    /// Notes one word, or replaces it by the one that was noted at this place. False at the end.
    fn pass(&mut self, word: &mut u32) -> bool;
}

/// What is kept or brought back has a value that can't be: where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Invalid {
    /// The type that refused it; `configuration`, where that is another one; or `end`, where there
    /// are fewer words than the state has.
    pub place: &'static str,
}

/// Between a state and its words.
pub struct Archive<'a> {
    words: &'a mut dyn Words,
    is_configuration: bool,
    refused: Option<Invalid>,
}

impl Archive<'_> {
    /// Passes one word by: it is noted, or replaced by the one that was noted at this place. What is
    /// configured is compared instead.
    #[inline(never)]
    pub fn word(&mut self, word: &mut u32) {
        if self.refused.is_some() {
            return;
        }
        let mut noted = *word;
        if !self.words.pass(&mut noted) {
            self.refuse("end");
        } else if !self.is_configuration {
            *word = noted;
        } else if noted != *word {
            self.refuse("configuration");
        }
    }

    /// Refuses what has passed by last: from now on nothing does.
    #[inline(never)]
    pub fn refuse(&mut self, place: &'static str) {
        self.refused.get_or_insert(Invalid { place });
    }

    /// Whether what passes by from now on is configuration. Returns whether it was.
    pub fn set_configuration(&mut self, is_configuration: bool) -> bool {
        core::mem::replace(&mut self.is_configuration, is_configuration)
    }
}

/// Notes a state, or brings it back.
///
/// # Errors
/// What was refused, and where. The state is then partly that of the words.
pub fn pass<P: Persist>(state: &mut P, words: &mut dyn Words) -> Result<(), Invalid> {
    let mut archive = Archive { words, is_configuration: false, refused: None };
    state.persist(&mut archive);
    archive.refused.map_or(Ok(()), Err)
}

/// What stands where a value is about to be brought back to.
pub trait Blank {
    /// A value without meaning.
    fn blank() -> Self;
}

/// To be changed where the meaning of what is kept changes and its layout doesn't.
const MEANING: u32 = 1;

/// Tells checkpoints of one layout of the state `P`, and of one version of this crate, from others.
///
/// Not those of one build from another's. A new image goes on from what the one before it has found,
/// which may have taken days, and must not lose it for a comment that was changed. The layout has the name
/// and type of every field in its order; configuration is compared, and values are checked, as they come
/// back. What none of these can see is a number that means something else than before under the same name:
/// whoever makes it so changes `MEANING`, or the version.
pub fn fingerprint<P: Persist>() -> u32 {
    const VERSION: u32 = mix(name(env!("CARGO_PKG_VERSION")), MEANING);
    mix(VERSION, P::layout())
}

/// FNV-1a, 32 bits, of a name.
pub const fn name(text: &str) -> u32 {
    let bytes = text.as_bytes();
    let (mut hash, mut i) = (0x811c_9dc5_u32, 0);
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u32).wrapping_mul(0x0100_0193);
        i += 1;
    }
    hash
}

/// One number of two, in this order.
pub const fn mix(a: u32, b: u32) -> u32 {
    (a.rotate_left(5) ^ b).wrapping_mul(0x9e37_79b1)
}

/// The layout of what a field accessor leads to: for [`persist!`](crate::persist).
#[doc(hidden)]
pub fn layout_of<S, P: Persist>(_: fn(&S) -> &P) -> u32 {
    P::layout()
}

/// Notes words in memory.
#[derive(Debug)]
pub struct ToWords<'a> {
    words: &'a mut [u32],
    noted: usize,
}

/// Brings words back from memory.
#[derive(Debug)]
pub struct FromWords<'a> {
    words: &'a [u32],
}

impl<'a> ToWords<'a> {
    /// Notes from the first on.
    pub fn new(words: &'a mut [u32]) -> Self {
        Self { words, noted: 0 }
    }

    /// How many have been noted.
    pub fn noted(&self) -> usize {
        self.noted
    }
}

impl<'a> FromWords<'a> {
    /// Brings back from the first on.
    pub fn new(words: &'a [u32]) -> Self {
        Self { words }
    }

    /// How many are left.
    pub fn left(&self) -> usize {
        self.words.len()
    }
}

impl Words for ToWords<'_> {
    fn pass(&mut self, word: &mut u32) -> bool {
        let Some(place) = self.words.get_mut(self.noted) else { return false };
        *place = *word;
        self.noted += 1;
        true
    }
}

impl Words for FromWords<'_> {
    fn pass(&mut self, word: &mut u32) -> bool {
        let Some((first, rest)) = self.words.split_first() else { return false };
        *word = *first;
        self.words = rest;
        true
    }
}
