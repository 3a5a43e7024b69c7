//! The flight computer: the loop of an image.
//!
//! ```text
//!  bytes ─► link ─► Command ─┐
//!                            ▼
//!  sensors ─► FlightLoop ─► SelectedEstimator ─► reports ─► link ─► bytes
//!                            ▲ │
//!                            │ ▼
//!                          Store (flash)
//! ```
//!
//! Input: the [`Parts`] of a board, or of the simulator. Output: telemetry, and a permit to feed the
//! watchdog after each round of tasks. [`Computer::poll`] blocks in two cases only: the start of the gyro
//! (0.2 s, while there are no samples to lose) and the flash (see [`crate::store`]). Failures are counted
//! and reported; none ends the loop.
//!
//! An erasure of a flash sector takes 1 to 2 s, in which samples are lost. Space for the next
//! checkpoint is therefore erased at the start, and at rest after the last window is concluded
//! (`window` only). Otherwise every third save of `window` erases a sector.
//!
//! The estimator's work beside its steps is done in slices, a fixed number after each sample. A window
//! that a telecommand closes is completed by those of the samples that follow.
//!
//! # Flipped bits
//!
//! The memory of the estimator is sealed between rounds ([`crate::runtime::sealed`]): configuration, wheels, prior,
//! stored blocks, factors and all else. A round that uses the estimator checks the seal first and renews it at its
//! end. After a flipped bit the sample is not used, and the estimator returns to the newest checkpoint, or starts again
//! without one. Telemetry has the number (`upsets`), and the outcome of the sample is that of a state that is not valid,
//! [`Reset::Diverged`](fsw_core::Reset::Diverged). Where craft or prior has changed, which only the image in flash
//! restores, the computer reboots.
//!
//! Infrequent functions are not inlined into the loop: their local variables would occupy its stack
//! frame during the step of an estimator.

mod checkpoints;
mod counters;
mod manoeuvring;
mod parts;
#[cfg(test)]
mod tests;

pub use parts::{Health, Housekeeping, Parts, Reporting, Security, SensorsOf};

use checkpoints::Checkpoints;
use counters::StoredCounters;

use crate::flight::craft::WHEELS;
use crate::flight::flight_loop::{FlightLoop, Tick};
use crate::flight::manoeuvre::Manoeuvre;
use crate::flight::selected::SelectedEstimator;
use crate::flight::sensors::{DataReady, TorqueCommand, WheelTachometers};
use crate::flight::sensors::{RateGyro, StartFault};
use crate::flight::supervisor::{Stage, Supervisor, Task};
use crate::flight::wheel_check::{self, WheelCheck};
use crate::link::command::{Command, MAX_COMMAND};
use crate::link::frame::MAX_FRAME;
use crate::link::telemetry::{
    CheckpointState, EstimateReport, GyroState, LINK_VERSION, Report, StatusReport,
};
use crate::link::{Downlink, Uplink};
use crate::runtime::sealed::Sealed;
use embedded_hal_nb::nb;
use embedded_hal_nb::serial::Read;
use fsw_core::manoeuvre::Abort;
use fsw_core::{Outcome, Vec3};

/// Capacity of the transmit queue, bytes: three reports and a part of a checkpoint.
const QUEUE: usize = 768;

/// Received bytes processed per poll: at least one telecommand, and few enough not to delay a sample.
const BYTES_PER_POLL: usize = 96;
const _: () = assert!(BYTES_PER_POLL >= MAX_COMMAND);

/// Slices of the estimator's work after each sample.
///
/// A fixed number, and not the time that is left, so that target and host do the same slices and compute
/// the same bits. A block of a pass, the slice that recurs, takes 18,000 instructions, 27,000 cycles, and
/// 43,000 instructions where the body turns by more than 0.45 rad in it (`docs/budgets.md`). 16 blocks are
/// 430,000 to 1.0 million of the 1.68 million cycles between two samples at 100 Hz and 168 MHz: 26 to 61 %.
/// A pass over 512 blocks takes 32 samples.
pub const SLICES_PER_SAMPLE: u32 = 16;

/// Time without a reading after which the gyro is started again, and period of further attempts, µs. Time
/// of flash operations, in which no sample can arrive, is not counted: an erasure takes longer.
const GYRO_SILENCE_US: u64 = 1_000_000;

/// Duration of a run after which its end is not a short life, µs: one minute. A state that crashes the next
/// step does so within seconds of the first sample.
pub const LONG_LIFE_US: u64 = 60_000_000;

/// Short lives in a row after which the checkpoint is not restored.
const SHORT_LIVES: u32 = 3;

/// Time from the telecommand `reboot` to the reset, µs: its status report leaves the line within 0.1 s.
const REBOOT_US: u64 = 500_000;

type FlightLoopOf<'a, P> = FlightLoop<
    Sealed<'a, SelectedEstimator>,
    <P as Parts>::DataReady,
    <P as Parts>::Gyro,
    <P as Parts>::Wheels,
    <P as Parts>::Torque,
    WHEELS,
>;

/// The flight computer.
pub struct Computer<'a, P: Parts> {
    flight: FlightLoopOf<'a, P>,
    board: P::Board,
    /// On-board time at the start, µs.
    started_us: u64,
    link: P::Link,
    uplink: Uplink,
    downlink: Downlink<QUEUE>,
    flash: Checkpoints<P::Flash>,
    counters: StoredCounters<P::CounterFlash>,
    manoeuvre: &'a mut Manoeuvre,
    supervisor: Supervisor,
    reporting: Reporting,
    next_report_us: u64,
    gyro: Gyro,
    /// Time stamp, µs, and outcome of the last step.
    last_step: Option<(u64, Outcome)>,
    /// Result of the last telecommand, true if executed; `None` before the first.
    last_executed: Option<bool>,
    /// A telecommand awaits its status report.
    status_due: bool,
    torque_n_m: [f32; 3],
    /// Starts in a row that ended as short lives.
    short_lives: u32,
    /// True once this run has lasted [`LONG_LIFE_US`].
    is_long: bool,
    /// Time of a requested reset, µs.
    reboot_us: Option<u64>,
    /// Flipped bits found in the memory of the estimator since the start; saturates.
    upsets: u8,
}

/// State of the gyro after its last start.
struct Gyro {
    state: GyroState,
    identity: Option<u8>,
    /// Failed self-tests since the start of the computer.
    self_tests_failed: u32,
    /// Time of the last reading, start or flash operation, µs.
    silent_since_us: u64,
}

impl<'a, P: Parts> Computer<'a, P> {
    /// The computer before [`start`](Self::start), with a manoeuvre for the wheels of the estimator's craft. Inlined, so that it is built in its place: it takes more
    /// than a kilobyte.
    #[inline(always)]
    pub fn new(
        (estimator, manoeuvre): (&'a mut SelectedEstimator, &'a mut Manoeuvre),
        sensors: SensorsOf<P>,
        link: P::Link,
        flash: P::Flash,
        security: Security<P::CounterFlash>,
        board: P::Board,
        reporting: Reporting,
    ) -> Self {
        Self {
            flight: FlightLoop::new(Sealed::new(estimator), sensors),
            board,
            started_us: 0,
            link,
            counters: StoredCounters::unopened(security.flash, security.master.is_some()),
            uplink: Uplink::new(security.master),
            downlink: Downlink::new(),
            flash: Checkpoints::unopened(flash),
            manoeuvre,
            supervisor: Supervisor::new(),
            reporting,
            next_report_us: 0,
            gyro: Gyro::not_started(),
            last_step: None,
            last_executed: None,
            status_due: false,
            torque_n_m: [0.0; 3],
            short_lives: 0,
            is_long: false,
            reboot_us: None,
            upsets: 0,
        }
    }

    /// Restores the newest valid checkpoint and the counters of telecommands, and starts the gyro. Call it
    /// once, before the first [`poll`](Self::poll).
    ///
    /// On-board time continues after that of the checkpoint, so that time stamps stay in order. The time
    /// without power is unknown: the estimator sees a gap.
    ///
    /// After three short lives in a row the checkpoint is not restored: it may be their cause.
    ///
    /// Each stage feeds the watchdog: an erasure (2 s) with the reading of the flash and the start of the gyro
    /// could exceed its period.
    pub fn start(&mut self) {
        self.short_lives = self.board.health().last_run.short_lives;
        let is_skipped = self.short_lives >= SHORT_LIVES;
        let estimator = self.flight.estimator_mut().get_mut();
        self.flash.restore(estimator, self.manoeuvre, &mut self.board, is_skipped);
        self.restore_manoeuvre();
        self.started_us = self.board.now_us();
        self.next_report_us = self.started_us;
        self.complete(Stage::Restored);
        self.uplink.restore(self.counters.restore());
        self.complete(Stage::CountersRead);
        self.flash.erase_ahead();
        self.complete(Stage::CheckpointErased);
        self.counters.erase_ahead();
        self.complete(Stage::CountersErased);
        self.start_gyro();
        self.complete(Stage::GyroStarted);
        self.check_wheels();
        self.flight.estimator_mut().seal();
    }

    /// Checks the wheels of the craft against their commands from the first sample on.
    #[inline(never)]
    fn check_wheels(&mut self) {
        let craft = self.estimator().craft();
        let (axes, spin_inertia_kg_m2) = (&craft.wheel_axes, &craft.spin_inertia_kg_m2);
        let check = WheelCheck::new(wheel_check::Config::default(), axes, spin_inertia_kg_m2);
        self.flight.check_wheels(check);
    }

    /// Feeds the watchdog after a stage of the start.
    fn complete(&mut self, stage: Stage) {
        if let Some(permit) = self.supervisor.stage_permit(stage) {
            self.board.feed(permit);
        }
    }

    /// One round: telecommands, one sample, checkpoint, telemetry.
    pub fn poll(&mut self) {
        self.take_commands();
        // Work and report are the deepest paths, and not below the locals of the sample.
        let sampled = self.take_sample();
        if sampled != Sampled::Nothing {
            self.checked().work(SLICES_PER_SAMPLE);
        }
        if sampled == Sampled::Stepped && self.reporting == Reporting::EachSample {
            self.report_estimate();
        }
        self.step_manoeuvre(sampled);
        self.maintain_checkpoint();
        self.send_reports();
        self.flight.estimator_mut().seal();
        self.keep_lives();
        if let Some(permit) = self.supervisor.permit() {
            self.board.feed(permit);
        }
    }

    /// Ends a row of short lives once this run is long, and executes a requested reset.
    fn keep_lives(&mut self) {
        let now_us = self.board.now_us();
        if self.reboot_us.is_some_and(|reboot_us| now_us >= reboot_us) {
            self.reboot_us = None;
            self.board.reboot();
        }
        if !self.is_long && now_us.saturating_sub(self.started_us) >= LONG_LIFE_US {
            self.is_long = true;
            self.short_lives = 0;
            self.board.note_long_life();
            if self.flash.found == CheckpointState::Skipped {
                // The skipped checkpoint was the cause: a newer one replaces it.
                self.flash.save_soon(now_us);
            }
        }
    }

    /// The selected estimator, without a check of its memory.
    pub fn estimator(&self) -> &SelectedEstimator {
        self.flight.estimator().get()
    }

    /// The estimator in use: as it was sealed, or restored after a flipped bit.
    fn checked(&mut self) -> &mut SelectedEstimator {
        if !self.flight.estimator_mut().open() {
            self.recover();
        }
        self.flight.estimator_mut().get_mut()
    }

    /// Restores the estimator after a flipped bit: from the newest checkpoint, otherwise from craft and prior.
    #[inline(never)]
    fn recover(&mut self) {
        self.upsets = self.upsets.saturating_add(1);
        let estimator = self.flight.estimator_mut().get_mut();
        match estimator.rebuild() {
            Ok(()) => self.flash.reload(estimator),
            Err(_) => self.board.reboot(),
        }
        self.gyro.silent_since_us = self.board.now_us();
    }

    /// Bytes in the transmit queue.
    pub fn waiting_bytes(&self) -> usize {
        self.downlink.waiting()
    }

    #[inline(never)] // its stack is free again in the reports, the deepest path
    fn take_commands(&mut self) {
        for _ in 0..BYTES_PER_POLL {
            match self.link.read() {
                Ok(byte) => {
                    if let Some(command) = self.uplink.push(byte) {
                        self.last_executed = Some(self.execute(command));
                        self.status_due = true;
                        // One telecommand per status report.
                        break;
                    }
                }
                Err(nb::Error::WouldBlock) => break,
                // Counted by the port; later bytes are read in the next round.
                Err(nb::Error::Other(_)) => {}
            }
        }
        self.supervisor.report(Task::Commanding);
    }

    /// Executes a telecommand; false if it is rejected. Its counter is stored first: after a reset during the
    /// execution it is not accepted again.
    #[inline(never)]
    fn execute(&mut self, command: Command) -> bool {
        let is_permitted = match command {
            Command::ChangeKey { slot } => self.uplink.change_key(slot),
            Command::TagTelemetry(on) => self.uplink.tag_telemetry(on),
            _ => true,
        };
        self.counters.save(self.uplink.ledger());
        if !is_permitted {
            return false;
        }
        self.gyro.silent_since_us = self.board.now_us(); // a write may erase
        let estimator = self.checked();
        let executed = match command {
            Command::Ping
            | Command::StartSequence
            | Command::ChangeKey { .. }
            | Command::TagTelemetry(_) => Ok(()),
            Command::AssumeWheelSpeed { wheel, speed_rad_s } => {
                let wheel = usize::from(wheel).wrapping_sub(1);
                return self.flight.sensors_mut().wheels.assume(wheel, speed_rad_s);
            }
            Command::LoadManoeuvre { segment, words } => {
                return self.load_manoeuvre(segment, &words);
            }
            Command::CommitManoeuvre { checksum } => return self.commit_manoeuvre(checksum),
            Command::StartManoeuvre { at_us } => return self.start_manoeuvre(at_us),
            Command::AbortManoeuvre => return self.manoeuvre.abort(Abort::Command),
            Command::Reboot => {
                self.reboot_us = Some(self.board.now_us().saturating_add(REBOOT_US));
                Ok(())
            }
            Command::Reset => estimator.reset(),
            Command::SetPrior(prior) => estimator.set_prior(prior),
            Command::OpenWindow => estimator.open_window(),
            Command::CloseWindow => estimator.close_window(),
            Command::Select(id) => estimator.select(id),
            Command::SaveCheckpoint => {
                return !self.manoeuvre.is_active() && self.save_checkpoint();
            }
            Command::DumpCheckpoint => return self.flash.begin_dump(),
            Command::SetTelemetryPeriod { ms } => {
                self.reporting = Reporting::Every(ms);
                self.next_report_us = self.board.now_us();
                Ok(())
            }
            Command::SetTorque(torque_n_m) => {
                self.torque_n_m = torque_n_m;
                self.flight.sensors_mut().torque.command(Vec3::from(torque_n_m));
                Ok(())
            }
        };
        let is_persistent =
            matches!(command, Command::Reset | Command::SetPrior(_) | Command::Select(_));
        if is_persistent && executed.is_ok() {
            self.flash.save_soon(self.board.now_us());
        }
        executed.is_ok()
    }

    #[inline(never)] // as `take_commands`
    fn take_sample(&mut self) -> Sampled {
        let tick = self.flight.tick();
        if !matches!(tick, Tick::Idle | Tick::GyroFailed(_)) {
            self.gyro.silent_since_us = self.board.now_us();
        }
        let sampled = match tick {
            Tick::Idle => Sampled::Nothing,
            Tick::Stepped { time_us, outcome } => {
                self.last_step = Some((time_us, outcome));
                Sampled::Stepped
            }
            _ => Sampled::Skipped,
        };
        let silence_us = self.board.now_us().saturating_sub(self.gyro.silent_since_us);
        if silence_us > GYRO_SILENCE_US {
            self.start_gyro();
        }
        self.supervisor.report(Task::Sampling);
        sampled
    }

    /// Starts the gyro and runs its self-test. A gyro that fails the test is reported and still used: wrong
    /// samples appear in the residuals of the estimator, and telemetry has both.
    #[inline(never)]
    fn start_gyro(&mut self) {
        let (gyro, delay) = (&mut self.flight.sensors_mut().gyro, self.board.delay());
        let (mut started, mut has_passed) = (gyro.restart(delay), true);
        if started.is_ok() {
            has_passed = gyro.self_test(delay).is_ok();
            // The restart discards the samples of the test.
            started = gyro.restart(delay);
        }
        self.flight.sensors_mut().data_ready.discard();
        self.gyro.note_start::<P::Gyro>(started, has_passed);
        self.gyro.silent_since_us = self.board.now_us();
    }

    /// Saves a checkpoint when it is due, or erases space for the next one at rest; neither during a manoeuvre.
    fn maintain_checkpoint(&mut self) {
        if self.manoeuvre.is_active() {
            return;
        }
        if self.last_step.is_some() && self.flash.is_due(self.board.now_us()) {
            self.save_checkpoint();
        } else if self.flight.estimator().is_open() && self.estimator().is_at_rest() {
            self.erase_ahead();
        }
    }

    /// Erases space for the next checkpoint, or for the next counters: one of both, each stops the core.
    fn erase_ahead(&mut self) {
        if self.flash.may_need_erasure() {
            self.flash.erase_ahead();
        } else if self.counters.may_need_erasure() {
            self.counters.erase_ahead();
        } else {
            return;
        }
        self.gyro.silent_since_us = self.board.now_us();
    }

    #[inline(never)]
    fn save_checkpoint(&mut self) -> bool {
        self.checked();
        let estimator = self.flight.estimator_mut().get_mut();
        let saved = self.flash.save(estimator, self.manoeuvre, &mut self.board);
        self.gyro.silent_since_us = self.board.now_us();
        saved
    }

    fn send_reports(&mut self) {
        let now_us = self.board.now_us();
        if let Reporting::Every(ms) = self.reporting
            && now_us >= self.next_report_us
        {
            self.next_report_us = now_us.saturating_add(u64::from(ms) * 1_000);
            self.report_estimate();
            self.report_status();
            self.report_manoeuvre();
        } else if self.status_due {
            self.report_status();
            self.report_manoeuvre();
        }
        self.dump_part();
        self.downlink.drain(&mut self.link);
        self.supervisor.report(Task::Reporting);
    }

    /// Queues a report, tagged if a telecommand has asked for it.
    #[inline(never)]
    fn send<R: Report>(&mut self, report: &R) {
        let key = self.uplink.telemetry_key();
        self.downlink.send(self.board.now_us(), report, key.as_ref());
    }

    #[inline(never)]
    fn report_estimate(&mut self) {
        let (sample_time_us, outcome) = match self.last_step {
            Some((time_us, outcome)) => (time_us, Some(outcome)),
            None => (0, None),
        };
        self.checked();
        let wheels = self.flight.wheels_follow();
        let (estimator, health) = self.flight.estimator_and_health();
        let (estimator, id) = (estimator.get(), estimator.get().selected());
        let report = EstimateReport::of(id, estimator, sample_time_us, outcome, health, wheels);
        self.send(&report);
    }

    #[inline(never)]
    fn report_status(&mut self) {
        self.status_due = false;
        let now_us = self.board.now_us();
        let health = self.board.health();
        let failure = health.last_run.failure;
        let counters = self.flight.counters();
        let overruns = self.flight.sensors().data_ready.overruns();
        let accepted = self.uplink.last_accepted();
        let uptime_us = now_us.saturating_sub(self.started_us);
        let slots = self.uplink.ledger().slots();
        let report = StatusReport {
            link_version: LINK_VERSION,
            uptime_s: seconds(uptime_us),
            reset_cause: health.reset_cause,
            failures: health.last_run.failures,
            last_failure: failure.map(|failure| failure.kind),
            last_failure_at: failure.map_or(0, |failure| failure.at),
            last_failure_from: failure.map_or(0, |failure| failure.from),
            clock: health.clock,
            watchdog: health.watchdog,
            brown_out: health.brown_out,
            option_bytes_as_set: health.option_bytes_as_set,
            supply_low: health.supply_low,
            configuration_intact: self.estimator().is_intact(),
            upsets: self.upsets,
            short_lives: u8::try_from(self.short_lives).unwrap_or(u8::MAX),
            stack_high_water_bytes: health.stack_high_water_bytes,
            gyro: self.gyro.state,
            gyro_identity: self.gyro.identity,
            gyro_self_tests_failed: self.gyro.self_tests_failed,
            gyro_failures: counters.gyro_failed,
            wheel_failures: counters.wheels_failed,
            wheel_valid: self.flight.sensors().wheels.are_valid(),
            data_ready_overruns: overruns.saturating_add(counters.overtaken),
            outcomes: counters.outcomes,
            uplink: self.uplink.counters(),
            downlink_dropped: self.downlink.dropped(),
            serial_errors: health.serial_errors.saturating_add(self.downlink.port_errors()),
            last_command: accepted.map(|accepted| accepted.function),
            last_sequence_count: accepted.map_or(0, |accepted| accepted.sequence_count.value()),
            last_command_done: self.last_executed,
            authentication: self.counters.state,
            key_counters: slots.map(|slot| slot.counter),
            key_generations: slots.map(|slot| slot.generation),
            telemetry_slot: self.uplink.ledger().telemetry_slot(),
            telemetry_period_ms: match self.reporting {
                Reporting::Every(ms) => ms,
                Reporting::EachSample => 0,
            },
            torque_n_m: self.torque_n_m,
            checkpoint: self.flash.found,
            checkpoints_saved: self.flash.saved,
            checkpoints_failed: self.flash.failed,
        };
        self.send(&report);
    }

    /// Sends the next part of a requested checkpoint, if the transmit queue has space for it and a report.
    #[inline(never)]
    fn dump_part(&mut self) {
        if !self.downlink.has_room_for(2 * MAX_FRAME) {
            return;
        }
        if let Some(part) = self.flash.next_part() {
            self.send(&part);
        }
    }
}

/// Result of one look for a sample.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sampled {
    /// No sample was pending.
    Nothing,
    /// A sample did not reach the estimator.
    Skipped,
    /// The estimator was stepped.
    Stepped,
}

/// Whole seconds of a time in µs. Saturates.
///
/// Schoolbook division by 15,625 = 10⁶ / 64, 16 bits at a time, in the 32 bits of the core: the library's
/// division of 64 bits takes 640 bytes and has no other caller.
fn seconds(time_us: u64) -> u32 {
    let (mut seconds, mut rest) = (0u64, 0u32);
    for digit in (time_us >> 6).to_be_bytes().as_chunks::<2>().0 {
        let part = rest << 16 | u32::from(u16::from_be_bytes(*digit));
        seconds = seconds << 16 | u64::from(part / 15_625);
        rest = part % 15_625;
    }
    u32::try_from(seconds).unwrap_or(u32::MAX)
}

impl Gyro {
    fn not_started() -> Self {
        Self {
            state: GyroState::NotStarted,
            identity: None,
            self_tests_failed: 0,
            silent_since_us: 0,
        }
    }

    fn note_start<G: RateGyro<StartError: Into<StartFault>>>(
        &mut self,
        started: Result<(), G::StartError>,
        has_passed: bool,
    ) {
        if !has_passed {
            self.self_tests_failed = self.self_tests_failed.saturating_add(1);
        }
        (self.state, self.identity) = match started.map_err(Into::into) {
            Ok(()) if !has_passed => (GyroState::SelfTestFailed, Some(G::IDENTITY)),
            Ok(()) => (GyroState::Ready, Some(G::IDENTITY)),
            Err(StartFault::Bus) => (GyroState::BusError, None),
            Err(StartFault::WrongIdentity { found }) => (GyroState::WrongIdentity, Some(found)),
            Err(StartFault::NotAsSet) => (GyroState::NotAsSet, Some(G::IDENTITY)),
            Err(StartFault::WrongSettings) => (GyroState::WrongSettings, None),
        };
    }
}
