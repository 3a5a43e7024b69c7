//! What state is made of in the end: numbers, and what holds them.
//!
//! A whole number takes a word, or two, the low one first; a float the words of its bits.
//!
//! Numbers and rows of them are passed by functions that aren't inlined: in an image they then stand once,
//! and a state is a list of calls.

use super::{Archive, Blank, Invalid, Persist, mix, name};
use crate::math::{Mat, scalar::Real};

macro_rules! persist_number {
    ($number:ident, $zero:expr, |$value:ident, $archive:ident| $persist:expr) => {
        impl Persist for $number {
            fn layout() -> u32 {
                const { name(stringify!($number)) }
            }

            #[inline(never)]
            fn persist<A: Archive>(&mut self, $archive: &mut A) -> Result<(), A::Error> {
                let $value = *self;
                *self = $persist;
                Ok(())
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

persist_number!(u32, 0, |value, archive| one_word(value, archive)?);
persist_number!(u64, 0, |value, archive| two_words(value, archive)?);
persist_number!(u8, 0, |value, archive| narrow(one_word(u32::from(value), archive)?, "u8")?);
persist_number!(u16, 0, |value, archive| narrow(one_word(u32::from(value), archive)?, "u16")?);
persist_number!(usize, 0, |value, archive| {
    narrow(one_word(narrow(value, "usize")?, archive)?, "usize")?
});
persist_number!(bool, false, |value, archive| match one_word(u32::from(value), archive)? {
    0 => false,
    1 => true,
    _ => return Err(Invalid { place: "bool" }.into()),
});
persist_number!(f32, 0.0, |value, archive| {
    finite(f32::from_bits(one_word(value.to_bits(), archive)?))?
});
persist_number!(f64, 0.0, |value, archive| {
    finite(f64::from_bits(two_words(value.to_bits(), archive)?))?
});

#[inline]
fn one_word<A: Archive>(value: u32, archive: &mut A) -> Result<u32, A::Error> {
    let mut word = value;
    archive.word(&mut word)?;
    Ok(word)
}

/// The low one first.
#[inline]
fn two_words<A: Archive>(value: u64, archive: &mut A) -> Result<u64, A::Error> {
    let low = one_word(value as u32, archive)?;
    let high = one_word((value >> 32) as u32, archive)?;
    Ok(u64::from(high) << 32 | u64::from(low))
}

#[inline]
fn narrow<A, B: TryFrom<A>>(value: A, place: &'static str) -> Result<B, Invalid> {
    B::try_from(value).map_err(|_| Invalid { place })
}

#[inline]
fn finite<T: Real>(value: T) -> Result<T, Invalid> {
    if value.is_finite() { Ok(value) } else { Err(Invalid { place: "a number that isn't finite" }) }
}

#[inline(never)]
fn each<P: Persist, A: Archive>(row: &mut [P], archive: &mut A) -> Result<(), A::Error> {
    row.iter_mut().try_for_each(|element| element.persist(archive))
}

/// A tag, 0 or 1, then the value if there is one.
impl<P: Persist + Blank> Persist for Option<P> {
    fn layout() -> u32 {
        mix(const { name("Option") }, P::layout())
    }

    fn persist<A: Archive>(&mut self, archive: &mut A) -> Result<(), A::Error> {
        let mut is_some = self.is_some();
        is_some.persist(archive)?;
        if !is_some {
            *self = None;
            return Ok(());
        }
        self.get_or_insert_with(P::blank).persist(archive)
    }
}

impl<P> Blank for Option<P> {
    fn blank() -> Self {
        None
    }
}

impl<P: Persist, const N: usize> Persist for [P; N] {
    fn layout() -> u32 {
        mix(mix(const { name("array") }, N as u32), P::layout())
    }

    fn persist<A: Archive>(&mut self, archive: &mut A) -> Result<(), A::Error> {
        each(self, archive)
    }
}

impl<P: Blank, const N: usize> Blank for [P; N] {
    fn blank() -> Self {
        core::array::from_fn(|_| P::blank())
    }
}

impl<T: Real, const R: usize, const C: usize> Persist for Mat<T, R, C> {
    fn layout() -> u32 {
        mix(mix(mix(const { name("matrix") }, R as u32), C as u32), T::layout())
    }

    fn persist<A: Archive>(&mut self, archive: &mut A) -> Result<(), A::Error> {
        each(self.as_mut_slice(), archive)
    }
}

impl<T: Real, const R: usize, const C: usize> Blank for Mat<T, R, C> {
    fn blank() -> Self {
        Mat::zeros()
    }
}

impl<P: Persist, Q: Persist> Persist for (P, Q) {
    fn layout() -> u32 {
        mix(mix(const { name("pair") }, P::layout()), Q::layout())
    }

    fn persist<A: Archive>(&mut self, archive: &mut A) -> Result<(), A::Error> {
        self.0.persist(archive)?;
        self.1.persist(archive)
    }
}

impl<P: Blank, Q: Blank> Blank for (P, Q) {
    fn blank() -> Self {
        (P::blank(), Q::blank())
    }
}
