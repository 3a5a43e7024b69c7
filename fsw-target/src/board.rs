//! The board: the only place that names a chip, its pins and its peripherals.
//!
//! To port, write a folder beside [`stm32f405`] that offers the same names, re-export it here, and
//! adapt `memory.x`.

#[cfg(target_os = "none")]
pub mod stm32f405;
#[cfg(target_os = "none")]
pub use stm32f405::*;

/// Of the board's files, the one that the host can test.
#[cfg(all(test, not(target_os = "none")))]
#[path = "board/stm32f405/rates.rs"]
mod rates;
