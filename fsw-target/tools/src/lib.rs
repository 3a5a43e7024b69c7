//! Firmware tools on a PC, shared by tests, simulator and the cargo aliases.
//!
//! From source to result: [`mod@board`] lists the boards, [`toolchain`] finds a compiler for the Cortex-M, [`firmware`] builds an
//! image, [`image`] reads its symbols and sections, [`qemu`] runs it and decodes its log. [`machine`]
//! runs an image without an end, with its serial ports as sockets. [`mod@bench`] counts instructions
//! and compares them with the [`budgets`]; [`cycles`] estimates processor cycles. [`command`] turns a
//! result into the exit code of a cargo alias.

pub mod bench;
pub mod board;
pub mod budgets;
pub mod command;
pub mod cycles;
pub mod firmware;
pub mod image;
#[cfg(unix)]
pub mod machine;
pub mod qemu;
pub mod toolchain;
