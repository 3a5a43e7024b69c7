//! Range checks of scalar parameters: each returns the error that names the field.

use super::scalar::Real;
use crate::error::{ConfigError, Invalid};

/// The error for `field`, if `value` isn't between `least` and `most`.
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

/// The error for `field`, if `value` isn't finite.
pub(crate) fn finite<T: Real>(field: &'static str, value: T) -> Result<(), ConfigError> {
    if !value.is_finite() {
        return Err(ConfigError { field, reason: Invalid::NotFinite });
    }
    Ok(())
}

/// The error for `field`, if `value` isn't finite and above zero.
pub(crate) fn positive<T: Real>(field: &'static str, value: T) -> Result<(), ConfigError> {
    if !value.is_finite() {
        return Err(ConfigError { field, reason: Invalid::NotFinite });
    }
    if value <= T::zero() {
        return Err(ConfigError { field, reason: Invalid::NotPositive });
    }
    Ok(())
}

/// The error for `field`, if `value` isn't finite and at least zero.
pub(crate) fn not_negative<T: Real>(field: &'static str, value: T) -> Result<(), ConfigError> {
    if !value.is_finite() {
        return Err(ConfigError { field, reason: Invalid::NotFinite });
    }
    if value < T::zero() {
        return Err(ConfigError { field, reason: Invalid::Negative });
    }
    Ok(())
}
