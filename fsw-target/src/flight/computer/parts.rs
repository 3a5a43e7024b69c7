//! What a board brings to its flight computer, or what stands in for one.

use crate::drivers::gyro::{RateGyro, StartFault};
use crate::flight::craft::WHEELS;
use crate::flight::flight_loop::Sensors;
use crate::flight::sensors::{DataReady, TorqueCommand, WheelTachometers};
use crate::flight::supervisor::FeedPermit;
use crate::link::telemetry::{ClockSource, ResetCause};
use crate::runtime::failure::LastRun;
use embedded_hal::delay::DelayNs;
use embedded_hal_nb::serial::{Read, Write};
use embedded_storage::nor_flash::NorFlash;

/// Between two reports of a kind, until the ground says otherwise, ms.
const TELEMETRY_PERIOD_MS: u32 = 1_000;

/// The parts of a flight computer: types of a board, or of what stands in for one.
pub trait Parts {
    /// Announces samples.
    type DataReady: DataReady;
    /// The gyro.
    type Gyro: RateGyro<StartError: Into<StartFault>>;
    /// The tachometers.
    type Wheels: WheelTachometers<WHEELS>;
    /// The external torque.
    type Torque: TorqueCommand;
    /// The serial port of telemetry and commands.
    type Link: Read<u8> + Write<u8>;
    /// Two equal halves for checkpoints.
    type Flash: NorFlash;
    /// The rest of the board.
    type Board: Housekeeping;
}

/// What else a board does for its computer.
pub trait Housekeeping {
    /// Waits, in bounded time.
    type Delay: DelayNs;

    /// Time since the start, µs: the clock that stamps samples.
    fn now_us(&mut self) -> u64;

    /// Time goes on from here, if it is behind that: it starts where it was when the computer stopped.
    /// Ignored by a clock that doesn't stop with the computer.
    fn resume_at(&mut self, time_us: u64);

    /// For the gyro's start.
    fn delay(&mut self) -> &mut Self::Delay;

    /// Feeds the watchdog.
    fn feed(&mut self, permit: FeedPermit);

    /// How the board is.
    fn health(&mut self) -> Health;
}

/// How a board is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Health {
    /// Why it started.
    pub reset_cause: ResetCause,
    /// What the life before left behind.
    pub last_run: LastRun,
    /// What its clock runs on.
    pub clock: ClockSource,
    /// Whether the watchdog runs.
    pub watchdog: bool,
    /// The most stack that was ever used, bytes; 0 where that isn't measured.
    pub stack_high_water_bytes: u32,
    /// Bytes that the link's port lost.
    pub serial_errors: u32,
}

/// When estimates are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reporting {
    /// So often, until the ground says otherwise, ms; the status as often.
    Every(u32),
    /// After each sample, in step with whoever sends them; the status after each command alone.
    EachSample,
}

impl Default for Reporting {
    fn default() -> Self {
        Self::Every(TELEMETRY_PERIOD_MS)
    }
}

/// The sensors of some parts.
pub type SensorsOf<P> = Sensors<
    <P as Parts>::DataReady,
    <P as Parts>::Gyro,
    <P as Parts>::Wheels,
    <P as Parts>::Torque,
>;
