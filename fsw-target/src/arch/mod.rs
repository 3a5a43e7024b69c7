//! Code that depends on the Cortex-M core, and not on the chip or board around it.
//!
//! 1. [`exit`]: end of an image, with a status by semihosting or with a system reset.
//! 2. [`instructions`]: instruction counter for QEMU.
//! 3. `exceptions`: exceptions without a handler of their own.
//! 4. `hard_fault`: entry of the hard fault.
//! 5. `v7m` (Armv7-M, Armv7E-M): stack guard of its memory protection unit. `v8m` (Armv8-M with the Main Extension):
//!    stack limit register.
//!
//! The board's cargo feature enables the feature of its core.

mod exceptions;
pub mod exit;
mod hard_fault;
pub mod instructions;

#[cfg(feature = "v7m")]
mod v7m;
#[cfg(feature = "v7m")]
use v7m::stack_overflowed;

#[cfg(feature = "v8m")]
mod v8m;
#[cfg(feature = "v8m")]
use v8m::stack_overflowed;
