//! The gyro of a Bosch BMI088, on SPI or I²C.
//!
//! Input: registers, as the data sheet BST-BMI088-DS001 names and numbers them. Output: body rate in
//! rad/s, and an error that says what the bus or the chip did.
//!
//! * Settings are written once and read back, and before each reading is believed the chip is asked
//!   for its range and bandwidth again: a chip that reset itself in flight is back at ±2000 deg/s, and
//!   its counts would otherwise be taken for rates many times too small.
//! * Counts become rad/s in one place, [`Bmi088::rate_rad_s`], and are turned into body axes there.
//! * A count at the end of the scale says only that the rate is at least that. The whole reading then
//!   becomes [`SATURATED_RAD_S`] on every axis, which any gate refuses as out of range: turned into
//!   body axes, the axis that is too fast is part of all three. A finite number, so that the reason
//!   isn't taken for a broken value.
//! * Every wait has an end.
//!
//! Written here because the crates don't fit. `bmi088` 0.2.1 speaks embedded-hal 1.0, but sets other
//! data rates than it is asked for (2000 Hz for 1000 and the reverse), offers two of the five ranges,
//! keeps neither what it found for an identity nor what it set, and has no data-ready and no self-test.
//! The others are for embedded-hal 0.2, or for the accelerometer.

use super::bus::RegisterBus;
use super::{RateGyro, StartFault};
use crate::flight::sensors::Gyro;
use embedded_hal::delay::DelayNs;
use fsw_core::{Mat, Vec3};

/// Address on I²C, with the pin SDO2 at ground.
pub const I2C_ADDRESS: u8 = 0x68;
/// Address on I²C, with the pin SDO2 at the supply.
pub const I2C_ADDRESS_SDO2_HIGH: u8 = 0x69;

/// What GYRO_CHIP_ID holds.
pub const CHIP_ID: u8 = 0x0F;

/// Register numbers, section 5.4 of the data sheet.
pub mod register {
    #![allow(missing_docs, reason = "the names are the data sheet's")]
    pub const CHIP_ID: u8 = 0x00;
    pub const RATE_X_LSB: u8 = 0x02;
    pub const INT_STAT_1: u8 = 0x0A;
    pub const RANGE: u8 = 0x0F;
    pub const BANDWIDTH: u8 = 0x10;
    pub const LPM1: u8 = 0x11;
    pub const SOFTRESET: u8 = 0x14;
    pub const INT_CTRL: u8 = 0x15;
    pub const INT3_INT4_IO_CONF: u8 = 0x16;
    pub const INT3_INT4_IO_MAP: u8 = 0x18;
    pub const SELF_TEST: u8 = 0x3C;
}

/// Written to GYRO_SOFTRESET: back to the state after power-up.
pub const SOFT_RESET: u8 = 0xB6;
/// Bit of GYRO_INT_STAT_1: there is a new sample.
pub const DATA_READY: u8 = 0x80;
/// Written to GYRO_INT_CTRL: a new sample makes an interrupt.
pub const DATA_READY_ON: u8 = 0x80;
/// Bit of GYRO_SELF_TEST: start the built-in self-test.
pub const SELF_TEST_START: u8 = 0x01;
/// Bit of GYRO_SELF_TEST: the test is over.
pub const SELF_TEST_DONE: u8 = 0x02;
/// Bit of GYRO_SELF_TEST: the test failed.
pub const SELF_TEST_FAILED: u8 = 0x04;
/// Bit of GYRO_SELF_TEST: the check that always runs in the background finds nothing wrong.
pub const SELF_TEST_RATE_OK: u8 = 0x10;

/// After power-up and after a soft reset the chip needs so long, ms.
const RESET_MS: u32 = 30;
/// After a write the interface rests for so long, µs (t_IDLE_wacc_nm, normal mode).
const WRITE_US: u32 = 2;
/// The data sheet gives the self-test no duration; it is asked for the end every 5 ms, for 0.1 s.
const SELF_TEST_POLL_MS: u32 = 5;
const SELF_TEST_POLLS: u32 = 20;

/// Largest count; with either sign it says that the rate is at least that.
pub const FULL_SCALE: i16 = 32_767;

/// What every axis reads once one of them is saturated, rad/s: beyond the range of any gyro.
pub const SATURATED_RAD_S: f32 = 1.0e9;

/// The rotation from sensor to body axes may be off by this in each entry of `Rᵀ R − 1`: more than
/// rounding of six digits does, less than a mistyped entry.
const ROTATION_TOLERANCE: f32 = 1.0e-4;

/// Range of GYRO_RANGE, deg/s; finer at the slow end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u8)]
pub enum Range {
    /// ±2000 deg/s, 0.061 deg/s a count.
    DegS2000 = 0,
    /// ±1000 deg/s, 0.031 deg/s a count.
    DegS1000 = 1,
    /// ±500 deg/s, 0.015 deg/s a count.
    DegS500 = 2,
    /// ±250 deg/s, 7.6e-3 deg/s a count.
    DegS250 = 3,
    /// ±125 deg/s, 3.8e-3 deg/s a count.
    DegS125 = 4,
}

impl Range {
    /// The ranges, finest first.
    pub const ALL: [Self; 5] =
        [Self::DegS125, Self::DegS250, Self::DegS500, Self::DegS1000, Self::DegS2000];

    /// The range that the register's value stands for.
    pub fn from_register(value: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|range| *range as u8 == value)
    }

    /// Full scale, rad/s: what 32768 counts would be.
    pub fn full_scale_rad_s(self) -> f32 {
        let deg_s = match self {
            Self::DegS2000 => 2000.0,
            Self::DegS1000 => 1000.0,
            Self::DegS500 => 500.0,
            Self::DegS250 => 250.0,
            Self::DegS125 => 125.0,
        };
        deg_s * (core::f32::consts::PI / 180.0)
    }

    /// Rate of one count, rad/s.
    pub fn quantum_rad_s(self) -> f32 {
        // Division by a power of two: exact.
        self.full_scale_rad_s() / 32_768.0
    }
}

/// Output data rate and bandwidth of the filter before it, as GYRO_BANDWIDTH pairs them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u8)]
pub enum Bandwidth {
    /// 2000 samples/s, filter 532 Hz.
    Odr2000Filter532 = 0,
    /// 2000 samples/s, filter 230 Hz.
    Odr2000Filter230 = 1,
    /// 1000 samples/s, filter 116 Hz.
    Odr1000Filter116 = 2,
    /// 400 samples/s, filter 47 Hz.
    Odr400Filter47 = 3,
    /// 200 samples/s, filter 23 Hz.
    Odr200Filter23 = 4,
    /// 100 samples/s, filter 12 Hz.
    Odr100Filter12 = 5,
    /// 200 samples/s, filter 64 Hz.
    Odr200Filter64 = 6,
    /// 100 samples/s, filter 32 Hz.
    Odr100Filter32 = 7,
}

/// The pin that announces a new sample, push-pull, high while there is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum DataReadyPin {
    /// INT3.
    Int3,
    /// INT4.
    Int4,
}

impl DataReadyPin {
    /// INT3_INT4_IO_CONF: after a reset both are open-drain (bits 1 and 3) and active high (bits 0
    /// and 2); this one becomes push-pull.
    fn io_conf(self) -> u8 {
        match self {
            Self::Int3 => 0b1101,
            Self::Int4 => 0b0111,
        }
    }

    /// INT3_INT4_IO_MAP: which pin the data-ready interrupt goes to.
    fn io_map(self) -> u8 {
        match self {
            Self::Int3 => 0x01,
            Self::Int4 => 0x80,
        }
    }
}

/// How the chip is set up and mounted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Default ±125 deg/s, the finest: no working spacecraft turns faster.
    pub range: Range,
    /// Default 100 samples/s, the fewest there are, with the faster of the two filters there.
    pub bandwidth: Bandwidth,
    /// Default INT3.
    pub data_ready: DataReadyPin,
    /// Rotation that takes components in sensor axes to components in body axes. Default none.
    pub body_from_sensor: Mat<f32, 3, 3>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            range: Range::DegS125,
            bandwidth: Bandwidth::Odr100Filter32,
            data_ready: DataReadyPin::Int3,
            body_from_sensor: Mat::<f32, 3, 3>::identity(),
        }
    }
}

/// Why the chip can't be set up. `E` is the error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum StartError<E> {
    /// The bus failed.
    Bus(E),
    /// It isn't a BMI088's gyro: GYRO_CHIP_ID should hold 0x0F. 0x00 or 0xFF: nothing answers.
    WrongIdentity {
        /// What the register held.
        found: u8,
    },
    /// A register doesn't hold what was written to it.
    NotAccepted(Differs),
    /// `Settings::body_from_sensor` is no rotation.
    NotARotation,
}

impl<E> From<StartError<E>> for StartFault {
    fn from(error: StartError<E>) -> Self {
        match error {
            StartError::Bus(_) => Self::Bus,
            StartError::WrongIdentity { found } => Self::WrongIdentity { found },
            StartError::NotAccepted(_) => Self::NotAsSet,
            StartError::NotARotation => Self::WrongSettings,
        }
    }
}

/// A register that holds something else than its setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Differs {
    /// Its number.
    pub register: u8,
    /// What it should hold.
    pub expected: u8,
    /// What it holds.
    pub found: u8,
}

/// Why there is no reading. `E` is the error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum ReadError<E> {
    /// The bus failed.
    Bus(E),
    /// The chip has other settings than it was given: it has been reset, or was never set up. Until
    /// [`RateGyro::restart`] it stays so.
    SettingsLost(Differs),
}

/// Why the self-test wasn't passed. `E` is the error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum SelfTestError<E> {
    /// The bus failed.
    Bus(E),
    /// It wasn't over after 0.1 s.
    TimedOut,
    /// The built-in self-test failed.
    Failed,
    /// The check that always runs in the background reports a fault.
    RateNotOk,
}

/// The gyro of a BMI088 on `B`.
#[derive(Debug, Clone, Copy)]
pub struct Bmi088<B> {
    bus: B,
    settings: Settings,
}

impl<B: RegisterBus> Bmi088<B> {
    /// The chip at power-up, without a transaction; [`RateGyro::restart`] sets it up. For a flight
    /// computer that has to live with a gyro that doesn't answer yet.
    pub fn new(bus: B, settings: Settings) -> Self {
        Self { bus, settings }
    }

    /// The chip, set up.
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

    /// Rate in counts, sensor axes, all three of one sample: the chip holds the upper byte of an axis
    /// from when the lower is read, and the burst is shorter than the time between samples.
    ///
    /// # Errors
    /// The error of the bus.
    pub fn counts(&mut self) -> Result<[i16; 3], B::Error> {
        let mut bytes = [0; 6];
        self.bus.read(register::RATE_X_LSB, &mut bytes)?;
        let [x_low, x_high, y_low, y_high, z_low, z_high] = bytes;
        Ok([[x_low, x_high], [y_low, y_high], [z_low, z_high]].map(i16::from_le_bytes))
    }

    /// Whether a sample came less than 280 µs ago, after which the chip clears the flag by itself.
    /// For a board that doesn't have the interrupt pin wired.
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

    /// Each register that is set, with its value and the bits that are read back: the others are
    /// reserved, and bit 7 of GYRO_BANDWIDTH always reads 1.
    fn registers(&self) -> [(u8, u8, u8); 6] {
        let Settings { range, bandwidth, data_ready, .. } = self.settings;
        [
            (register::LPM1, 0x00, 0xA0), // normal mode: neither suspended nor deeply so
            (register::RANGE, range as u8, 0x07),
            (register::BANDWIDTH, bandwidth as u8, 0x0F),
            (register::INT3_INT4_IO_CONF, data_ready.io_conf(), 0x0F),
            (register::INT3_INT4_IO_MAP, data_ready.io_map(), 0x81),
            (register::INT_CTRL, DATA_READY_ON, 0x80),
        ]
    }

    /// Writes every setting, and sees that it is there.
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

    /// Whether the chip still has its range and bandwidth.
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
}

impl<B: RegisterBus> Gyro for Bmi088<B> {
    type Error = ReadError<B::Error>;

    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, Self::Error> {
        let counts = self.counts().map_err(ReadError::Bus)?;
        self.check_settings()?;
        if counts.iter().any(|count| count.unsigned_abs() >= FULL_SCALE.unsigned_abs()) {
            return Ok(Vec3::repeat(SATURATED_RAD_S));
        }
        let quantum_rad_s = self.quantum_rad_s();
        let sensor_rad_s = Vec3::from(counts.map(|count| f32::from(count) * quantum_rad_s));
        Ok(self.settings.body_from_sensor * sensor_rad_s)
    }
}

impl<B: RegisterBus> RateGyro for Bmi088<B> {
    const IDENTITY: u8 = CHIP_ID;

    type StartError = StartError<B::Error>;
    type SelfTestError = SelfTestError<B::Error>;

    /// Nothing is written to a part that isn't the right one.
    fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::StartError> {
        if !is_rotation(&self.settings.body_from_sensor) {
            return Err(StartError::NotARotation);
        }
        delay.delay_ms(RESET_MS);
        let found = self.read_one(register::CHIP_ID).map_err(StartError::Bus)?;
        if found != CHIP_ID {
            return Err(StartError::WrongIdentity { found });
        }
        self.bus.write(register::SOFTRESET, SOFT_RESET).map_err(StartError::Bus)?;
        delay.delay_ms(RESET_MS);
        self.configure(delay)
    }

    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::SelfTestError> {
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

    fn range_rad_s(&self) -> f32 {
        self.quantum_rad_s() * f32::from(FULL_SCALE)
    }

    fn quantum_rad_s(&self) -> f32 {
        self.settings.range.quantum_rad_s()
    }
}

/// Whether `r` turns without stretching or mirroring: `Rᵀ R = 1`, and the third column is the cross
/// product of the first two.
fn is_rotation(r: &Mat<f32, 3, 3>) -> bool {
    let column = |i: usize| Vec3::new(r[(0, i)], r[(1, i)], r[(2, i)]);
    let (x, y, z) = (column(0), column(1), column(2));
    let is_small = |value: f32| value.abs() < ROTATION_TOLERANCE;
    is_small(x.dot(&x) - 1.0)
        && is_small(y.dot(&y) - 1.0)
        && is_small(x.dot(&y))
        && (x.cross(&y) - z).iter().all(|value| is_small(*value))
}

#[cfg(test)]
mod tests;
