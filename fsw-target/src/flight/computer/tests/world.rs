//! Simulated parts of a flight computer, and a ground station that commands it.

extern crate std;
use super::super::*;
use crate::flight::manoeuvre::Manoeuvre;
use crate::flight::sensors::WheelMotors;
use crate::flight::supervisor::FeedPermit;
use crate::link::Receiver;
use crate::link::authentication::Key;
use crate::link::frame::Frame;
use crate::link::packet::SequenceCount;
use crate::link::telemetry::{BrownOutLevel, ClockSource, Received, ResetCause, Telemetry};
use crate::runtime::failure::LastRun;
use crate::stand_in::recording::cubesat_pyramid::CRAFT;
use crate::stand_in::recording::{Recording, Row};
use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal_nb::serial::{ErrorType, Write};
use embedded_storage::nor_flash::{
    ErrorType as FlashErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use fsw_core::Prior;
use fsw_core::Vec3;
use std::boxed::Box;
use std::collections::VecDeque;
use std::rc::Rc;
use std::vec;
use std::vec::Vec;

/// State that the test shares with the parts of the computer: link, gyro, time, flash.
#[derive(Default)]
pub struct World {
    pub to_computer: RefCell<VecDeque<u8>>,
    pub from_computer: RefCell<VecDeque<u8>>,
    pub gyro_is_absent: Cell<bool>,
    pub gyro_starts: Cell<u32>,
    pub gyro_is_set_up: Cell<bool>,
    pub gyro_fails_its_test: Cell<bool>,
    /// A sample of the self-test is pending.
    pub test_sample_pending: Cell<bool>,
    pub wheels_fail: Cell<bool>,
    pub now_us: Cell<u64>,
    pub feeds: Cell<u32>,
    pub flash: RefCell<Vec<u8>>,
    pub erasures: Cell<u32>,
    /// Duration of an erasure, µs.
    pub erasure_us: Cell<u64>,
    /// Duration of the reading of 32 bytes of flash, µs.
    pub chunk_us: Cell<u64>,
    /// Duration of a start of the gyro and of its self-test, µs.
    pub gyro_start_us: Cell<u64>,
    /// Flash of the telecommand counters.
    pub counters: RefCell<Vec<u8>>,
    /// Writes of counters fail.
    pub counters_fail: Cell<bool>,
    /// Time of the last feed of the watchdog, and the longest time between two, µs.
    pub fed_us: Cell<u64>,
    pub longest_us: Cell<u64>,
    pub short_lives: Cell<u32>,
    pub reboots: Cell<u32>,
    pub long_lives: Cell<u32>,
    /// Torque of the motors, N m.
    pub motors_n_m: Cell<[f32; WHEELS]>,
}

impl World {
    /// With this content of the flash of checkpoints, and erased counters.
    pub fn with(flash: Vec<u8>) -> Self {
        let counters = RefCell::new(vec![0xff; COUNTERS]);
        Self { flash: RefCell::new(flash), counters, ..Self::default() }
    }

    fn elapse_us(&self, us: u64) {
        self.now_us.set(self.now_us.get() + us);
    }
}

/// A part of the computer: a handle to the shared state.
#[derive(Clone)]
pub struct Part(pub Rc<World>);

/// Gyro of the recording, which can be absent.
pub struct RecordedGyro(&'static Recording<'static, WHEELS>, Part);

/// Time stamps of the recording and of self-test samples.
pub struct RecordedDataReady(&'static Recording<'static, WHEELS>, Part);

/// Wheels of the recording, which can fail.
pub struct RecordedWheels(&'static Recording<'static, WHEELS>, Part);

pub struct TestParts;

impl Parts for TestParts {
    type DataReady = RecordedDataReady;
    type Gyro = RecordedGyro;
    type Wheels = RecordedWheels;
    type Torque = &'static Recording<'static, WHEELS>;
    type Link = Part;
    type Flash = Part;
    type CounterFlash = CounterPart;
    type Board = Part;
}

impl crate::flight::sensors::Gyro for RecordedGyro {
    type Error = ();

    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, ()> {
        if !self.1.0.gyro_is_set_up.get() {
            return Err(());
        }
        self.0.rate_rad_s().map_err(|_| ())
    }
}

impl DataReady for RecordedDataReady {
    fn take_us(&mut self) -> Option<u64> {
        assert!(!self.1.0.test_sample_pending.get(), "a self-test sample is stepped");
        self.0.take_us()
    }

    fn has_newer(&mut self) -> bool {
        self.0.has_newer()
    }

    fn discard(&mut self) {
        self.1.0.test_sample_pending.set(false);
    }

    fn overruns(&self) -> u32 {
        self.0.overruns()
    }
}

impl WheelTachometers<WHEELS> for RecordedWheels {
    type Error = ();

    fn speed_rad_s(&mut self) -> Result<[f32; WHEELS], ()> {
        if self.1.0.wheels_fail.get() {
            return Err(());
        }
        self.0.speed_rad_s().map_err(|_| ())
    }
}

impl RateGyro for RecordedGyro {
    const IDENTITY: u8 = 0x42;
    type StartError = StartFault;
    type SelfTestError = ();

    fn restart(&mut self, _: &mut impl DelayNs) -> Result<(), StartFault> {
        let world = &self.1.0;
        world.gyro_starts.set(world.gyro_starts.get() + 1);
        world.elapse_us(world.gyro_start_us.get());
        world.gyro_is_set_up.set(!world.gyro_is_absent.get());
        match world.gyro_is_absent.get() {
            true => Err(StartFault::WrongIdentity { found: 0xff }),
            false => Ok(()),
        }
    }

    fn self_test(&mut self, _: &mut impl DelayNs) -> Result<(), ()> {
        self.1.0.test_sample_pending.set(true);
        self.1.0.elapse_us(self.1.0.gyro_start_us.get());
        if self.1.0.gyro_fails_its_test.get() { Err(()) } else { Ok(()) }
    }

    fn range_rad_s(&self) -> f32 {
        1.0
    }

    fn quantum_rad_s(&self) -> f32 {
        1e-5
    }
}

impl ErrorType for Part {
    type Error = Infallible;
}

impl Read for Part {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        self.0.to_computer.borrow_mut().pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl Write for Part {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        self.0.from_computer.borrow_mut().push_back(byte);
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        Ok(())
    }
}

#[derive(Debug)]
pub struct Beyond;

impl NorFlashError for Beyond {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

/// Flash of the telecommand counters.
pub struct CounterPart(Rc<World>);

/// Bytes of a flash from `offset` on.
fn cells(flash: &mut [u8], offset: u32, length: usize) -> Result<&mut [u8], Beyond> {
    flash.get_mut(offset as usize..offset as usize + length).ok_or(Beyond)
}

/// Flash memory in the cell `$cell` of the world.
macro_rules! flash {
    ($part:ident, $cell:ident, $world:ident => $fails:expr) => {
        impl FlashErrorType for $part {
            type Error = Beyond;
        }

        impl ReadNorFlash for $part {
            const READ_SIZE: usize = 1;

            fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Beyond> {
                self.0.elapse_us(self.0.chunk_us.get() * bytes.len() as u64 / 32);
                let mut flash = self.0.$cell.borrow_mut();
                bytes.copy_from_slice(cells(&mut flash, offset, bytes.len())?);
                Ok(())
            }

            fn capacity(&self) -> usize {
                self.0.$cell.borrow().len()
            }
        }

        impl NorFlash for $part {
            const WRITE_SIZE: usize = 4;
            const ERASE_SIZE: usize = 1024;

            fn erase(&mut self, from: u32, to: u32) -> Result<(), Beyond> {
                let mut flash = self.0.$cell.borrow_mut();
                cells(&mut flash, from, (to - from) as usize)?.fill(0xff);
                self.0.erasures.set(self.0.erasures.get() + 1);
                self.0.elapse_us(self.0.erasure_us.get());
                Ok(())
            }

            fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Beyond> {
                let $world = &self.0;
                if $fails {
                    return Err(Beyond);
                }
                let mut flash = self.0.$cell.borrow_mut();
                let to = cells(&mut flash, offset, bytes.len())?;
                to.iter_mut().zip(bytes).for_each(|(to, byte)| *to &= byte);
                Ok(())
            }
        }
    };
}

flash!(Part, flash, _world => false);
flash!(CounterPart, counters, world => world.counters_fail.get());

impl WheelMotors<WHEELS> for Part {
    fn set_torque_n_m(&mut self, torque_n_m: &[f32; WHEELS]) -> bool {
        self.0.motors_n_m.set(*torque_n_m);
        true
    }
}

impl DelayNs for Part {
    fn delay_ns(&mut self, _: u32) {}
}

impl Housekeeping for Part {
    type Delay = Self;
    type Motors = Self;

    fn now_us(&mut self) -> u64 {
        self.0.now_us.get()
    }

    fn resume_at(&mut self, time_us: u64) {
        self.0.now_us.set(self.0.now_us.get().max(time_us));
    }

    fn delay(&mut self) -> &mut Self {
        self
    }

    fn motors(&mut self) -> &mut Self {
        self
    }

    fn feed(&mut self, _: FeedPermit) {
        let now_us = self.0.now_us.get();
        let since_us = now_us.saturating_sub(self.0.fed_us.replace(now_us));
        self.0.longest_us.set(self.0.longest_us.get().max(since_us));
        self.0.feeds.set(self.0.feeds.get() + 1);
    }

    fn health(&mut self) -> Health {
        Health {
            reset_cause: ResetCause::PowerOn,
            last_run: LastRun { short_lives: self.0.short_lives.get(), ..LastRun::default() },
            brown_out: BrownOutLevel::Level3,
            option_bytes_as_set: true,
            supply_low: false,
            clock: ClockSource::Crystal,
            watchdog: true,
            stack_high_water_bytes: 0,
            serial_errors: 0,
        }
    }

    fn note_long_life(&mut self) {
        self.0.long_lives.set(self.0.long_lives.get() + 1);
    }

    fn reboot(&mut self) {
        self.0.reboots.set(self.0.reboots.get() + 1);
    }
}

/// A computer and its ground station.
pub struct Ground {
    pub world: Part,
    pub computer: Computer<'static, TestParts>,
    pub receiver: Receiver,
    pub sequence_count: SequenceCount,
    /// Master key, slot and last counter of the telecommands.
    pub key: Option<(Key, u8, u32)>,
}

impl Ground {
    /// A started computer with these samples and this content of the flash.
    pub fn new(rows: &'static [Row<WHEELS>], flash: Vec<u8>, reporting: Reporting) -> Self {
        Self::start(rows, World::with(flash), reporting, None)
    }

    pub fn with_gyro(
        rows: &'static [Row<WHEELS>],
        flash: Vec<u8>,
        reporting: Reporting,
        is_present: bool,
    ) -> Self {
        let world = World::with(flash);
        world.gyro_is_absent.set(!is_present);
        Self::start(rows, world, reporting, None)
    }

    /// A started computer in this world, with a master key or without.
    pub fn start(
        rows: &'static [Row<WHEELS>],
        world: World,
        reporting: Reporting,
        master: Option<Key>,
    ) -> Self {
        let world = Part(Rc::new(world));
        let recording: &'static _ = Box::leak(Box::new(Recording::new(rows)));
        let sensors = crate::flight::flight_loop::Sensors {
            data_ready: RecordedDataReady(recording, world.clone()),
            gyro: RecordedGyro(recording, world.clone()),
            wheels: RecordedWheels(recording, world.clone()),
            torque: recording,
        };
        let estimator = Box::leak(Box::new(SelectedEstimator::new(CRAFT).unwrap()));
        let security = Security { flash: CounterPart(Rc::clone(&world.0)), master };
        let spin_inertia_kg_m2 = estimator.craft().spin_inertia_kg_m2;
        let manoeuvre = Box::leak(Box::new(Manoeuvre::new(spin_inertia_kg_m2)));
        let mut computer = Computer::new(
            (estimator, manoeuvre),
            sensors,
            world.clone(),
            world.clone(),
            security,
            world.clone(),
            reporting,
        );
        computer.start();
        Self {
            world,
            computer,
            receiver: Receiver::default(),
            sequence_count: SequenceCount::new(0),
            key: master.map(|master| (master, 1, 0)),
        }
    }

    /// Polls the computer every 0.1 s and returns its telemetry.
    pub fn poll(&mut self, times: u32) -> Vec<Telemetry> {
        for _ in 0..times {
            self.world.0.now_us.set(self.world.0.now_us.get() + 100_000);
            self.computer.poll();
        }
        let bytes: Vec<u8> = self.world.0.from_computer.borrow_mut().drain(..).collect();
        let received = bytes.into_iter().filter_map(|byte| self.receiver.push(byte));
        received.map(|received| -> Received { received.unwrap() }).map(|r| r.telemetry).collect()
    }

    /// Frame of the next telecommand.
    pub fn next_frame(&mut self, command: Command) -> Frame {
        let packet = match &mut self.key {
            Some((master, slot, counter)) => {
                *counter += 1;
                self.sequence_count = SequenceCount::new(*counter as u16);
                command.tagged_packet(&master.of_slot(*slot, 0), *slot, *counter).unwrap()
            }
            None => {
                self.sequence_count = crate::link::packet::next(self.sequence_count);
                command.packet(self.sequence_count).unwrap()
            }
        };
        Frame::of(packet.bytes()).unwrap()
    }

    /// Sends bytes on the line.
    pub fn send(&self, bytes: &[u8]) {
        self.world.0.to_computer.borrow_mut().extend(bytes);
    }

    /// Sends a telecommand and returns its status report.
    pub fn command(&mut self, command: Command) -> StatusReport {
        let frame = self.next_frame(command);
        self.send(frame.bytes());
        let sent = self.poll(1);
        let status = statuses(&sent).last().copied().expect("a status report");
        assert_eq!(status.last_command, Some(command.function()));
        assert_eq!(status.last_sequence_count, self.sequence_count.value());
        status
    }
}

pub fn statuses(sent: &[Telemetry]) -> Vec<StatusReport> {
    sent.iter()
        .filter_map(|telemetry| match telemetry {
            Telemetry::Status(status) => Some(*status),
            _ => None,
        })
        .collect()
}

pub fn estimates(sent: &[Telemetry]) -> Vec<EstimateReport> {
    sent.iter()
        .filter_map(|telemetry| match telemetry {
            Telemetry::Estimate(estimate) => Some(*estimate),
            _ => None,
        })
        .collect()
}

pub const PRIOR: Prior<f32> = Prior {
    inertia_kg_m2: [0.06, 0.1, 0.12, 0.0, 0.0, 0.0],
    sigma_kg_m2: [0.02, 0.02, 0.02, 0.005, 0.005, 0.005],
};

/// Flash size, bytes: each half holds a checkpoint of `window`.
pub const FLASH: usize = 128 * 1024;

pub fn erased() -> Vec<u8> {
    vec![0xff; FLASH]
}

/// Size of the flash of counters, bytes: two halves of ten records.
pub const COUNTERS: usize = 2048;
