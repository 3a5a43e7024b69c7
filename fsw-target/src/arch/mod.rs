//! What a Cortex-M core decides, whichever chip it is on.

pub mod exit;
pub mod instructions;
