//! Range checks of scalar parameters.
//!
//! Input: the field's name and its value. Output: `Ok`, or the [`ConfigError`] that names the field
//! and the violated condition. NaN is rejected by each check.

use super::scalar::Real;
use crate::error::{ConfigError, Invalid};

/// Integer within `least ≤ value ≤ most`.
///
/// # Errors
/// [`Invalid::OutOfRange`] with both limits.
pub(crate) fn within(
    field: &'static str,
    value: usize,
    least: usize,
    most: usize,
) -> Result<(), ConfigError> {
    if value < least || value > most {
        let reason = Invalid::OutOfRange { least: least as u32, most: most as u32 };
        return Err(ConfigError { field, reason });
    }
    Ok(())
}

/// Finite number.
///
/// # Errors
/// [`Invalid::NotFinite`].
pub(crate) fn finite<T: Real>(field: &'static str, value: T) -> Result<(), ConfigError> {
    if !value.is_finite() {
        return Err(ConfigError { field, reason: Invalid::NotFinite });
    }
    Ok(())
}

/// Finite number above zero.
///
/// # Errors
/// [`Invalid::NotFinite`] or [`Invalid::NotPositive`].
pub(crate) fn positive<T: Real>(field: &'static str, value: T) -> Result<(), ConfigError> {
    if !value.is_finite() {
        return Err(ConfigError { field, reason: Invalid::NotFinite });
    }
    if value <= T::zero() {
        return Err(ConfigError { field, reason: Invalid::NotPositive });
    }
    Ok(())
}

/// Finite number within `0 ≤ value ≤ most`.
///
/// # Errors
/// [`Invalid::NotFinite`], [`Invalid::Negative`] or [`Invalid::OutOfRange`].
pub(crate) fn up_to<T: Real>(field: &'static str, value: T, most: u32) -> Result<(), ConfigError> {
    not_negative(field, value)?;
    if value > T::count(most) {
        return Err(ConfigError { field, reason: Invalid::OutOfRange { least: 0, most } });
    }
    Ok(())
}

/// Finite number, zero or above.
///
/// # Errors
/// [`Invalid::NotFinite`] or [`Invalid::Negative`].
pub(crate) fn not_negative<T: Real>(field: &'static str, value: T) -> Result<(), ConfigError> {
    if !value.is_finite() {
        return Err(ConfigError { field, reason: Invalid::NotFinite });
    }
    if value < T::zero() {
        return Err(ConfigError { field, reason: Invalid::Negative });
    }
    Ok(())
}
