//! The processor in the loop: the flight computer on its own processor, in QEMU, with simulated sensors
//! at register level; and the very same software on the host, to compare with, bit by bit.
//!
//! ```text
//!  scenario ─► truth ─► Bench: chip, encoders, flash ◄── requests ── bin/pil in QEMU ──► telemetry ─┐
//!                  └──► another Bench, the same ◄─────── software: the same code, here ─► telemetry ─┤
//!                                                                           sample by sample: compare
//! ```
//!
//! 1. [`setup`]: what the flight computer is told of the spacecraft.
//! 2. [`mod@bench`], [`flash`]: the hardware, from sample to sample.
//! 3. [`software`]: the flight computer on the host, directly on the chip's wires.
//! 4. [`firmware`]: the image in QEMU, its questions and its telemetry.
//! 5. [`compare`]: the first difference, by name.
//!
//! The host's flight computer knows nothing of the tunnel that the firmware's sensors come through, so
//! that a tunnel which garbles is seen too. At the end both save a checkpoint, and the two flash
//! memories are compared: that is the whole state of the estimator.

pub mod bench;
pub mod compare;
pub mod firmware;
pub mod flash;
pub mod setup;
pub mod software;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Instant;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use fsw_core::outcome::OutcomeCounts;
use fsw_target::drivers::gyro::bmi088::register;
use fsw_target::flight::selected::{EstimatorId, SelectedEstimator};
use fsw_target::link::command::Command;
use fsw_target::link::frame::Frame;
use fsw_target::link::packet::SequenceCount;
use fsw_target::link::telemetry::{Received, Telemetry};
use fsw_target::stand_in::tunnel::Setup;
use thiserror::Error;

use crate::input::Scenario;
use crate::truth::Flight;

use bench::Bench;
use compare::{After, Difference};
use firmware::{Firmware, LineFailed, Request};
use setup::NotFlown;
use software::Software;

/// What to fly.
#[derive(Clone, Copy, Debug)]
pub struct Mission<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its truth.
    pub flight: &'a Flight,
    /// Of the gyro's noise.
    pub seed: u64,
    /// Which estimator.
    pub estimator: EstimatorId,
    /// After so many samples both computers save a checkpoint, lose their power and start again.
    pub restart_at: Option<usize>,
    /// What the ground commands: each after so many samples.
    pub commands: &'a [(usize, Command)],
}

/// A bit of a gyro reading that the processor gets wrong: to see that it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrokenBit {
    /// At which sample, from zero.
    pub sample: usize,
    /// Which byte of the reading, from zero: lower and upper byte of x, y, z.
    pub byte: usize,
    /// Which bit of it, 0 to 7.
    pub bit: u8,
}

/// Why a flight came to no good end.
#[derive(Debug, Error)]
pub enum PilFailed {
    /// A scenario that the flight computer can't fly.
    #[error(transparent)]
    NotFlown(#[from] NotFlown),
    /// No image, or no QEMU.
    #[error("{0:#}")]
    Machine(#[from] anyhow::Error),
    /// A line to the firmware.
    #[error("{why}, {progress}")]
    Line {
        /// What happened.
        why: LineFailed,
        /// How far it had come.
        progress: Progress,
    },
    /// Not the same code: no sample is flown.
    #[error("{0}")]
    NotTheSame(LineFailed),
    /// The same code, other bits.
    #[error(transparent)]
    Differs(#[from] Box<Difference>),
}

/// How far a flight has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Samples that were compared.
    pub compared: usize,
    /// Whether the firmware has said hello since its last start.
    pub has_begun: bool,
}

impl std::fmt::Display for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.has_begun, self.compared) {
            (false, 0) => f.write_str("before it said hello: is the image a pil of this version?"),
            (false, compared) => write!(f, "in its restart after {compared} samples"),
            (true, 0) => f.write_str("before the first sample"),
            (true, compared) => write!(f, "after {compared} samples"),
        }
    }
}

/// A flight at its end.
#[derive(Debug)]
pub struct Flown {
    /// The estimators: the host's, and the firmware's are the same.
    pub onboard: SelectedEstimator,
    /// What became of the samples that were stepped.
    pub outcomes: OutcomeCounts,
    /// Samples skipped because the gyro could not be read.
    pub gyro_failures: u32,
    /// Samples skipped because a tachometer could not be read.
    pub wheel_failures: u32,
    /// Samples that were compared: all.
    pub compared: usize,
    /// The most stack that the firmware has used, bytes, as its telemetry tells.
    pub stack_high_water_bytes: u32,
}

/// Flies a mission on the firmware and on the host, in lock-step, and compares what both tell the ground
/// after each sample. `start` starts the firmware; `watch` is shown the host's computer after each.
///
/// # Errors
/// The first difference; or what kept the flight from its end.
pub fn fly(
    mission: &Mission<'_>,
    mut start: impl FnMut() -> anyhow::Result<Firmware>,
    broken: Option<BrokenBit>,
    mut watch: impl FnMut(&Software<'_, '_>, &[Received]),
) -> Result<Flown, PilFailed> {
    let setup = setup::of(mission)?;
    let samples = mission.flight.instants.len();
    let host = Rc::new(RefCell::new(Bench::new(mission, &setup)));
    let mut onboard = setup.estimator().map_err(NotFlown::Unfit)?;
    let mut duel = Duel {
        firmware: start()?,
        bench: Bench::new(mission, &setup),
        setup,
        broken,
        expected: VecDeque::new(),
        commands: 0,
        progress: Progress::default(),
        when: After::Start,
        stack_high_water_bytes: 0,
    };
    let (mut outcomes, mut gyro_failures, mut wheel_failures) = (OutcomeCounts::default(), 0, 0);

    let legs = [mission.restart_at, Some(samples)];
    for (leg, until) in legs.into_iter().flatten().enumerate() {
        if leg > 0 {
            onboard = duel.setup.estimator().map_err(NotFlown::Unfit)?;
            duel.restart(start()?);
        }
        let mut software =
            Software::start(&host, &duel.setup, &mut onboard).map_err(NotFlown::Unfit)?;
        duel.settle()?;
        if leg == 0 {
            duel.command(&mut software, Command::Select(mission.estimator))?;
        }
        while duel.progress.compared < until {
            for (after, command) in mission.commands {
                if *after == duel.progress.compared {
                    duel.command(&mut software, *command)?;
                }
            }
            let told = software.fly_sample();
            duel.fly_sample(&told)?;
            for received in &told {
                if let Telemetry::Estimate(estimate) = &received.telemetry {
                    estimate.outcome.iter().for_each(|outcome| outcomes.add(outcome));
                }
            }
            watch(&software, &told);
        }
        duel.command(&mut software, Command::SaveCheckpoint)?;
        duel.compare_flash(host.borrow().flash.bytes())?;
        for received in duel.command(&mut software, Command::Ping)? {
            if let Telemetry::Status(status) = received.telemetry {
                gyro_failures += status.gyro_failures;
                wheel_failures += status.wheel_failures;
            }
        }
    }
    // Whether it still hears that doesn't matter.
    let _ = duel.firmware.end();
    let (compared, stack_high_water_bytes) = (duel.progress.compared, duel.stack_high_water_bytes);
    Ok(Flown { onboard, outcomes, gyro_failures, wheel_failures, compared, stack_high_water_bytes })
}

/// The firmware's side of a flight, and what it is to tell the ground.
struct Duel<'a> {
    firmware: Firmware,
    bench: Bench<'a>,
    setup: Setup,
    broken: Option<BrokenBit>,
    /// What the host has told, and the firmware has yet to.
    expected: VecDeque<Received>,
    /// Sent since the last start.
    commands: u16,
    progress: Progress,
    when: After,
    stack_high_water_bytes: u32,
}

impl Duel<'_> {
    /// Another firmware takes over the bench, which has lost nothing but its computer.
    fn restart(&mut self, firmware: Firmware) {
        self.firmware = firmware;
        self.commands = 0;
        self.progress.has_begun = false;
        self.setup.now_us = self.bench.now_us();
    }

    /// Has the firmware handle the next sample, of which the host has told this.
    fn fly_sample(&mut self, told: &[Received]) -> Result<(), PilFailed> {
        self.when = After::Sample(self.progress.compared);
        self.expected.extend(told);
        let announced = self.bench.announce();
        match announced {
            Some(announced) => self.firmware.announce(&announced),
            None => self.firmware.idle(),
        }
        .map_err(|why| self.failed(why))?;
        self.settle()?;
        self.progress.compared += 1;
        Ok(())
    }

    /// Sends a command to both; what both tell of it.
    fn command(
        &mut self,
        software: &mut Software<'_, '_>,
        command: Command,
    ) -> Result<Vec<Received>, PilFailed> {
        self.commands += 1;
        let packet = command.packet(SequenceCount::new(self.commands));
        let frame = packet.and_then(|packet| Frame::of(packet.bytes()));
        let frame = frame.ok_or_else(|| anyhow::anyhow!("a command that fits in no packet"))?;
        let told = software.obey(frame.bytes());
        self.expected.extend(&told);
        let sent = self.firmware.command(frame.bytes()).and_then(|()| self.firmware.idle());
        sent.map_err(|why| self.failed(why))?;
        self.settle()?;
        Ok(told)
    }

    /// Serves the firmware until it asks for a sample and has told the ground all that the host has.
    fn settle(&mut self) -> Result<(), PilFailed> {
        let begun = Instant::now();
        loop {
            let request = self.firmware.request().map_err(|why| self.failed(why))?;
            if request != Request::Next {
                self.serve(request).map_err(|why| self.failed(why))?;
                continue;
            }
            self.compare()?;
            if self.expected.is_empty() {
                return Ok(());
            }
            let patience = self.firmware.patience();
            if begun.elapsed() > patience {
                return Err(self.failed(LineFailed::NoTelemetry(patience)));
            }
            self.firmware.idle().map_err(|why| self.failed(why))?;
        }
    }

    /// What has arrived on the ground, beside what the host has told.
    fn compare(&mut self) -> Result<(), PilFailed> {
        for received in self.firmware.telemetry().map_err(|why| self.failed(why))? {
            if let Telemetry::Status(status) = &received.telemetry {
                self.stack_high_water_bytes =
                    self.stack_high_water_bytes.max(status.stack_high_water_bytes);
            }
            match self.expected.pop_front() {
                Some(expected) => compare::same(self.when, &expected, &received)?,
                None => return Err(Box::new(Difference::unexpected(self.when, &received)).into()),
            }
        }
        Ok(())
    }

    /// Answers a request that isn't for a sample.
    fn serve(&mut self, request: Request) -> Result<(), LineFailed> {
        match request {
            Request::Hello if self.progress.has_begun => Err(LineFailed::Restarted),
            Request::Hello => {
                self.progress.has_begun = true;
                self.firmware.introduce(&self.setup)
            }
            Request::Next => self.firmware.idle(),
            Request::Transfer { written, read } => {
                let mut answer = self.bench.transfer(&written, read);
                if let (Some(broken), Ok(bytes)) = (self.broken, &mut answer) {
                    broken.spoil(self.bench.announced(), &written, bytes);
                }
                let answer = answer.as_ref().map(Vec::as_slice).map_err(|fault| *fault);
                self.firmware.transferred(answer)
            }
            Request::Wait { us } => {
                self.bench.wait(us);
                self.firmware.waited()
            }
            Request::Captures => self.firmware.captured(&self.bench.captured()),
            Request::FlashRead { offset, length } => {
                let mut bytes = vec![0; usize::from(length)];
                let answer = self.bench.flash.read(offset, &mut bytes);
                self.firmware.flash_read(answer.map(|()| bytes.as_slice()))
            }
            Request::FlashWrite { offset, bytes } => {
                let answer = self.bench.flash.write(offset, &bytes);
                self.firmware.flash_written(answer)
            }
            Request::FlashErase { from, to } => {
                let answer = self.bench.flash.erase(from, to);
                self.firmware.flash_erased(answer)
            }
        }
    }

    /// That both have the same in their flash: the estimator's whole state.
    fn compare_flash(&self, host: &[u8]) -> Result<(), PilFailed> {
        let cells = self.bench.flash.bytes().iter().zip(host);
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

    fn failed(&self, why: LineFailed) -> PilFailed {
        match why {
            LineFailed::OtherVersion(_) | LineFailed::OtherSources => PilFailed::NotTheSame(why),
            _ => PilFailed::Line { why, progress: self.progress },
        }
    }
}

impl BrokenBit {
    /// Turns the bit over, if these bytes are that sample's reading.
    fn spoil(&self, announced: usize, written: &[u8], bytes: &mut [u8]) {
        let is_reading = written == [register::RATE_X_LSB | 0x80];
        if is_reading
            && announced == self.sample + 1
            && let Some(byte) = bytes.get_mut(self.byte)
        {
            *byte ^= 1 << (self.bit % 8);
        }
    }
}

#[cfg(test)]
mod tests;
