//! The gyro of a BMI088 as its bus sees it: registers, and what can be wrong with them.
//!
//! In: the true rate in sensor axes, at each sample; bytes on SPI or I²C. Out: bytes, as the data sheet
//! BST-BMI088-DS001 says. So the flight driver runs against it unchanged: [`Wire`] is one end of the
//! wires, an embedded-hal bus and a clock.
//!
//! The model takes in a sample whenever it is told to, whatever the data rate in its register: time is
//! the caller's, and so is noise. It has the registers that the driver touches, and of the rest only
//! that they keep what is written.

use std::cell::{RefCell, RefMut};
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{self, I2c, NoAcknowledgeSource};
use embedded_hal::spi::{self, Operation, SpiDevice};
use fsw_target::drivers::gyro::bmi088::{
    CHIP_ID, DATA_READY, DATA_READY_ON, FULL_SCALE, I2C_ADDRESS, Range, SELF_TEST_DONE,
    SELF_TEST_FAILED, SELF_TEST_RATE_OK, SELF_TEST_START, SOFT_RESET, register,
};
use nalgebra::Vector3;

/// Registers, six bits of address.
const REGISTERS: usize = 0x40;
/// After a soft reset the chip doesn't answer for so long, µs.
const RESET_US: u64 = 30_000;
/// The data-ready flag clears itself after so long, µs: the least of what the data sheet says.
const DATA_READY_US: u64 = 280;
/// How long the built-in self-test takes, µs. The data sheet doesn't say.
const SELF_TEST_US: u64 = 20_000;
/// Bits of GYRO_LPM1 that suspend the chip.
const SUSPENDED: u8 = 0xA0;
/// Of a bus line that nobody drives.
const FLOATING: u8 = 0xFF;

/// What is wrong with a chip. Default: nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Faults {
    /// What GYRO_CHIP_ID holds.
    pub identity: u8,
    /// The rate registers don't change any more.
    pub is_stuck: bool,
    /// It answers nothing: SPI floats, and I²C isn't acknowledged.
    pub is_dead: bool,
    /// The bus fails at this transaction, counted from the next one, which is 0; once.
    pub bus_fails_in: Option<u32>,
    /// A register that doesn't take what is written.
    pub deaf_register: Option<u8>,
    /// How the self-test goes.
    pub self_test: SelfTest,
}

/// How a self-test goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfTest {
    /// Passed.
    Passes,
    /// Over, and failed.
    Fails,
    /// Never over.
    Hangs,
    /// Passed, but the check that always runs sees a fault.
    RateNotOk,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            identity: CHIP_ID,
            is_stuck: false,
            is_dead: false,
            bus_fails_in: None,
            deaf_register: None,
            self_test: SelfTest::Passes,
        }
    }
}

/// The chip.
#[derive(Clone, Debug)]
pub struct Chip {
    /// What is wrong with it; may change in flight.
    pub faults: Faults,
    registers: [u8; REGISTERS],
    counts: [i16; 3],
    /// Upper byte of each axis, held from when its lower one is read.
    held: [Option<u8>; 3],
    now_us: u64,
    /// Since when it has been resetting itself.
    reset_us: Option<u64>,
    sampled_us: Option<u64>,
    self_test_us: Option<u64>,
    transactions: u64,
}

/// The bus failed: the fault [`Faults::bus_fails_in`], or a chip that doesn't acknowledge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFault;

impl Default for Chip {
    fn default() -> Self {
        Self::new(Faults::default())
    }
}

impl Chip {
    /// A chip that has been under power for long.
    pub fn new(faults: Faults) -> Self {
        let mut chip = Self {
            faults,
            registers: [0; REGISTERS],
            counts: [0; 3],
            held: [None; 3],
            now_us: 0,
            reset_us: None,
            sampled_us: None,
            self_test_us: None,
            transactions: 0,
        };
        chip.power_up();
        chip
    }

    /// Registers as after power-up.
    fn power_up(&mut self) {
        self.registers = [0; REGISTERS];
        self.registers[usize::from(register::BANDWIDTH)] = 0x80;
        self.registers[usize::from(register::INT3_INT4_IO_CONF)] = 0x0F;
        self.counts = [0; 3];
        self.held = [None; 3];
        self.sampled_us = None;
        self.self_test_us = None;
    }

    /// It resets itself: a brown-out, or a single event.
    pub fn reset(&mut self) {
        self.power_up();
        self.reset_us = Some(self.now_us);
    }

    /// Time passes.
    pub fn elapse_us(&mut self, us: u64) {
        self.now_us += us;
        if self.reset_us.is_some_and(|since| self.now_us - since >= RESET_US) {
            self.reset_us = None;
        }
    }

    /// A new sample of this rate, sensor axes, rad/s: quantised and held within the range.
    pub fn sample(&mut self, rate_rad_s: &Vector3<f64>) {
        let is_off = self.reset_us.is_some() || self.register(register::LPM1) & SUSPENDED != 0;
        if is_off || self.faults.is_stuck {
            return;
        }
        if self.is_testing_itself() {
            // What it measures is the test.
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

    fn is_testing_itself(&self) -> bool {
        self.self_test_us.is_some_and(|since| self.now_us - since < SELF_TEST_US)
    }

    /// The range in force.
    pub fn range(&self) -> Range {
        let value = self.register(register::RANGE) & 0x07;
        Range::from_register(value).unwrap_or(Range::DegS2000)
    }

    /// Whether pin INT3 is driven high.
    pub fn int3(&self) -> bool {
        self.has_new_sample()
            && self.register(register::INT_CTRL) & DATA_READY_ON != 0
            && self.register(register::INT3_INT4_IO_MAP) & 0x01 != 0
            && self.register(register::INT3_INT4_IO_CONF) & 0x03 == 0x01
    }

    /// How many transactions there have been on the bus.
    pub fn transactions(&self) -> u64 {
        self.transactions
    }

    fn register(&self, register: u8) -> u8 {
        self.registers.get(usize::from(register)).copied().unwrap_or(0)
    }

    fn has_new_sample(&self) -> bool {
        self.sampled_us.is_some_and(|then| self.now_us - then < DATA_READY_US)
    }

    /// One transaction: whether it fails.
    fn begin(&mut self) -> Result<(), BusFault> {
        self.transactions += 1;
        match self.faults.bus_fails_in.take() {
            Some(0) => return Err(BusFault),
            Some(left) => self.faults.bus_fails_in = Some(left - 1),
            None => {}
        }
        Ok(())
    }

    /// One chip select on SPI: these bytes in, then so many out. Bit 7 of the first says read.
    ///
    /// # Errors
    /// A fault that was asked for.
    pub fn spi(&mut self, written: &[u8], read: &mut [u8]) -> Result<(), BusFault> {
        self.begin()?;
        read.fill(FLOATING);
        let Some((command, data)) = written.split_first() else { return Ok(()) };
        if self.faults.is_dead {
            return Ok(());
        }
        if command & 0x80 != 0 {
            self.read(command & 0x7F, read);
        } else {
            self.write(*command, data);
        }
        Ok(())
    }

    /// Registers upwards from this one.
    fn read(&mut self, first: u8, into: &mut [u8]) {
        for (value, register) in into.iter_mut().zip(first..) {
            *value = self.read_register(register);
        }
    }

    fn write(&mut self, first: u8, values: &[u8]) {
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

    /// The lower byte takes the upper one along, which stays until it is read.
    fn read_rate(&mut self, axis: usize, upper: bool) -> u8 {
        let [low, high] = self.counts[axis].to_le_bytes();
        if upper {
            return self.held[axis].take().unwrap_or(high);
        }
        self.held[axis] = Some(high);
        low
    }

    fn self_test_result(&self) -> u8 {
        let is_over = self.self_test_us.is_some() && !self.is_testing_itself();
        match (self.faults.self_test, is_over) {
            (SelfTest::Passes, true) => SELF_TEST_DONE | SELF_TEST_RATE_OK,
            (SelfTest::Fails, true) => SELF_TEST_DONE | SELF_TEST_FAILED | SELF_TEST_RATE_OK,
            (SelfTest::RateNotOk, true) => SELF_TEST_DONE,
            (SelfTest::RateNotOk, false) => 0,
            (SelfTest::Hangs, _) | (_, false) => SELF_TEST_RATE_OK,
        }
    }

    fn write_register(&mut self, register: u8, value: u8) {
        if self.reset_us.is_some() || self.faults.deaf_register == Some(register) {
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
                if let Some(place) = self.registers.get_mut(usize::from(register)) {
                    *place = value;
                }
            }
        }
    }
}

/// One end of the chip's wires: a bus, and a clock that runs while the driver waits.
#[derive(Clone, Debug, Default)]
pub struct Wire(Rc<RefCell<Chip>>);

impl Wire {
    /// The wires of this chip.
    pub fn to(chip: Chip) -> Self {
        Self(Rc::new(RefCell::new(chip)))
    }

    /// The chip at the other end.
    pub fn chip(&self) -> RefMut<'_, Chip> {
        self.0.borrow_mut()
    }
}

impl DelayNs for Wire {
    fn delay_ns(&mut self, ns: u32) {
        self.chip().elapse_us(u64::from(ns.div_ceil(1000)));
    }
}

impl spi::Error for BusFault {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl spi::ErrorType for Wire {
    type Error = BusFault;
}

impl SpiDevice for Wire {
    /// Full duplex isn't modelled: what is written comes first, what is read last, as the gyro has it.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFault> {
        let mut written = Vec::new();
        for operation in operations.iter() {
            if let Operation::Write(bytes) = operation {
                written.extend_from_slice(bytes);
            }
        }
        let mut read = operations.iter_mut().filter_map(|operation| match operation {
            Operation::Read(bytes) => Some(bytes),
            _ => None,
        });
        match read.next() {
            Some(bytes) => self.chip().spi(&written, bytes),
            None => self.chip().spi(&written, &mut []),
        }
    }
}

impl i2c::Error for BusFault {
    fn kind(&self) -> i2c::ErrorKind {
        i2c::ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown)
    }
}

/// The chip's wires on I²C, its pin SDO2 at ground.
#[derive(Clone, Debug, Default)]
pub struct TwoWires(pub Wire);

impl i2c::ErrorType for TwoWires {
    type Error = BusFault;
}

impl I2c for TwoWires {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [i2c::Operation<'_>],
    ) -> Result<(), BusFault> {
        let mut chip = self.0.chip();
        chip.begin()?;
        if address != I2C_ADDRESS || chip.faults.is_dead {
            return Err(BusFault);
        }
        let mut first = 0;
        for operation in operations {
            match operation {
                i2c::Operation::Write(bytes) => {
                    if let Some((register, data)) = bytes.split_first() {
                        first = *register;
                        chip.write(first, data);
                    }
                }
                i2c::Operation::Read(bytes) => chip.read(first, bytes),
            }
        }
        Ok(())
    }
}

/// A clock for a driver on I²C.
impl DelayNs for TwoWires {
    fn delay_ns(&mut self, ns: u32) {
        self.0.delay_ns(ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
    use fsw_core::gate::Rejection;
    use fsw_core::{Coasting, Estimator, Outcome, Sample, Vec3, WheelArray};
    use fsw_target::drivers::gyro::bmi088::{
        Bmi088, Differs, ReadError, SelfTestError, Settings, StartError,
    };
    use fsw_target::drivers::gyro::bus::{Spi, TwoWire};
    use fsw_target::drivers::gyro::{RateGyro, bmi088};
    use fsw_target::flight::sensors::Gyro;

    type Driver = Bmi088<Spi<Wire>>;

    fn start(faults: Faults) -> (Wire, Result<Driver, StartError<BusFault>>) {
        let wire = Wire::to(Chip::new(faults));
        let driver = Bmi088::start(Spi::new(wire.clone()), Settings::default(), &mut wire.clone());
        (wire, driver)
    }

    fn started() -> (Wire, Driver) {
        let (wire, driver) = start(Faults::default());
        (wire, driver.unwrap())
    }

    fn rate() -> Vector3<f64> {
        Vector3::new(0.1, -1.7, 0.002)
    }

    #[test]
    fn the_driver_reads_the_rate_to_half_a_count() {
        let (wire, mut driver) = started();
        assert!(!wire.chip().int3());
        wire.chip().sample(&rate());
        assert!(wire.chip().int3(), "data ready");
        assert_eq!(driver.is_data_ready(), Ok(true));
        let read = driver.rate_rad_s().unwrap().map(f64::from);
        assert!((read - rate()).abs().max() < 0.501 * f64::from(driver.quantum_rad_s()), "{read}");
        wire.chip().elapse_us(DATA_READY_US);
        assert_eq!(driver.is_data_ready(), Ok(false));
    }

    #[test]
    fn on_i2c_it_is_the_same_chip() {
        let mut wires = TwoWires::default();
        let bus = TwoWire::new(wires.clone(), I2C_ADDRESS);
        let mut driver = Bmi088::start(bus, Settings::default(), &mut wires).unwrap();
        wires.0.chip().sample(&rate());
        let quantum = f64::from(driver.quantum_rad_s());
        let expected = [rate().x, rate().y, rate().z].map(|rate| (rate / quantum).round() as i16);
        assert_eq!(driver.counts(), Ok(expected));

        let elsewhere = TwoWire::new(wires.clone(), bmi088::I2C_ADDRESS_SDO2_HIGH);
        let started = Bmi088::start(elsewhere, Settings::default(), &mut wires);
        assert_eq!(started.err(), Some(StartError::Bus(BusFault)));
    }

    #[test]
    fn every_range_is_as_fine_as_it_says() {
        for range in Range::ALL {
            let wire = Wire::default();
            let settings = Settings { range, ..Settings::default() };
            let mut driver =
                Bmi088::start(Spi::new(wire.clone()), settings, &mut wire.clone()).unwrap();
            assert_eq!(wire.chip().range(), range);
            wire.chip().sample(&rate());
            let error = driver.rate_rad_s().unwrap().map(f64::from) - rate();
            assert!(error.abs().max() < 0.501 * f64::from(range.quantum_rad_s()), "{range:?}");
        }
    }

    #[test]
    fn another_part_and_none_at_all_are_told_apart() {
        let (wire, driver) = start(Faults { identity: 0x1E, ..Faults::default() });
        assert_eq!(driver.err(), Some(StartError::WrongIdentity { found: 0x1E }));
        assert_eq!(wire.chip().transactions(), 1, "nothing was written");
        let (_, driver) = start(Faults { is_dead: true, ..Faults::default() });
        assert_eq!(driver.err(), Some(StartError::WrongIdentity { found: 0xFF }));
    }

    #[test]
    fn a_register_that_takes_nothing_is_named() {
        for register in [register::RANGE, register::BANDWIDTH, register::INT_CTRL] {
            let faults = Faults { deaf_register: Some(register), ..Faults::default() };
            let (_, driver) = start(faults);
            match driver.err() {
                Some(StartError::NotAccepted(differs)) => assert_eq!(differs.register, register),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn the_bus_may_fail_at_any_transaction_and_the_driver_starts_the_next_time() {
        let (wire, _) = started();
        let transactions = wire.chip().transactions() as u32;
        for bus_fails_in in 0..transactions {
            let faults = Faults { bus_fails_in: Some(bus_fails_in), ..Faults::default() };
            let wire = Wire::to(Chip::new(faults));
            let mut driver = Bmi088::new(Spi::new(wire.clone()), Settings::default());
            assert_eq!(driver.restart(&mut wire.clone()), Err(StartError::Bus(BusFault)));
            assert_eq!(driver.restart(&mut wire.clone()), Ok(()));
        }
    }

    #[test]
    fn the_self_test_tells_each_end() {
        for (self_test, expected) in [
            (SelfTest::Passes, Ok(())),
            (SelfTest::Fails, Err(SelfTestError::Failed)),
            (SelfTest::RateNotOk, Err(SelfTestError::RateNotOk)),
            (SelfTest::Hangs, Err(SelfTestError::TimedOut)),
        ] {
            let (wire, mut driver) = started();
            wire.chip().faults.self_test = self_test;
            assert_eq!(driver.self_test(&mut wire.clone()), expected);
        }
    }

    #[test]
    fn nothing_of_the_self_test_is_left_after_a_restart() {
        let (wire, mut driver) = started();
        driver.self_test(&mut wire.clone()).unwrap();
        wire.chip().spi(&[register::SELF_TEST, SELF_TEST_START], &mut []).unwrap();
        wire.chip().sample(&rate());
        assert!((driver.rate_rad_s().unwrap().map(f64::from) - rate()).norm() > 0.5);
        driver.restart(&mut wire.clone()).unwrap();
        assert_eq!(driver.rate_rad_s(), Ok(Vec3::zeros()));
        wire.chip().sample(&rate());
        assert!((driver.rate_rad_s().unwrap().map(f64::from) - rate()).norm() < 1e-4);
    }

    #[test]
    fn a_chip_that_resets_itself_in_flight_is_noticed_and_set_up_again() {
        let (wire, mut driver) = started();
        wire.chip().sample(&rate());
        driver.rate_rad_s().unwrap();
        wire.chip().reset();
        wire.chip().elapse_us(RESET_US);
        wire.chip().sample(&rate());
        let differs = Differs { register: register::RANGE, expected: 4, found: 0 };
        assert_eq!(driver.rate_rad_s(), Err(ReadError::SettingsLost(differs)));
        driver.restart(&mut wire.clone()).unwrap();
        wire.chip().sample(&rate());
        assert!(wire.chip().int3());
        assert!((driver.rate_rad_s().unwrap().map(f64::from) - rate()).norm() < 1e-4);
    }

    #[test]
    fn the_two_bytes_of_an_axis_belong_together_even_if_a_sample_comes_between() {
        let (wire, driver) = started();
        let quantum = f64::from(driver.quantum_rad_s());
        let mut chip = wire.chip();
        chip.sample(&Vector3::repeat(255.0 * quantum));
        let mut low = [0];
        chip.spi(&[0x82], &mut low).unwrap();
        chip.sample(&Vector3::repeat(256.0 * quantum));
        let mut high = [0];
        chip.spi(&[0x83], &mut high).unwrap();
        assert_eq!((low, high), ([0xFF], [0x00]));
        chip.spi(&[0x83], &mut high).unwrap();
        assert_eq!(high, [0x01]);
    }

    /// The gate of a flying estimator, fed with what the driver reads.
    struct Flight {
        filter: JointEkfUd<f32, 0>,
        time_us: u64,
    }

    impl Flight {
        fn new() -> Self {
            let wheels = WheelArray::new([], []).unwrap();
            Self { filter: JointEkfUd::new(Config::new(1e-3), wheels).unwrap(), time_us: 0 }
        }

        fn step(&mut self, driver: &mut Driver) -> Outcome {
            self.time_us += 100_000;
            self.filter.step(&Sample {
                time_us: self.time_us,
                rate_rad_s: driver.rate_rad_s().unwrap(),
                wheel_speed_rad_s: [],
                torque_n_m: Vec3::zeros(),
                attitude: None,
            })
        }
    }

    #[test]
    fn a_saturated_axis_is_out_of_range_to_the_estimator() {
        let (wire, mut driver) = started();
        let mut flight = Flight::new();
        for too_fast in [2.2, -2.2, 100.0] {
            wire.chip().sample(&Vector3::new(0.0, too_fast, 0.0));
            let refused = Outcome::Coasting(Coasting::Rejected(Rejection::OutOfRange));
            assert_eq!(flight.step(&mut driver), refused);
        }
        wire.chip().sample(&Vector3::new(0.0, 2.18, 0.0));
        assert!(flight.step(&mut driver).used_sample());
    }

    #[test]
    fn a_stuck_chip_is_noticed_by_the_estimator() {
        let (wire, mut driver) = started();
        let mut flight = Flight::new();
        wire.chip().sample(&rate());
        wire.chip().faults.is_stuck = true;
        let outcomes: Vec<_> = (0..20)
            .map(|k| {
                wire.chip().sample(&(rate() * f64::from(k)));
                flight.step(&mut driver)
            })
            .collect();
        let stuck = Outcome::Coasting(Coasting::Rejected(Rejection::Stuck));
        assert!(outcomes[..10].iter().all(|outcome| *outcome != stuck));
        assert!(outcomes[10..].iter().all(|outcome| *outcome == stuck));
    }
}
