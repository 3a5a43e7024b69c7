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

/// What the test and the computer's parts share: both ends of the line, the gyro's health, the time.
#[derive(Default)]
struct World {
    to_computer: RefCell<VecDeque<u8>>,
    from_computer: RefCell<VecDeque<u8>>,
    gyro_is_absent: Cell<bool>,
    gyro_starts: Cell<u32>,
    gyro_is_set_up: Cell<bool>,
    gyro_fails_its_test: Cell<bool>,
    /// A sample of the gyro's test is announced.
    test_is_announced: Cell<bool>,
    wheels_fail: Cell<bool>,
    now_us: Cell<u64>,
    feeds: Cell<u32>,
    flash: RefCell<Vec<u8>>,
    erasures: Cell<u32>,
    /// How long one takes.
    erasure_us: Cell<u64>,
}

/// Each part is a handle to the world.
#[derive(Clone)]
struct Part(Rc<World>);

/// The recording, with a gyro that can be missing.
struct RecordedGyro(&'static Recording<'static, WHEELS>, Part);

/// The recording, and samples that are none of it.
struct RecordedDataReady(&'static Recording<'static, WHEELS>, Part);

/// The recording, with wheels that can fail.
struct RecordedWheels(&'static Recording<'static, WHEELS>, Part);

struct Bench;

impl Parts for Bench {
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
        assert!(!self.1.0.test_is_announced.get(), "a sample of the gyro's test is taken for one");
        self.0.take_us()
    }

    fn has_newer(&mut self) -> bool {
        self.0.has_newer()
    }

    fn forget(&mut self) {
        self.1.0.test_is_announced.set(false);
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
        self.1.0.test_is_announced.set(true);
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

/// A computer, and the ground.
struct Ground {
    world: Part,
    computer: Computer<'static, Bench>,
    receiver: Receiver,
    sequence_count: SequenceCount,
}

impl Ground {
    /// A computer that flies these rows, with this in its flash.
    fn new(rows: &'static [Row<WHEELS>], flash: Vec<u8>, reporting: Reporting) -> Self {
        Self::with_gyro(rows, flash, reporting, true)
    }

    fn with_gyro(
        rows: &'static [Row<WHEELS>],
        flash: Vec<u8>,
        reporting: Reporting,
        is_there: bool,
    ) -> Self {
        let world = Part(Rc::new(World { flash: RefCell::new(flash), ..World::default() }));
        world.0.gyro_is_absent.set(!is_there);
        let recording: &'static _ = Box::leak(Box::new(Recording::new(rows)));
        let sensors = crate::flight::flight_loop::Sensors {
            data_ready: RecordedDataReady(recording, world.clone()),
            gyro: RecordedGyro(recording, world.clone()),
            wheels: RecordedWheels(recording, world.clone()),
            torque: recording,
        };
        let onboard = Box::leak(Box::new(SelectedEstimator::new(CRAFT).unwrap()));
        let mut computer =
            Computer::new(onboard, sensors, world.clone(), world.clone(), world.clone(), reporting);
        computer.start();
        Self {
            world,
            computer,
            receiver: Receiver::default(),
            sequence_count: SequenceCount::new(0),
        }
    }

    /// Polls so often, a tenth of a second apart, and returns what was sent.
    fn poll(&mut self, times: u32) -> Vec<Telemetry> {
        for _ in 0..times {
            self.world.0.now_us.set(self.world.0.now_us.get() + 100_000);
            self.computer.poll();
        }
        let bytes: Vec<u8> = self.world.0.from_computer.borrow_mut().drain(..).collect();
        let received = bytes.into_iter().filter_map(|byte| self.receiver.push(byte));
        received.map(|received| -> Received { received.unwrap() }).map(|r| r.telemetry).collect()
    }

    /// Sends a command, and returns the answer to it.
    fn ask(&mut self, command: Command) -> StatusReport {
        self.sequence_count = crate::link::packet::next(self.sequence_count);
        let packet = command.packet(self.sequence_count).unwrap();
        let frame = Frame::of(packet.bytes()).unwrap();
        self.world.0.to_computer.borrow_mut().extend(frame.bytes());
        let sent = self.poll(1);
        let status = statuses(&sent).last().copied().expect("an answer");
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

/// Room for a checkpoint of `window` in each half.
const FLASH: usize = 64 * 1024;

fn erased() -> Vec<u8> {
    vec![0xff; FLASH]
}

#[test]
fn each_sample_comes_out_as_an_estimate_of_the_same_bits() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let mut alone = SelectedEstimator::new(CRAFT).unwrap();
    for row in &ROWS {
        let outcome = alone.step(&fsw_core::Sample {
            time_us: row.time_us,
            rate_rad_s: Vec3::from(row.rate_rad_s),
            wheel_speed_rad_s: row.wheel_speed_rad_s,
            torque_n_m: Vec3::from(row.torque_n_m),
            attitude: None,
        });
        let expected = EstimateReport::of(EstimatorId::Window, &alone, row.time_us, Some(outcome));
        assert_eq!(estimates(&ground.poll(1)), [expected]);
    }
    assert_eq!(alone.estimate().status, Status::Converged);
}

#[test]
fn reports_come_at_the_period_that_the_ground_sets() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::Every(1_000));
    let sent = ground.poll(100);
    assert_eq!((statuses(&sent).len(), estimates(&sent).len()), (10, 10));
    ground.ask(Command::SetTelemetryPeriod { ms: 200 });
    let sent = ground.poll(100);
    assert_eq!((statuses(&sent).len(), estimates(&sent).len()), (50, 50));
}

#[test]
fn every_command_is_answered_and_refusals_are_told() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    assert_eq!(ground.ask(Command::Ping).last_command_done, Some(true));
    let no_nominal = ground.ask(Command::Select(EstimatorId::EkfSgfRls));
    assert_eq!(no_nominal.last_command_done, Some(false));
    assert_eq!(ground.ask(Command::SetPrior(PRIOR)).last_command_done, Some(true));
    let selected = ground.ask(Command::Select(EstimatorId::EkfSgfRls));
    assert_eq!(selected.last_command_done, Some(true));
    assert_eq!(ground.ask(Command::OpenWindow).last_command_done, Some(false), "it has none");
    assert_eq!(ground.ask(Command::SetTorque([0.1, 0.0, 0.0])).torque_n_m, [0.1, 0.0, 0.0]);
    assert_eq!(estimates(&ground.poll(1))[0].estimator, EstimatorId::EkfSgfRls);
}

#[test]
fn a_computer_that_starts_again_goes_on_from_its_checkpoint() {
    for id in EstimatorId::ALL {
        let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
        ground.ask(Command::SetPrior(PRIOR));
        ground.ask(Command::Select(id));
        ground.poll(300);
        // Commands are obeyed before the next sample is looked at.
        let before = ground.computer.onboard().estimate();
        let saved = ground.ask(Command::SaveCheckpoint);
        // One for what was set, ten seconds after, and this one.
        assert_eq!((saved.last_command_done, saved.checkpoints_saved), (Some(true), 2));
        let flash = ground.world.0.flash.borrow().clone();

        let mut again = Ground::new(&ROWS[303..], flash, Reporting::EachSample);
        let after = again.computer.onboard();
        assert_eq!((after.selected(), after.estimate()), (id, before));
        assert!(again.world.0.now_us.get() > ground.world.0.now_us.get());
        let told = again.ask(Command::Ping);
        assert!(told.uptime_s < 2, "{} s since the start, not since the first one", told.uptime_s);
    }
}

#[test]
fn a_checkpoint_is_sent_whole() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.ask(Command::Select(EstimatorId::JointEkf));
    assert_eq!(ground.ask(Command::DumpCheckpoint).last_command_done, Some(false), "none yet");
    ground.ask(Command::SaveCheckpoint);
    ground.ask(Command::DumpCheckpoint);
    let mut bytes = Vec::new();
    let (mut next, mut parts) = (0, 0);
    // The first parts went out with the answer.
    ground.ask(Command::DumpCheckpoint);
    for telemetry in ground.poll(200) {
        if let Telemetry::Checkpoint(part) = telemetry {
            next = part.index + 1;
            parts = part.parts;
            bytes.extend_from_slice(part.bytes());
        }
    }
    assert!(parts > 3 && next == parts, "{next} of {parts}");
    assert!(ground.world.0.flash.borrow().windows(bytes.len()).any(|there| there == bytes));
}

#[test]
fn a_gyro_that_is_missing_is_told_tried_again_and_taken_when_it_comes() {
    let mut ground = Ground::with_gyro(&ROWS, erased(), Reporting::Every(1_000), false);
    let sent = ground.poll(45);
    let told = statuses(&sent).last().copied().unwrap();
    assert_eq!((told.gyro, told.gyro_identity), (GyroState::WrongIdentity, Some(0xff)));
    assert!(told.gyro_failures > 30 && told.outcomes.accepted == 0);
    assert_eq!(ground.world.0.gyro_starts.get(), 5, "at the start, and about once a second");
    assert_eq!(ground.world.0.feeds.get(), 45, "the loop has done its work");

    ground.world.0.gyro_is_absent.set(false);
    let sent = ground.poll(30);
    let told = statuses(&sent).last().copied().unwrap();
    assert_eq!((told.gyro, told.gyro_identity), (GyroState::Ready, Some(0x42)));
    assert_eq!(told.gyro_self_tests_failed, 0);
    assert!(told.outcomes.accepted > 10);
}

#[test]
fn a_gyro_that_fails_its_test_is_told_and_flies_all_the_same() {
    let mut ground = Ground::with_gyro(&ROWS, erased(), Reporting::Every(1_000), false);
    ground.world.0.gyro_is_absent.set(false);
    ground.world.0.gyro_fails_its_test.set(true);
    let sent = ground.poll(45);
    let told = statuses(&sent).last().copied().unwrap();
    assert_eq!((told.gyro, told.gyro_identity), (GyroState::SelfTestFailed, Some(0x42)));
    assert_eq!(told.gyro_self_tests_failed, 1);
    assert!(told.outcomes.accepted > 20);
}

#[test]
fn wheels_that_fail_are_not_taken_for_a_silent_gyro() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::Every(1_000));
    let starts = ground.world.0.gyro_starts.get();
    ground.world.0.wheels_fail.set(true);
    let sent = ground.poll(100);
    let told = statuses(&sent).last().copied().unwrap();
    assert!(told.wheel_failures > 80 && told.outcomes.accepted == 0);
    assert_eq!(ground.world.0.gyro_starts.get(), starts);
}

#[test]
fn commands_in_a_row_are_answered_one_by_one() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let refused = Command::Select(EstimatorId::EkfSgfRls); // without a prior
    for (count, command) in [(1, refused), (2, Command::Ping), (3, Command::Ping)] {
        let packet = command.packet(SequenceCount::new(count)).unwrap();
        let frame = Frame::of(packet.bytes()).unwrap();
        ground.world.0.to_computer.borrow_mut().extend(frame.bytes());
    }
    let sent = ground.poll(3);
    let answers: Vec<_> = statuses(&sent)
        .iter()
        .map(|status| (status.last_sequence_count, status.last_command_done))
        .collect();
    assert_eq!(answers, [(1, Some(false)), (2, Some(true)), (3, Some(true))]);
}

#[test]
fn what_the_ground_has_set_is_kept_before_long() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.poll(10);
    ground.ask(Command::SetPrior(PRIOR));
    ground.ask(Command::Select(EstimatorId::EkfSgfRls));
    ground.poll(101);
    assert_eq!(ground.ask(Command::Ping).checkpoints_saved, 1, "both together");
    let flash = ground.world.0.flash.borrow().clone();
    let again = Ground::new(&ROWS[303..], flash, Reporting::EachSample);
    let onboard = again.computer.onboard();
    assert_eq!((onboard.selected(), onboard.prior()), (EstimatorId::EkfSgfRls, Some(PRIOR)));
}

/// Halves that hold one or two checkpoints.
fn small_flash() -> Vec<u8> {
    vec![0xff; 40 * 1024]
}

/// As long as an STM32F405 may take for a sector: twice the silence that a gyro is allowed.
const ERASURE_US: u64 = 2_000_000;

#[test]
fn while_the_flash_is_erased_the_gyro_is_not_to_blame() {
    let mut ground = Ground::new(&ROWS, small_flash(), Reporting::EachSample);
    ground.world.0.erasure_us.set(ERASURE_US);
    let (starts, erasures) = (ground.world.0.gyro_starts.get(), ground.world.0.erasures.get());
    for _ in 0..10 {
        ground.ask(Command::SaveCheckpoint);
        ground.poll(5);
    }
    assert!(ground.world.0.erasures.get() > erasures);
    assert_eq!(ground.world.0.gyro_starts.get(), starts);
}

/// Three times a manoeuvre, in which a checkpoint is saved, and then two minutes of steady rotation, in
/// which the window is concluded.
#[test]
fn a_save_in_mid_manoeuvre_finds_its_room_erased_in_the_quiet_before() {
    const MANOEUVRE: usize = 200;
    const QUIET: usize = 1_200;
    let mut rows = Vec::new();
    for _ in 0..3 {
        rows.extend_from_slice(&ROWS[..MANOEUVRE]);
        for k in 0..QUIET {
            let mut row = ROWS[MANOEUVRE];
            // Not stuck: as if the gyro had a little noise.
            row.rate_rad_s[k % 3] += 1e-5 * (k % 7) as f32;
            rows.push(row);
        }
    }
    for (k, row) in (0..).zip(&mut rows) {
        row.time_us = 100_000 * k;
    }
    let mut ground = Ground::new(Vec::leak(rows), small_flash(), Reporting::EachSample);
    let erasures = |ground: &Ground| ground.world.0.erasures.get();
    assert_eq!(erasures(&ground), 1, "the flash was new");
    for manoeuvre in 1..=3 {
        ground.poll(MANOEUVRE as u32 - 50);
        assert!(!ground.computer.onboard().is_at_rest());
        assert_eq!(ground.ask(Command::SaveCheckpoint).last_command_done, Some(true));
        assert_eq!(erasures(&ground), manoeuvre, "none in it");
        ground.poll(QUIET as u32 + 49);
        assert!(ground.computer.onboard().is_at_rest());
        assert_eq!(
            erasures(&ground),
            manoeuvre + 1,
            "the half that is left is too small for another"
        );
    }
}

#[test]
fn noise_on_the_line_is_counted_and_does_no_harm() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let mut state = 1_u32;
    let noise = core::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    ground.world.0.to_computer.borrow_mut().extend(noise.take(3_000));
    assert_eq!(estimates(&ground.poll(60)).len(), 60);
    let status = ground.ask(Command::Ping);
    let uplink = status.uplink;
    assert_eq!(uplink.accepted, 1);
    assert!(uplink.truncated + uplink.malformed + uplink.wrong_checksum > 0, "{uplink:?}");
}

#[test]
fn without_flash_it_flies_all_the_same() {
    let mut ground = Ground::new(&ROWS, Vec::new(), Reporting::EachSample);
    assert_eq!(estimates(&ground.poll(10)).len(), 10);
    let status = ground.ask(Command::SaveCheckpoint);
    assert_eq!((status.last_command_done, status.checkpoints_failed), (Some(false), 1));
    assert_eq!(status.checkpoint, CheckpointState::Failed);
}
