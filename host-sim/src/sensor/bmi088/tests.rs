//! The flight driver against the model of the chip, healthy and faulty.

use super::chip::{DATA_READY_US, RESET_US};
use super::*;
use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
use fsw_core::gate::Rejection;
use fsw_core::{Coasting, Estimator, Outcome, Sample, Vec3, WheelArray};
use fsw_target::drivers::gyro::bmi088;
use fsw_target::drivers::gyro::bmi088::{
    Bmi088, Differs, I2C_ADDRESS, Range, ReadError, SELF_TEST_START, SelfTestError, Settings,
    StartError, register,
};
use fsw_target::drivers::gyro::bus::{Spi, TwoWire};
use nalgebra::Vector3;

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

fn measured(driver: &mut Driver) -> Vector3<f64> {
    driver.rate_rad_s().unwrap().map(f64::from).into()
}

fn rate() -> Vector3<f64> {
    Vector3::new(0.1, -1.7, 0.002)
}

#[test]
fn rate_is_read_to_half_a_count() {
    let (wire, mut driver) = started();
    assert!(!wire.chip().int3());
    wire.chip().sample(&rate());
    assert!(wire.chip().int3(), "data ready");
    assert_eq!(driver.is_data_ready(), Ok(true));
    let read = measured(&mut driver);
    assert!((read - rate()).abs().max() < 0.501 * f64::from(driver.quantum_rad_s()), "{read}");
    wire.chip().elapse_us(DATA_READY_US);
    assert_eq!(driver.is_data_ready(), Ok(false));
}

#[test]
fn i2c_reads_the_same_counts() {
    let mut wires = I2cWire::default();
    let bus = TwoWire::new(wires.clone(), I2C_ADDRESS);
    let mut driver = Bmi088::start(bus, Settings::default(), &mut wires).unwrap();
    wires.0.chip().sample(&rate());
    let quantum = f64::from(driver.quantum_rad_s());
    let expected = [rate().x, rate().y, rate().z].map(|rate| (rate / quantum).round() as i16);
    assert_eq!(driver.counts(), Ok(expected));

    let other_address = TwoWire::new(wires.clone(), bmi088::I2C_ADDRESS_SDO2_HIGH);
    let started = Bmi088::start(other_address, Settings::default(), &mut wires);
    assert_eq!(started.err(), Some(StartError::Bus(BusFault)));
}

#[test]
fn every_range_has_its_quantum() {
    for range in Range::ALL {
        let wire = Wire::default();
        let settings = Settings { range, ..Settings::default() };
        let mut driver =
            Bmi088::start(Spi::new(wire.clone()), settings, &mut wire.clone()).unwrap();
        assert_eq!(wire.chip().range(), range);
        wire.chip().sample(&rate());
        let error = measured(&mut driver) - rate();
        assert!(error.abs().max() < 0.501 * f64::from(range.quantum_rad_s()), "{range:?}");
    }
}

#[test]
fn filter_is_that_of_the_bandwidth_in_force() {
    let lag_s = |bandwidth| {
        let wire = Wire::default();
        let settings = Settings { bandwidth, ..Settings::default() };
        Bmi088::start(Spi::new(wire.clone()), settings, &mut wire.clone()).unwrap();
        wire.chip().lag_s()
    };
    // A low-pass filter of first order and 32 Hz has 5.0 ms, of 12 Hz 13.3 ms.
    assert!((lag_s(bmi088::Bandwidth::Odr100Filter32) - 4.97e-3).abs() < 1e-5);
    assert!((lag_s(bmi088::Bandwidth::Odr100Filter12) - 13.26e-3).abs() < 1e-5);
}

#[test]
fn wrong_part_and_missing_part_are_distinguished() {
    let (wire, driver) = start(Faults { identity: 0x1E, ..Faults::default() });
    assert_eq!(driver.err(), Some(StartError::WrongIdentity { found: 0x1E }));
    assert_eq!(wire.chip().transactions(), 1, "no register was written");
    let (_, driver) = start(Faults { is_dead: true, ..Faults::default() });
    assert_eq!(driver.err(), Some(StartError::WrongIdentity { found: 0xFF }));
}

#[test]
fn register_that_ignores_writes_is_named() {
    for register in [register::RANGE, register::BANDWIDTH, register::INT_CTRL] {
        let faults = Faults { stuck_register: Some(register), ..Faults::default() };
        let (_, driver) = start(faults);
        match driver.err() {
            Some(StartError::NotAccepted(differs)) => assert_eq!(differs.register, register),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn driver_restarts_after_a_bus_failure_at_any_transaction() {
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
fn each_self_test_result_is_reported() {
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
fn restart_clears_the_self_test() {
    let (wire, mut driver) = started();
    driver.self_test(&mut wire.clone()).unwrap();
    wire.chip().spi(&[register::SELF_TEST, SELF_TEST_START], &mut []).unwrap();
    wire.chip().sample(&rate());
    assert!((measured(&mut driver) - rate()).norm() > 0.5);
    driver.restart(&mut wire.clone()).unwrap();
    assert_eq!(driver.rate_rad_s(), Ok([0.0; 3]));
    wire.chip().sample(&rate());
    assert!((measured(&mut driver) - rate()).norm() < 1e-4);
}

#[test]
fn reset_in_flight_is_detected_and_repaired() {
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
    assert!((measured(&mut driver) - rate()).norm() < 1e-4);
}

#[test]
fn both_bytes_of_an_axis_are_of_one_sample() {
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

/// A flight estimator with the readings of the driver.
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
            rate_rad_s: driver.rate_rad_s().unwrap().into(),
            wheel_speed_rad_s: [],
            torque_n_m: Vec3::zeros(),
            attitude: None,
        })
    }
}

#[test]
fn saturated_axis_is_rejected_as_out_of_range() {
    let (wire, mut driver) = started();
    let mut flight = Flight::new();
    for saturated in [2.2, -2.2, 100.0] {
        wire.chip().sample(&Vector3::new(0.0, saturated, 0.0));
        let rejected = Outcome::Coasting(Coasting::Rejected(Rejection::OutOfRange));
        assert_eq!(flight.step(&mut driver), rejected);
    }
    wire.chip().sample(&Vector3::new(0.0, 2.18, 0.0));
    assert!(flight.step(&mut driver).used_sample());
}

#[test]
fn stuck_chip_is_rejected_as_stuck() {
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
