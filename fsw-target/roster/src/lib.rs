//! Roster of the estimators that fly, and all of them that is not a step, compiled for size.
//!
//! Starts, reports, checkpoints and the [`Work`] of `window` in slices have the time between samples; the
//! steps of [`fsw_steps`] do not. Reason for a separate crate: the optimisation level is set per crate, and
//! a generic function has that of the crate that instantiates it.

#![no_std]
#![forbid(unsafe_code)]

mod roster;
mod work;

pub use roster::{
    EstimatorId, EstimatorSlot, FlightJointEkf, FlightWindow, InitialData, Refused, Selected,
};
pub use work::Work;
