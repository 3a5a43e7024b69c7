//! Rate gyros: the interface beyond a reading, and the supported parts.
//!
//! A further gyro takes a file beside [`bmi088`], in which its driver implements [`Gyro`] and
//! [`RateGyro`], and this one, with its module and [`fitted`]. [`bus`] serves parts with 8-bit
//! registers on SPI or I²C.

pub mod bmi088;

pub use bmi088_gyro::bus;

/// Gyro of the images `flight` and `bringup`.
pub mod fitted {
    pub use super::bmi088::{Bmi088 as Chip, Settings};
}

pub use crate::flight::sensors::{Gyro, RateGyro, StartFault};
