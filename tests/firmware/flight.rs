//! The flight image in QEMU, as flashed, with a ground station on its serial port.
//!
//! QEMU has no gyro, a flash that cannot be programmed, and a clock unit that reads 0. The image has
//! to report each and to continue.

use anyhow::{Context, Result, bail};
use fsw_core::Prior;
use fsw_core::Status;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::Receiver;
use fsw_target::link::authentication::Authentication;
use fsw_target::link::command::{Command, Function};
use fsw_target::link::frame::Frame;
use fsw_target::link::packet::SequenceCount;
use fsw_target::link::telemetry::{
    BrownOutLevel, CheckpointState, ClockSource, EstimateReport, GyroState, StatusReport, Telemetry,
};
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use target_tools::image::Memory;
use target_tools::machine::Machine;
use target_tools::{budgets, firmware, image};

/// Time limit of a report, which takes milliseconds in QEMU. A loaded machine takes longer.
const LIMIT: Duration = Duration::from_secs(60);

/// Ground station.
struct Ground {
    _machine: Machine,
    port: UnixStream,
    receiver: Receiver,
    received: VecDeque<Telemetry>,
}

fn flight() -> Result<PathBuf> {
    firmware::build("flight")
}

impl Ground {
    fn start() -> Result<Self> {
        let (machine, [port]) = Machine::start(&flight()?)?;
        port.set_read_timeout(Some(Duration::from_millis(100)))?;
        Ok(Self {
            _machine: machine,
            port,
            receiver: Receiver::default(),
            received: VecDeque::new(),
        })
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.port.write_all(bytes).context("the link is closed")
    }

    fn command(&mut self, command: Command, sequence_count: u16) -> Result<()> {
        self.send(&frame(command, sequence_count)?)
    }

    /// Waits for the first telemetry packet that `wanted` accepts.
    fn wait_for<R>(&mut self, mut wanted: impl FnMut(&Telemetry) -> Option<R>) -> Result<R> {
        let deadline = Instant::now() + LIMIT;
        let mut bytes = [0; 256];
        while Instant::now() < deadline {
            while let Some(telemetry) = self.received.pop_front() {
                if let Some(found) = wanted(&telemetry) {
                    return Ok(found);
                }
            }
            let count = match self.port.read(&mut bytes) {
                Ok(0) => bail!("the image has ended"),
                Ok(count) => count,
                Err(_) => continue,
            };
            for byte in &bytes[..count] {
                if let Some(received) = self.receiver.push(*byte) {
                    self.received.push_back(received?.telemetry);
                }
            }
        }
        bail!("no such packet within {} s", LIMIT.as_secs())
    }

    fn status(&mut self, wanted: impl Fn(&StatusReport) -> bool) -> Result<StatusReport> {
        self.wait_for(|telemetry| match telemetry {
            Telemetry::Status(status) if wanted(status) => Some(*status),
            _ => None,
        })
    }

    fn estimate(&mut self, wanted: impl Fn(&EstimateReport) -> bool) -> Result<EstimateReport> {
        self.wait_for(|telemetry| match telemetry {
            Telemetry::Estimate(estimate) if wanted(estimate) => Some(*estimate),
            _ => None,
        })
    }

    /// Waits for the status after a telecommand.
    fn answer(&mut self, sequence_count: u16) -> Result<StatusReport> {
        self.status(|status| status.last_sequence_count == sequence_count)
    }
}

fn frame(command: Command, sequence_count: u16) -> Result<Vec<u8>> {
    let packet = command.packet(SequenceCount::new(sequence_count)).context("a packet")?;
    Ok(Frame::of(packet.bytes()).context("a frame")?.bytes().to_vec())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn missing_gyro_flash_and_crystal_are_reported_and_the_loop_continues() -> Result<()> {
    let _alone = crate::alone();
    let mut ground = Ground::start()?;
    let first = ground.status(|_| true)?;
    // Without a chip on the SPI the identity register reads 0.
    assert_eq!((first.gyro, first.gyro_identity), (GyroState::WrongIdentity, Some(0)));
    assert_eq!(first.clock, ClockSource::Internal);
    // No watchdog, no option bytes, no key: each is read back.
    assert!(!first.watchdog && !first.option_bytes_as_set && !first.supply_low);
    assert_eq!(first.brown_out, BrownOutLevel::Unknown);
    assert_eq!(first.authentication, Authentication::Off);
    let stack = first.stack_high_water_bytes;
    let most = budgets::FLIGHT_STACK.held - budgets::INTERRUPTS_STACK;
    println!("flight, without a gyro: {stack} bytes of stack");
    assert!(stack > 0 && u64::from(stack) <= most, "{stack} bytes of stack, of {most}");
    assert_eq!(first.outcomes.accepted, 0);
    let estimate = ground.estimate(|_| true)?;
    assert_eq!((estimate.estimator, estimate.outcome), (EstimatorId::Window, None));
    assert_eq!(estimate.status, Status::Unobservable);
    // The loop continues: reports arrive, and the gyro is restarted.
    ground.status(|status| status.uptime_s >= first.uptime_s + 3)?;
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn telecommands_are_executed_and_answered() -> Result<()> {
    let _alone = crate::alone();
    let mut ground = Ground::start()?;
    ground.status(|_| true)?;
    ground.command(Command::Select(EstimatorId::JointEkf), 1)?;
    let answer = ground.answer(1)?;
    assert_eq!(
        (answer.last_command, answer.last_command_done),
        (Some(Function::Select), Some(true))
    );
    ground.estimate(|estimate| estimate.estimator == EstimatorId::JointEkf)?;

    let prior = Prior {
        inertia_kg_m2: [0.06, 0.1, 0.12, 0.0, 0.0, 0.0],
        sigma_kg_m2: [0.02, 0.02, 0.02, 0.005, 0.005, 0.005],
    };
    ground.command(Command::SetPrior(prior), 2)?;
    assert_eq!(ground.answer(2)?.last_command_done, Some(true));
    let estimate = ground.estimate(|estimate| estimate.inertia_kg_m2[0] == 0.06)?;
    assert_eq!(estimate.inertia_kg_m2, prior.inertia_kg_m2);

    // QEMU's flash cannot be programmed: reading back detects it, and the status reports it.
    ground.command(Command::SaveCheckpoint, 3)?;
    let answer = ground.answer(3)?;
    assert_eq!((answer.last_command_done, answer.checkpoints_failed), (Some(false), 1));
    assert_eq!(answer.checkpoint, CheckpointState::None);
    Ok(())
}

/// Three short lives would take a fault; a reboot by telecommand is none.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn reboot_is_answered_and_restarts_the_computer() -> Result<()> {
    let _alone = crate::alone();
    let mut ground = Ground::start()?;
    ground.status(|status| status.uptime_s >= 3)?;
    ground.command(Command::Reboot, 1)?;
    assert_eq!(ground.answer(1)?.last_command_done, Some(true));
    let restarted = ground.status(|status| status.last_command.is_none())?;
    assert_eq!((restarted.failures, restarted.short_lives), (0, 0));
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn malformed_truncated_replayed_and_oversized_telecommands_are_counted_and_ignored() -> Result<()> {
    let _alone = crate::alone();
    let mut ground = Ground::start()?;
    ground.status(|_| true)?;
    ground.command(Command::Ping, 100)?;
    ground.answer(100)?;

    let good = frame(Command::Select(EstimatorId::JointEkf), 101)?;
    ground.send(&good[..good.len() / 2])?;
    ground.send(&[0])?;
    let mut flipped = good.clone();
    flipped[9] ^= 0x10;
    ground.send(&flipped)?;
    ground.send(&[0x55; 300])?;
    ground.send(&[0])?;
    ground.command(Command::Reset, 100)?;
    ground.command(Command::Reset, 99)?;
    ground.command(Command::Ping, 101)?;

    let uplink = ground.answer(101)?.uplink;
    assert_eq!((uplink.accepted, uplink.replayed, uplink.oversized), (2, 2, 1), "{uplink:?}");
    assert!(uplink.truncated + uplink.wrong_checksum + uplink.malformed >= 2, "{uplink:?}");
    let estimate = ground.estimate(|_| true)?;
    assert_eq!(estimate.estimator, EstimatorId::Window, "no telecommand was executed");
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target: tests/check.sh runs it"]
fn flight_image_is_within_its_memory_budget() -> Result<()> {
    let _alone = crate::alone();
    let Memory { flash, static_ram } = image::memory(&flight()?)?;
    println!("flight: flash {flash} bytes, static RAM {static_ram} bytes");
    assert!(flash <= budgets::FLIGHT_FLASH.held, "{flash} bytes of flash");
    assert!(static_ram <= budgets::FLIGHT_STATIC_RAM.held, "{static_ram} bytes of static RAM");
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target: tests/check.sh runs it"]
fn flight_image_has_no_code_that_panics_allocates_emulates_doubles_or_needs_a_debugger()
-> Result<()> {
    let _alone = crate::alone();
    let symbols = image::symbols(&flight()?)?;
    assert!(symbols.iter().any(|name| name == "main"), "the image has no symbol table");
    let unwanted: Vec<_> = symbols.iter().filter(|name| image::is_unwanted(name)).collect();
    assert!(unwanted.is_empty(), "{unwanted:#?}");
    assert!(!symbols.iter().any(|name| name.contains("semihosting")));
    Ok(())
}
