//! Firmware on a PC: what the tests, the simulator and the `cargo qemu` alias share.
//!
//! The firmware's way from source to a result, in order: [`toolchain`] finds a compiler for the
//! Cortex-M, [`firmware`] builds an image with it, [`image`] looks into the image, [`qemu`] runs it
//! and decodes its log.

pub mod firmware;
pub mod image;
pub mod qemu;
pub mod toolchain;
