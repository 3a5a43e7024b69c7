//! [board]: self::board
//! [porting]: self::porting
//! [budgets]: self::budgets
//! [link]: crate::link
//!
#![doc = include_str!("../docs/index.md")]

/// [link]: crate::link
///
#[doc = include_str!("../docs/board.md")]
pub mod board {}

/// [board module]: crate::board
///
#[doc = include_str!("../docs/porting.md")]
pub mod porting {}

#[doc = include_str!("../docs/budgets.md")]
pub mod budgets {}
