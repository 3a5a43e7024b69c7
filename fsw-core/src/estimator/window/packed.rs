//! Blocks as they are stored, in 24 bytes.
//!
//! | what | bits | resolution |
//! |---|---|---|
//! | rate | 3 × 17, and 6 of a common exponent | 2⁻¹⁶ of the largest axis |
//! | drive, less the window's first | 3 × 19, and 6 | 2⁻¹⁸ |
//! | impulse | 3 × 15, and 6 | 2⁻¹⁴ |
//! | duration, up to four usual blocks | 15 | 2⁻¹³ of one |
//! | samples | 2, and 4 of an exponent | exact up to 8, then 1/4 to 1/8 |
//!
//! What rounding takes from one block is given to the next, so that over many blocks nothing is
//! lost, and a rounding error is that of one block alone: of a rate 4·10⁻⁶, one sigma, which adds a
//! hundredth to the variance of the quietest gyros (10⁻⁴ of the rate a sample, four samples a block).
//! Twelve bits of impulse, or seventeen of drive where wheels carry many times the body's momentum,
//! were too few for them, and showed in residuals and NEES.

use super::block::Block;
use crate::math::{Vec3, scalar::Real};
use crate::persist::{Archive, Persist};

/// Bits of each axis.
const RATE_BITS: u32 = 17;
const DRIVE_BITS: u32 = 19;
const IMPULSE_BITS: u32 = 15;
/// Bits of a common exponent, and what is added to it: sizes from 2⁻⁴⁰ to 2²³ (of rad/s, N m s).
const EXPONENT_BITS: u32 = 6;
const EXPONENT_BIAS: i32 = 40;
/// Bits of a duration, and how many units a usual block has.
const DURATION_BITS: u32 = 15;
const USUAL_DURATION: f64 = 8192.0;
/// Bits of a number of samples, and of its exponent.
const SAMPLES_BITS: u32 = 2;
const SAMPLES_EXPONENT_BITS: u32 = 4;

/// A block as it is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packed([u32; 6]);

impl Persist for Packed {
    fn layout() -> u32 {
        <[u32; 6]>::layout()
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
    }
}

/// What blocks are counted from and in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale<T: Real> {
    /// Drive of the window's first block, N m s.
    pub drive_n_m_s: Vec3<T>,
    /// Length of a usual block, s.
    pub duration_s: T,
}

crate::persist!([T: Real] Scale<T> { drive_n_m_s, duration_s });

/// Packs blocks in a row, and carries on what rounding takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packer<T: Real> {
    rounding: Block<T>,
}

crate::persist!([T: Real] Packer<T> { rounding });

impl<T: Real> Default for Packer<T> {
    fn default() -> Self {
        Self { rounding: Block::empty() }
    }
}

impl<T: Real> Packer<T> {
    /// Packs the next block.
    pub fn pack(&mut self, block: &Block<T>, scale: &Scale<T>) -> Packed {
        let lost = &self.rounding;
        let wanted = Block {
            samples: block.samples,
            duration_s: block.duration_s + lost.duration_s,
            rate_rad_s: block.rate_rad_s + lost.rate_rad_s,
            drive_n_m_s: block.drive_n_m_s + lost.drive_n_m_s,
            impulse_n_m_s: block.impulse_n_m_s + lost.impulse_n_m_s,
        };
        let packed = Packed::of(&wanted, scale);
        let got = packed.block(scale);
        self.rounding = Block {
            samples: 0,
            duration_s: wanted.duration_s - got.duration_s,
            rate_rad_s: wanted.rate_rad_s - got.rate_rad_s,
            drive_n_m_s: wanted.drive_n_m_s - got.drive_n_m_s,
            impulse_n_m_s: wanted.impulse_n_m_s - got.impulse_n_m_s,
        };
        packed
    }
}

impl Packed {
    /// Whether a block isn't too long to be packed.
    pub fn fits<T: Real>(block: &Block<T>, scale: &Scale<T>) -> bool {
        let most = T::count((1 << DURATION_BITS) - 2) * T::lit(1.0 / USUAL_DURATION);
        block.duration_s < scale.duration_s * most
    }

    fn of<T: Real>(block: &Block<T>, scale: &Scale<T>) -> Self {
        let mut bits = Bits::default();
        bits.put_vector(&block.rate_rad_s, RATE_BITS);
        bits.put_vector(&(block.drive_n_m_s - scale.drive_n_m_s), DRIVE_BITS);
        bits.put_vector(&block.impulse_n_m_s, IMPULSE_BITS);
        let units = block.duration_s / scale.duration_s * T::lit(USUAL_DURATION) + T::lit(0.5);
        // Saturates: a negative number, or NaN, is 0.
        bits.put((units.to_f32() as u32).min((1 << DURATION_BITS) - 1), DURATION_BITS);
        let half = 1 << SAMPLES_BITS;
        let longest = (1 << SAMPLES_EXPONENT_BITS) - 1;
        let exponent = (u32::BITS - block.samples.leading_zeros()).saturating_sub(SAMPLES_BITS + 1);
        let (exponent, mantissa) = match block.samples {
            few if few < half => (0, few),
            many => ((exponent + 1).min(longest), ((many >> exponent) - half).min(half - 1)),
        };
        bits.put(mantissa, SAMPLES_BITS);
        bits.put(exponent, SAMPLES_EXPONENT_BITS);
        Self(bits.words)
    }

    /// The block.
    #[inline(never)]
    pub fn block<T: Real>(&self, scale: &Scale<T>) -> Block<T> {
        let mut bits = Bits { words: self.0, at: 0 };
        let rate_rad_s = bits.take_vector(RATE_BITS);
        let drive: Vec3<T> = bits.take_vector(DRIVE_BITS);
        let impulse_n_m_s = bits.take_vector(IMPULSE_BITS);
        let units = T::count(bits.take(DURATION_BITS));
        let duration_s = units * scale.duration_s * T::lit(1.0 / USUAL_DURATION);
        Block {
            samples: Self::samples_in(&mut bits),
            duration_s,
            rate_rad_s,
            drive_n_m_s: drive + scale.drive_n_m_s,
            impulse_n_m_s,
        }
    }

    /// Its rate, rad/s.
    pub fn rate_rad_s<T: Real>(&self) -> Vec3<T> {
        Bits { words: self.0, at: 0 }.take_vector(RATE_BITS)
    }

    /// Its samples.
    pub fn samples(&self) -> u32 {
        Self::samples_in(&mut Bits { words: self.0, at: SAMPLES_AT })
    }

    #[inline(always)]
    fn samples_in(bits: &mut Bits) -> u32 {
        let mantissa = bits.take(SAMPLES_BITS);
        match bits.take(SAMPLES_EXPONENT_BITS) {
            0 => mantissa,
            exponent => ((1 << SAMPLES_BITS) + mantissa) << (exponent - 1),
        }
    }

    /// The same with no samples: a stretch to be crossed, whose rate isn't believed.
    pub fn without_samples(self) -> Self {
        let mut bits = Bits { words: self.0, at: SAMPLES_AT };
        bits.clear(SAMPLES_BITS + SAMPLES_EXPONENT_BITS);
        Self(bits.words)
    }
}

/// Where the number of samples begins.
const SAMPLES_AT: u32 = 3 * (RATE_BITS + DRIVE_BITS + IMPULSE_BITS + EXPONENT_BITS) + DURATION_BITS;
const _: () =
    assert!(SAMPLES_AT + SAMPLES_BITS + SAMPLES_EXPONENT_BITS <= 192, "a block has 192 bits");

/// Six words, written or read from their lowest bit on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bits {
    words: [u32; 6],
    at: u32,
}

impl Bits {
    /// Appends the lowest `width` bits, 1 to 31, of a number.
    fn put(&mut self, value: u32, width: u32) {
        let (word, shift) = self.next(width);
        let spread = u64::from(value & ((1 << width) - 1)) << shift;
        if let Some(low) = self.words.get_mut(word) {
            *low |= spread as u32;
        }
        if let Some(high) = self.words.get_mut(word + 1) {
            *high |= (spread >> 32) as u32;
        }
    }

    /// The next `width` bits. Inlined, so that where they are is known when compiled.
    #[inline(always)]
    fn take(&mut self, width: u32) -> u32 {
        let (word, shift) = self.next(width);
        let part = |i: usize| u64::from(self.words.get(i).copied().unwrap_or(0));
        ((part(word) | part(word + 1) << 32) >> shift) as u32 & ((1 << width) - 1)
    }

    /// Sets the next `width` bits to zero.
    fn clear(&mut self, width: u32) {
        let (word, shift) = self.next(width);
        let mask = !(((1u64 << width) - 1) << shift);
        if let Some(low) = self.words.get_mut(word) {
            *low &= mask as u32;
        }
        if let Some(high) = self.words.get_mut(word + 1) {
            *high &= (mask >> 32) as u32;
        }
    }

    #[inline(always)]
    fn next(&mut self, width: u32) -> (usize, u32) {
        let at = self.at;
        self.at += width;
        ((at / 32) as usize, at % 32)
    }

    /// Three numbers of so many bits, sign included, and their common exponent.
    fn put_vector<T: Real>(&mut self, vector: &Vec3<T>, width: u32) {
        let v: [f32; 3] = core::array::from_fn(|i| vector[i].to_f32());
        let largest = v.iter().fold(0.0f32, |max, x| max.max(x.abs()));
        // The power of two above it.
        let exponent = (largest.to_bits() >> 23) as i32 - 126;
        let code = (exponent + EXPONENT_BIAS).clamp(0, (1 << EXPONENT_BITS) - 1);
        let scale = power_of_two(width as i32 - 1 - (code - EXPONENT_BIAS));
        let top = (1 << (width - 1)) - 1;
        for x in v {
            let scaled = x * scale;
            let nearest = scaled + if scaled < 0.0 { -0.5 } else { 0.5 };
            self.put((nearest as i32).clamp(-top, top) as u32, width);
        }
        self.put(code as u32, EXPONENT_BITS);
    }

    #[inline(always)]
    fn take_vector<T: Real>(&mut self, width: u32) -> Vec3<T> {
        let unused = 32 - width;
        let mut axis = || (self.take(width) << unused) as i32 >> unused;
        let (x, y, z) = (axis(), axis(), axis());
        let exponent = self.take(EXPONENT_BITS) as i32 - EXPONENT_BIAS;
        let scale = power_of_two(exponent + 1 - width as i32);
        let value = |mantissa: i32| T::from_f32(mantissa as f32 * scale);
        Vec3::new(value(x), value(y), value(z))
    }
}

/// 2ⁿ, for n from −126 to 127.
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127).clamp(1, 254) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SCALE: Scale<f64> = Scale { drive_n_m_s: Vec3::new(0.0, 0.0, 0.0), duration_s: 0.4 };

    fn block(x: &[f64; 11]) -> Block<f64> {
        Block {
            samples: x[9] as u32,
            duration_s: x[10],
            rate_rad_s: Vec3::new(x[0], x[1], x[2]),
            drive_n_m_s: Vec3::new(x[3], x[4], x[5]),
            impulse_n_m_s: Vec3::new(x[6], x[7], x[8]),
        }
    }

    fn near(found: &Vec3<f64>, wanted: &Vec3<f64>, bits: i32) -> bool {
        (found - wanted).abs().max() <= wanted.abs().max() * 2f64.powi(1 - bits)
    }

    proptest! {
        #[test]
        fn a_block_comes_back_to_its_resolution(
            v in prop::array::uniform9(-1.0..1.0f64),
            sizes in prop::array::uniform3(-9.0..5.0f64),
            samples in 0u32..3000,
            length in 0.01..3.9f64,
        ) {
            let size = |i: usize| 10f64.powf(sizes[i]);
            let mut x = [0.0; 11];
            for i in 0..9 {
                x[i] = v[i] * size(i / 3);
            }
            let drive_n_m_s = Vec3::new(1.0, -2.0, 0.5) * size(1);
            let scale = Scale { drive_n_m_s, duration_s: 0.4 };
            (x[9], x[10]) = (f64::from(samples), length * scale.duration_s);
            let wanted = block(&x);
            let found = Packer::default().pack(&wanted, &scale).block::<f64>(&scale);
            prop_assert!(near(&found.rate_rad_s, &wanted.rate_rad_s, 17));
            let beyond = |b: &Block<f64>| b.drive_n_m_s - scale.drive_n_m_s;
            prop_assert!(near(&beyond(&found), &beyond(&wanted), 18));
            prop_assert!(near(&found.impulse_n_m_s, &wanted.impulse_n_m_s, 15));
            prop_assert!((found.duration_s - wanted.duration_s).abs() < 0.4 / 8192.0);
            let close = found.samples.abs_diff(wanted.samples) * 4 <= wanted.samples;
            prop_assert!(close && (samples > 8 || found.samples == samples));
        }

        #[test]
        fn sums_over_many_blocks_are_kept(
            xs in prop::collection::vec(prop::array::uniform9(-1.0..1.0f64), 100),
        ) {
            let mut packer = Packer::default();
            let (mut wanted, mut found) = (Vec3::zeros(), Vec3::zeros());
            for x in &xs {
                let b = block(&[
                    x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], 4.0, 0.4 + 0.1 * x[8],
                ]);
                let back = packer.pack(&b, &SCALE).block::<f64>(&SCALE);
                wanted += Vec3::new(b.rate_rad_s.x, b.impulse_n_m_s.y, b.duration_s);
                found += Vec3::new(back.rate_rad_s.x, back.impulse_n_m_s.y, back.duration_s);
            }
            // One rounding of 15 bits, or of a duration.
            prop_assert!((wanted - found).abs().max() < 1e-4);
        }

        #[test]
        fn any_bits_pack(bits in prop::array::uniform9(any::<u32>()), samples in any::<u32>()) {
            let f = bits.map(f32::from_bits);
            let wild = Block {
                samples,
                duration_s: f[0],
                rate_rad_s: Vec3::new(f[0], f[1], f[2]),
                drive_n_m_s: Vec3::new(f[3], f[4], f[5]),
                impulse_n_m_s: Vec3::new(f[6], f[7], f[8]),
            };
            let scale = Scale { drive_n_m_s: Vec3::zeros(), duration_s: 0.4 };
            let back = Packed::of(&wild, &scale).block::<f32>(&scale);
            prop_assert!(back.rate_rad_s.iter().all(|x| x.is_finite()));
            prop_assert!(back.duration_s.is_finite());
        }
    }

    #[test]
    fn a_block_without_samples_is_otherwise_the_same() {
        let full = block(&[0.1, 0.2, -0.3, 1.0, 2.0, 3.0, 0.5, 0.25, 0.125, 6.0, 0.5]);
        let packed = Packed::of(&full, &SCALE);
        let (with, without) = (packed.block::<f64>(&SCALE), packed.without_samples().block(&SCALE));
        assert_eq!(without, Block { samples: 0, ..with });
        assert_eq!(with.samples, 6);
    }
}
