//! Rate gyros: the interface beyond a reading, and the supported parts.
//!
//! A further gyro takes two files: a driver beside [`bmi088`] that implements [`Gyro`] and
//! [`RateGyro`], and this one, with its module and [`fitted`]. [`bus`] serves parts with 8-bit
//! registers on SPI or I²C.

pub mod bmi088;
pub mod bus;

/// Gyro of the images `flight` and `bringup`.
pub mod fitted {
    pub use super::bmi088::{Bmi088 as Chip, Settings};
}

use crate::flight::sensors::Gyro;
use embedded_hal::delay::DelayNs;

/// Reason for a failed start, common to all gyros: for telemetry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum StartFault {
    /// Bus error.
    Bus,
    /// Another part, or no part.
    WrongIdentity {
        /// Value of the identity register.
        found: u8,
    },
    /// A register does not read back as written.
    NotAsSet,
    /// Invalid settings.
    WrongSettings,
}

/// A gyro chip that can be configured and tested, at power-up and in flight.
pub trait RateGyro: Gyro {
    /// Value of its identity register.
    const IDENTITY: u8;

    /// Reason for a failed start.
    type StartError;
    /// Reason for a failed self-test, or for one that could not run.
    type SelfTestError;

    /// Resets the chip, checks its identity and configures it. For power-up, and in flight after
    /// failed readings or missing data-ready: a chip that reset itself (brown-out, single event) has
    /// lost its settings. Takes less than 0.1 s, all of it in `delay`.
    fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::StartError>;

    /// Runs the chip's self-test, in bounded time. Readings during the test are invalid.
    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::SelfTestError>;

    /// Largest rate of a reading on a sensor axis, rad/s.
    fn range_rad_s(&self) -> f32;

    /// Rate per count, rad/s.
    fn quantum_rad_s(&self) -> f32;
}
