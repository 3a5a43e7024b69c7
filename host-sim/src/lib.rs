//! The simulator.

pub mod input;
pub mod sensor;
pub mod simulation;
pub mod truth;
