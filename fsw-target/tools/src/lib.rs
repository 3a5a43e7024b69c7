//! Firmware on a PC: what the tests, the simulator and the `cargo qemu` alias share.
//!
//! The firmware's way from source to a result, in order: [`toolchain`] finds a compiler for the
//! Cortex-M, [`firmware`] builds an image with it, [`image`] looks into the image, [`qemu`] runs it
//! and decodes its log; [`machine`] runs one that doesn't end, and leaves its serial ports to us;
//! [`mod@bench`] has one count instructions, and holds them against the [`budgets`]; [`cycles`] estimates
//! what they take of the time.

pub mod bench;
pub mod budgets;
pub mod cycles;
pub mod firmware;
pub mod image;
#[cfg(unix)]
pub mod machine;
pub mod qemu;
pub mod toolchain;
