//! A value whose memory is sealed between uses: a flipped bit is found before the value is used again.
//!
//! ```text
//!  seal ── sum of all words ──► idle ──► open ── same sum? ──► use ──► seal
//!                                          └─ no: the value is not used, see `open`
//! ```
//!
//! The sum covers the memory of the value as it lies: numbers, counters, tags of enums, unused places and padding.
//! It depends on no type within the value, so that no invalid tag or index is read before it is found. For words `w`
//! in order, modulo 2³²:
//!
//! `s ← rotl(s, 5) + w`
//!
//! Each step is invertible in `s` and in `w`: a change within one word always changes the sum, and so does any single
//! flipped bit. The rotation separates equal bits of adjacent words. Changes of several words cancel with a
//! probability of about 2⁻³².
//!
//! # Limits
//!
//! * Between [`Sealed::open`] and [`Sealed::seal`] the value is in use: a bit that flips then is sealed with the result.
//! * A bit flipped in the sum itself is reported as one in the value.
//! * Memory beyond references of the value is not covered.
//!
//! Cost: two passes over the memory per use, see `docs/budgets.md`.

use core::ptr;
use fsw_core::hardware::Finding;
use fsw_core::{Estimate, Estimator, Innovation, Outcome, Reset, Sample, Vec3};

/// Words of one turn of the loop over the memory.
const TURN: usize = 8;

/// A value in place, with the sum of its memory.
#[derive(Debug)]
pub struct Sealed<'a, T> {
    value: &'a mut T,
    sum: u32,
    /// True while the value may be used.
    is_open: bool,
}

impl<'a, T> Sealed<'a, T> {
    /// The value, in use.
    pub const fn new(value: &'a mut T) -> Self {
        Self { value, sum: 0, is_open: true }
    }

    /// Permits the use of a sealed value. False if its memory has changed since [`seal`](Self::seal): no part of the
    /// value may then be relied on.
    #[must_use]
    pub fn open(&mut self) -> bool {
        self.is_open = self.is_open || sum_of(self.value) == self.sum;
        self.is_open
    }

    /// Ends the use. No effect on a sealed value.
    pub fn seal(&mut self) {
        if self.is_open {
            self.sum = sum_of(self.value);
            self.is_open = false;
        }
    }

    /// True between [`open`](Self::open) and [`seal`](Self::seal).
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// The value, without a check.
    pub fn get(&self) -> &T {
        self.value
    }

    /// The value in use, without a check: after [`open`](Self::open), or to be replaced.
    pub fn get_mut(&mut self) -> &mut T {
        self.is_open = true;
        self.value
    }
}

#[cfg(test)]
impl<T> Sealed<'_, T> {
    /// Flips a bit of the value as it lies in memory, without opening it.
    pub fn flip(&mut self, bit: usize) {
        assert!(bit / 8 < size_of::<T>());
        let byte = ptr::from_mut(self.value).cast::<u8>();
        #[allow(unsafe_code, reason = "an upset changes memory without regard to types")]
        // SAFETY: a byte of the value, which is borrowed mutably. The value may be invalid afterwards: it is not used
        // before the seal has been checked.
        unsafe {
            let byte = byte.add(bit / 8);
            byte.write_volatile(byte.read_volatile() ^ (1 << (bit % 8)));
        }
    }
}

/// Sum of the words of a value in memory.
#[inline(never)]
fn sum_of<T>(value: &T) -> u32 {
    const { assert!(align_of::<T>() >= align_of::<u32>(), "a value of whole words") };
    let words = size_of::<T>() / size_of::<u32>();
    let first = ptr::from_ref(value).cast::<u32>();
    #[allow(unsafe_code, reason = "tags and padding have no other form in which they can be read")]
    // SAFETY: the index is below the number of words of the value, which is borrowed, aligned to words, and has a
    // size that is a multiple of its alignment. Volatile: a word is the content of memory, in padding too, and not
    // what the compiler infers of it.
    let word = |index: usize| unsafe { first.add(index).read_volatile() };
    let mut sum = 0;
    let mut index = 0;
    while index + TURN <= words {
        // Unrolled by hand: this crate is compiled for size.
        sum =
            add(add(add(add(sum, word(index)), word(index + 1)), word(index + 2)), word(index + 3));
        index += TURN / 2;
        sum =
            add(add(add(add(sum, word(index)), word(index + 1)), word(index + 2)), word(index + 3));
        index += TURN / 2;
    }
    while index < words {
        sum = add(sum, word(index));
        index += 1;
    }
    sum
}

/// Sum of words in this order, as of a value in memory: for the words of a checkpoint.
pub fn sum(words: impl IntoIterator<Item = u32>) -> u32 {
    words.into_iter().fold(0, add)
}

/// Sum with one more word.
#[inline(always)]
fn add(sum: u32, word: u32) -> u32 {
    sum.rotate_left(5).wrapping_add(word)
}

/// The estimator, whose step opens it. After a flipped bit the sample is not used and the seal stays broken: the state is
/// not valid, [`Reset::Diverged`].
impl<const W: usize, E: Estimator<f32, W>> Estimator<f32, W> for Sealed<'_, E> {
    fn step(&mut self, sample: &Sample<f32, W>) -> Outcome {
        match self.open() {
            true => self.value.step(sample),
            false => Outcome::Reset(Reset::Diverged),
        }
    }

    fn estimate(&self) -> Estimate<f32> {
        self.value.estimate()
    }

    fn rate_rad_s(&self) -> Vec3<f32> {
        self.value.rate_rad_s()
    }

    fn innovation(&self) -> Option<Innovation<f32>> {
        self.value.innovation()
    }

    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<f32>)) {
        self.value.each_of_hardware(visit);
    }

    fn finish(&mut self) {
        self.value.finish();
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// Words, in a number that is no multiple of a turn.
    type Value = [u32; 2 * TURN + 3];

    fn value() -> Value {
        core::array::from_fn(|i| 0x9e37_79b9_u32.wrapping_mul(i as u32))
    }

    #[test]
    fn every_flipped_bit_breaks_the_seal() {
        for bit in 0..size_of::<Value>() * 8 {
            let mut value = value();
            let mut sealed = Sealed::new(&mut value);
            sealed.seal();
            sealed.value[bit / 32] ^= 1 << (bit % 32);
            assert!(!sealed.open() && !sealed.is_open(), "bit {bit}");
            sealed.value[bit / 32] ^= 1 << (bit % 32);
            assert!(sealed.open(), "bit {bit}");
        }
    }

    #[test]
    fn equal_bits_of_adjacent_words_do_not_cancel() {
        let sums: Vec<u32> = (0..Value::default().len() - 1)
            .flat_map(|word| (0..32).map(move |bit| (word, bit)))
            .map(|(word, bit)| {
                let mut value = value();
                value[word] ^= 1 << bit;
                value[word + 1] ^= 1 << bit;
                sum_of(&value)
            })
            .collect();
        assert!(!sums.contains(&sum_of(&value())));
        assert_eq!(sum(value()), sum_of(&value()));
    }

    #[test]
    fn use_between_open_and_seal_is_part_of_the_sum() {
        let mut value = value();
        let mut sealed = Sealed::new(&mut value);
        assert!(sealed.open());
        sealed.get_mut()[5] = 7;
        sealed.seal();
        assert!(!sealed.is_open() && sealed.open());
        assert_eq!(sealed.get()[5], 7);
    }
}
