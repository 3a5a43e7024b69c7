//! The simulator.

pub mod input;
