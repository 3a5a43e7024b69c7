//! Gyro of a Bosch BMI088, on SPI or I²C (data sheet BST-BMI088-DS001).
//!
//! Output: body rate in rad/s, or the error of the bus or of the chip.
//!
//! * Wiring: CSB2 selects the gyro on SPI; PS at ground selects SPI, PS at VDDIO selects I²C; SDO2
//!   sets the I²C address. INT3 or INT4 signals a new sample.
//! * Range: ±125 to ±2000 deg/s, 16 bits per axis. [`Bmi088::rate_rad_s`] alone scales counts to
//!   rad/s and rotates them into body axes.
//! * Settings: written once and read back. Each reading also reads range and bandwidth: after an
//!   unnoticed reset the chip is back at ±2000 deg/s, and its counts would be scaled to rates up to
//!   16 times too small.
//! * Saturation: a count at full scale is a lower bound of the rate. A saturated reading is
//!   [`SATURATED_RAD_S`] on all axes, since the rotation into body axes mixes them. A range check
//!   rejects it; the value is finite, so that the reason differs from that of a NaN.
//! * Timing: a start takes 60 ms, a self-test at most 100 ms. Every wait is bounded.
//!
//! # Alternatives
//!
//! The crate `bmi088` 0.2.1 speaks embedded-hal 1.0, but swaps the data rates 1000 Hz and 2000 Hz,
//! offers two of the five ranges, stores neither the identity nor the settings, and supports neither
//! data-ready nor self-test. Other crates are for embedded-hal 0.2, or for the accelerometer.

#![no_std]
#![forbid(unsafe_code)]

pub mod bus;
mod error;
mod registers;
mod settings;
#[cfg(test)]
mod tests;

pub use error::{Differs, ReadError, SelfTestError, StartError};
pub use registers::*;
pub use settings::{Bandwidth, DataReadyPin, Range, Settings};

use bus::RegisterBus;
use embedded_hal::delay::DelayNs;

/// Reading of every axis while one of them is saturated, rad/s: beyond the range of any gyro.
pub const SATURATED_RAD_S: f32 = 1.0e9;

/// Counts of an undriven bus, 0xFFFF on every axis. A body at rest reads them by chance: one reading in
/// 10⁵ at a noise of 25 counts, which is skipped.
const NO_ANSWER: [i16; 3] = [-1; 3];

/// Gyro of a BMI088 on the bus `B`.
#[derive(Debug, Clone, Copy)]
pub struct Bmi088<B> {
    bus: B,
    settings: Settings,
}

impl<B: RegisterBus> Bmi088<B> {
    /// A chip that is not configured yet, without a bus transaction. [`restart`](Self::restart)
    /// configures it. For a computer that starts without an answering gyro.
    pub fn new(bus: B, settings: Settings) -> Self {
        Self { bus, settings }
    }

    /// A configured chip.
    ///
    /// # Errors
    /// See [`StartError`].
    pub fn start(
        bus: B,
        settings: Settings,
        delay: &mut impl DelayNs,
    ) -> Result<Self, StartError<B::Error>> {
        let mut gyro = Self::new(bus, settings);
        gyro.restart(delay)?;
        Ok(gyro)
    }

    /// Rate of one sample in counts, sensor axes. The chip latches the upper byte of an axis when
    /// the lower is read, and the burst is shorter than a sample interval.
    ///
    /// # Errors
    /// The error of the bus.
    pub fn counts(&mut self) -> Result<[i16; 3], B::Error> {
        let mut bytes = [0; 6];
        self.bus.read(register::RATE_X_LSB, &mut bytes)?;
        let [x_low, x_high, y_low, y_high, z_low, z_high] = bytes;
        Ok([[x_low, x_high], [y_low, y_high], [z_low, z_high]].map(i16::from_le_bytes))
    }

    /// Value of the identity register; [`CHIP_ID`] for this part.
    ///
    /// # Errors
    /// The error of the bus.
    pub fn identity(&mut self) -> Result<u8, B::Error> {
        self.read_one(register::CHIP_ID)
    }

    /// True if a sample arrived within the last 280 µs, after which the chip clears the flag. For
    /// boards without the interrupt pin.
    ///
    /// # Errors
    /// The error of the bus.
    pub fn is_data_ready(&mut self) -> Result<bool, B::Error> {
        Ok(self.read_one(register::INT_STAT_1)? & DATA_READY != 0)
    }

    fn read_one(&mut self, register: u8) -> Result<u8, B::Error> {
        let mut value = [0];
        self.bus.read(register, &mut value)?;
        let [value] = value;
        Ok(value)
    }

    /// Configured registers: number, value, mask of the bits to read back. The other bits are
    /// reserved; bit 7 of GYRO_BANDWIDTH always reads 1.
    fn registers(&self) -> [(u8, u8, u8); 6] {
        let Settings { range, bandwidth, data_ready, .. } = self.settings;
        [
            (register::LPM1, 0x00, 0xA0), // normal mode, neither suspend nor deep suspend
            (register::RANGE, range as u8, 0x07),
            (register::BANDWIDTH, bandwidth as u8, 0x0F),
            (register::INT3_INT4_IO_CONF, data_ready.io_conf(), 0x0F),
            (register::INT3_INT4_IO_MAP, data_ready.io_map(), 0x81),
            (register::INT_CTRL, DATA_READY_ON, 0x80),
        ]
    }

    /// Writes every setting and reads it back.
    fn configure(&mut self, delay: &mut impl DelayNs) -> Result<(), StartError<B::Error>> {
        for (register, expected, bits) in self.registers() {
            self.bus.write(register, expected).map_err(StartError::Bus)?;
            delay.delay_us(WRITE_US);
            let found = self.read_one(register).map_err(StartError::Bus)?;
            if found & bits != expected {
                return Err(StartError::NotAccepted(Differs { register, expected, found }));
            }
        }
        Ok(())
    }

    /// Compares range and bandwidth with the settings.
    fn check_settings(&mut self) -> Result<(), ReadError<B::Error>> {
        let mut found = [0; 2];
        self.bus.read(register::RANGE, &mut found).map_err(ReadError::Bus)?;
        let [range, bandwidth] = found;
        let expected = (self.settings.range as u8, self.settings.bandwidth as u8);
        for (register, expected, found) in [
            (register::RANGE, expected.0, range & 0x07),
            (register::BANDWIDTH, expected.1, bandwidth & 0x0F),
        ] {
            if found != expected {
                return Err(ReadError::SettingsLost(Differs { register, expected, found }));
            }
        }
        Ok(())
    }

    /// Rate of the last sample, body axes, rad/s. Three transactions: counts, range and bandwidth.
    ///
    /// # Errors
    /// See [`ReadError`].
    pub fn rate_rad_s(&mut self) -> Result<[f32; 3], ReadError<B::Error>> {
        let counts = self.counts().map_err(ReadError::Bus)?;
        if counts == NO_ANSWER {
            return Err(ReadError::NoAnswer);
        }
        self.check_settings()?;
        if counts.iter().any(|count| count.unsigned_abs() >= FULL_SCALE.unsigned_abs()) {
            return Ok([SATURATED_RAD_S; 3]);
        }
        let quantum_rad_s = self.quantum_rad_s();
        Ok(self.settings.to_body(&counts.map(|count| f32::from(count) * quantum_rad_s)))
    }

    /// Resets the chip, checks its identity and configures it: at power-up, and after failed readings or
    /// missing samples, since a chip that reset itself (brown-out, single event) has lost its settings.
    /// Takes 60 ms in `delay`. Writes nothing to a part with another identity.
    ///
    /// # Errors
    /// See [`StartError`].
    pub fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), StartError<B::Error>> {
        if !self.settings.is_valid() {
            return Err(StartError::NotARotation);
        }
        delay.delay_ms(RESET_MS);
        let found = self.identity().map_err(StartError::Bus)?;
        if found != CHIP_ID {
            return Err(StartError::WrongIdentity { found });
        }
        self.bus.write(register::SOFTRESET, SOFT_RESET).map_err(StartError::Bus)?;
        delay.delay_ms(RESET_MS);
        self.configure(delay)
    }

    /// Runs the built-in self-test, 0.1 s at most. Readings during the test are invalid.
    ///
    /// # Errors
    /// See [`SelfTestError`].
    pub fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), SelfTestError<B::Error>> {
        self.bus.write(register::SELF_TEST, SELF_TEST_START).map_err(SelfTestError::Bus)?;
        for _ in 0..SELF_TEST_POLLS {
            delay.delay_ms(SELF_TEST_POLL_MS);
            let result = self.read_one(register::SELF_TEST).map_err(SelfTestError::Bus)?;
            if result & SELF_TEST_DONE == 0 {
                continue;
            }
            if result & SELF_TEST_FAILED != 0 {
                return Err(SelfTestError::Failed);
            }
            if result & SELF_TEST_RATE_OK == 0 {
                return Err(SelfTestError::RateNotOk);
            }
            return Ok(());
        }
        Err(SelfTestError::TimedOut)
    }

    /// Delay of a reading, µs: the rate is that of the body this time before data-ready.
    pub fn delay_us(&self) -> u32 {
        self.settings.delay_us
    }

    /// Largest rate of a reading on a sensor axis, rad/s.
    pub fn range_rad_s(&self) -> f32 {
        self.quantum_rad_s() * f32::from(FULL_SCALE)
    }

    /// Rate per count, rad/s.
    pub fn quantum_rad_s(&self) -> f32 {
        self.settings.range.quantum_rad_s()
    }
}

/// The code of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
