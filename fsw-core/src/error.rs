//! What a constructor says of a configuration that it can't accept.

use core::fmt;

/// A configuration value that is out of its range: which, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigError {
    /// The field's name, with its element where it has several: `prior.sigma_kg_m2`.
    pub field: &'static str,
    /// What is wrong with it.
    pub reason: Invalid,
}

/// Why a configuration value is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Invalid {
    /// Infinite or not a number.
    NotFinite,
    /// Must be above zero.
    NotPositive,
    /// Must be zero or above.
    Negative,
    /// Must be one or below.
    AboveOne,
    /// A whole number outside its range.
    OutOfRange {
        /// The least that is allowed.
        least: u32,
        /// The most that is allowed.
        most: u32,
    },
    /// An axis of no length has no direction.
    ZeroAxis,
    /// More unknowns than the estimator is compiled for.
    NoRoom,
    /// No rigid body has this inertia tensor.
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
            Self::NoRoom => f.write_str("is an unknown that this estimator isn't compiled for"),
            Self::NotPhysical(why) => write!(f, "{why}"),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Why no rigid body has such an inertia tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotPhysical {
    /// An element is infinite or not a number.
    NotFinite,
    /// A principal moment is zero or negative.
    NotPositiveDefinite,
    /// A principal moment exceeds the sum of the two others.
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
