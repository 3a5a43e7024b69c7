//! Interface of a flight computer to its board, or to the simulator in place of a board.

use crate::flight::craft::WHEELS;
use crate::flight::flight_loop::Sensors;
use crate::flight::sensors::{DataReady, TorqueCommand, WheelMotors, WheelTachometers};
use crate::flight::sensors::{RateGyro, StartFault};
use crate::flight::supervisor::FeedPermit;
use crate::link::authentication::Key;
use crate::link::telemetry::{BrownOutLevel, ClockSource, ResetCause};
use crate::runtime::failure::LastRun;
use embedded_hal::delay::DelayNs;
use embedded_hal_nb::serial::{Read, Write};
use embedded_storage::nor_flash::NorFlash;

/// Telemetry period until a telecommand sets another one, ms.
const TELEMETRY_PERIOD_MS: u32 = 1_000;

/// Types of the parts of a flight computer.
pub trait Parts {
    /// Time stamps of gyro samples.
    type DataReady: DataReady;
    /// Gyro.
    type Gyro: RateGyro<StartError: Into<StartFault>>;
    /// Wheel tachometers.
    type Wheels: WheelTachometers<WHEELS>;
    /// External torque.
    type Torque: TorqueCommand;
    /// Serial port of telemetry and telecommands.
    type Link: Read<u8> + Write<u8>;
    /// Flash of the checkpoints, in two equal halves.
    type Flash: NorFlash;
    /// Flash of the telecommand counters, in two equal halves.
    type CounterFlash: NorFlash;
    /// Clock, watchdog and health of the board.
    type Board: Housekeeping;
}

/// Services of a board beside sensors, link and flash.
pub trait Housekeeping {
    /// Delay of bounded duration.
    type Delay: DelayNs;
    /// Motors of the wheels.
    type Motors: WheelMotors<WHEELS>;

    /// On-board time, µs: the clock that stamps samples.
    fn now_us(&mut self) -> u64;

    /// Advances the clock to at least this time, µs: on-board time continues after that of the checkpoint.
    /// Ignored by a clock that runs independently of the computer.
    fn resume_at(&mut self, time_us: u64);

    /// Delay for the start of the gyro.
    fn delay(&mut self) -> &mut Self::Delay;

    /// Motors of the wheels, for a manoeuvre.
    fn motors(&mut self) -> &mut Self::Motors;

    /// Feeds the watchdog.
    fn feed(&mut self, permit: FeedPermit);

    /// Health of the board.
    fn health(&mut self) -> Health;

    /// Records that this run has lasted [`LONG_LIFE_US`](super::LONG_LIFE_US): it ends a row of short lives.
    fn note_long_life(&mut self) {}

    /// Resets the computer. Returns where there is nothing to reset.
    fn reboot(&mut self) {}
}

/// Flash and key of the authentication of telecommands.
#[derive(Debug)]
pub struct Security<F> {
    /// Flash of the counters.
    pub flash: F,
    /// Master key; `None`: telecommands are accepted without a tag.
    pub master: Option<Key>,
}

/// Health of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Health {
    /// Cause of the last reset.
    pub reset_cause: ResetCause,
    /// Failure that ended the last run.
    pub last_run: LastRun,
    /// Clock source in use.
    pub clock: ClockSource,
    /// True if the watchdog is running.
    pub watchdog: bool,
    /// Brown-out level in the option bytes.
    pub brown_out: BrownOutLevel,
    /// True if the option bytes are those of a flight board.
    pub option_bytes_as_set: bool,
    /// True if the supply is below the limit of flash operations.
    pub supply_low: bool,
    /// High-water mark of the stack, bytes; 0 if not measured.
    pub stack_high_water_bytes: u32,
    /// Bytes lost by the port of the link.
    pub serial_errors: u32,
}

/// Schedule of the telemetry reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reporting {
    /// Estimate and status at this period, ms, until a telecommand sets another one.
    Every(u32),
    /// An estimate after each sample, a status after each telecommand: lock-step with a simulator.
    EachSample,
}

impl Default for Reporting {
    fn default() -> Self {
        Self::Every(TELEMETRY_PERIOD_MS)
    }
}

/// Sensors of these parts.
pub type SensorsOf<P> = Sensors<
    <P as Parts>::DataReady,
    <P as Parts>::Gyro,
    <P as Parts>::Wheels,
    <P as Parts>::Torque,
>;
