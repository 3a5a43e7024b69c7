//! Rejected configurations: field and reason.
//!
//! Constructors validate their configuration before use. Input: a configuration. Output: `Ok`, or
//! the first field that is out of its range. This module depends on no other, so that every layer
//! can report through it.
//!
//! | reason | permitted range |
//! |---|---|
//! | [`Invalid::NotFinite`] | finite numbers |
//! | [`Invalid::NotPositive`] | above zero |
//! | [`Invalid::Negative`] | zero and above |
//! | [`Invalid::AboveOne`] | one and below |
//! | [`Invalid::OutOfRange`] | an interval of integers |
//! | [`Invalid::ZeroAxis`] | vectors of a length above zero |
//! | [`Invalid::NoRoom`] | unknowns that the estimator's type includes |
//! | [`Invalid::NotPhysical`] | tensors of a rigid body |
//!
//! A rejected configuration is a result of construction alone: no step returns an error.

use core::fmt;

/// Rejected configuration value, with its field and the reason.
///
/// Displayed as `field: reason`:
///
/// ```
/// use fsw_core::{ConfigError, Vec3, WheelArray};
///
/// let error = WheelArray::new([Vec3::zeros()], [1e-3f32]).unwrap_err();
/// assert_eq!(error.field, "wheel.axis");
/// assert_eq!(error.to_string(), "wheel.axis: an axis must have a length above zero");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigError {
    /// Name of the field, with the structure that holds it: `prior.sigma_kg_m2`.
    pub field: &'static str,
    /// Violated condition.
    pub reason: Invalid,
}

/// Reason for which a configuration value is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Invalid {
    /// Infinite or NaN.
    NotFinite,
    /// Zero or negative; must be above zero.
    NotPositive,
    /// Negative; must be zero or above.
    Negative,
    /// Above one; must be one or below.
    AboveOne,
    /// Integer outside its range.
    OutOfRange {
        /// Smallest permitted value.
        least: u32,
        /// Largest permitted value.
        most: u32,
    },
    /// Axis of zero length: its direction is undefined.
    ZeroAxis,
    /// Unknown that the number of unknowns, a compile-time constant, does not include.
    NoRoom,
    /// Tensor that no rigid body has.
    NotPhysical(NotPhysical),
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.field, self.reason)
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => f.write_str("must be a finite number"),
            Self::NotPositive => f.write_str("must be above zero"),
            Self::Negative => f.write_str("must not be negative"),
            Self::AboveOne => f.write_str("must not be above one"),
            Self::OutOfRange { least, most } => write!(f, "must lie between {least} and {most}"),
            Self::ZeroAxis => f.write_str("an axis must have a length above zero"),
            Self::NoRoom => f.write_str("is an unknown that this estimator is not compiled for"),
            Self::NotPhysical(why) => write!(f, "{why}"),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Reason for which no rigid body has an inertia tensor.
///
/// With principal moments `A ≤ B ≤ C`, a body has `A > 0` and `C ≤ A + B`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotPhysical {
    /// An element is infinite or not a number.
    NotFinite,
    /// The smallest principal moment is zero or negative: `A ≤ 0`.
    NotPositiveDefinite,
    /// The largest principal moment exceeds the sum of the others: `C > A + B`.
    TriangleInequality,
}

impl fmt::Display for NotPhysical {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "an inertia element is not finite",
            Self::NotPositiveDefinite => "the inertia tensor is not positive definite",
            Self::TriangleInequality => {
                "a principal moment of inertia exceeds the sum of the two others"
            }
        })
    }
}
