//! The one scalar trait: everything in this crate is generic over it, and the caller picks
//! `f32` or `f64` once, at the edge.

use core::fmt::Debug;
use core::ops::Neg;
use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign, Scalar};
use num_traits::{One, Zero};

/// `f32` or `f64`.
///
/// Deliberately not nalgebra's `RealField`: that trait takes its functions from the platform's
/// library where `std` is on and from `libm` where it isn't, so host and target could differ in
/// the last bit. Here both use `libm`, and no operation is fused.
pub trait Real:
    Scalar
    + Copy
    + Debug
    + PartialOrd
    + Zero
    + One
    + Neg<Output = Self>
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + ClosedDivAssign
{
    /// Distance from 1 to the next number.
    const EPSILON: Self;
    /// Largest finite number.
    const MAX: Self;

    /// Name of the type: `f32` or `f64`.
    const NAME: &'static str;

    /// A literal in a formula, rounded to this precision.
    fn lit(value: f64) -> Self;
    /// Widens to `f64`, without loss.
    fn to_f64(self) -> f64;
    /// Rounds to single precision, for storage.
    fn to_f32(self) -> f32;
    /// Widens from single precision, without loss.
    fn from_f32(value: f32) -> Self;
    /// Bits of the IEEE 754 representation; single precision has 32, in the low half.
    fn to_bits(self) -> u64;
    /// Number with these bits. Single precision ignores the high half.
    fn from_bits(bits: u64) -> Self;
    /// Seconds in a whole number of microseconds.
    ///
    /// The caller subtracts time stamps as integers first, so that single precision loses
    /// nothing however long the mission lasts.
    fn seconds(microseconds: u64) -> Self;
    /// A count, rounded to this precision.
    fn count(number: u32) -> Self;
    /// Square root (exactly rounded, so the same on every machine).
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// The larger of two; the other one where one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of two; the other one where one is NaN.
    fn min(self, other: Self) -> Self;
}

macro_rules! real {
    ($float:ident, $bits:ident, $sqrt:path, $abs:path) => {
        impl Real for $float {
            const EPSILON: Self = $float::EPSILON;
            const MAX: Self = $float::MAX;
            const NAME: &'static str = stringify!($float);

            #[inline]
            fn lit(value: f64) -> Self {
                value as $float
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn to_f32(self) -> f32 {
                self as f32
            }
            #[inline]
            fn from_f32(value: f32) -> Self {
                $float::from(value)
            }
            #[inline]
            fn to_bits(self) -> u64 {
                $float::to_bits(self).into()
            }
            #[inline]
            fn from_bits(bits: u64) -> Self {
                $float::from_bits(bits as $bits)
            }
            #[inline]
            fn seconds(microseconds: u64) -> Self {
                // Up to 16 s a step is below 2^24 µs: exact in f32 before the division. The processor
                // converts 32 bits in one instruction, and has none for 64.
                let (high, low) = ((microseconds >> 32) as u32, microseconds as u32);
                let whole = high as $float * 4_294_967_296.0 + low as $float;
                whole / 1.0e6
            }
            #[inline]
            fn count(number: u32) -> Self {
                number as $float
            }
            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn abs(self) -> Self {
                $abs(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                $float::max(self, other)
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                $float::min(self, other)
            }
        }
    };
}

real!(f32, u32, libm::sqrtf, libm::fabsf);
real!(f64, u64, libm::sqrt, libm::fabs);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_period_survives_ten_years_of_mission_time() {
        let (start, period_us) = (315_576_000_000_000_u64, 248_u64);
        let dt: f32 = Real::seconds((start + period_us) - start);
        assert_eq!(dt, 248.0e-6);
        let (single, double): (f32, f64) = (Real::seconds(start), Real::seconds(start));
        assert_eq!(double, 315_576_000.0);
        assert!((f64::from(single) / double - 1.0).abs() < 2.0 * f64::from(f32::EPSILON));
    }
}
