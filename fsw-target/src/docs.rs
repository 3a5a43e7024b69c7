//! [board]: self::board
//! [porting]: self::porting
//! [manoeuvre]: self::manoeuvre
//! [security]: self::security
//! [robustness]: self::robustness
//! [verification]: self::verification
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
/// [wheel check]: crate::flight::wheel_check
///
#[doc = include_str!("../docs/porting.md")]
pub mod porting {}

/// [link]: crate::link
/// [robustness]: self::robustness
///
#[doc = include_str!("../docs/manoeuvre.md")]
pub mod manoeuvre {}

/// [link]: crate::link
/// [budgets]: self::budgets
///
#[doc = include_str!("../docs/security.md")]
pub mod security {}

/// [budgets]: self::budgets
/// [`sealed`]: crate::runtime::sealed
///
#[doc = include_str!("../docs/robustness.md")]
pub mod robustness {}

/// [budgets]: self::budgets
/// [robustness]: self::robustness
///
#[doc = include_str!("../docs/verification.md")]
pub mod verification {}

#[doc = include_str!("../docs/budgets.md")]
pub mod budgets {}
