//! Code that depends on the Cortex-M core, and not on the chip or board around it.
//!
//! 1. [`exit`]: end of an image, with a status by semihosting or with a system reset.
//! 2. [`instructions`]: instruction counter for QEMU.
//! 3. `exceptions`: exceptions without a handler of their own.
//! 4. `v7m` (Armv7-M, Armv7E-M): entry of the hard fault, and the stack guard of its memory protection
//!    unit.
//!
//! The board's cargo feature enables the feature of its core. An Armv8-M core is a folder beside `v7m`
//! with the same two parts: registers of its memory protection unit are different, and it has stack
//! limit registers.

mod exceptions;
pub mod exit;
pub mod instructions;

#[cfg(feature = "v7m")]
mod v7m;
