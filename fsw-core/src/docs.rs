//! [theory]: self::theory
//! [window]: self::window
//! [accuracy]: self::accuracy
//!
#![doc = include_str!("../docs/index.md")]

/// [theory]: super::theory
///
#[doc = include_str!("../docs/theory.md")]
pub mod theory {}

/// [theory]: super::theory
/// [accuracy]: super::accuracy
///
#[doc = include_str!("../docs/window.md")]
pub mod window {}

/// [theory]: super::theory
///
#[doc = include_str!("../docs/accuracy.md")]
pub mod accuracy {}
