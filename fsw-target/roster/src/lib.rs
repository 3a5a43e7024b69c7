//! Roster of the estimators that fly, their starts, reports and checkpoints, compiled for the smallest
//! size.
//!
//! | package | contents | `opt-level` |
//! |---|---|---|
//! | `fsw-steps` | steps, at each sample | 3 |
//! | `fsw-work` | the [`Work`] of `window`, between samples | s |
//! | `fsw-roster` | starts, reports, checkpoints: by command, or once a second | z |
//!
//! Reason for separate crates: the optimisation level is set per crate, and a generic function has that
//! of the crate that instantiates it. At `z` functions are not inlined, and loops not unrolled: an index
//! that only the caller knows is then checked at run time, with a panic. Code of `fsw-core` reads the
//! elements of its matrices by functions that are always inlined.

#![no_std]
#![forbid(unsafe_code)]

mod roster;

pub use fsw_work::Work;
pub use roster::{EstimatorId, EstimatorSlot, InitialData, Refused, Selected};
