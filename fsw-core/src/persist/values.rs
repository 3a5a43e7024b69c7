//! Numbers and containers of numbers as words.
//!
//! | type | words | rejected on reading |
//! |---|---|---|
//! | `bool` | one, 0 or 1 | any other value |
//! | `u8`, `u16`, `usize` | one | a value beyond the type |
//! | `u32` | one | – |
//! | `u64` | two, low word first | – |
//! | `f32`, `f64` | bits: one word, or two with the low one first | infinity, NaN |
//! | `Option` | tag 0 or 1, then the value if there is one | any other tag |
//! | array, matrix, pair | elements in order; a matrix by columns | – |
//!
//! The layout of a container contains that of its elements and its length.
//!
//! Functions for numbers and arrays are not inlined: each stands once in an image, and a state is a
//! list of calls.
//!
//! ```
//! use fsw_core::checkpoint::{ToWords, transfer};
//!
//! let mut state = (Some(1.0f32), [2u64, 3]);
//! let mut words = [0; 6];
//! transfer(&mut state, &mut ToWords::new(&mut words)).unwrap();
//! assert_eq!(words, [1, 0x3f80_0000, 2, 0, 3, 0]);
//! ```

use super::{Archive, Blank, Persist, mix, name, replace};
use crate::math::{Mat, scalar::Real};

/// Implements [`Persist`] for an integer or a flag: conversion to words and, where possible, back.
macro_rules! persist_number {
    ($number:ident: $zero:expr, |$value:ident, $archive:ident| $passed:expr) => {
        impl Persist for $number {
            fn layout() -> u32 {
                const { name(stringify!($number)) }
            }

            #[inline(never)]
            fn persist(&mut self, $archive: &mut Archive<'_>) {
                let $value = *self;
                match $passed {
                    Some(passed) => *self = passed,
                    None => $archive.refuse(stringify!($number)),
                }
            }
        }

        impl Blank for $number {
            #[inline]
            fn blank() -> Self {
                $zero
            }
        }
    };
}

persist_number!(u32: 0, |value, archive| Some(one(value, archive)));
persist_number!(u64: 0, |value, archive| Some(two(value, archive)));
persist_number!(u8: 0, |value, archive| u8::try_from(one(value.into(), archive)).ok());
persist_number!(u16: 0, |value, archive| u16::try_from(one(value.into(), archive)).ok());
persist_number!(usize: 0, |value, archive| {
    let word = u32::try_from(value).ok();
    word.and_then(|word| usize::try_from(one(word, archive)).ok())
});
persist_number!(bool: false, |value, archive| match one(value.into(), archive) {
    0 => Some(false),
    1 => Some(true),
    _ => None,
});
/// Bits of a float. A number that is not finite is rejected.
impl<T: Real> Persist for T {
    fn layout() -> u32 {
        const { name(T::NAME) }
    }

    #[inline(never)]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let bits = self.to_bits();
        let value = T::from_bits(if size_of::<T>() == size_of::<u32>() {
            one(bits as u32, archive).into()
        } else {
            two(bits, archive)
        });
        if value.is_finite() {
            *self = value;
        } else {
            archive.refuse(T::NAME);
        }
    }
}

impl<T: Real> Blank for T {
    #[inline]
    fn blank() -> Self {
        T::zero()
    }
}

/// Transfers one word.
fn one(mut word: u32, archive: &mut Archive<'_>) -> u32 {
    archive.word(&mut word);
    word
}

/// Transfers two words, low word first.
fn two(value: u64, archive: &mut Archive<'_>) -> u64 {
    let low = one(value as u32, archive);
    let high = one((value >> 32) as u32, archive);
    u64::from(high) << 32 | u64::from(low)
}

/// Transfers the elements of an array.
#[inline(never)]
fn each<P: Persist>(row: &mut [P], archive: &mut Archive<'_>) {
    for element in row {
        element.persist(archive);
    }
}

/// Tag, 0 or 1, then the value if there is one.
impl<P: Persist + Blank> Persist for Option<P> {
    fn layout() -> u32 {
        mix(const { name("Option") }, P::layout())
    }

    #[inline(never)]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut is_some = self.is_some();
        is_some.persist(archive);
        if !is_some {
            *self = None;
        } else if self.is_none() {
            replace(self, || Some(P::blank()));
        }
        if let Some(value) = self {
            value.persist(archive);
        }
    }
}

/// No value.
impl<P> Blank for Option<P> {
    fn blank() -> Self {
        None
    }
}

/// Elements in order.
impl<P: Persist, const N: usize> Persist for [P; N] {
    fn layout() -> u32 {
        mix(mix(const { name("array") }, N as u32), P::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        each(self, archive);
    }
}

impl<P: Blank, const N: usize> Blank for [P; N] {
    fn blank() -> Self {
        core::array::from_fn(|_| P::blank())
    }
}

/// Elements by columns.
impl<T: Real, const R: usize, const C: usize> Persist for Mat<T, R, C> {
    fn layout() -> u32 {
        mix(mix(mix(const { name("matrix") }, R as u32), C as u32), T::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        each(self.as_mut_slice(), archive);
    }
}

impl<T: Real, const R: usize, const C: usize> Blank for Mat<T, R, C> {
    fn blank() -> Self {
        Mat::zeros()
    }
}

/// First element, second element.
impl<P: Persist, Q: Persist> Persist for (P, Q) {
    fn layout() -> u32 {
        mix(mix(const { name("pair") }, P::layout()), Q::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
        self.1.persist(archive);
    }
}

impl<P: Blank, Q: Blank> Blank for (P, Q) {
    fn blank() -> Self {
        (P::blank(), Q::blank())
    }
}
