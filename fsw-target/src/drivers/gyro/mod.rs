//! Rate gyros: what a chip must offer beyond a reading, and the parts that are known.
//!
//! A second gyro is one file beside [`bmi088`] with an `impl` of [`Gyro`] and [`RateGyro`]; if it has
//! registers of eight bits, [`bus`] already speaks SPI and I²C.

pub mod bmi088;
pub mod bus;

use crate::flight::sensors::Gyro;
use embedded_hal::delay::DelayNs;

/// Why a gyro can't be set up, whichever it is: for telemetry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum StartFault {
    /// The bus failed.
    Bus,
    /// Another part, or none.
    WrongIdentity {
        /// What the identity register held.
        found: u8,
    },
    /// A register doesn't hold what was written to it.
    NotAsSet,
    /// What it was to be set to makes no sense.
    WrongSettings,
}

/// A gyro chip that can be set up, tested and set up again in flight.
pub trait RateGyro: Gyro {
    /// What its identity register holds.
    const IDENTITY: u8;

    /// Why it can't be set up.
    type StartError;
    /// Why it failed its self-test, or couldn't do it.
    type SelfTestError;

    /// Resets the chip, checks what it is, and sets it up. For power-up, and again in flight once
    /// readings fail or no data-ready comes any more: a chip that reset itself (brown-out, single
    /// event) has lost its settings. Takes less than 0.1 s, all of it in `delay`.
    fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::StartError>;

    /// Has the chip test itself, in bounded time. Readings during the test are worth nothing.
    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::SelfTestError>;

    /// Largest rate that a reading can show on an axis of the sensor, rad/s.
    fn range_rad_s(&self) -> f32;

    /// Rate of one count, rad/s.
    fn quantum_rad_s(&self) -> f32;
}
