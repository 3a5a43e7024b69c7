//! [board]: self::board
//! [porting]: self::porting
//! [security]: self::security
//! [budgets]: self::budgets
//! [link]: crate::link
//!
#![doc = include_str!("../docs/index.md")]

/// [security]: self::security
/// [link]: crate::link
///
#[doc = include_str!("../docs/board.md")]
pub mod board {}

/// [board module]: crate::board
///
#[doc = include_str!("../docs/porting.md")]
pub mod porting {}

/// [link]: crate::link
/// [budgets]: self::budgets
///
#[doc = include_str!("../docs/security.md")]
pub mod security {}

#[doc = include_str!("../docs/budgets.md")]
pub mod budgets {}
