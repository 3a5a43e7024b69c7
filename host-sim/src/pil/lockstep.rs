//! A flight of firmware and host in lockstep.
//!
//! After each sample and each telecommand the firmware is served until it requests the next sample
//! and has sent the telemetry that the host has sent. Each packet is compared.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Instant;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use fsw_core::outcome::OutcomeCounts;
use fsw_target::flight::manoeuvre::Manoeuvre;
use fsw_target::flight::selected::SelectedEstimator;
use fsw_target::link::command::Command;
use fsw_target::link::frame::Frame;
use fsw_target::link::telemetry::{Received, Telemetry};
use fsw_target::stand_in::tunnel::{Setup, Stated};

use super::compare::{self, After, Difference};
use super::firmware::{Firmware, LineFailed, Request};
use super::hardware::{Hardware, START_US};
use super::mission::{BrokenBit, Mission};
use super::result::{PilFailed, PilFlight, Progress};
use super::setup::{self, NotFlown};
use super::software::Software;
use crate::estimation::Events;

/// Key slot of the telecommands.
const SLOT: u8 = 1;

/// Flies a mission on firmware and host, and compares their telemetry after each sample.
///
/// `start` starts the firmware. `watch` is called after each sample with the host's computer and its
/// telemetry.
///
/// The gyro's filter acts on the motion between the samples: it is simulated if the flight has it not.
///
/// # Errors
/// The first difference, or the failure that ended the flight.
pub fn fly(
    mission: &Mission<'_>,
    start: impl FnMut() -> anyhow::Result<Firmware>,
    broken: Option<BrokenBit>,
    watch: impl FnMut(&Software<'_, '_>, &[Received]),
) -> Result<PilFlight, PilFailed> {
    if mission.flight.trajectory.is_some() {
        return fly_with_filter(mission, start, broken, watch);
    }
    let flight = mission.flight.clone().with_trajectory(mission.scenario)?;
    fly_with_filter(&Mission { flight: &flight, ..*mission }, start, broken, watch)
}

/// As [`fly`], along a trajectory.
fn fly_with_filter(
    mission: &Mission<'_>,
    mut start: impl FnMut() -> anyhow::Result<Firmware>,
    broken: Option<BrokenBit>,
    mut watch: impl FnMut(&Software<'_, '_>, &[Received]),
) -> Result<PilFlight, PilFailed> {
    let setup = setup::of(mission)?;
    let host = Rc::new(RefCell::new(Hardware::new(mission, &setup)));
    let stated = setup::stated(mission);
    let mut estimator = setup.estimator(&stated).map_err(NotFlown::Unfit)?;
    let mut lockstep = Lockstep::new(mission, setup, start()?, broken);
    let legs = [mission.restart_at, Some(mission.flight.instants.len())];
    for (leg, until) in legs.into_iter().flatten().enumerate() {
        if leg > 0 {
            estimator = lockstep.setup.estimator(&stated).map_err(NotFlown::Unfit)?;
            lockstep.restart(start()?);
        }
        let mut manoeuvre = Manoeuvre::new(estimator.craft().spin_inertia_kg_m2);
        let kept = (&mut estimator, &mut manoeuvre);
        let mut software =
            Software::start(&host, &lockstep.setup, kept).map_err(NotFlown::Unfit)?;
        lockstep.settle()?;
        if leg == 0 {
            lockstep.command(&mut software, Command::Select(mission.estimator))?;
        }
        lockstep.fly_leg(mission, &mut software, until, &mut watch)?;
        lockstep.command(&mut software, Command::SaveCheckpoint)?;
        lockstep.compare_flash(host.borrow().flash.bytes())?;
        lockstep.count_failures(&mut software)?;
    }
    // The flight is complete: a failure to announce the end does not matter.
    let _ = lockstep.firmware.end();
    Ok(lockstep.counts.into_flight(estimator, lockstep.progress.compared))
}

/// The firmware's side of a flight, and the telemetry expected from it.
struct Lockstep<'a> {
    firmware: Firmware,
    hardware: Hardware<'a>,
    setup: Setup,
    stated: Stated,
    broken: Option<BrokenBit>,
    /// Telemetry that the host has sent and the firmware has not.
    expected: VecDeque<Received>,
    /// Telecommands sent, over a restart too: their counter.
    commands: u32,
    progress: Progress,
    when: After,
    counts: Counts,
}

/// Counters of a flight.
#[derive(Default)]
struct Counts {
    outcomes: OutcomeCounts,
    events: Events,
    gyro_failures: u32,
    wheel_failures: u32,
    wheel_doubts: u32,
    stack_high_water_bytes: u32,
}

impl Counts {
    fn into_flight(self, estimator: SelectedEstimator, compared: usize) -> PilFlight {
        let Self {
            outcomes,
            events,
            gyro_failures,
            wheel_failures,
            wheel_doubts,
            stack_high_water_bytes,
        } = self;
        PilFlight {
            estimator,
            outcomes,
            events,
            gyro_failures,
            wheel_failures,
            wheel_doubts,
            compared,
            stack_high_water_bytes,
        }
    }
}

impl<'a> Lockstep<'a> {
    fn new(
        mission: &Mission<'a>,
        setup: Setup,
        firmware: Firmware,
        broken: Option<BrokenBit>,
    ) -> Self {
        Self {
            firmware,
            hardware: Hardware::new(mission, &setup),
            setup,
            stated: setup::stated(mission),
            broken,
            expected: VecDeque::new(),
            commands: 0,
            progress: Progress::default(),
            when: After::Start,
            counts: Counts::default(),
        }
    }

    /// Connects a new firmware to the hardware after a power cut of the computer.
    fn restart(&mut self, firmware: Firmware) {
        self.firmware = firmware;
        self.progress.has_started = false;
        self.setup.now_us = self.hardware.now_us();
    }

    /// Flies until `until` samples are compared, with the telecommands of the mission.
    fn fly_leg(
        &mut self,
        mission: &Mission<'_>,
        software: &mut Software<'_, '_>,
        until: usize,
        watch: &mut impl FnMut(&Software<'_, '_>, &[Received]),
    ) -> Result<(), PilFailed> {
        while self.progress.compared < until {
            for (after, command) in mission.commands {
                if *after == self.progress.compared {
                    self.command(software, *command)?;
                }
            }
            let telemetry = software.fly_sample();
            self.fly_sample(&telemetry)?;
            for received in &telemetry {
                if let Telemetry::Estimate(estimate) = &received.telemetry
                    && let Some(outcome) = &estimate.outcome
                {
                    self.counts.outcomes.add(outcome);
                    let time_us = estimate.sample_time_us.saturating_sub(START_US);
                    self.counts.events.add(time_us, outcome);
                }
            }
            watch(software, &telemetry);
        }
        Ok(())
    }

    /// Adds the failure counters of the status since the last start.
    fn count_failures(&mut self, software: &mut Software<'_, '_>) -> Result<(), PilFailed> {
        for received in self.command(software, Command::Ping)? {
            if let Telemetry::Status(status) = received.telemetry {
                self.counts.gyro_failures += status.gyro_failures;
                self.counts.wheel_failures += status.wheel_failures;
            }
        }
        Ok(())
    }

    /// Announces the next sample to the firmware. `telemetry` is that of the host after the sample.
    fn fly_sample(&mut self, telemetry: &[Received]) -> Result<(), PilFailed> {
        self.when = After::Sample(self.progress.compared);
        self.expected.extend(telemetry);
        let announced = self.hardware.announce();
        match announced {
            Some(announced) => self.firmware.announce(&announced),
            None => self.firmware.idle(),
        }
        .map_err(|error| self.failed(error))?;
        self.settle()?;
        self.progress.compared += 1;
        Ok(())
    }

    /// Sends a telecommand to both computers. Output: the telemetry of both.
    fn command(
        &mut self,
        software: &mut Software<'_, '_>,
        command: Command,
    ) -> Result<Vec<Received>, PilFailed> {
        self.commands += 1;
        let packet =
            command.tagged_packet(&setup::MASTER_KEY.of_slot(SLOT, 0), SLOT, self.commands);
        let frame = packet.and_then(|packet| Frame::of(packet.bytes()));
        let frame = frame.ok_or_else(|| anyhow::anyhow!("telecommand larger than a packet"))?;
        let telemetry = software.execute(frame.bytes());
        self.expected.extend(&telemetry);
        let sent = self.firmware.command(frame.bytes()).and_then(|()| self.firmware.idle());
        sent.map_err(|error| self.failed(error))?;
        self.settle()?;
        Ok(telemetry)
    }

    /// Serves the firmware until it requests a sample and has sent all expected telemetry.
    fn settle(&mut self) -> Result<(), PilFailed> {
        let start = Instant::now();
        loop {
            let request = self.firmware.request().map_err(|error| self.failed(error))?;
            if request != Request::Next {
                self.serve(request).map_err(|error| self.failed(error))?;
                continue;
            }
            self.compare()?;
            if self.expected.is_empty() {
                return Ok(());
            }
            let patience = self.firmware.patience();
            if start.elapsed() > patience {
                return Err(self.failed(LineFailed::NoTelemetry(patience)));
            }
            self.firmware.idle().map_err(|error| self.failed(error))?;
        }
    }

    /// Compares the telemetry received with that expected.
    fn compare(&mut self) -> Result<(), PilFailed> {
        for received in self.firmware.telemetry().map_err(|error| self.failed(error))? {
            if let Telemetry::Estimate(estimate) = &received.telemetry {
                self.counts.wheel_doubts += u32::from(estimate.wheel_follows.contains(&false));
            }
            if let Telemetry::Status(status) = &received.telemetry {
                let stack = &mut self.counts.stack_high_water_bytes;
                *stack = (*stack).max(status.stack_high_water_bytes);
            }
            match self.expected.pop_front() {
                Some(expected) => compare::packets(self.when, &expected, &received)?,
                None => return Err(Box::new(Difference::unexpected(self.when, &received)).into()),
            }
        }
        Ok(())
    }

    /// Answers a request.
    fn serve(&mut self, request: Request) -> Result<(), LineFailed> {
        match request {
            Request::Hello if self.progress.has_started => Err(LineFailed::Restarted),
            Request::Hello => {
                self.progress.has_started = true;
                self.firmware.introduce(&self.setup)
            }
            Request::Hardware => self.firmware.state(&self.stated),
            Request::Next => self.firmware.idle(),
            Request::Transfer { written, read } => {
                let mut answer = self.hardware.transfer(&written, read);
                if let (Some(broken), Ok(bytes)) = (self.broken, &mut answer) {
                    broken.invert(self.hardware.announced(), &written, bytes);
                }
                let answer = answer.as_ref().map(Vec::as_slice).map_err(|fault| *fault);
                self.firmware.transferred(answer)
            }
            Request::Wait { us } => {
                self.hardware.wait(us);
                self.firmware.waited()
            }
            Request::Captures => {
                let motors_n_m = self.hardware.motor_torque_n_m();
                self.firmware.captured(&self.hardware.captured(), motors_n_m)
            }
            Request::Motors { torque_n_m } => {
                let is_taken = self.hardware.command_motors(&torque_n_m);
                self.firmware.commanded(is_taken)
            }
            Request::FlashRead { offset, length } => {
                let mut bytes = vec![0; usize::from(length)];
                let answer = self.hardware.flash.read(offset, &mut bytes);
                self.firmware.flash_read(answer.map(|()| bytes.as_slice()))
            }
            Request::FlashWrite { offset, bytes } => {
                let answer = self.hardware.flash.write(offset, &bytes);
                self.firmware.flash_written(answer)
            }
            Request::FlashErase { from, to } => {
                let answer = self.hardware.flash.erase(from, to);
                self.firmware.flash_erased(answer)
            }
        }
    }

    /// Compares the flash memories, which hold the whole state of the estimators.
    fn compare_flash(&self, host: &[u8]) -> Result<(), PilFailed> {
        let cells = self.hardware.flash.bytes().iter().zip(host);
        for (offset, (firmware, host)) in cells.enumerate() {
            if firmware != host {
                let cell = |byte: &u8| format!("{byte:#04x}");
                return Err(Box::new(Difference {
                    when: self.when,
                    element: format!("byte {offset} of the checkpoint in flash"),
                    firmware: cell(firmware),
                    host: cell(host),
                })
                .into());
            }
        }
        Ok(())
    }

    fn failed(&self, error: LineFailed) -> PilFailed {
        match error {
            LineFailed::OtherVersion(_) | LineFailed::OtherSources => PilFailed::OtherBuild(error),
            _ => PilFailed::Line { error, progress: self.progress },
        }
    }
}
