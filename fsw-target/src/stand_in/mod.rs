//! Substitutes of sensors: a recorded flight, or a simulator on a serial line.
//!
//! 1. [`recording`]: a recorded flight in place of all sensors; [`replay`]: the committed flight with its
//!    estimator.
//! 2. [`tunnel`]: sensors, flash and clock of a simulator, for the processor in the loop.

pub mod recording;
pub mod replay;
pub mod tunnel;
