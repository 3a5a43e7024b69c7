//! The flight computer: what the loop of an image does, again and again.
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
//! Input: the [`Parts`] that a board brings, or the simulator in its place. Output: telemetry, and
//! leave to feed the watchdog once every task has done its work. [`Computer::poll`] never waits but
//! for the gyro's start (0.2 s, and only while there is no gyro to lose samples of) and for the flash
//! (see [`crate::store`]), and never ends the loop: whatever fails is counted and told.
//!
//! An erasure of the flash costs a second or two of samples. Room for the next checkpoint is made at the
//! start, and whenever `window` sees that nothing moves and has concluded what did. Only where neither comes
//! between two checkpoints, as with the other estimators, which don't know of rest, one may come with an
//! erasure: that of `window` each eighth time.
//!
//! What is done now and then is not inlined into the loop: there its locals would lie under the step of
//! an estimator, whose own need of the stack is the largest.

mod checkpoints;
mod parts;
#[cfg(test)]
mod tests;

pub use parts::{Health, Housekeeping, Parts, Reporting, SensorsOf};

use checkpoints::Checkpoints;

use crate::drivers::gyro::{RateGyro, StartFault};
use crate::flight::craft::WHEELS;
use crate::flight::flight_loop::{FlightLoop, Tick};
use crate::flight::selected::SelectedEstimator;
use crate::flight::sensors::{DataReady, TorqueCommand};
use crate::flight::supervisor::{Supervisor, Task};
use crate::link::command::{Command, MAX_COMMAND};
use crate::link::frame::MAX_FRAME;
use crate::link::telemetry::{EstimateReport, GyroState, StatusReport};
use crate::link::{Downlink, Uplink};
use embedded_hal_nb::nb;
use embedded_hal_nb::serial::Read;
use fsw_core::{Outcome, Vec3};

/// Bytes that wait for the line: two reports and a part of a checkpoint.
const QUEUE: usize = 768;

/// Received bytes that one poll looks at: more than a command, fewer than keep a sample waiting.
const BYTES_PER_POLL: usize = 64;
const _: () = assert!(BYTES_PER_POLL >= MAX_COMMAND);

/// Without a reading for so long, the gyro is started anew; so soon again if that fails, µs. While the flash is
/// worked on no sample can come, and that time doesn't count: an erasure takes longer.
const GYRO_SILENCE_US: u64 = 1_000_000;

type FlightLoopOf<'a, P> = FlightLoop<
    &'a mut SelectedEstimator,
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
    /// On-board time when this computer started.
    started_us: u64,
    link: P::Link,
    uplink: Uplink,
    downlink: Downlink<QUEUE>,
    flash: Checkpoints<P::Flash>,
    supervisor: Supervisor,
    reporting: Reporting,
    next_report_us: u64,
    gyro: Gyro,
    last: Option<(u64, Outcome)>,
    /// Whether the last command was done, and has to be answered.
    last_done: Option<bool>,
    must_answer: bool,
    torque_n_m: [f32; 3],
}

/// How the gyro was at its last start, and since when it is waited for.
struct Gyro {
    state: GyroState,
    identity: Option<u8>,
    /// Self-tests that weren't passed, since the computer's start.
    self_tests_failed: u32,
    /// Its last reading or start, or the end of what kept the computer from listening.
    silent_since_us: u64,
}

impl<'a, P: Parts> Computer<'a, P> {
    /// A computer on its parts, that hasn't touched them yet. Inline, so that one can be built where it
    /// stays: it takes more than a kilobyte.
    #[inline(always)]
    pub fn new(
        onboard: &'a mut SelectedEstimator,
        sensors: SensorsOf<P>,
        link: P::Link,
        flash: P::Flash,
        board: P::Board,
        reporting: Reporting,
    ) -> Self {
        Self {
            flight: FlightLoop::new(onboard, sensors),
            board,
            started_us: 0,
            link,
            uplink: Uplink::new(),
            downlink: Downlink::new(),
            flash: Checkpoints::unopened(flash),
            supervisor: Supervisor::new(),
            reporting,
            next_report_us: 0,
            gyro: Gyro::not_started(),
            last: None,
            last_done: None,
            must_answer: false,
            torque_n_m: [0.0; 3],
        }
    }

    /// Goes on from the last checkpoint, if it can, and starts the gyro. Call it once, before the
    /// first [`poll`](Self::poll).
    ///
    /// On-board time goes on from the checkpoint's, so that samples stay in order; how long the
    /// computer was off nobody knows, so that the estimator sees a gap.
    pub fn start(&mut self) {
        self.flash.restore(self.flight.estimator_mut(), &mut self.board);
        self.started_us = self.board.now_us();
        self.next_report_us = self.started_us;
        self.flash.make_room();
        self.start_gyro();
    }

    /// One round: what the ground asks, what the sensors say, what the ground is told.
    pub fn poll(&mut self) {
        self.take_commands();
        self.take_sample();
        self.keep_checkpoint();
        self.send_reports();
        if let Some(permit) = self.supervisor.permit() {
            self.board.feed(permit);
        }
    }

    /// The estimators.
    pub fn onboard(&self) -> &SelectedEstimator {
        self.flight.estimator()
    }

    /// Bytes that wait for the link.
    pub fn waiting_bytes(&self) -> usize {
        self.downlink.waiting()
    }

    fn take_commands(&mut self) {
        for _ in 0..BYTES_PER_POLL {
            match self.link.read() {
                Ok(byte) => {
                    if let Some(command) = self.uplink.push(byte) {
                        self.last_done = Some(self.obey(command));
                        self.must_answer = true;
                        // The next one waits until this one is answered.
                        break;
                    }
                }
                Err(nb::Error::WouldBlock) => break,
                // Counted by the port; what is around the byte is still to come.
                Err(nb::Error::Other(_)) => {}
            }
        }
        self.supervisor.report(Task::Commanding);
    }

    /// Does what the ground asks; false if it can't be done.
    #[inline(never)]
    fn obey(&mut self, command: Command) -> bool {
        let onboard = self.flight.estimator_mut();
        let done = match command {
            Command::Ping | Command::StartSequence => Ok(()),
            Command::Reset => onboard.reset(),
            Command::SetPrior(prior) => onboard.set_prior(prior),
            Command::OpenWindow => onboard.open_window(),
            Command::CloseWindow => onboard.close_window(),
            Command::Select(id) => onboard.select(id),
            Command::SaveCheckpoint => return self.save_checkpoint(),
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
        let is_kept = matches!(command, Command::Reset | Command::SetPrior(_) | Command::Select(_));
        if is_kept && done.is_ok() {
            self.flash.save_soon(self.board.now_us());
        }
        done.is_ok()
    }

    fn take_sample(&mut self) {
        let tick = self.flight.tick();
        if !matches!(tick, Tick::Idle | Tick::GyroFailed(_)) {
            self.gyro.silent_since_us = self.board.now_us();
        }
        if let Tick::Stepped { time_us, outcome } = tick {
            self.last = Some((time_us, outcome));
            if self.reporting == Reporting::EachSample {
                self.report_estimate();
            }
        }
        let silence_us = self.board.now_us().saturating_sub(self.gyro.silent_since_us);
        if silence_us > GYRO_SILENCE_US {
            self.start_gyro();
        }
        self.supervisor.report(Task::Sampling);
    }

    /// Starts the gyro and has it test itself. One that fails its test is reported, and flies all the same:
    /// wrong samples show in what the estimator says of its residuals, and the ground has seen both.
    #[inline(never)]
    fn start_gyro(&mut self) {
        let (gyro, delay) = (&mut self.flight.sensors_mut().gyro, self.board.delay());
        let (mut started, mut has_passed) = (gyro.restart(delay), true);
        if started.is_ok() {
            has_passed = gyro.self_test(delay).is_ok();
            // What the test has made it feel goes with a reset.
            started = gyro.restart(delay);
        }
        self.flight.sensors_mut().data_ready.forget();
        self.gyro.note_start::<P::Gyro>(started, has_passed);
        self.gyro.silent_since_us = self.board.now_us();
    }

    /// Between two samples, saves a checkpoint when it is time, and makes room for the next one when nothing
    /// moves.
    fn keep_checkpoint(&mut self) {
        if self.last.is_some() && self.flash.is_due(self.board.now_us()) {
            self.save_checkpoint();
        } else if self.flash.needs_room() && self.flight.estimator().is_at_rest() {
            self.flash.make_room();
            self.gyro.silent_since_us = self.board.now_us();
        }
    }

    #[inline(never)]
    fn save_checkpoint(&mut self) -> bool {
        let saved = self.flash.save(self.flight.estimator_mut(), &mut self.board);
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
        } else if self.must_answer {
            self.report_status();
        }
        self.dump_part();
        self.downlink.drain(&mut self.link);
        self.supervisor.report(Task::Reporting);
    }

    #[inline(never)]
    fn report_estimate(&mut self) {
        let (sample_time_us, outcome) = match self.last {
            Some((time_us, outcome)) => (time_us, Some(outcome)),
            None => (0, None),
        };
        let onboard = self.flight.estimator();
        let id = onboard.selected();
        let report = EstimateReport::of(id, &**onboard, sample_time_us, outcome);
        self.downlink.send(self.board.now_us(), &report);
    }

    #[inline(never)]
    fn report_status(&mut self) {
        self.must_answer = false;
        let now_us = self.board.now_us();
        let health = self.board.health();
        let failure = health.last_run.failure;
        let counters = self.flight.counters();
        let overruns = self.flight.sensors().data_ready.overruns();
        let accepted = self.uplink.last_accepted();
        let uptime_us = now_us.saturating_sub(self.started_us);
        let report = StatusReport {
            uptime_s: u32::try_from(uptime_us / 1_000_000).unwrap_or(u32::MAX),
            reset_cause: health.reset_cause,
            failures: health.last_run.failures,
            last_failure: failure.map(|failure| failure.kind),
            last_failure_at: failure.map_or(0, |failure| failure.at),
            last_failure_from: failure.map_or(0, |failure| failure.from),
            clock: health.clock,
            watchdog: health.watchdog,
            stack_high_water_bytes: health.stack_high_water_bytes,
            gyro: self.gyro.state,
            gyro_identity: self.gyro.identity,
            gyro_self_tests_failed: self.gyro.self_tests_failed,
            gyro_failures: counters.gyro_failed,
            wheel_failures: counters.wheels_failed,
            data_ready_overruns: overruns.saturating_add(counters.overtaken),
            outcomes: counters.outcomes,
            uplink: self.uplink.counters(),
            downlink_dropped: self.downlink.dropped(),
            serial_errors: health.serial_errors.saturating_add(self.downlink.port_errors()),
            last_command: accepted.map(|accepted| accepted.function),
            last_sequence_count: accepted.map_or(0, |accepted| accepted.sequence_count.value()),
            last_command_done: self.last_done,
            telemetry_period_ms: match self.reporting {
                Reporting::Every(ms) => ms,
                Reporting::EachSample => 0,
            },
            torque_n_m: self.torque_n_m,
            checkpoint: self.flash.found,
            checkpoints_saved: self.flash.saved,
            checkpoints_failed: self.flash.failed,
        };
        self.downlink.send(now_us, &report);
    }

    /// Sends the next part of a checkpoint, if one is asked for and the line has room beside reports.
    #[inline(never)]
    fn dump_part(&mut self) {
        if !self.downlink.has_room_for(2 * MAX_FRAME) {
            return;
        }
        if let Some(part) = self.flash.next_part() {
            self.downlink.send(self.board.now_us(), &part);
        }
    }
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
