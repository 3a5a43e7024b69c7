//! 5. An estimator's state to and from non-volatile memory, bit for bit.
//!
//! ```text
//!  estimator ◄──► persist(): one method for both ways ◄──► Archive: a stream of 32-bit words
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
//! Written here because serde, with postcard or another format, builds each value before it is moved to
//! its place, on the stack; has no arrays of more than 32 elements or of generic length; and knows
//! neither which numbers are finite nor what is configured.

mod persist;
#[cfg(test)]
mod tests;
mod values;

/// What is kept or brought back has a value that can't be: where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Invalid {
    /// The type that refused it.
    pub place: &'static str,
}

/// A stream of words that state goes into, or comes out of.
pub trait Archive {
    /// Why the stream ends.
    type Error: From<Invalid>;

    /// Passes one word by: it is noted, or replaced by the one that was noted at this place.
    fn word(&mut self, word: &mut u32) -> Result<(), Self::Error>;
}

/// State that can be kept.
pub trait Persist {
    /// Tells this type's layout in the stream from another.
    fn layout() -> u32;

    /// Passes all of the state by an archive, in both directions.
    ///
    /// # Errors
    /// The archive's, and [`Invalid`]. The state is then partly that of the archive.
    fn persist<A: Archive>(&mut self, archive: &mut A) -> Result<(), A::Error>;
}

/// What stands where a value is about to be brought back to.
pub trait Blank {
    /// A value without meaning.
    fn blank() -> Self;
}

/// To be changed where the meaning of what is kept changes and its layout doesn't.
const MEANING: u32 = 1;

/// Tells checkpoints of one layout of the state `P`, and of one version of this crate, from others.
pub fn fingerprint<P: Persist>() -> u32 {
    const VERSION: u32 = mix(name(env!("CARGO_PKG_VERSION")), MEANING);
    mix(VERSION, P::layout())
}

/// How many words the state takes.
///
/// # Errors
/// Where it has a value that can't be kept.
pub fn words<P: Persist>(state: &mut P) -> Result<u32, Invalid> {
    struct Count(u32);
    impl Archive for Count {
        type Error = Invalid;
        fn word(&mut self, _: &mut u32) -> Result<(), Invalid> {
            self.0 = self.0.saturating_add(1);
            Ok(())
        }
    }
    let mut count = Count(0);
    state.persist(&mut count)?;
    Ok(count.0)
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

/// Passes configuration by: it is noted, and compared when it comes back, but never changed.
#[derive(Debug)]
pub struct Unchanged<'a, A>(pub &'a mut A);

impl<A: Archive> Archive for Unchanged<'_, A> {
    type Error = A::Error;

    fn word(&mut self, word: &mut u32) -> Result<(), A::Error> {
        let mut noted = *word;
        self.0.word(&mut noted)?;
        if noted == *word { Ok(()) } else { Err(Invalid { place: "configuration" }.into()) }
    }
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

/// Why words in memory weren't enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// See [`Invalid`].
    Invalid(Invalid),
    /// There are fewer words than the state has, or room for fewer.
    TooShort,
}

impl From<Invalid> for Refused {
    fn from(why: Invalid) -> Self {
        Self::Invalid(why)
    }
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

impl Archive for ToWords<'_> {
    type Error = Refused;

    fn word(&mut self, word: &mut u32) -> Result<(), Refused> {
        *self.words.get_mut(self.noted).ok_or(Refused::TooShort)? = *word;
        self.noted += 1;
        Ok(())
    }
}

impl Archive for FromWords<'_> {
    type Error = Refused;

    fn word(&mut self, word: &mut u32) -> Result<(), Refused> {
        let (first, rest) = self.words.split_first().ok_or(Refused::TooShort)?;
        *word = *first;
        self.words = rest;
        Ok(())
    }
}
