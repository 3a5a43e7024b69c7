//! Gyro of a BMI088 at register level, with faults.
//!
//! In: the true rate in sensor axes at each sample; bytes on SPI or I²C. Out: bytes, by the data
//! sheet BST-BMI088-DS001, so that the flight driver runs against the model unchanged.
//!
//! ```text
//! true rate ─► Chip: counts, registers, faults ◄─► Wire: SpiDevice, DelayNs ◄─► flight driver
//!                                              ◄─► I2cWire: I2c, DelayNs
//! ```
//!
//! The model samples when [`Chip::sample`] is called, independent of the data rate in its register:
//! time and noise are the caller's. Modelled are the registers that the driver uses; all others
//! return the value written. The low-pass filter needs the rate between the samples and is the
//! caller's too: [`Chip::lag_s`] is its time constant.

mod chip;
mod faults;
mod wire;

#[cfg(test)]
mod tests;

pub use chip::Chip;
pub use faults::{BusFault, Faults, SelfTest};
pub use wire::{I2cWire, Wire};
