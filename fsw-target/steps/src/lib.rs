//! Steps of the estimators that fly, compiled for speed: `f32`, four wheels.
//!
//! The work of each sample is compiled for speed, all other firmware for size. Reason for a
//! separate crate: the optimisation level is set per crate, and a generic function has that of the
//! crate that instantiates it. The functions here are not generic and never inlined. Profile
//! `firmware`: this crate for speed, `fsw-roster` and `fsw-target` for size.

#![no_std]
#![forbid(unsafe_code)]

mod step;

pub use step::{
    BLOCKS, CONSIDERED, EkfSgfRls, Fast, JointEkf, JointEkfOfHardware, Step, WHEELS, Window9,
    Window18, WindowOfHardware, step_covariance,
};
