//! Drivers: one per kind of part, over embedded-hal 1.0 or a small trait of its own, each a crate that
//! stands alone (`fsw-target/drivers`). Here each implements one trait of [`crate::flight::sensors`].
//!
//! 1. [`gyro`]: rate gyros on SPI or I²C.
//! 2. [`wheel_tach`]: reaction-wheel speed from the edges of a Hall sensor or encoder.

pub mod gyro;
pub mod wheel_tach;
