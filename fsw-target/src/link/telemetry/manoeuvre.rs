//! Manoeuvre report: state of upload and manoeuvre.

use crate::flight::craft::WHEELS;
use crate::flight::manoeuvre::{LoadError, Manoeuvre};
use crate::link::packet::MANOEUVRE;
use crate::link::wire::{codes, record};
use fsw_core::manoeuvre::{Abort, State, TableError};

record! {
    /// State of upload and manoeuvre.
    struct ManoeuvreReport {
        /// State.
        state: State, "–";
        /// Reason for an abort; absent for a manoeuvre that is not or was not aborted.
        abort: Option<Abort>, "–";
        /// CRC-32 of the table; absent without a usable one.
        table_checksum: Option<u32>, "–";
        /// Reason why the last upload is not usable; absent if it is, or is not ended.
        table_error: Option<TableFault>, "–";
        /// Wheel of that reason, from 1; 0 for the whole table.
        table_error_wheel: u8, "–";
        /// Segments received since the upload began: bit i for segment i.
        segments: u32, "–";
        /// Time in the table; after the end, the part that was flown.
        flown_us: u32, "µs";
        /// Repeat of the pattern, from 0.
        repeat: u16, "–";
        /// Knot of the pattern, from 0.
        knot: u16, "–";
        /// Largest body rate of the last manoeuvre.
        peak_rate_rad_s: f32, "rad/s";
        /// Largest rotation from the attitude at its start.
        peak_excursion_rad: f32, "rad";
        /// Speed of each wheel at its start.
        start_speed_rad_s: [f32; WHEELS], "rad/s";
        /// Commanded torque of each motor on its wheel.
        torque_n_m: [f32; WHEELS], "N m";
    }
}

report!(ManoeuvreReport, MANOEUVRE);

impl ManoeuvreReport {
    /// Report of a manoeuvre.
    #[inline(never)]
    pub fn of(manoeuvre: &Manoeuvre) -> Self {
        let (progress, error) = (manoeuvre.progress(), manoeuvre.error());
        let (repeat, knot, _) = manoeuvre.table().place(progress.flown_us);
        Self {
            state: progress.state,
            abort: progress.abort,
            table_checksum: manoeuvre.checksum(),
            table_error: error.map(TableFault::of),
            table_error_wheel: match error {
                Some(LoadError::Invalid(error)) => error.wheel(),
                _ => 0,
            },
            segments: manoeuvre.received(),
            flown_us: progress.flown_us,
            repeat: u16::try_from(repeat).unwrap_or(u16::MAX),
            knot: u16::try_from(knot).unwrap_or(u16::MAX),
            peak_rate_rad_s: progress.peak_rate_rad_s,
            peak_excursion_rad: progress.peak_excursion_rad,
            start_speed_rad_s: progress.start_speed_rad_s,
            torque_n_m: progress.torque_n_m,
        }
    }
}

codes! { State {
    0 "idle" => Idle;
    1 "waiting" => Waiting;
    2 "flying" => Flying;
    3 "resting" => Resting;
    4 "at_rest" => AtRest;
    5 "not_at_rest" => NotAtRest;
} }

codes! { Abort {
    1 "command" => Command;
    2 "restart" => Restart;
    3 "gap" => Gap;
    4 "glitch" => Glitch;
    5 "rate" => Rate;
    6 "excursion" => Excursion;
    7 "speed" => Speed;
    8 "wheel" => Wheel;
    9 "motors" => Motors;
} }

/// Reason for an unusable table, without its wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFault {
    /// [`LoadError::Checksum`].
    Checksum,
    /// [`TableError::Knot`].
    Knot,
    /// [`TableError::Splines`].
    Splines,
    /// [`TableError::Repeats`].
    Repeats,
    /// [`TableError::Duration`].
    Duration,
    /// [`TableError::RateLimit`].
    RateLimit,
    /// [`TableError::ExcursionLimit`].
    ExcursionLimit,
    /// [`TableError::TorqueLimit`].
    TorqueLimit,
    /// [`TableError::SpeedLimit`].
    SpeedLimit,
    /// [`TableError::NoWheel`].
    NoWheel,
    /// [`TableError::Coefficient`].
    Coefficient,
    /// [`TableError::Torque`].
    Torque,
}

impl TableFault {
    fn of(error: LoadError) -> Self {
        match error {
            LoadError::Checksum => Self::Checksum,
            LoadError::Invalid(error) => match error {
                TableError::Knot => Self::Knot,
                TableError::Splines => Self::Splines,
                TableError::Repeats => Self::Repeats,
                TableError::Duration => Self::Duration,
                TableError::RateLimit => Self::RateLimit,
                TableError::ExcursionLimit => Self::ExcursionLimit,
                TableError::TorqueLimit(_) => Self::TorqueLimit,
                TableError::SpeedLimit(_) => Self::SpeedLimit,
                TableError::NoWheel(_) => Self::NoWheel,
                TableError::Coefficient(_) => Self::Coefficient,
                TableError::Torque(_) => Self::Torque,
            },
        }
    }
}

codes! { TableFault {
    1 "checksum" => Checksum;
    2 "knot" => Knot;
    3 "splines" => Splines;
    4 "repeats" => Repeats;
    5 "duration" => Duration;
    6 "rate_limit" => RateLimit;
    7 "excursion_limit" => ExcursionLimit;
    8 "torque_limit" => TorqueLimit;
    9 "speed_limit" => SpeedLimit;
    10 "no_wheel" => NoWheel;
    11 "coefficient" => Coefficient;
    12 "torque" => Torque;
} }
