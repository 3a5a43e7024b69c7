//! Telecommands: function code and arguments.
//!
//! Encoder: a [`Command`] to a packet. Decoder: user data to a [`Command`] with valid arguments:
//! finite, in range, and an inertia that a rigid body can have. Layout: `link.md`.

use super::authentication::{Key, SLOTS};
use super::packet::{COMMAND, Header, Packet, Secondary, SequenceCount};
use super::wire::{Coded, Reader, Unreadable, Wire, Writer, codes};
use crate::flight::craft::WHEELS;
use crate::flight::manoeuvre::{self, FlightTable, SEGMENT, SEGMENTS};
use core::fmt;
use fsw_core::Prior;
use fsw_roster::EstimatorId;

/// Longest telecommand packet, bytes: 95 for `load_manoeuvre` with a tag.
pub const MAX_COMMAND: usize = 96;

/// Shortest report period, ms. Both reports take 34 ms on the line at 115,200 baud.
pub const MIN_PERIOD_MS: u32 = 50;
/// Longest report period, ms: one hour. A longer silence is indistinguishable from a failure.
pub const MAX_PERIOD_MS: u32 = 3_600_000;
/// Largest external torque per axis, N m: above the actuators of small satellites. A larger value is an error
/// of the unit.
pub const MAX_TORQUE_N_M: f32 = 100.0;
/// Largest assumed wheel speed, rad/s: 19,000 rpm, above small reaction wheels.
pub const MAX_WHEEL_RAD_S: f32 = 2_000.0;
/// Largest inertia element and sigma of a prior, kg m²: the limit of the estimators.
pub const MAX_PRIOR_KG_M2: f32 = 1.0e4;
/// Smallest moment and sigma of a prior, kg m². Its square is a normal number in `f32`.
pub const MIN_PRIOR_KG_M2: f32 = 1.0e-9;

/// A telecommand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Command {
    /// No action. The next status report shows its acceptance.
    Ping,
    /// No action. Accepted with any sequence count, which becomes the reference for the following
    /// telecommands: for a ground station without the last count.
    StartSequence,
    /// Restart the selected estimator. Its estimate is discarded, its prior is kept.
    Reset,
    /// Set the prior of the inertia and restart the selected estimator with it.
    SetPrior(Prior<f32>),
    /// Open a window at the next sample.
    OpenWindow,
    /// Close the open window.
    CloseWindow,
    /// Select an estimator and start it without an estimate.
    Select(EstimatorId),
    /// Write the state of the selected estimator to flash.
    SaveCheckpoint,
    /// Send the newest checkpoint as [`CheckpointPart`](super::telemetry::CheckpointPart)s.
    DumpCheckpoint,
    /// Set the report period.
    SetTelemetryPeriod {
        /// Time between two reports of a kind, ms.
        ms: u32,
    },
    /// Set the external torque from the next sample on, body axes, N m.
    SetTorque([f32; 3]),
    /// Assume the speed of a wheel whose sensor has failed, or use its sensor again.
    AssumeWheelSpeed {
        /// Index of the wheel, 1 to 4.
        wheel: u8,
        /// Speed, rad/s; `None`: its sensor's.
        speed_rad_s: Option<f32>,
    },
    /// Give a key slot its next key. Executed in slot 0 only.
    ChangeKey {
        /// The slot, 1 or above.
        slot: u8,
    },
    /// Tag telemetry with the key of this telecommand's slot, or send it without a tag.
    TagTelemetry(bool),
    /// Write a segment of the table of a manoeuvre ([`manoeuvre`]).
    LoadManoeuvre {
        /// Index of the segment, 0 to 19.
        segment: u8,
        /// Its words.
        words: [u32; SEGMENT],
    },
    /// End the upload: the table is checked, and kept in flash.
    CommitManoeuvre {
        /// CRC-32 over the words of the table.
        checksum: u32,
    },
    /// Start the manoeuvre of the table.
    StartManoeuvre {
        /// On-board time, µs; a past one: at the next sample.
        at_us: u64,
    },
    /// Abort the manoeuvre: the wheels return to their speeds at its start.
    AbortManoeuvre,
    /// Reset the computer, after its status report. The state since the last checkpoint is lost:
    /// [`Command::SaveCheckpoint`] keeps it.
    Reboot,
}

/// Function of a telecommand, without arguments. Its code is the first byte of the user data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Function {
    /// [`Command::Ping`].
    Ping,
    /// [`Command::StartSequence`].
    StartSequence,
    /// [`Command::Reset`].
    Reset,
    /// [`Command::SetPrior`].
    SetPrior,
    /// [`Command::OpenWindow`].
    OpenWindow,
    /// [`Command::CloseWindow`].
    CloseWindow,
    /// [`Command::Select`].
    Select,
    /// [`Command::SaveCheckpoint`].
    SaveCheckpoint,
    /// [`Command::DumpCheckpoint`].
    DumpCheckpoint,
    /// [`Command::SetTelemetryPeriod`].
    SetTelemetryPeriod,
    /// [`Command::SetTorque`].
    SetTorque,
    /// [`Command::AssumeWheelSpeed`].
    AssumeWheelSpeed,
    /// [`Command::ChangeKey`].
    ChangeKey,
    /// [`Command::TagTelemetry`].
    TagTelemetry,
    /// [`Command::Reboot`].
    Reboot,
    /// [`Command::LoadManoeuvre`].
    LoadManoeuvre,
    /// [`Command::CommitManoeuvre`].
    CommitManoeuvre,
    /// [`Command::StartManoeuvre`].
    StartManoeuvre,
    /// [`Command::AbortManoeuvre`].
    AbortManoeuvre,
}

codes! { Function {
    1 "ping" => Ping;
    2 "start_sequence" => StartSequence;
    3 "reset" => Reset;
    4 "set_prior" => SetPrior;
    5 "open_window" => OpenWindow;
    6 "close_window" => CloseWindow;
    7 "select" => Select;
    8 "save_checkpoint" => SaveCheckpoint;
    9 "dump_checkpoint" => DumpCheckpoint;
    10 "set_telemetry_period" => SetTelemetryPeriod;
    11 "set_torque" => SetTorque;
    12 "change_key" => ChangeKey;
    13 "tag_telemetry" => TagTelemetry;
    14 "reboot" => Reboot;
    15 "assume_wheel_speed" => AssumeWheelSpeed;
    16 "load_manoeuvre" => LoadManoeuvre;
    17 "commit_manoeuvre" => CommitManoeuvre;
    18 "start_manoeuvre" => StartManoeuvre;
    19 "abort_manoeuvre" => AbortManoeuvre;
} }

impl Coded for EstimatorId {
    const NAME: &'static str = "EstimatorId";
    const CODES: &'static [(u8, &'static str)] = Self::CODES;

    fn code(self) -> (u8, &'static str) {
        (self as u8, self.name())
    }

    fn of_code(code: u8) -> Option<Self> {
        Self::from_number(code)
    }
}

/// Reason for user data that is not a valid telecommand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandError {
    /// Unknown function code.
    UnknownFunction,
    /// Length of the arguments differs from that of the function.
    WrongLength,
    /// An argument is not finite, out of range, or an impossible inertia.
    Argument(&'static str),
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownFunction => f.write_str("unknown function code"),
            Self::WrongLength => f.write_str("wrong length of the arguments"),
            Self::Argument(why) => f.write_str(why),
        }
    }
}

impl core::error::Error for CommandError {}

impl Command {
    /// Function of the command.
    pub fn function(&self) -> Function {
        match self {
            Self::Ping => Function::Ping,
            Self::StartSequence => Function::StartSequence,
            Self::Reset => Function::Reset,
            Self::SetPrior(_) => Function::SetPrior,
            Self::OpenWindow => Function::OpenWindow,
            Self::CloseWindow => Function::CloseWindow,
            Self::Select(_) => Function::Select,
            Self::SaveCheckpoint => Function::SaveCheckpoint,
            Self::DumpCheckpoint => Function::DumpCheckpoint,
            Self::SetTelemetryPeriod { .. } => Function::SetTelemetryPeriod,
            Self::SetTorque(_) => Function::SetTorque,
            Self::ChangeKey { .. } => Function::ChangeKey,
            Self::TagTelemetry(_) => Function::TagTelemetry,
            Self::Reboot => Function::Reboot,
            Self::AssumeWheelSpeed { .. } => Function::AssumeWheelSpeed,
            Self::LoadManoeuvre { .. } => Function::LoadManoeuvre,
            Self::CommitManoeuvre { .. } => Function::CommitManoeuvre,
            Self::StartManoeuvre { .. } => Function::StartManoeuvre,
            Self::AbortManoeuvre => Function::AbortManoeuvre,
        }
    }

    /// Telecommands of the upload of a table, in order: its segments, then the end of the upload.
    pub fn upload(table: &FlightTable) -> impl Iterator<Item = Self> {
        let segments = manoeuvre::words(table).div_ceil(SEGMENT);
        let load = |index: usize| Self::LoadManoeuvre {
            segment: index as u8,
            words: manoeuvre::segment(table, index),
        };
        let commit = Self::CommitManoeuvre { checksum: manoeuvre::checksum(table) };
        (0..segments).map(load).chain([commit])
    }

    /// Packet of the command without a tag. Does not validate the arguments: the ground calls
    /// [`check`](Self::check) first. Always `Some`: every command is shorter than a packet.
    pub fn packet(&self, sequence_count: SequenceCount) -> Option<Packet> {
        let header = Header { apid: COMMAND, sequence_count, secondary: Secondary::Plain };
        Packet::new(&header, None, &|out| self.put(out))
    }

    /// Packet of the command with the tag of a slot's key. Its sequence count is the end of the counter.
    /// Otherwise as [`packet`](Self::packet).
    pub fn tagged_packet(&self, key: &Key, slot: u8, counter: u32) -> Option<Packet> {
        let sequence_count = SequenceCount::new(counter as u16 & 0x3fff);
        let secondary = Secondary::Tagged { slot, counter };
        let header = Header { apid: COMMAND, sequence_count, secondary };
        Packet::new(&header, Some(key), &|out| self.put(out))
    }

    /// Writes function code and arguments.
    fn put(&self, out: &mut Writer<'_>) {
        self.function().put(out);
        match self {
            Self::SetPrior(prior) => {
                prior.inertia_kg_m2.put(out);
                prior.sigma_kg_m2.put(out);
            }
            Self::Select(id) => id.put(out),
            Self::SetTelemetryPeriod { ms } => ms.put(out),
            Self::SetTorque(torque_n_m) => torque_n_m.put(out),
            Self::ChangeKey { slot } => slot.put(out),
            Self::TagTelemetry(on) => on.put(out),
            Self::AssumeWheelSpeed { wheel, speed_rad_s } => {
                wheel.put(out);
                speed_rad_s.put(out);
            }
            Self::LoadManoeuvre { segment, words } => {
                segment.put(out);
                words.put(out);
            }
            Self::CommitManoeuvre { checksum } => checksum.put(out),
            Self::StartManoeuvre { at_us } => at_us.put(out),
            Self::Ping
            | Self::StartSequence
            | Self::Reset
            | Self::OpenWindow
            | Self::CloseWindow
            | Self::SaveCheckpoint
            | Self::DumpCheckpoint
            | Self::AbortManoeuvre
            | Self::Reboot => {}
        }
    }

    /// Command from the user data of a packet.
    ///
    /// # Errors
    /// The first [`CommandError`] that applies.
    pub fn decode(data: &[u8]) -> Result<Self, CommandError> {
        let mut from = Reader::new(data);
        let command = Self::take(&mut from)?;
        from.end().map_err(|_| CommandError::WrongLength)?;
        command.check()?;
        Ok(command)
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, CommandError> {
        let function = <Function as Wire>::take(from).map_err(|why| match why {
            Unreadable::UnknownCode { .. } => CommandError::UnknownFunction,
            _ => CommandError::WrongLength,
        })?;
        Ok(match function {
            Function::Ping => Self::Ping,
            Function::StartSequence => Self::StartSequence,
            Function::Reset => Self::Reset,
            Function::SetPrior => Self::SetPrior(Prior {
                inertia_kg_m2: argument(from)?,
                sigma_kg_m2: argument(from)?,
            }),
            Function::OpenWindow => Self::OpenWindow,
            Function::CloseWindow => Self::CloseWindow,
            Function::Select => Self::Select(argument(from)?),
            Function::SaveCheckpoint => Self::SaveCheckpoint,
            Function::DumpCheckpoint => Self::DumpCheckpoint,
            Function::SetTelemetryPeriod => Self::SetTelemetryPeriod { ms: argument(from)? },
            Function::SetTorque => Self::SetTorque(argument(from)?),
            Function::ChangeKey => Self::ChangeKey { slot: argument(from)? },
            Function::TagTelemetry => Self::TagTelemetry(argument(from)?),
            Function::Reboot => Self::Reboot,
            Function::AssumeWheelSpeed => {
                Self::AssumeWheelSpeed { wheel: argument(from)?, speed_rad_s: argument(from)? }
            }
            Function::LoadManoeuvre => {
                Self::LoadManoeuvre { segment: argument(from)?, words: argument(from)? }
            }
            Function::CommitManoeuvre => Self::CommitManoeuvre { checksum: argument(from)? },
            Function::StartManoeuvre => Self::StartManoeuvre { at_us: argument(from)? },
            Function::AbortManoeuvre => Self::AbortManoeuvre,
        })
    }

    /// Validates the arguments.
    ///
    /// # Errors
    /// [`CommandError::Argument`] with the violated limit.
    pub fn check(&self) -> Result<(), CommandError> {
        match self {
            Self::SetPrior(prior) => check_prior(prior),
            Self::SetTelemetryPeriod { ms } => {
                let allowed = (MIN_PERIOD_MS..=MAX_PERIOD_MS).contains(ms);
                require(allowed, "the telemetry period must be between 50 ms and 3600000 ms")
            }
            Self::SetTorque(torque_n_m) => {
                // NaN compares as out of range.
                let allowed = torque_n_m.iter().all(|axis| axis.abs() <= MAX_TORQUE_N_M);
                require(allowed, "each axis of the torque must be within ±100 N m")
            }
            Self::AssumeWheelSpeed { wheel, speed_rad_s } => {
                let is_wheel = (1..=WHEELS).contains(&usize::from(*wheel));
                require(is_wheel, "the wheel must be 1 to 4")?;
                let allowed = speed_rad_s.is_none_or(|speed| speed.abs() <= MAX_WHEEL_RAD_S);
                require(allowed, "the wheel speed must be within ±2000 rad/s")
            }
            Self::ChangeKey { slot } => {
                let allowed = (1..SLOTS as u8).contains(slot);
                require(allowed, "the key slot must be 1 or 2; the key of slot 0 stays")
            }
            Self::LoadManoeuvre { segment, .. } => {
                let allowed = usize::from(*segment) < SEGMENTS;
                require(allowed, "the segment of the manoeuvre must be 0 to 19")
            }
            Self::Ping
            | Self::StartSequence
            | Self::Reset
            | Self::OpenWindow
            | Self::CloseWindow
            | Self::CommitManoeuvre { .. }
            | Self::StartManoeuvre { .. }
            | Self::AbortManoeuvre
            | Self::Select(_)
            | Self::SaveCheckpoint
            | Self::DumpCheckpoint
            | Self::TagTelemetry(_)
            | Self::Reboot => Ok(()),
        }
    }
}

fn argument<W: Wire>(from: &mut Reader<'_>) -> Result<W, CommandError> {
    W::take(from).map_err(|why| match why {
        Unreadable::UnknownCode { .. } => CommandError::Argument("an argument has an unknown code"),
        _ => CommandError::WrongLength,
    })
}

fn check_prior(prior: &Prior<f32>) -> Result<(), CommandError> {
    let range = MIN_PRIOR_KG_M2..=MAX_PRIOR_KG_M2;
    let [jxx, jyy, jzz, jxy, jxz, jyz] = prior.inertia_kg_m2;
    require(
        [jxx, jyy, jzz].iter().all(|moment| range.contains(moment))
            && [jxy, jxz, jyz].iter().all(|product| product.abs() <= MAX_PRIOR_KG_M2),
        "each moment must be 1e-9 to 1e4 kg m², each product within ±1e4 kg m²",
    )?;
    require(
        prior.sigma_kg_m2.iter().all(|sigma| range.contains(sigma)),
        "each sigma must be 1e-9 to 1e4 kg m²",
    )?;
    require(prior.validate().is_ok(), "no rigid body has this inertia tensor")
}

fn require(allowed: bool, why: &'static str) -> Result<(), CommandError> {
    if allowed { Ok(()) } else { Err(CommandError::Argument(why)) }
}

/// Test commands.
#[cfg(test)]
pub mod fixtures {
    use super::*;
    use proptest::prelude::*;

    /// One command of each function.
    pub fn one_of_each() -> [Command; 19] {
        let prior = Prior {
            inertia_kg_m2: [14.2, 17.3, 20.3, 0.0867, -0.1357, 0.6016],
            sigma_kg_m2: [30.0, 30.0, 30.0, 10.0, 10.0, 10.0],
        };
        [
            Command::Ping,
            Command::StartSequence,
            Command::Reset,
            Command::SetPrior(prior),
            Command::OpenWindow,
            Command::CloseWindow,
            Command::Select(EstimatorId::EkfSgfRls),
            Command::SaveCheckpoint,
            Command::DumpCheckpoint,
            Command::SetTelemetryPeriod { ms: 1000 },
            Command::SetTorque([1e-3, -2e-3, 5e-4]),
            Command::ChangeKey { slot: 1 },
            Command::TagTelemetry(true),
            Command::Reboot,
            Command::AssumeWheelSpeed { wheel: 2, speed_rad_s: Some(12.5) },
            Command::LoadManoeuvre { segment: 19, words: [0x3a83_126f; SEGMENT] },
            Command::CommitManoeuvre { checksum: 0xcbf4_3926 },
            Command::StartManoeuvre { at_us: 123_456_789_012 },
            Command::AbortManoeuvre,
        ]
    }

    /// Any valid command.
    pub fn any_command() -> impl Strategy<Value = Command> {
        let moments = prop::array::uniform3(1.0_f32..2.0);
        let products = prop::array::uniform3(-0.1_f32..0.1);
        let sigma_kg_m2 = prop::array::uniform6(1e-6_f32..1e3);
        let prior = (moments, products, sigma_kg_m2).prop_map(|(m, p, sigma_kg_m2)| {
            let inertia_kg_m2 = [m[0], m[1], m[2], p[0], p[1], p[2]];
            Command::SetPrior(Prior { inertia_kg_m2, sigma_kg_m2 })
        });
        prop_oneof![
            4 => prop::sample::select(one_of_each().to_vec()),
            1 => prior.prop_filter("a physical inertia", |command| command.check().is_ok()),
            1 => prop::array::uniform3(-100.0_f32..100.0).prop_map(Command::SetTorque),
            1 => (MIN_PERIOD_MS..=MAX_PERIOD_MS).prop_map(|ms| Command::SetTelemetryPeriod { ms }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::Coded;

    #[test]
    fn estimators_have_their_own_names_and_numbers() {
        for id in EstimatorId::ALL {
            assert_eq!(id.code(), (id as u8, id.name()));
        }
    }

    #[test]
    fn reset_is_its_code_alone() {
        assert_eq!(Command::decode(&[3]), Ok(Command::Reset));
        assert_eq!(Command::decode(&[3, 3]), Err(CommandError::WrongLength));
        assert_eq!(Command::decode(&[]), Err(CommandError::WrongLength));
        assert_eq!(Command::decode(&[0xff]), Err(CommandError::UnknownFunction));
    }
}
