//! Status report: health of the flight computer and effect of telecommands.

use crate::flight::craft::WHEELS;
use crate::link::authentication::{Authentication, SLOTS};
use crate::link::command::Function;
use crate::link::packet::STATUS;
use crate::link::uplink::UplinkCounters;
use crate::link::wire::{codes, record};
use crate::runtime::failure::Kind as FailureKind;
use fsw_core::outcome::OutcomeCounts;

/// Version of the link: changes with the layout of any packet.
///
/// 2: tags of telecommands and telemetry; key slot in the secondary header of telemetry; health of supply,
/// option bytes and single wheels. 3: flipped bits. 4: health; wheels against their commands.
/// 5: manoeuvre.
pub const LINK_VERSION: u8 = 5;

record! {
    /// Health of the flight computer and effect of telecommands.
    struct StatusReport {
        /// Version of this link.
        link_version: u8, "–";
        /// Time since the last start of the computer.
        uptime_s: u32, "s";
        /// Cause of the last start.
        reset_cause: ResetCause, "–";
        /// Software failures since power-up, each followed by a restart.
        failures: u32, "–";
        /// Failure before the last start; absent if it started for another cause.
        last_failure: Option<FailureKind>, "–";
        /// Location of that failure: instruction address, line of a panic, or interrupt number; 0 if unknown.
        last_failure_at: u32, "–";
        /// Caller of that location; address of the file name of a panic; 0 if unknown.
        last_failure_from: u32, "–";
        /// Clock source.
        clock: ClockSource, "–";
        /// True if the watchdog runs.
        watchdog: bool, "–";
        /// Brown-out level in the option bytes of the chip.
        brown_out: BrownOutLevel, "–";
        /// True if the option bytes are those of a flight board.
        option_bytes_as_set: bool, "–";
        /// True if the supply is below the limit of flash operations, which are refused.
        supply_low: bool, "–";
        /// True if craft and prior in memory are as they were set; after a flipped bit no estimator starts until a reboot.
        configuration_intact: bool, "–";
        /// Flipped bits found in the memory of the estimator since the last start, each followed by a return to the newest checkpoint; saturates.
        upsets: u8, "–";
        /// Starts in a row that a failure or the watchdog ended within a minute.
        short_lives: u8, "–";
        /// Largest stack depth since the last start.
        stack_high_water_bytes: u32, "byte";
        /// Result of the gyro's last start.
        gyro: GyroState, "–";
        /// Value of the gyro's identity register; absent if unreadable.
        gyro_identity: Option<u8>, "–";
        /// Failed self-tests of the gyro; one test per start.
        gyro_self_tests_failed: u32, "–";
        /// Samples without a rate after a failed reading of the gyro.
        gyro_failures: u32, "–";
        /// Samples in which a fitted wheel had no valid speed.
        wheel_failures: u32, "–";
        /// True for each wheel with a valid speed at the last sample, or not fitted.
        wheel_valid: [bool; WHEELS], "–";
        /// Samples lost because the flight loop was late.
        data_ready_overruns: u32, "–";
        /// Samples stepped, by outcome.
        outcomes: OutcomeCounts, "–";
        /// Received frames, by outcome.
        uplink: UplinkCounters, "–";
        /// Telemetry packets dropped because the queue of the line was full.
        downlink_dropped: u32, "–";
        /// Bytes lost by the serial port, or not read or written.
        serial_errors: u32, "–";
        /// Last accepted telecommand.
        last_command: Option<Function>, "–";
        /// Sequence count of the last accepted telecommand; 0 before the first.
        last_sequence_count: u16, "–";
        /// True if the last accepted telecommand was executed; absent before the first.
        last_command_done: Option<bool>, "–";
        /// Authentication of telecommands.
        authentication: Authentication, "–";
        /// Counter of the last accepted telecommand of each key slot.
        key_counters: [u32; SLOTS], "–";
        /// Generation of the key of each slot: counter of the slot-0 telecommand that changed it; 0 for the first key.
        key_generations: [u32; SLOTS], "–";
        /// Key slot of the tag of telemetry; absent for telemetry without a tag.
        telemetry_slot: Option<u8>, "–";
        /// Time between two reports of a kind; 0: an estimate after each sample, a status after each telecommand.
        telemetry_period_ms: u32, "ms";
        /// Last commanded external torque, body axes.
        torque_n_m: [f32; 3], "N m";
        /// Checkpoint found in flash at the last start.
        checkpoint: CheckpointState, "–";
        /// Checkpoints written since the last start.
        checkpoints_saved: u32, "–";
        /// Failed attempts to write a checkpoint since the last start.
        checkpoints_failed: u32, "–";
    }
}

report!(StatusReport, STATUS);

record! { OutcomeCounts {
    /// Samples used, for an update or for a start.
    accepted: u32, "–";
    /// Samples rejected: infinite or NaN.
    not_finite: u32, "–";
    /// Samples rejected: beyond the gyro's range.
    out_of_range: u32, "–";
    /// Samples rejected: time stamp not after the last.
    out_of_order: u32, "–";
    /// Samples rejected: identical gyro readings in a row.
    stuck: u32, "–";
    /// Samples rejected: innovation too large.
    spike: u32, "–";
    /// Samples rejected: no usable attitude.
    no_attitude: u32, "–";
    /// Samples rejected: motion before the first rest.
    waiting_for_rest: u32, "–";
    /// Resets after a gap in time.
    gap_resets: u32, "–";
    /// Resets after a change of the clock.
    clock_resets: u32, "–";
    /// Resets after consecutive spikes.
    lockout_resets: u32, "–";
    /// Resets after a fault in mid-motion that has ended.
    interruption_resets: u32, "–";
    /// Resets of the carried estimate, contradicted by new data.
    change_resets: u32, "–";
    /// Resets of a state that is no longer finite.
    divergence_resets: u32, "–";
} }

/// Cause of the computer's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetCause {
    /// Not indicated by the chip.
    Unknown,
    /// Power-up.
    PowerOn,
    /// Supply voltage below its limit.
    BrownOut,
    /// Reset pin.
    Pin,
    /// Software request.
    Software,
    /// Watchdog time-out.
    Watchdog,
    /// Entry into a low-power mode that the option bytes forbid.
    LowPower,
}

/// Supply voltage below which the chip is held in reset, as its option bytes state it (DS8626, brown-out
/// reset levels).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BrownOutLevel {
    /// Option bytes not readable, or no such chip.
    Unknown,
    /// Off, as delivered: reset below 1.8 V only.
    Off,
    /// Level 1, 2.1 to 2.4 V.
    Level1,
    /// Level 2, 2.4 to 2.7 V.
    Level2,
    /// Level 3, 2.7 to 3.0 V. Required in flight.
    Level3,
}

/// Source of the computer's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockSource {
    /// Internal oscillator: crystal or PLL not usable at the start, or failed in flight.
    Internal,
    /// Crystal oscillator.
    Crystal,
}

/// Result of the gyro's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GyroState {
    /// Not started.
    NotStarted,
    /// Identity, self-test and settings correct.
    Ready,
    /// Bus error.
    BusError,
    /// Another part, or no part: see the identity.
    WrongIdentity,
    /// A setting does not read back as written.
    NotAsSet,
    /// Self-test failed or timed out, otherwise ready. Its samples are used.
    SelfTestFailed,
    /// Invalid settings.
    WrongSettings,
}

/// Checkpoint found in flash at the computer's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckpointState {
    /// None. The estimators started without an estimate.
    None,
    /// The newest checkpoint was intact and has been restored.
    Restored,
    /// The newest checkpoint was torn; the one before has been restored.
    RestoredOlder,
    /// All checkpoints were torn, or of another state or configuration. The estimators started without
    /// an estimate.
    Unusable,
    /// Flash not readable.
    Failed,
    /// The newest checkpoint is of an image of other precision or size. The estimators started without an
    /// estimate.
    OtherImage,
    /// Not restored after short lives in a row: the checkpoint may be their cause.
    Skipped,
}

codes! { ResetCause {
    0 "unknown" => Unknown;
    1 "power_on" => PowerOn;
    2 "brown_out" => BrownOut;
    3 "pin" => Pin;
    4 "software" => Software;
    5 "watchdog" => Watchdog;
    6 "low_power" => LowPower;
} }

codes! { FailureKind {
    1 "panic" => Panic;
    2 "hard_fault" => HardFault;
    3 "stack_overflow" => StackOverflow;
    4 "unserved_interrupt" => UnservedInterrupt;
    5 "watchdog" => Watchdog;
} }

codes! { ClockSource {
    0 "internal" => Internal;
    1 "crystal" => Crystal;
} }

codes! { GyroState {
    0 "not_started" => NotStarted;
    1 "ready" => Ready;
    2 "bus_error" => BusError;
    3 "wrong_identity" => WrongIdentity;
    4 "not_as_set" => NotAsSet;
    5 "self_test_failed" => SelfTestFailed;
    6 "wrong_settings" => WrongSettings;
} }

codes! { CheckpointState {
    0 "none" => None;
    1 "restored" => Restored;
    2 "restored_older" => RestoredOlder;
    3 "unusable" => Unusable;
    4 "failed" => Failed;
    5 "other_image" => OtherImage;
    6 "skipped" => Skipped;
} }

codes! { BrownOutLevel {
    0 "unknown" => Unknown;
    1 "off" => Off;
    2 "level_1" => Level1;
    3 "level_2" => Level2;
    4 "level_3" => Level3;
} }
