//! Scalar of all formulas: `f32` or `f64`.
//!
//! Every item of this crate is generic over one trait, [`Real`]. The caller picks the precision
//! once, at the edge. Functions come from `libm` on every platform and no operation is fused, so
//! that host and target agree to the last bit.
//!
//! | | `f32` | `f64` |
//! |---|---|---|
//! | ε | 2⁻²³ = 1.2e-7 | 2⁻⁵² = 2.2e-16 |
//! | largest number | 3.4e38 | 1.8e308 |
//! | smallest normal number | 1.2e-38 | 2.2e-308 |
//! | exact integers | up to 2²⁴ | up to 2⁵³ |
//!
//! Squares of quantities below 1e-19 underflow in `f32`. Formulas with products of small inertias
//! divide by a typical size first.

use core::fmt::Debug;
use core::ops::Neg;
use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign, Scalar};
use num_traits::{One, Zero};

/// `f32` or `f64`.
///
/// Differs from nalgebra's `RealField` on purpose: that trait takes its functions from the
/// platform's library where `std` is on and from `libm` elsewhere, and the two differ in the last
/// bit.
///
/// ```
/// use fsw_core::Real;
///
/// /// Kinetic energy of rotation about a principal axis, J.
/// fn energy_j<T: Real>(moment_kg_m2: T, rate_rad_s: T) -> T {
///     T::lit(0.5) * moment_kg_m2 * rate_rad_s * rate_rad_s
/// }
/// assert_eq!(energy_j(2.0f32, 3.0), 9.0);
/// assert_eq!(energy_j(2.0f64, 3.0), 9.0);
/// ```
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
    /// Zero, for initial values that are built in their place.
    const ZERO: Self;
    /// Distance from 1 to the next larger number: 2⁻²³ or 2⁻⁵².
    const EPSILON: Self;
    /// Largest finite number.
    const MAX: Self;

    /// Name of the type: `f32` or `f64`.
    const NAME: &'static str;

    /// Literal of a formula, rounded to this precision.
    fn lit(value: f64) -> Self;
    /// Conversion to `f64`, exact.
    fn to_f64(self) -> f64;
    /// Conversion to `f32`, rounded: for storage.
    fn to_f32(self) -> f32;
    /// Conversion from `f32`, exact.
    fn from_f32(value: f32) -> Self;
    /// Bits of the IEEE 754 representation; those of `f32` are the low 32.
    fn to_bits(self) -> u64;
    /// Number with these bits; `f32` ignores the high 32.
    fn from_bits(bits: u64) -> Self;
    /// Seconds of a difference between two time stamps, µs.
    ///
    /// Time stamps are subtracted as integers first. Single precision is then exact to rounding,
    /// however old the epoch is. Differences below 2²⁴ µs (16.8 s) are represented exactly before
    /// the division.
    ///
    /// ```
    /// use fsw_core::Real;
    ///
    /// let (last_us, now_us) = (315_576_000_000_000u64, 315_576_000_100_000u64);
    /// assert_eq!(f32::seconds(now_us - last_us), 0.1);
    /// ```
    fn seconds(microseconds: u64) -> Self;
    /// Integer, rounded to this precision.
    fn count(number: u32) -> Self;
    /// Square root, correctly rounded, and so the same on every machine.
    fn sqrt(self) -> Self;
    /// Angle of the point with ordinate `self` and abscissa `x`, rad, -π to π.
    fn atan2(self, x: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// True unless infinite or NaN.
    fn is_finite(self) -> bool;
    /// Larger of two numbers; the other one where one is NaN.
    fn max(self, other: Self) -> Self;
    /// Smaller of two numbers; the other one where one is NaN.
    fn min(self, other: Self) -> Self;
}

macro_rules! real {
    ($float:ident, $bits:ident, $sqrt:path, $atan2:path, $abs:path) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
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
                // Halves of 32 bits: the Cortex-M4F converts 32 bits in one instruction and 64 in a
                // library call.
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
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
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

real!(f32, u32, libm::sqrtf, libm::atan2f, libm::fabsf);
real!(f64, u64, libm::sqrt, libm::atan2, libm::fabs);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_period_is_exact_after_ten_years() {
        let (start, period_us) = (315_576_000_000_000_u64, 248_u64);
        let dt: f32 = Real::seconds((start + period_us) - start);
        assert_eq!(dt, 248.0e-6);
        let (single, double): (f32, f64) = (Real::seconds(start), Real::seconds(start));
        assert_eq!(double, 315_576_000.0);
        assert!((f64::from(single) / double - 1.0).abs() < 2.0 * f64::from(f32::EPSILON));
    }
}
