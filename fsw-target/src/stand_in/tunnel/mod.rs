//! Sensors, flash and clock of a simulator on a serial line: the processor in the loop.
//!
//! The flight computer sends requests, the simulator replies: spacecraft data, time of the next sample,
//! result of a transaction on the bus of the gyro, captures of the wheel timer, content of the flash.
//! Computer, drivers, conversions and estimators are those of the flight image, on its processor; only the
//! pins are not involved. The simulator waits for requests: both run in lock-step.
//!
//! ```text
//!  flight computer                                              simulator
//!  Tunnel  ── request: kind, fields, CRC-16, as a COBS frame ──►
//!          ◄── reply: kind or NO, fields, CRC-16, as a frame ──
//! ```
//!
//! | request | fields | reply |
//! |---|---|---|
//! | [`HELLO`] | version of this protocol; [`SOURCES`], u64 | [`Setup`] |
//! | [`HARDWARE`] | – | [`Stated`] |
//! | [`NEXT`] | – | µs since the last sample, u32; [`NEXT_WITH_TORQUE`]: and N m, 3 × f32; [`IDLE`]: no sample yet; NO: end of the flight |
//! | [`TRANSFER`] | bytes to read, bytes to write | the bytes read; NO: bus error |
//! | [`WAIT`] | µs, u32 | – |
//! | [`CAPTURES`] | – | [`Captures`] |
//! | [`MOTORS`] | torque of each motor, N m, 4 × f32 | –; NO: the wheels follow the scenario |
//! | [`FLASH_READ`] | offset, u32; bytes to read | the bytes; NO: out of range |
//! | [`FLASH_WRITE`] | offset, u32; bytes | –; NO: out of range |
//! | [`FLASH_ERASE`] | from, to, u32 | –; NO: out of range |
//! | [`FAILED`] | reason, as text | none |
//!
//! Fields are big-endian, as in [`crate::link::wire`]. Messages are short, since each byte to the computer
//! takes tens of microseconds in QEMU. An incomplete frame ends the run at both ends, without
//! retransmission: a retry could hide an error of the computer.
//!
//! 1. [`message`]: the messages, for both ends.
//! 2. [`setup`]: spacecraft data.
//! 3. [`Tunnel`]: requests and replies, at the computer's end.
//! 4. [`parts`]: the parts of a [`crate::flight::computer::Computer`], each by requests.

mod line;
pub mod message;
pub mod parts;
pub mod setup;

pub use line::{Port, Tunnel, TunnelError};
pub use message::*;
pub use setup::{Setup, Stated};
