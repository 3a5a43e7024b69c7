//! The driver on scripted buses: the bytes on the bus, and the response to each fault.

extern crate std;

use super::bus::{Spi, TwoWire};
use super::*;
use embedded_hal::spi::{self, Operation, SpiDevice};
use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::i2c::{Mock as I2cMock, Transaction as I2cTransaction};
use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction as SpiTransaction};
use std::vec::Vec;

type Script = Vec<SpiTransaction<u8>>;

/// Write of one register on SPI, with chip select.
fn write(register: u8, value: u8) -> Script {
    std::vec![
        SpiTransaction::transaction_start(),
        SpiTransaction::write_vec(std::vec![register, value]),
        SpiTransaction::transaction_end(),
    ]
}

/// Read on SPI of consecutive registers, with the answer.
fn read(register: u8, values: &[u8]) -> Script {
    std::vec![
        SpiTransaction::transaction_start(),
        SpiTransaction::write_vec(std::vec![register | 0x80]),
        SpiTransaction::read_vec(values.to_vec()),
        SpiTransaction::transaction_end(),
    ]
}

/// Start with the default settings, in the numbers of the data sheet.
fn start_script() -> Script {
    [
        read(0x00, &[0x0F]),
        write(0x14, 0xB6),
        write(0x11, 0x00),
        read(0x11, &[0x00]),
        write(0x0F, 0x04), // 125 deg/s
        read(0x0F, &[0x04]),
        write(0x10, 0x07), // 100 Hz, filter 32 Hz
        read(0x10, &[0x87]),
        write(0x16, 0x0D), // INT3 push-pull, active high
        read(0x16, &[0x0D]),
        write(0x18, 0x01), // data ready on INT3
        read(0x18, &[0x01]),
        write(0x15, 0x80),
        read(0x15, &[0x80]),
    ]
    .concat()
}

/// Reading: the counts of one sample, then range and bandwidth.
fn reading_script(bytes: [u8; 6]) -> Script {
    [read(0x02, &bytes), read(0x0F, &[0x04, 0x87])].concat()
}

fn gyro(script: &Script) -> (Bmi088<Spi<SpiMock<u8>>>, SpiMock<u8>) {
    let mock = SpiMock::new(script);
    (Bmi088::new(Spi::new(mock.clone()), Settings::default()), mock)
}

/// Starts a chip that answers with `script`, to its last step.
fn start(script: &Script) -> Result<(), StartError<spi::ErrorKind>> {
    let (mut gyro, mut mock) = gyro(script);
    let result = gyro.restart(&mut NoopDelay::new());
    mock.done();
    result
}

/// Rate of one sample with these counts.
fn rate_of(counts: [i16; 3], settings: Settings) -> [f32; 3] {
    let [x, y, z] = counts.map(i16::to_le_bytes);
    let script = reading_script([x[0], x[1], y[0], y[1], z[0], z[1]]);
    let mut mock = SpiMock::new(&script);
    let rate = Bmi088::new(Spi::new(mock.clone()), settings).rate_rad_s().unwrap();
    mock.done();
    rate
}

#[test]
fn start_writes_the_bytes_of_the_data_sheet() {
    assert_eq!(start(&start_script()), Ok(()));
}

#[test]
fn i2c_writes_the_same_registers() {
    let write = |register, value| I2cTransaction::write(0x68, std::vec![register, value]);
    let read = |register, values: &[u8]| {
        I2cTransaction::write_read(0x68, std::vec![register], values.to_vec())
    };
    let script = [
        read(0x00, &[0x0F]),
        write(0x14, 0xB6),
        write(0x11, 0x00),
        read(0x11, &[0x00]),
        write(0x0F, 0x04),
        read(0x0F, &[0x04]),
        write(0x10, 0x07),
        read(0x10, &[0x87]),
        write(0x16, 0x0D),
        read(0x16, &[0x0D]),
        write(0x18, 0x01),
        read(0x18, &[0x01]),
        write(0x15, 0x80),
        read(0x15, &[0x80]),
        read(0x02, &[0x01, 0x00, 0xFE, 0xFF, 0x00, 0x01]),
    ];
    let mut mock = I2cMock::new(&script);
    let bus = TwoWire::new(mock.clone(), I2C_ADDRESS);
    let mut gyro = Bmi088::start(bus, Settings::default(), &mut NoopDelay::new()).unwrap();
    assert_eq!(gyro.counts(), Ok([1, -2, 256]));
    mock.done();
}

#[test]
fn wrong_identity_is_reported_and_nothing_is_written() {
    for found in [0x00, 0x1E, 0xFF] {
        assert_eq!(start(&read(0x00, &[found])), Err(StartError::WrongIdentity { found }));
    }
}

#[test]
fn setting_that_does_not_read_back_is_named() {
    let mut script = start_script();
    script.truncate(read(0, &[0]).len() + 3 * write(0, 0).len() + read(0, &[0]).len());
    script.extend(read(0x0F, &[0x00]));
    let differs = Differs { register: 0x0F, expected: 0x04, found: 0x00 };
    assert_eq!(start(&script), Err(StartError::NotAccepted(differs)));
}

#[test]
fn mounting_that_is_no_rotation_is_rejected() {
    let diagonal = |x, y, z| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
    let mut broken = diagonal(1.0, 1.0, 1.0);
    broken[1][0] = f32::NAN;
    let [larger, mirrored, zero] =
        [diagonal(1.001, 1.001, 1.001), diagonal(1.0, 1.0, -1.0), diagonal(0.0, 0.0, 0.0)];
    for matrix in [larger, mirrored, broken, zero] {
        let settings = Settings { body_from_sensor: matrix, ..Settings::default() };
        let mut mock = SpiMock::new(&[]);
        let started = Bmi088::start(Spi::new(mock.clone()), settings, &mut NoopDelay::new());
        assert_eq!(started.err(), Some(StartError::NotARotation));
        mock.done();
    }
}

#[test]
fn counts_scale_with_the_range() {
    for range in Range::ALL {
        let settings = Settings { range, ..Settings::default() };
        let script = [read(0x02, &[0, 0x40, 0, 0xC0, 1, 0]), read(0x0F, &[range as u8, 0x87])];
        let mut mock = SpiMock::new(&script.concat());
        let rate = Bmi088::new(Spi::new(mock.clone()), settings).rate_rad_s().unwrap();
        mock.done();
        let half = range.full_scale_rad_s() / 2.0;
        assert_eq!(rate, [half, -half, half / 16_384.0]);
    }
    // Data sheet: 16.384 counts per deg/s at ±2000 deg/s.
    let deg_s = 1.0f32.to_radians();
    assert!((deg_s / Range::DegS2000.quantum_rad_s() - 16.384).abs() < 1e-4);
}

#[test]
fn rates_are_rotated_into_body_axes() {
    // The sensor's x axis is the body's −y axis, its y axis the body's x axis.
    let body_from_sensor = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let settings = Settings { body_from_sensor, ..Settings::default() };
    let quantum = settings.range.quantum_rad_s();
    let rate = rate_of([100, 20, -3], settings);
    assert_eq!(rate, [20.0, -100.0, -3.0].map(|count: f32| count * quantum));
}

#[test]
fn saturated_axis_puts_the_whole_reading_out_of_range() {
    for counts in [[32_767, 0, 0], [0, -32_767, 0], [0, 0, i16::MIN]] {
        let rate = rate_of(counts, Settings::default());
        assert_eq!(rate, [SATURATED_RAD_S; 3]);
    }
    let [x, y, _] = rate_of([32_766, -32_766, 0], Settings::default());
    assert!(x < 2.19 && x > 2.18 && y == -x, "{x} {y}");
}

#[test]
fn chip_that_reset_itself_gives_no_reading() {
    // After a reset: ±2000 deg/s, 2000 Hz with a filter of 532 Hz.
    let (mut gyro, mut mock) = gyro(&[read(0x02, &[9; 6]), read(0x0F, &[0x00, 0x80])].concat());
    let differs = Differs { register: 0x0F, expected: 0x04, found: 0x00 };
    assert_eq!(gyro.rate_rad_s(), Err(ReadError::SettingsLost(differs)));
    mock.done();

    let (mut gyro, mut mock) = self::gyro(&[read(0x02, &[9; 6]), read(0x0F, &[4, 0x85])].concat());
    let differs = Differs { register: 0x10, expected: 0x07, found: 0x05 };
    assert_eq!(gyro.rate_rad_s(), Err(ReadError::SettingsLost(differs)));
    mock.done();
}

#[test]
fn self_test_ends_with_the_chip_or_after_its_time_limit() {
    let begin = || write(0x3C, 0x01);
    let poll = |value| read(0x3C, &[value]);
    let test = |script: Script| {
        let (mut gyro, mut mock) = gyro(&script);
        let result = gyro.self_test(&mut NoopDelay::new());
        mock.done();
        result
    };
    assert_eq!(test([begin(), poll(0x10), poll(0x10), poll(0x12)].concat()), Ok(()));
    assert_eq!(test([begin(), poll(0x16)].concat()), Err(SelfTestError::Failed));
    assert_eq!(test([begin(), poll(0x02)].concat()), Err(SelfTestError::RateNotOk));
    let polls: Script = (0..20).flat_map(|_| poll(0x10)).collect();
    assert_eq!(test([begin(), polls].concat()), Err(SelfTestError::TimedOut));
}

#[test]
fn data_ready_flag_is_bit_7() {
    let (mut gyro, mut mock) = gyro(&[read(0x0A, &[0x80]), read(0x0A, &[0x7F])].concat());
    assert_eq!(gyro.is_data_ready(), Ok(true));
    assert_eq!(gyro.is_data_ready(), Ok(false));
    mock.done();
}

/// A bus that fails at one transaction; the SPI mock of embedded-hal-mock cannot fail.
struct FailsAt<D> {
    device: D,
    transactions_left: usize,
}

/// Error of the failing bus.
const BUS_ERROR: spi::ErrorKind = spi::ErrorKind::ModeFault;

impl<D: SpiDevice<Error = spi::ErrorKind>> spi::ErrorType for FailsAt<D> {
    type Error = spi::ErrorKind;
}

impl<D: SpiDevice<Error = spi::ErrorKind>> SpiDevice for FailsAt<D> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusError> {
        self.transactions_left = self.transactions_left.checked_sub(1).ok_or(BUS_ERROR)?;
        self.device.transaction(operations)
    }
}

type BusError = spi::ErrorKind;

/// Transactions of a script.
fn transactions(script: &Script) -> Vec<Script> {
    let end = SpiTransaction::transaction_end();
    script.split_inclusive(|step| *step == end).map(<[_]>::to_vec).collect()
}

/// A driver with a bus that works for the first `count` transactions of the script.
fn failing_after(count: usize, script: &Script) -> Bmi088<Spi<FailsAt<SpiMock<u8>>>> {
    let until = transactions(script)[..count].concat();
    let device = FailsAt { device: SpiMock::new(&until), transactions_left: count };
    Bmi088::new(Spi::new(device), Settings::default())
}

/// Checks that the mock's script is complete.
fn done(gyro: Bmi088<Spi<FailsAt<SpiMock<u8>>>>) {
    let Bmi088 { bus, .. } = gyro;
    bus.into_device().device.done();
}

#[test]
fn bus_error_passes_through_from_every_transaction() {
    let script = start_script();
    assert_eq!(transactions(&script).len(), 14);
    for count in 0..transactions(&script).len() {
        let mut gyro = failing_after(count, &script);
        let result = gyro.restart(&mut NoopDelay::new());
        assert_eq!(result, Err(StartError::Bus(BUS_ERROR)), "transaction {count}");
        done(gyro);
    }
    let script = reading_script([0; 6]);
    for count in 0..transactions(&script).len() {
        let mut gyro = failing_after(count, &script);
        assert_eq!(gyro.rate_rad_s(), Err(ReadError::Bus(BUS_ERROR)), "transaction {count}");
        done(gyro);
    }
    let script = [write(0x3C, 0x01), read(0x3C, &[0x12])].concat();
    for count in 0..transactions(&script).len() {
        let mut gyro = failing_after(count, &script);
        let result = gyro.self_test(&mut NoopDelay::new());
        assert_eq!(result, Err(SelfTestError::Bus(BUS_ERROR)), "transaction {count}");
        done(gyro);
    }
}

#[test]
fn bus_error_on_i2c_passes_through() {
    use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
    let error = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
    let read = I2cTransaction::write_read(0x69, std::vec![0x00], std::vec![0x0F]);
    let mut mock = I2cMock::new(&[read.with_error(error)]);
    let bus = TwoWire::new(mock.clone(), I2C_ADDRESS_SDO2_HIGH);
    let started = Bmi088::start(bus, Settings::default(), &mut NoopDelay::new());
    assert_eq!(started.err(), Some(StartError::Bus(error)));
    mock.done();
}

#[test]
fn undriven_bus_is_no_rate() {
    let (mut gyro, mut mock) = gyro(&read(0x02, &[0xFF; 6]));
    assert_eq!(gyro.rate_rad_s(), Err(ReadError::NoAnswer));
    mock.done();
    let [x, y, z] = rate_of([-1, -1, 0], Settings::default());
    assert!(x == y && x < 0.0 && z == 0.0, "one count is a rate");
}

#[test]
fn delay_is_that_of_the_filter_unless_it_was_measured() {
    let delay_us = |bandwidth: Bandwidth| bandwidth.delay_us();
    assert_eq!(delay_us(Bandwidth::Odr100Filter32), 4_973);
    assert_eq!(delay_us(Bandwidth::Odr100Filter12), 13_262);
    let settings = Settings { delay_us: 6_200, ..Settings::default() };
    let mut mock = SpiMock::new(&[]);
    assert_eq!(Bmi088::new(Spi::new(mock.clone()), settings).delay_us(), 6_200);
    mock.done();
}
