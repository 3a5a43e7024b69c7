//! Receiver of telecommands.
//!
//! Input: bytes of the line. Output: commands that arrived intact, are addressed to this computer,
//! have valid arguments and are new. Every other frame is counted by its reason, each frame once.
//!
//! ```text
//!  byte -> frame -> packet -> checksum -> APID -> function, arguments -> sequence count -> command
//! ```
//!
//! A packet is new if its sequence count is 1 to 8191 ahead of the last accepted count, modulo 2¹⁴.
//! After a reset of the computer the first valid packet is accepted with any count.
//! [`Command::StartSequence`] is accepted with any count, as the control commands of COP-1 are
//! (CCSDS 232.1-B): a ground station without the last count sends it first. The check prevents the
//! repeated execution of a duplicated packet. It does not authenticate the sender.

use super::command::{Command, CommandError, Function, MAX_COMMAND};
use super::frame::{FrameError, FrameReceiver};
use super::packet::{self, COMMAND, PacketError, PacketType, SequenceCount};
use super::wire::record;

record! {
    /// Received frames by outcome. Counts saturate.
    struct UplinkCounters {
        /// Telecommands passed to the flight computer.
        accepted: u32, "–";
        /// Frames or packets that ended early: before the end of the COBS data, or before the packet's length.
        truncated: u32, "–";
        /// Frames longer than the longest telecommand.
        oversized: u32, "–";
        /// Packets with a wrong checksum.
        wrong_checksum: u32, "–";
        /// Packets longer than their length field, arguments of a wrong length, telemetry, another APID, another version, or a segment.
        malformed: u32, "–";
        /// Telecommands with an unknown function code.
        unknown_function: u32, "–";
        /// Telecommands with an argument that is not finite, out of range, or an impossible inertia.
        refused_argument: u32, "–";
        /// Telecommands with a sequence count not ahead of the last accepted one.
        replayed: u32, "–";
    }
}

impl UplinkCounters {
    /// No frame received.
    pub const NONE: Self = Self {
        accepted: 0,
        truncated: 0,
        oversized: 0,
        wrong_checksum: 0,
        malformed: 0,
        unknown_function: 0,
        refused_argument: 0,
        replayed: 0,
    };

    /// Counter of a rejection.
    fn of(&mut self, rejection: Rejection) -> &mut u32 {
        match rejection {
            Rejection::Truncated => &mut self.truncated,
            Rejection::Oversized => &mut self.oversized,
            Rejection::WrongChecksum => &mut self.wrong_checksum,
            Rejection::Malformed => &mut self.malformed,
            Rejection::UnknownFunction => &mut self.unknown_function,
            Rejection::Argument => &mut self.refused_argument,
            Rejection::Replayed => &mut self.replayed,
        }
    }
}

/// An accepted telecommand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accepted {
    /// Function.
    pub function: Function,
    /// Sequence count of its packet.
    pub sequence_count: SequenceCount,
}

/// Reason for a rejected frame; each has a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rejection {
    Truncated,
    Oversized,
    WrongChecksum,
    Malformed,
    UnknownFunction,
    Argument,
    Replayed,
}

/// Receiving end of the line.
#[derive(Debug)]
pub struct Uplink {
    frames: FrameReceiver<MAX_COMMAND>,
    counters: UplinkCounters,
    last: Option<Accepted>,
}

impl Uplink {
    /// An uplink before its first byte.
    pub const fn new() -> Self {
        Self { frames: FrameReceiver::new(), counters: UplinkCounters::NONE, last: None }
    }

    /// Takes the next byte. The last byte of a valid telecommand yields the command.
    pub fn push(&mut self, byte: u8) -> Option<Command> {
        let read = self.frames.push(byte)?.map_err(Rejection::from).and_then(read);
        match read.and_then(|(command, count)| in_sequence(self.last, command, count)) {
            Ok((command, accepted)) => {
                self.last = Some(accepted);
                increment(&mut self.counters.accepted);
                Some(command)
            }
            Err(rejection) => {
                increment(self.counters.of(rejection));
                None
            }
        }
    }

    /// Received frames by outcome.
    pub fn counters(&self) -> UplinkCounters {
        self.counters
    }

    /// The last accepted telecommand.
    pub fn last_accepted(&self) -> Option<Accepted> {
        self.last
    }
}

impl Default for Uplink {
    fn default() -> Self {
        Self::new()
    }
}

/// Command and sequence count of a packet.
fn read(packet: &[u8]) -> Result<(Command, SequenceCount), Rejection> {
    let (header, data) = packet::parse(packet)?;
    let is_telecommand =
        header.packet_type == PacketType::Tc && header.apid == COMMAND && header.time_us.is_none();
    if !is_telecommand {
        return Err(Rejection::Malformed);
    }
    Ok((Command::decode(data)?, header.sequence_count))
}

/// Accepts a command that is new, or that starts a sequence.
fn in_sequence(
    last: Option<Accepted>,
    command: Command,
    sequence_count: SequenceCount,
) -> Result<(Command, Accepted), Rejection> {
    let new = last.is_none_or(|last| packet::is_ahead(sequence_count, last.sequence_count));
    if new || command == Command::StartSequence {
        Ok((command, Accepted { function: command.function(), sequence_count }))
    } else {
        Err(Rejection::Replayed)
    }
}

fn increment(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl From<FrameError> for Rejection {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::Truncated => Self::Truncated,
            FrameError::Oversized => Self::Oversized,
        }
    }
}

impl From<PacketError> for Rejection {
    fn from(error: PacketError) -> Self {
        match error {
            PacketError::Truncated => Self::Truncated,
            PacketError::WrongChecksum => Self::WrongChecksum,
            PacketError::TooLong | PacketError::Unsupported => Self::Malformed,
        }
    }
}

impl From<CommandError> for Rejection {
    fn from(error: CommandError) -> Self {
        match error {
            CommandError::UnknownFunction => Self::UnknownFunction,
            CommandError::WrongLength => Self::Malformed,
            CommandError::Argument(_) => Self::Argument,
        }
    }
}

#[cfg(test)]
mod tests;
