//! [theory]: self::theory
//! [window]: self::window
//! [accuracy]: self::accuracy
//!
#![doc = include_str!("../docs/index.md")]

/// [theory]: crate::docs::theory
///
#[doc = include_str!("../docs/theory.md")]
pub mod theory {}

/// [theory]: crate::docs::theory
/// [accuracy]: crate::docs::accuracy
///
#[doc = include_str!("../docs/window.md")]
pub mod window {}

/// [theory]: crate::docs::theory
///
#[doc = include_str!("../docs/accuracy.md")]
pub mod accuracy {}
