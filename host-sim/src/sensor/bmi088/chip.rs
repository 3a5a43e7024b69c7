//! Registers of the chip, BST-BMI088-DS001 section 5.4.

use fsw_target::drivers::gyro::bmi088::{
    DATA_READY, DATA_READY_ON, FULL_SCALE, Range, SELF_TEST_DONE, SELF_TEST_FAILED,
    SELF_TEST_RATE_OK, SELF_TEST_START, SOFT_RESET, register,
};
use nalgebra::Vector3;

use super::faults::{BusFault, Faults, SelfTest};

/// Number of registers: six bits of address.
const REGISTERS: usize = 0x40;
/// Time after a soft reset in which the chip does not respond, µs (GYRO_SOFTRESET).
pub(super) const RESET_US: u64 = 30_000;
/// Time after which the data-ready flag clears itself, µs: the minimum of the data sheet
/// (GYRO_INT_STAT_1).
pub(super) const DATA_READY_US: u64 = 280;
/// Duration of the built-in self-test, µs. The data sheet gives none.
const SELF_TEST_US: u64 = 20_000;
/// Bits of GYRO_LPM1 that suspend the chip.
const SUSPENDED: u8 = 0xA0;
/// Byte read from an undriven bus line.
const FLOATING: u8 = 0xFF;
/// Bandwidth of the low-pass filter by the content of GYRO_BANDWIDTH, Hz.
const BANDWIDTHS_HZ: [f64; 8] = [532.0, 230.0, 116.0, 47.0, 23.0, 12.0, 64.0, 32.0];
/// Bits of GYRO_BANDWIDTH that select data rate and filter.
const BANDWIDTH_BITS: u8 = 0x07;
/// Bit of the SPI command byte that selects a read.
const SPI_READ: u8 = 0x80;

/// Model of the chip.
#[derive(Clone, Debug)]
pub struct Chip {
    /// Faults in force. They may change at any time.
    pub faults: Faults,
    registers: [u8; REGISTERS],
    /// Sampled rate, counts.
    counts: [i16; 3],
    /// Upper byte of each axis, latched by the read of its lower byte.
    latched: [Option<u8>; 3],
    now_us: u64,
    /// Start of the reset in progress.
    reset_us: Option<u64>,
    /// Time of the last sample.
    sampled_us: Option<u64>,
    /// Start of the last self-test.
    self_test_us: Option<u64>,
    transactions: u64,
}

impl Default for Chip {
    fn default() -> Self {
        Self::new(Faults::default())
    }
}

impl Chip {
    /// A chip whose power-up is complete.
    pub fn new(faults: Faults) -> Self {
        let mut chip = Self {
            faults,
            registers: [0; REGISTERS],
            counts: [0; 3],
            latched: [None; 3],
            now_us: 0,
            reset_us: None,
            sampled_us: None,
            self_test_us: None,
            transactions: 0,
        };
        chip.power_up();
        chip
    }

    /// Sets the registers to their values after power-up.
    fn power_up(&mut self) {
        self.registers = [0; REGISTERS];
        self.registers[usize::from(register::BANDWIDTH)] = 0x80;
        self.registers[usize::from(register::INT3_INT4_IO_CONF)] = 0x0F;
        self.counts = [0; 3];
        self.latched = [None; 3];
        self.sampled_us = None;
        self.self_test_us = None;
    }

    /// Resets the chip, as a brown-out or a single-event upset does.
    pub fn reset(&mut self) {
        self.power_up();
        self.reset_us = Some(self.now_us);
    }

    /// Advances time.
    pub fn elapse_us(&mut self, us: u64) {
        self.now_us += us;
        if self.reset_us.is_some_and(|since| self.now_us - since >= RESET_US) {
            self.reset_us = None;
        }
    }

    /// Samples this rate, sensor axes, rad/s: quantised, and saturated at the range. During a
    /// self-test the chip samples the test stimulus instead.
    pub fn sample(&mut self, rate_rad_s: &Vector3<f64>) {
        let is_off = self.reset_us.is_some() || self.register(register::LPM1) & SUSPENDED != 0;
        if is_off || self.faults.is_stuck {
            return;
        }
        if self.is_self_test_running() {
            self.counts = [FULL_SCALE / 2; 3];
            self.sampled_us = Some(self.now_us);
            return;
        }
        let quantum_rad_s = f64::from(self.range().quantum_rad_s());
        let most = f64::from(FULL_SCALE);
        self.counts = [rate_rad_s.x, rate_rad_s.y, rate_rad_s.z]
            .map(|rate| (rate / quantum_rad_s).round().clamp(-most, most) as i16);
        self.sampled_us = Some(self.now_us);
    }

    fn is_self_test_running(&self) -> bool {
        self.self_test_us.is_some_and(|since| self.now_us - since < SELF_TEST_US)
    }

    /// Time constant `1/(2π f)` of the low-pass filter at the bandwidth `f` in force, taken as of first
    /// order, s. It is the caller's filter of the rate between two samples.
    pub fn lag_s(&self) -> f64 {
        let content = self.register(register::BANDWIDTH) & BANDWIDTH_BITS;
        1.0 / (std::f64::consts::TAU * BANDWIDTHS_HZ[usize::from(content)])
    }

    /// Range in force.
    pub fn range(&self) -> Range {
        let value = self.register(register::RANGE) & 0x07;
        Range::from_register(value).unwrap_or(Range::DegS2000)
    }

    /// Level of pin INT3, with the data-ready interrupt mapped to it as a push-pull, active-high
    /// output.
    pub fn int3(&self) -> bool {
        self.has_new_sample()
            && self.register(register::INT_CTRL) & DATA_READY_ON != 0
            && self.register(register::INT3_INT4_IO_MAP) & 0x01 != 0
            && self.register(register::INT3_INT4_IO_CONF) & 0x03 == 0x01
    }

    /// The next transaction ends in a bus error.
    pub fn fail_next_transaction(&mut self) {
        self.faults.bus_fails_in = Some(0);
    }

    /// Number of bus transactions.
    pub fn transactions(&self) -> u64 {
        self.transactions
    }

    fn register(&self, register: u8) -> u8 {
        self.registers.get(usize::from(register)).copied().unwrap_or(0)
    }

    fn has_new_sample(&self) -> bool {
        self.sampled_us.is_some_and(|then| self.now_us - then < DATA_READY_US)
    }

    /// Counts a transaction.
    ///
    /// # Errors
    /// [`BusFault`] at the transaction of [`Faults::bus_fails_in`].
    pub(super) fn begin(&mut self) -> Result<(), BusFault> {
        self.transactions += 1;
        match self.faults.bus_fails_in.take() {
            Some(0) => return Err(BusFault),
            Some(left) => self.faults.bus_fails_in = Some(left - 1),
            None => {}
        }
        Ok(())
    }

    /// One chip select on SPI: command byte and data in, then bytes out. Bit 7 of the command selects
    /// a read, bits 6 to 0 the first register.
    ///
    /// # Errors
    /// [`BusFault`] at the transaction of [`Faults::bus_fails_in`].
    pub fn spi(&mut self, written: &[u8], read: &mut [u8]) -> Result<(), BusFault> {
        self.begin()?;
        read.fill(FLOATING);
        let Some((command, data)) = written.split_first() else { return Ok(()) };
        if self.faults.is_dead {
            return Ok(());
        }
        if command & SPI_READ != 0 {
            self.read(command & !SPI_READ, read);
        } else {
            self.write(*command, data);
        }
        Ok(())
    }

    /// Reads registers upwards from `first`.
    pub(super) fn read(&mut self, first: u8, into: &mut [u8]) {
        for (value, register) in into.iter_mut().zip(first..) {
            *value = self.read_register(register);
        }
    }

    /// Writes registers upwards from `first`.
    pub(super) fn write(&mut self, first: u8, values: &[u8]) {
        for (value, register) in values.iter().zip(first..) {
            self.write_register(register, *value);
        }
    }

    fn read_register(&mut self, register: u8) -> u8 {
        if self.reset_us.is_some() {
            return 0;
        }
        match register {
            register::CHIP_ID => self.faults.identity,
            register::RATE_X_LSB..=0x07 => {
                let byte = usize::from(register - register::RATE_X_LSB);
                self.read_rate(byte / 2, byte % 2 == 1)
            }
            register::INT_STAT_1 if self.has_new_sample() => DATA_READY,
            register::INT_STAT_1 => 0,
            register::BANDWIDTH => self.register(register) | 0x80,
            register::SELF_TEST => self.self_test_result(),
            _ => self.register(register),
        }
    }

    /// The read of a lower byte latches the upper byte until it is read (shadowing of the rate
    /// registers).
    fn read_rate(&mut self, axis: usize, upper: bool) -> u8 {
        let [low, high] = self.counts[axis].to_le_bytes();
        if upper {
            return self.latched[axis].take().unwrap_or(high);
        }
        self.latched[axis] = Some(high);
        low
    }

    fn self_test_result(&self) -> u8 {
        let is_over = self.self_test_us.is_some() && !self.is_self_test_running();
        match (self.faults.self_test, is_over) {
            (SelfTest::Passes, true) => SELF_TEST_DONE | SELF_TEST_RATE_OK,
            (SelfTest::Fails, true) => SELF_TEST_DONE | SELF_TEST_FAILED | SELF_TEST_RATE_OK,
            (SelfTest::RateNotOk, true) => SELF_TEST_DONE,
            (SelfTest::RateNotOk, false) => 0,
            (SelfTest::Hangs, _) | (_, false) => SELF_TEST_RATE_OK,
        }
    }

    fn write_register(&mut self, register: u8, value: u8) {
        if self.reset_us.is_some() || self.faults.stuck_register == Some(register) {
            return;
        }
        match register {
            register::SOFTRESET if value == SOFT_RESET => self.reset(),
            register::SELF_TEST if value & SELF_TEST_START != 0 => {
                self.self_test_us = Some(self.now_us);
            }
            // Read only.
            register::CHIP_ID..=register::INT_STAT_1 => {}
            _ => {
                if let Some(content) = self.registers.get_mut(usize::from(register)) {
                    *content = value;
                }
            }
        }
    }
}
