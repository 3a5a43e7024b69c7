//! [theory]: self::theory
//! [hardware]: self::hardware
//! [window]: self::window
//! [accuracy]: self::accuracy
//! [c]: self::c
//!
#![doc = include_str!("../docs/index.md")]

/// [theory]: crate::docs::theory
/// [hardware]: crate::docs::hardware
///
#[doc = include_str!("../docs/theory.md")]
pub mod theory {}

/// [theory]: crate::docs::theory
///
#[doc = include_str!("../docs/hardware.md")]
pub mod hardware {}

/// [theory]: crate::docs::theory
/// [hardware]: crate::docs::hardware
/// [accuracy]: crate::docs::accuracy
///
#[doc = include_str!("../docs/window.md")]
pub mod window {}

/// [theory]: crate::docs::theory
/// [hardware]: crate::docs::hardware
///
#[doc = include_str!("../docs/accuracy.md")]
pub mod accuracy {}

#[doc = include_str!("../docs/c.md")]
pub mod c {}
