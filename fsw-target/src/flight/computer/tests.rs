//! The flight computer on simulated parts, commanded by a simulated ground station.

extern crate std;
use super::*;
use crate::flight::selected::EstimatorId;
use crate::flight::supervisor::FeedPermit;
use crate::link::Receiver;
use crate::link::frame::Frame;
use crate::link::packet::SequenceCount;
use crate::link::telemetry::{CheckpointState, ClockSource, Received, ResetCause, Telemetry};
use crate::runtime::failure::LastRun;
use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};
use crate::stand_in::recording::{Recording, Row};
use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal_nb::serial::{ErrorType, Write};
use embedded_storage::nor_flash::{
    ErrorType as FlashErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use fsw_core::Prior;
use fsw_core::{Estimator, Status, Vec3};
use std::boxed::Box;
use std::collections::VecDeque;
use std::rc::Rc;
use std::vec;
use std::vec::Vec;

/// State that the test shares with the parts of the computer: link, gyro, time, flash.
#[derive(Default)]
struct World {
    to_computer: RefCell<VecDeque<u8>>,
    from_computer: RefCell<VecDeque<u8>>,
    gyro_is_absent: Cell<bool>,
    gyro_starts: Cell<u32>,
    gyro_is_set_up: Cell<bool>,
    gyro_fails_its_test: Cell<bool>,
    /// A sample of the self-test is pending.
    test_sample_pending: Cell<bool>,
    wheels_fail: Cell<bool>,
    now_us: Cell<u64>,
    feeds: Cell<u32>,
    flash: RefCell<Vec<u8>>,
    erasures: Cell<u32>,
    /// Duration of an erasure, µs.
    erasure_us: Cell<u64>,
}

/// A part of the computer: a handle to the shared state.
#[derive(Clone)]
struct Part(Rc<World>);

/// Gyro of the recording, which can be absent.
struct RecordedGyro(&'static Recording<'static, WHEELS>, Part);

/// Time stamps of the recording and of self-test samples.
struct RecordedDataReady(&'static Recording<'static, WHEELS>, Part);

/// Wheels of the recording, which can fail.
struct RecordedWheels(&'static Recording<'static, WHEELS>, Part);

struct TestParts;

impl Parts for TestParts {
    type DataReady = RecordedDataReady;
    type Gyro = RecordedGyro;
    type Wheels = RecordedWheels;
    type Torque = &'static Recording<'static, WHEELS>;
    type Link = Part;
    type Flash = Part;
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

impl crate::flight::sensors::WheelTachometers<WHEELS> for RecordedWheels {
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
        world.gyro_is_set_up.set(!world.gyro_is_absent.get());
        match world.gyro_is_absent.get() {
            true => Err(StartFault::WrongIdentity { found: 0xff }),
            false => Ok(()),
        }
    }

    fn self_test(&mut self, _: &mut impl DelayNs) -> Result<(), ()> {
        self.1.0.test_sample_pending.set(true);
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
struct Beyond;

impl NorFlashError for Beyond {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl FlashErrorType for Part {
    type Error = Beyond;
}

impl ReadNorFlash for Part {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Beyond> {
        let flash = self.0.flash.borrow();
        let from = flash.get(offset as usize..offset as usize + bytes.len()).ok_or(Beyond)?;
        bytes.copy_from_slice(from);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.flash.borrow().len()
    }
}

impl NorFlash for Part {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Beyond> {
        let mut flash = self.0.flash.borrow_mut();
        flash.get_mut(from as usize..to as usize).ok_or(Beyond)?.fill(0xff);
        self.0.erasures.set(self.0.erasures.get() + 1);
        self.0.now_us.set(self.0.now_us.get() + self.0.erasure_us.get());
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Beyond> {
        let mut flash = self.0.flash.borrow_mut();
        let to = flash.get_mut(offset as usize..offset as usize + bytes.len()).ok_or(Beyond)?;
        to.iter_mut().zip(bytes).for_each(|(to, byte)| *to &= byte);
        Ok(())
    }
}

impl DelayNs for Part {
    fn delay_ns(&mut self, _: u32) {}
}

impl Housekeeping for Part {
    type Delay = Self;

    fn now_us(&mut self) -> u64 {
        self.0.now_us.get()
    }

    fn resume_at(&mut self, time_us: u64) {
        self.0.now_us.set(self.0.now_us.get().max(time_us));
    }

    fn delay(&mut self) -> &mut Self {
        self
    }

    fn feed(&mut self, _: FeedPermit) {
        self.0.feeds.set(self.0.feeds.get() + 1);
    }

    fn health(&mut self) -> Health {
        Health {
            reset_cause: ResetCause::PowerOn,
            last_run: LastRun::default(),
            clock: ClockSource::Crystal,
            watchdog: true,
            stack_high_water_bytes: 0,
            serial_errors: 0,
        }
    }
}

/// A computer and its ground station.
struct Ground {
    world: Part,
    computer: Computer<'static, TestParts>,
    receiver: Receiver,
    sequence_count: SequenceCount,
}

impl Ground {
    /// A started computer with these samples and this content of the flash.
    fn new(rows: &'static [Row<WHEELS>], flash: Vec<u8>, reporting: Reporting) -> Self {
        Self::with_gyro(rows, flash, reporting, true)
    }

    fn with_gyro(
        rows: &'static [Row<WHEELS>],
        flash: Vec<u8>,
        reporting: Reporting,
        is_present: bool,
    ) -> Self {
        let world = Part(Rc::new(World { flash: RefCell::new(flash), ..World::default() }));
        world.0.gyro_is_absent.set(!is_present);
        let recording: &'static _ = Box::leak(Box::new(Recording::new(rows)));
        let sensors = crate::flight::flight_loop::Sensors {
            data_ready: RecordedDataReady(recording, world.clone()),
            gyro: RecordedGyro(recording, world.clone()),
            wheels: RecordedWheels(recording, world.clone()),
            torque: recording,
        };
        let estimator = Box::leak(Box::new(SelectedEstimator::new(CRAFT).unwrap()));
        let mut computer = Computer::new(
            estimator,
            sensors,
            world.clone(),
            world.clone(),
            world.clone(),
            reporting,
        );
        computer.start();
        Self {
            world,
            computer,
            receiver: Receiver::default(),
            sequence_count: SequenceCount::new(0),
        }
    }

    /// Polls the computer every 0.1 s and returns its telemetry.
    fn poll(&mut self, times: u32) -> Vec<Telemetry> {
        for _ in 0..times {
            self.world.0.now_us.set(self.world.0.now_us.get() + 100_000);
            self.computer.poll();
        }
        let bytes: Vec<u8> = self.world.0.from_computer.borrow_mut().drain(..).collect();
        let received = bytes.into_iter().filter_map(|byte| self.receiver.push(byte));
        received.map(|received| -> Received { received.unwrap() }).map(|r| r.telemetry).collect()
    }

    /// Sends a telecommand and returns its status report.
    fn command(&mut self, command: Command) -> StatusReport {
        self.sequence_count = crate::link::packet::next(self.sequence_count);
        let packet = command.packet(self.sequence_count).unwrap();
        let frame = Frame::of(packet.bytes()).unwrap();
        self.world.0.to_computer.borrow_mut().extend(frame.bytes());
        let sent = self.poll(1);
        let status = statuses(&sent).last().copied().expect("a status report");
        assert_eq!(status.last_command, Some(command.function()));
        assert_eq!(status.last_sequence_count, self.sequence_count.value());
        status
    }
}

fn statuses(sent: &[Telemetry]) -> Vec<StatusReport> {
    sent.iter()
        .filter_map(|telemetry| match telemetry {
            Telemetry::Status(status) => Some(*status),
            _ => None,
        })
        .collect()
}

fn estimates(sent: &[Telemetry]) -> Vec<EstimateReport> {
    sent.iter()
        .filter_map(|telemetry| match telemetry {
            Telemetry::Estimate(estimate) => Some(*estimate),
            _ => None,
        })
        .collect()
}

const PRIOR: Prior<f32> = Prior {
    inertia_kg_m2: [0.06, 0.1, 0.12, 0.0, 0.0, 0.0],
    sigma_kg_m2: [0.02, 0.02, 0.02, 0.005, 0.005, 0.005],
};

/// Flash size, bytes: each half holds a checkpoint of `window`.
const FLASH: usize = 96 * 1024;

fn erased() -> Vec<u8> {
    vec![0xff; FLASH]
}

#[test]
fn telemetry_equals_the_estimator_bit_for_bit() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let mut reference = SelectedEstimator::new(CRAFT).unwrap();
    for row in &ROWS {
        let outcome = reference.step(&fsw_core::Sample {
            time_us: row.time_us,
            rate_rad_s: Vec3::from(row.rate_rad_s),
            wheel_speed_rad_s: row.wheel_speed_rad_s,
            torque_n_m: Vec3::from(row.torque_n_m),
            attitude: None,
        });
        reference.work(SLICES_PER_SAMPLE);
        let expected =
            EstimateReport::of(EstimatorId::Window, &reference, row.time_us, Some(outcome));
        assert_eq!(estimates(&ground.poll(1)), [expected]);
    }
    assert_eq!(reference.estimate().status, Status::Converged);
}

#[test]
fn the_telemetry_period_is_commandable() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::Every(1_000));
    let sent = ground.poll(100);
    assert_eq!((statuses(&sent).len(), estimates(&sent).len()), (10, 10));
    ground.command(Command::SetTelemetryPeriod { ms: 200 });
    let sent = ground.poll(100);
    assert_eq!((statuses(&sent).len(), estimates(&sent).len()), (50, 50));
}

#[test]
fn every_telecommand_has_a_status_report_with_its_result() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    assert_eq!(ground.command(Command::Ping).last_command_done, Some(true));
    let no_nominal = ground.command(Command::Select(EstimatorId::EkfSgfRls));
    assert_eq!(no_nominal.last_command_done, Some(false));
    assert_eq!(ground.command(Command::SetPrior(PRIOR)).last_command_done, Some(true));
    let selected = ground.command(Command::Select(EstimatorId::EkfSgfRls));
    assert_eq!(selected.last_command_done, Some(true));
    assert_eq!(ground.command(Command::OpenWindow).last_command_done, Some(false), "no windows");
    assert_eq!(ground.command(Command::SetTorque([0.1, 0.0, 0.0])).torque_n_m, [0.1, 0.0, 0.0]);
    assert_eq!(estimates(&ground.poll(1))[0].estimator, EstimatorId::EkfSgfRls);
}

#[test]
fn a_restarted_computer_continues_from_its_checkpoint() {
    for id in EstimatorId::ALL {
        let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
        ground.command(Command::SetPrior(PRIOR));
        ground.command(Command::Select(id));
        ground.poll(300);
        // Telecommands are executed before the next sample.
        let before = ground.computer.estimator().estimate();
        let saved = ground.command(Command::SaveCheckpoint);
        // The first one was saved ten seconds after the telecommands.
        assert_eq!((saved.last_command_done, saved.checkpoints_saved), (Some(true), 2));
        let flash = ground.world.0.flash.borrow().clone();

        let mut again = Ground::new(&ROWS[303..], flash, Reporting::EachSample);
        let after = again.computer.estimator();
        assert_eq!((after.selected(), after.estimate()), (id, before));
        assert!(again.world.0.now_us.get() > ground.world.0.now_us.get());
        let status = again.command(Command::Ping);
        assert!(
            status.uptime_s < 2,
            "{} s since the start, not since the first one",
            status.uptime_s
        );
    }
}

#[test]
fn a_dump_contains_the_whole_checkpoint() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.command(Command::Select(EstimatorId::JointEkf));
    assert_eq!(
        ground.command(Command::DumpCheckpoint).last_command_done,
        Some(false),
        "no checkpoint"
    );
    ground.command(Command::SaveCheckpoint);
    ground.command(Command::DumpCheckpoint);
    let mut bytes = Vec::new();
    let (mut next, mut parts) = (0, 0);
    // Starts again: the first parts were sent with the status report.
    ground.command(Command::DumpCheckpoint);
    for telemetry in ground.poll(200) {
        if let Telemetry::Checkpoint(part) = telemetry {
            next = part.index + 1;
            parts = part.parts;
            bytes.extend_from_slice(part.bytes());
        }
    }
    assert!(parts > 3 && next == parts, "{next} of {parts}");
    assert!(ground.world.0.flash.borrow().windows(bytes.len()).any(|stored| stored == bytes));
}

#[test]
fn an_absent_gyro_is_reported_and_started_once_it_answers() {
    let mut ground = Ground::with_gyro(&ROWS, erased(), Reporting::Every(1_000), false);
    let sent = ground.poll(45);
    let status = statuses(&sent).last().copied().unwrap();
    assert_eq!((status.gyro, status.gyro_identity), (GyroState::WrongIdentity, Some(0xff)));
    assert!(status.gyro_failures > 30 && status.outcomes.accepted == 0);
    assert_eq!(ground.world.0.gyro_starts.get(), 5, "at the start, then once a second");
    assert_eq!(ground.world.0.feeds.get(), 45, "every round completes");

    ground.world.0.gyro_is_absent.set(false);
    let sent = ground.poll(30);
    let status = statuses(&sent).last().copied().unwrap();
    assert_eq!((status.gyro, status.gyro_identity), (GyroState::Ready, Some(0x42)));
    assert_eq!(status.gyro_self_tests_failed, 0);
    assert!(status.outcomes.accepted > 10);
}

#[test]
fn a_gyro_that_fails_its_self_test_is_reported_and_used() {
    let mut ground = Ground::with_gyro(&ROWS, erased(), Reporting::Every(1_000), false);
    ground.world.0.gyro_is_absent.set(false);
    ground.world.0.gyro_fails_its_test.set(true);
    let sent = ground.poll(45);
    let status = statuses(&sent).last().copied().unwrap();
    assert_eq!((status.gyro, status.gyro_identity), (GyroState::SelfTestFailed, Some(0x42)));
    assert_eq!(status.gyro_self_tests_failed, 1);
    assert!(status.outcomes.accepted > 20);
}

#[test]
fn wheel_errors_do_not_restart_the_gyro() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::Every(1_000));
    let starts = ground.world.0.gyro_starts.get();
    ground.world.0.wheels_fail.set(true);
    let sent = ground.poll(100);
    let status = statuses(&sent).last().copied().unwrap();
    assert!(status.wheel_failures > 80 && status.outcomes.accepted == 0);
    assert_eq!(ground.world.0.gyro_starts.get(), starts);
}

#[test]
fn queued_telecommands_have_one_status_report_each() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let rejected = Command::Select(EstimatorId::EkfSgfRls); // without a prior
    for (count, command) in [(1, rejected), (2, Command::Ping), (3, Command::Ping)] {
        let packet = command.packet(SequenceCount::new(count)).unwrap();
        let frame = Frame::of(packet.bytes()).unwrap();
        ground.world.0.to_computer.borrow_mut().extend(frame.bytes());
    }
    let sent = ground.poll(3);
    let results: Vec<_> = statuses(&sent)
        .iter()
        .map(|status| (status.last_sequence_count, status.last_command_done))
        .collect();
    assert_eq!(results, [(1, Some(false)), (2, Some(true)), (3, Some(true))]);
}

#[test]
fn a_checkpoint_follows_a_change_by_telecommand() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.poll(10);
    ground.command(Command::SetPrior(PRIOR));
    ground.command(Command::Select(EstimatorId::EkfSgfRls));
    ground.poll(101);
    assert_eq!(ground.command(Command::Ping).checkpoints_saved, 1, "one for both telecommands");
    let flash = ground.world.0.flash.borrow().clone();
    let again = Ground::new(&ROWS[303..], flash, Reporting::EachSample);
    let estimator = again.computer.estimator();
    assert_eq!((estimator.selected(), estimator.prior()), (EstimatorId::EkfSgfRls, Some(PRIOR)));
}

/// The fit over the window's blocks takes more slices than one sample has.
#[test]
fn a_window_closed_by_telecommand_is_completed_with_the_samples_that_follow() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.poll(400);
    ground.command(Command::CloseWindow);
    let mut complete = ground.computer.estimator().clone();
    complete.work(100_000);
    let mut samples = 0;
    let expected = complete.estimate().inertia.elements_kg_m2();
    // The last block has a neighbour now, and a time offset is read from both: the result differs by rounding.
    let is_complete = |ground: &Ground| {
        let found = ground.computer.estimator().estimate().inertia.elements_kg_m2();
        found.iter().zip(&expected).all(|(found, expected)| (found - expected).abs() < 1e-8)
    };
    while samples < 300 && !is_complete(&ground) {
        ground.poll(1);
        samples += 1;
    }
    assert!(samples > 1 && samples < 300, "{samples}");
    assert_eq!(complete.estimate().status, Status::Converged);
}

/// Flash whose halves hold one checkpoint of `window`.
fn small_flash() -> Vec<u8> {
    vec![0xff; 112 * 1024]
}

/// Longest erasure of a sector of an STM32F405, µs: twice `GYRO_SILENCE_US`.
const ERASURE_US: u64 = 2_000_000;

#[test]
fn an_erasure_does_not_restart_the_gyro() {
    let mut ground = Ground::new(&ROWS, small_flash(), Reporting::EachSample);
    ground.world.0.erasure_us.set(ERASURE_US);
    let (starts, erasures) = (ground.world.0.gyro_starts.get(), ground.world.0.erasures.get());
    for _ in 0..20 {
        ground.command(Command::SaveCheckpoint);
        ground.poll(5);
    }
    assert!(ground.world.0.erasures.get() > erasures);
    assert_eq!(ground.world.0.gyro_starts.get(), starts);
}

/// Three manoeuvres with a save in each, every one followed by two minutes of steady rotation, in which
/// the window closes.
#[test]
fn space_for_a_save_is_erased_at_rest() {
    const MANOEUVRE: usize = 200;
    const QUIET: usize = 1_200;
    let mut rows = Vec::new();
    for _ in 0..3 {
        rows.extend_from_slice(&ROWS[..MANOEUVRE]);
        for k in 0..QUIET {
            let mut row = ROWS[MANOEUVRE];
            // Small gyro noise: constant readings would count as stuck.
            row.rate_rad_s[k % 3] += 1e-5 * (k % 7) as f32;
            rows.push(row);
        }
    }
    for (k, row) in (0..).zip(&mut rows) {
        row.time_us = 100_000 * k;
    }
    let mut ground = Ground::new(Vec::leak(rows), small_flash(), Reporting::EachSample);
    let erasures = |ground: &Ground| ground.world.0.erasures.get();
    assert_eq!(erasures(&ground), 1, "new flash");
    for manoeuvre in 1..=3 {
        ground.poll(MANOEUVRE as u32 - 50);
        assert!(!ground.computer.estimator().is_at_rest());
        assert_eq!(ground.command(Command::SaveCheckpoint).last_command_done, Some(true));
        assert_eq!(erasures(&ground), manoeuvre, "no erasure in the manoeuvre");
        ground.poll(QUIET as u32 + 49);
        assert!(ground.computer.estimator().is_at_rest());
        assert_eq!(erasures(&ground), manoeuvre + 1, "no space for another checkpoint");
    }
}

#[test]
fn noise_on_the_link_is_counted_and_ignored() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let mut state = 1_u32;
    let noise = core::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    ground.world.0.to_computer.borrow_mut().extend(noise.take(3_000));
    assert_eq!(estimates(&ground.poll(60)).len(), 60);
    let status = ground.command(Command::Ping);
    let uplink = status.uplink;
    assert_eq!(uplink.accepted, 1);
    assert!(uplink.truncated + uplink.malformed + uplink.wrong_checksum > 0, "{uplink:?}");
}

#[test]
fn the_computer_runs_without_flash() {
    let mut ground = Ground::new(&ROWS, Vec::new(), Reporting::EachSample);
    assert_eq!(estimates(&ground.poll(10)).len(), 10);
    let status = ground.command(Command::SaveCheckpoint);
    assert_eq!((status.last_command_done, status.checkpoints_failed), (Some(false), 1));
    assert_eq!(status.checkpoint, CheckpointState::Failed);
}

/// Against the division of 64 bits, at the limits of each digit and of the result.
#[test]
fn seconds_are_whole_and_saturate() {
    for time_us in
        [0, 999_999, 1_000_000, 4_294_967_296, 90_061_000_001, u64::from(u32::MAX) * 1_000_000]
    {
        assert_eq!(u64::from(seconds(time_us)), time_us / 1_000_000);
    }
    assert_eq!(seconds(u64::MAX), u32::MAX);
}
