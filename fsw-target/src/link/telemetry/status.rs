//! How the flight computer is.

use crate::link::command::Function;
use crate::link::packet::STATUS;
use crate::link::uplink::UplinkCounters;
use crate::link::wire::{codes, record};
use crate::runtime::failure::Kind as FailureKind;
use fsw_core::outcome::OutcomeCounts;

record! {
    /// How the flight computer is, and what the ground has made it do.
    struct StatusReport {
        /// Time since the computer's last start.
        uptime_s: u32, "s";
        /// Why the computer started.
        reset_cause: ResetCause, "–";
        /// Failures of the program since power came, each of which made it start again.
        failures: u32, "–";
        /// The failure that ended the life before this one, if one did.
        last_failure: Option<FailureKind>, "–";
        /// Where that was: address of an instruction, line of a panic, number of an interrupt; 0 if it isn't known.
        last_failure_at: u32, "–";
        /// Where that was called from; address of the name of a panic's file; 0 if it isn't known.
        last_failure_from: u32, "–";
        /// What its clock runs on.
        clock: ClockSource, "–";
        /// Whether the watchdog runs.
        watchdog: bool, "–";
        /// The most stack that was ever used.
        stack_high_water_bytes: u32, "byte";
        /// Whether the gyro was found, and is set up as asked.
        gyro: GyroState, "–";
        /// What the gyro's identity register read; missing where it couldn't be read.
        gyro_identity: Option<u8>, "–";
        /// Self-tests that the gyro didn't pass; it does one at each of its starts.
        gyro_self_tests_failed: u32, "–";
        /// Samples skipped because the gyro could not be read.
        gyro_failures: u32, "–";
        /// Samples skipped because a wheel tachometer could not be read.
        wheel_failures: u32, "–";
        /// Samples announced and lost, because the loop came too late.
        data_ready_overruns: u32, "–";
        /// What became of the samples that reached the estimator.
        outcomes: OutcomeCounts, "–";
        /// What became of the frames that arrived.
        uplink: UplinkCounters, "–";
        /// Telemetry packets dropped whole, because the line was busy.
        downlink_dropped: u32, "–";
        /// Bytes that the serial port lost or couldn't read or write.
        serial_errors: u32, "–";
        /// The last command that the link accepted.
        last_command: Option<Function>, "–";
        /// Its sequence count; 0 before the first.
        last_sequence_count: u16, "–";
        /// Whether the computer did what it asked for; missing before the first.
        last_command_done: Option<bool>, "–";
        /// How often a report of each kind is sent; 0: an estimate after each sample, a status after each command.
        telemetry_period_ms: u32, "ms";
        /// The external torque that was commanded last, body axes.
        torque_n_m: [f32; 3], "N m";
        /// What the computer found in flash at its start.
        checkpoint: CheckpointState, "–";
        /// Checkpoints written since the start.
        checkpoints_saved: u32, "–";
        /// Checkpoints that could not be written.
        checkpoints_failed: u32, "–";
    }
}

report!(StatusReport, STATUS);

record! { OutcomeCounts {
    /// Used, whether for an update or a start.
    accepted: u32, "–";
    /// Refused: infinite or NaN.
    not_finite: u32, "–";
    /// Refused: saturated.
    out_of_range: u32, "–";
    /// Refused: time stamp not after the last.
    out_of_order: u32, "–";
    /// Refused: the gyro repeats itself.
    stuck: u32, "–";
    /// Refused: too far from the prediction.
    spike: u32, "–";
    /// Refused: no attitude that could be used.
    no_attitude: u32, "–";
    /// Refused: the body moved before it ever was at rest.
    waiting_for_rest: u32, "–";
    /// Resets after a gap in time.
    gap_resets: u32, "–";
    /// Resets after many spikes in a row.
    lockout_resets: u32, "–";
    /// Resets of what was known before, since new data contradict it.
    change_resets: u32, "–";
    /// Resets of a state that left the finite numbers.
    divergence_resets: u32, "–";
} }

/// Why the computer started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetCause {
    /// The chip doesn't say.
    Unknown,
    /// Power came.
    PowerOn,
    /// The supply voltage fell too low.
    BrownOut,
    /// The reset pin.
    Pin,
    /// Software asked for it.
    Software,
    /// The loop no longer fed the watchdog.
    Watchdog,
    /// A low-power mode was left.
    LowPower,
}

/// What the computer's clock runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockSource {
    /// The internal oscillator, since the crystal didn't start in time.
    Internal,
    /// The crystal.
    Crystal,
}

/// How the gyro's start went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GyroState {
    /// Not tried.
    NotStarted,
    /// Its identity is right, it has passed its own test, and its settings read back as set.
    Ready,
    /// The bus reported an error.
    BusError,
    /// Another part, or nothing, answers: see the identity.
    WrongIdentity,
    /// A setting reads back otherwise.
    NotAsSet,
    /// Ready but for its own test, which it failed or didn't end. Its samples are used all the same.
    SelfTestFailed,
    /// The program's settings for it make no sense.
    WrongSettings,
}

/// What the computer found in flash at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckpointState {
    /// No checkpoint: the estimators started afresh.
    None,
    /// The newest one is whole: the estimator went on from it.
    Restored,
    /// The newest one was torn: the estimator went on from the one before.
    RestoredOlder,
    /// Only torn ones, or such of another state or configuration: the estimators started afresh.
    Unusable,
    /// The flash could not be read.
    Failed,
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
} }
