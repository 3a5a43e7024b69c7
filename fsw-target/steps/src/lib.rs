//! Steps of the estimators that fly, compiled for speed: `f32`, four wheels; and their [`roster`].
//!
//! The work of each sample is compiled for speed, all other firmware for size. The optimisation level is
//! set per crate, and generic code is compiled in the crate that first uses it with a type. So the steps
//! are instantiated here, in functions that are not generic and never inlined, and the profile
//! `firmware` (`Cargo.toml` of the workspace) compiles this crate for speed.

#![no_std]
#![forbid(unsafe_code)]

pub mod roster;
mod step;

pub use roster::{EstimatorId, EstimatorSlot, InitialData, Refused, Selected};
pub use step::{
    BLOCKS, EkfSgfRls, Fast, JointEkf, Step, WHEELS, Window9, Window12, Window15, Window18,
    step_covariance,
};
