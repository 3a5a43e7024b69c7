//! Telecommands: what the ground may ask for, as a number and arguments.
//!
//! In: a command, or the user data of a packet. Out: the user data, or a command whose arguments a
//! flight computer can rely on: finite, in range, of a body that can exist. Layout: `link.md`.

use super::packet::{COMMAND, Header, Packet, PacketType, SequenceCount};
use super::wire::{Coded, Reader, Unreadable, Wire, codes};
use core::fmt;
use fsw_core::Prior;
use fsw_steps::EstimatorId;

/// Bytes of the longest telecommand packet, and a few to spare for a later one.
pub const MAX_COMMAND: usize = 64;

/// The shortest time between two reports, ms: at 115,200 baud both take 34 ms on the line.
pub const LEAST_PERIOD_MS: u32 = 50;
/// The longest time between two reports, ms: an hour. Who hears nothing for longer thinks it dead.
pub const MOST_PERIOD_MS: u32 = 3_600_000;
/// The largest external torque on an axis, N m. No small satellite has an actuator for more: it is
/// a wrong unit.
pub const MOST_TORQUE_N_M: f32 = 100.0;
/// The largest element of a prior and its sigma, kg m²: what the estimators hold as possible.
pub const MOST_PRIOR_KG_M2: f32 = 1.0e4;
/// The least moment and the least sigma, kg m²: its square is still a normal number in `f32`.
pub const LEAST_PRIOR_KG_M2: f32 = 1.0e-9;

/// What the ground asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Command {
    /// Nothing: that it was accepted shows in the next status report.
    Ping,
    /// Nothing, but it is accepted whatever its sequence count, and the next ones are measured
    /// against that: for a ground station that has lost count.
    StartSequence,
    /// Start the selected estimator afresh: all that it has found is forgotten, the prior stays.
    Reset,
    /// Believe this of the inertia beforehand, and start the selected estimator afresh with it.
    SetPrior(Prior<f32>),
    /// Begin a window with the next sample.
    OpenWindow,
    /// End the window that is open.
    CloseWindow,
    /// Step this estimator from now on, from a fresh start.
    Select(EstimatorId),
    /// Write the estimator's state to flash now.
    SaveCheckpoint,
    /// Send the estimator's state as [`CheckpointPart`](super::telemetry::CheckpointPart)s.
    DumpCheckpoint,
    /// Send reports so often.
    SetTelemetryPeriod {
        /// Between two reports of a kind, ms.
        ms: u32,
    },
    /// The external torque that acts from now on, body axes, N m.
    SetTorque([f32; 3]),
}

/// The commands without their arguments, by the number that goes first in the user data.
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

/// Why the user data of an intact packet is no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandError {
    /// No function has this number.
    UnknownFunction,
    /// Fewer or more bytes than the function's arguments take.
    WrongLength,
    /// An argument isn't finite, is out of range, or is of no body.
    Argument(&'static str),
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownFunction => f.write_str("no function has this number"),
            Self::WrongLength => f.write_str("the arguments have another length"),
            Self::Argument(why) => f.write_str(why),
        }
    }
}

impl core::error::Error for CommandError {}

impl Command {
    /// The command without its arguments.
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
        }
    }

    /// As a packet, whatever its arguments; the ground calls [`check`](Self::check) before.
    /// `None` never happens: no command is longer than a packet.
    pub fn packet(&self, sequence_count: SequenceCount) -> Option<Packet> {
        let header =
            Header { packet_type: PacketType::Tc, apid: COMMAND, sequence_count, time_us: None };
        Packet::new(&header, |out| {
            self.function().put(out);
            match self {
                Self::SetPrior(prior) => {
                    prior.inertia_kg_m2.put(out);
                    prior.sigma_kg_m2.put(out);
                }
                Self::Select(id) => id.put(out),
                Self::SetTelemetryPeriod { ms } => ms.put(out),
                Self::SetTorque(torque_n_m) => torque_n_m.put(out),
                Self::Ping
                | Self::StartSequence
                | Self::Reset
                | Self::OpenWindow
                | Self::CloseWindow
                | Self::SaveCheckpoint
                | Self::DumpCheckpoint => {}
            }
        })
    }

    /// From the user data of a packet.
    ///
    /// # Errors
    /// The first of [`CommandError`] that applies.
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
        })
    }

    /// Whether a flight computer can rely on the arguments.
    ///
    /// # Errors
    /// [`CommandError::Argument`], with what is wrong.
    pub fn check(&self) -> Result<(), CommandError> {
        match self {
            Self::SetPrior(prior) => check_prior(prior),
            Self::SetTelemetryPeriod { ms } => {
                let allowed = (LEAST_PERIOD_MS..=MOST_PERIOD_MS).contains(ms);
                refuse_unless(allowed, "the period must lie between 50 ms and 3600000 ms")
            }
            Self::SetTorque(torque_n_m) => {
                // Written so that NaN is out of range.
                let allowed = torque_n_m.iter().all(|axis| axis.abs() <= MOST_TORQUE_N_M);
                refuse_unless(allowed, "each axis of the torque must lie within 100 N m")
            }
            Self::Ping
            | Self::StartSequence
            | Self::Reset
            | Self::OpenWindow
            | Self::CloseWindow
            | Self::Select(_)
            | Self::SaveCheckpoint
            | Self::DumpCheckpoint => Ok(()),
        }
    }
}

fn argument<W: Wire>(from: &mut Reader<'_>) -> Result<W, CommandError> {
    W::take(from).map_err(|why| match why {
        Unreadable::UnknownCode { .. } => CommandError::Argument("no estimator has this number"),
        _ => CommandError::WrongLength,
    })
}

fn check_prior(prior: &Prior<f32>) -> Result<(), CommandError> {
    let range = LEAST_PRIOR_KG_M2..=MOST_PRIOR_KG_M2;
    let [jxx, jyy, jzz, jxy, jxz, jyz] = prior.inertia_kg_m2;
    refuse_unless(
        [jxx, jyy, jzz].iter().all(|moment| range.contains(moment))
            && [jxy, jxz, jyz].iter().all(|product| product.abs() <= MOST_PRIOR_KG_M2),
        "each moment must lie between 1e-9 and 1e4 kg m², each product within 1e4 kg m²",
    )?;
    refuse_unless(
        prior.sigma_kg_m2.iter().all(|sigma| range.contains(sigma)),
        "each sigma must lie between 1e-9 and 1e4 kg m²",
    )?;
    refuse_unless(prior.validate().is_ok(), "no body has this inertia tensor")
}

fn refuse_unless(allowed: bool, why: &'static str) -> Result<(), CommandError> {
    if allowed { Ok(()) } else { Err(CommandError::Argument(why)) }
}

/// Commands to test with.
#[cfg(test)]
pub mod samples {
    use super::*;
    use proptest::prelude::*;

    /// Each function, with arguments.
    pub fn one_of_each() -> [Command; 11] {
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
        ]
    }

    /// Any command that is accepted.
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
            1 => prior.prop_filter("of a body", |command| command.check().is_ok()),
            1 => prop::array::uniform3(-100.0_f32..100.0).prop_map(Command::SetTorque),
            1 => (LEAST_PERIOD_MS..=MOST_PERIOD_MS).prop_map(|ms| Command::SetTelemetryPeriod { ms }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::Coded;

    #[test]
    fn estimators_have_the_names_and_numbers_of_the_program() {
        for id in EstimatorId::ALL {
            assert_eq!(id.code(), (id as u8, id.name()));
        }
    }

    #[test]
    fn reset_is_its_number_alone() {
        assert_eq!(Command::decode(&[3]), Ok(Command::Reset));
        assert_eq!(Command::decode(&[3, 3]), Err(CommandError::WrongLength));
        assert_eq!(Command::decode(&[]), Err(CommandError::WrongLength));
        assert_eq!(Command::decode(&[0xff]), Err(CommandError::UnknownFunction));
    }
}
