//! Roster of the estimators that fly, and all of them that recurs less than once a block, compiled for
//! the smallest size.
//!
//! | package | contents | `opt-level` |
//! |---|---|---|
//! | `fsw-steps` | steps, at each sample | 3 |
//! | `fsw-work` | slices of `window` that take in a block | s |
//! | `fsw-roster` | its other slices, starts, reports, checkpoints | z |
//!
//! Reason for separate crates: the optimisation level is set per crate, and a generic function has that
//! of the crate that instantiates it. At `z` functions are not inlined, and loops not unrolled: an index
//! that only the caller knows is then checked at run time, with a panic. Code of `fsw-core` reads the
//! elements of its matrices by functions that are always inlined.

#![no_std]
#![forbid(unsafe_code)]

mod roster;
mod work;

pub use roster::{EstimatorId, EstimatorSlot, InitialData, Refused, Selected};
pub use work::Work;
