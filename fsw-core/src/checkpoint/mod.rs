//! 6. Checkpoint: an estimator's state to and from non-volatile memory, bit for bit.
//!
//! The restored state is bit-identical to the saved one, and so are all later results if the time
//! stamps have no gap. [`transfer`] writes or reads a state ([`Persist`]) by way of any medium
//! ([`Words`]); [`fingerprint`] identifies the layout, so that a medium can be checked before it is
//! read.
//!
//! # Use
//!
//! 1. At the start: an estimator with its configuration.
//! 2. If the medium holds a checkpoint with the [`fingerprint`] of the estimator's type:
//!    [`transfer`] from the medium. After a rejection the state is partly overwritten, and the
//!    estimator is constructed again.
//! 3. From time to time: [`transfer`] to the medium, together with the fingerprint and a checksum.
//!
//! A checksum is up to the medium: it detects a flipped bit, which validation does not always
//! reject. Restored numbers are finite in any case.
//!
//! # Limits
//!
//! * Time stamps are absolute. After an interruption longer than the gate's gap the rate is
//!   initialised, and the inertia is kept.
//! * The byte order is that of the medium: a word is a `u32`.
//! * `f32` and `f64` estimators have different layouts.

#[cfg(test)]
mod tests;

pub use crate::persist::{Archive, InvalidWord, Persist, Words, mix};

/// Writes a state to a medium, or reads it from there: the medium decides on the direction.
///
/// # Errors
/// The first rejected value. After a rejected read the state is partly overwritten and must be
/// constructed again.
///
/// ```
/// use fsw_core::checkpoint::{FromWords, ToWords, transfer};
/// use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
/// use fsw_core::{ConfigError, WheelArray};
///
/// let new = || JointEkfUd::<f32, 1>::new(
///     Config::new(1e-4),
///     WheelArray::new([fsw_core::Vec3::z()], [1e-3])?,
/// );
/// let (mut filter, mut restored) = (new()?, new()?);
/// let mut words = [0; 640];
/// let mut medium = ToWords::new(&mut words);
/// transfer(&mut filter, &mut medium).unwrap();
/// let length = medium.written();
/// transfer(&mut restored, &mut FromWords::new(&words[..length])).unwrap();
/// # Ok::<(), ConfigError>(())
/// ```
pub fn transfer<P: Persist + ?Sized>(
    state: &mut P,
    words: &mut dyn Words,
) -> Result<(), InvalidWord> {
    let mut archive = Archive::new(words);
    state.persist(&mut archive);
    archive.finish()
}

/// To be changed where the meaning of a stored value changes and its layout does not.
const MEANING: u32 = 1;

/// Identifies checkpoints of one layout of the state `P` and one version of this crate.
///
/// Two builds of the same layout are compatible on purpose: a new image continues from the estimate of
/// the previous one, which may have taken days. The layout covers name and type of every field in
/// their order; configuration is compared and values are validated while they are read. A number whose
/// meaning changes under the same name is the one change that none of these detect: it requires a new
/// `MEANING` or a new version.
pub fn fingerprint<P: Persist>() -> u32 {
    use crate::persist::name;
    const VERSION: u32 = mix(name(env!("CARGO_PKG_VERSION")), MEANING);
    mix(VERSION, P::layout())
}

/// Medium that writes words to memory.
#[derive(Debug)]
pub struct ToWords<'a> {
    words: &'a mut [u32],
    written: usize,
}

/// Medium that reads words from memory.
#[derive(Debug)]
pub struct FromWords<'a> {
    words: &'a [u32],
}

impl<'a> ToWords<'a> {
    /// Starts at the first word.
    pub fn new(words: &'a mut [u32]) -> Self {
        Self { words, written: 0 }
    }

    /// Number of words written.
    pub fn written(&self) -> usize {
        self.written
    }
}

impl<'a> FromWords<'a> {
    /// Starts at the first word.
    pub fn new(words: &'a [u32]) -> Self {
        Self { words }
    }

    /// Number of words not read yet.
    pub fn remaining(&self) -> usize {
        self.words.len()
    }
}

impl Words for ToWords<'_> {
    fn transfer(&mut self, word: &mut u32) -> bool {
        let Some(place) = self.words.get_mut(self.written) else { return false };
        *place = *word;
        self.written += 1;
        true
    }
}

impl Words for FromWords<'_> {
    fn transfer(&mut self, word: &mut u32) -> bool {
        let Some((first, rest)) = self.words.split_first() else { return false };
        *word = *first;
        self.words = rest;
        true
    }
}
