//! [scenarios]: self::scenarios
//! [replay]: self::replay
//! [logs]: self::logs
//! [report]: self::report
//! [diagnose]: self::diagnose
//! [keys]: crate::input::keys
//! [campaigns]: self::campaigns
//! [manoeuvres]: self::manoeuvres
//! [faults]: self::faults
//! [python]: self::python
//! [packagers]: self::packagers
//! [papers]: self::papers
//! [pil]: self::pil
//!
#![doc = include_str!("../docs/index.md")]

/// [keys]: crate::input::keys
/// [campaigns]: crate::docs::campaigns
/// [faults]: crate::docs::faults
/// [report]: crate::docs::report
///
#[doc = include_str!("../docs/scenarios.md")]
pub mod scenarios {}

/// [keys]: crate::input::keys
/// [logs]: crate::docs::logs
/// [diagnose]: crate::docs::diagnose
/// [report]: crate::docs::report
/// [table]: fsw_core::monitor::health
///
#[doc = include_str!("../docs/replay.md")]
pub mod replay {}

/// [keys]: crate::input::keys
/// [replay]: crate::docs::replay
/// [report]: crate::docs::report
///
#[doc = include_str!("../docs/logs.md")]
pub mod logs {}

/// [diagnose]: crate::docs::diagnose
/// [campaigns]: crate::docs::campaigns
/// [faults]: crate::docs::faults
/// [papers]: crate::docs::papers
///
#[doc = include_str!("../docs/report.md")]
pub mod report {}

#[doc = include_str!("../docs/diagnose.md")]
pub mod diagnose {}

/// [accuracy]: fsw_core::docs::accuracy
/// [report]: crate::docs::report
///
#[doc = include_str!("../docs/campaigns.md")]
pub mod campaigns {}

/// [keys]: crate::input::keys
///
#[doc = include_str!("../docs/manoeuvres.md")]
pub mod manoeuvres {}

/// [scenarios]: crate::docs::scenarios
/// [report]: crate::docs::report
/// [health]: fsw_core::monitor::health
///
#[doc = include_str!("../docs/faults.md")]
pub mod faults {}

/// [replay]: crate::docs::replay
/// [campaigns]: crate::docs::campaigns
/// [manoeuvres]: crate::docs::manoeuvres
/// [diagnose]: crate::docs::diagnose
/// [keys]: crate::input::keys
///
#[doc = include_str!("../docs/python.md")]
pub mod python {}

#[doc = include_str!("../docs/packagers.md")]
pub mod packagers {}

/// [report]: crate::docs::report
///
#[doc = include_str!("../docs/papers.md")]
pub mod papers {}

/// [board]: fsw_target::docs::board
///
#[doc = include_str!("../docs/pil.md")]
pub mod pil {}
