//! The board: the only place that names a chip, its pins and its peripherals.
//!
//! To port, write a file beside [`stm32f405`] that offers the same names, re-export it here, and
//! adapt `memory.x`.

pub mod stm32f405;

pub use stm32f405::{Board, LogPort};
