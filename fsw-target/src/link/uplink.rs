//! Receiver of telecommands.
//!
//! Input: bytes of the line. Output: commands that arrived intact, are addressed to this computer, are
//! authentic, new, and have valid arguments. Every other frame is counted by its reason, each frame once.
//!
//! ```text
//!  byte -> frame -> packet -> checksum -> APID -> counter -> tag -> function, arguments -> command
//! ```
//!
//! # With a key
//!
//! A telecommand is accepted if its counter is 1 to [`MAX_ADVANCE`](super::authentication::MAX_ADVANCE) ahead
//! of the last accepted one of its key slot and its tag is right. The caller stores the
//! [`ledger`](Uplink::ledger) of counters before it executes the command, so that a
//! telecommand is executed at most once, over restarts too. Sequence counts are not checked.
//!
//! # Without a key
//!
//! A packet without a tag is new if its sequence count is 1 to 8191 ahead of the last accepted count, modulo
//! 2¹⁴. After a reset of the computer the first valid packet is accepted with any count.
//! [`Command::StartSequence`] is accepted with any count, as the control commands of COP-1 are
//! (CCSDS 232.1-B): a ground station without the last count sends it first. The check prevents the
//! repeated execution of a duplicated packet. It does not authenticate the sender.

use super::authentication::{CounterFault, Key, Ledger};
use super::command::{Command, CommandError, Function, MAX_COMMAND};
use super::frame::{FrameError, FrameReceiver};
use super::packet::{self, COMMAND, PacketError, Parsed, Secondary, SequenceCount};
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
        /// Telecommands with a sequence count, or with a tag a counter, not ahead of the last accepted one.
        replayed: u32, "–";
        /// Telecommands with a counter too far ahead of the last accepted one.
        far_ahead: u32, "–";
        /// Telecommands without a tag where one is required, or with one where the image has no key.
        unauthenticated: u32, "–";
        /// Telecommands with a wrong tag or an unknown key slot.
        wrong_tag: u32, "–";
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
        far_ahead: 0,
        unauthenticated: 0,
        wrong_tag: 0,
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
            Rejection::FarAhead => &mut self.far_ahead,
            Rejection::Unauthenticated => &mut self.unauthenticated,
            Rejection::WrongTag => &mut self.wrong_tag,
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
    /// Key slot of its tag; `None` in an image without a key.
    pub slot: Option<u8>,
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
    FarAhead,
    Unauthenticated,
    WrongTag,
}

/// Receiving end of the line.
#[derive(Debug)]
pub struct Uplink {
    frames: FrameReceiver<MAX_COMMAND>,
    counters: UplinkCounters,
    last: Option<Accepted>,
    /// Master key; `None`: telecommands are accepted without a tag.
    master: Option<Key>,
    ledger: Ledger,
}

impl Uplink {
    /// An uplink before its first byte, which requires tags if there is a master key.
    pub const fn new(master: Option<Key>) -> Self {
        Self {
            frames: FrameReceiver::new(),
            counters: UplinkCounters::NONE,
            last: None,
            master,
            ledger: Ledger::INITIAL,
        }
    }

    /// Takes the next byte. The last byte of a valid telecommand yields the command.
    pub fn push(&mut self, byte: u8) -> Option<Command> {
        let Self { frames, last, master, ledger, .. } = self;
        let frame = frames.push(byte)?.map_err(Rejection::from);
        match frame.and_then(|packet| read(packet, master.as_ref(), ledger, *last)) {
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

    /// True if telecommands need a tag.
    pub fn requires_tags(&self) -> bool {
        self.master.is_some()
    }

    /// Counters and key generations, to be kept over a restart.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Ledger as stored, at the start.
    pub fn restore(&mut self, ledger: Ledger) {
        self.ledger = ledger;
    }

    /// Executes [`Command::ChangeKey`] as the last accepted telecommand; false if it is not permitted.
    pub fn change_key(&mut self, target: u8) -> bool {
        let Some(by) = self.last.and_then(|last| last.slot) else { return false };
        let counter = self.ledger.slot(by).map_or(0, |slot| slot.counter);
        self.ledger.change_key(by, counter, target)
    }

    /// Executes [`Command::TagTelemetry`] as the last accepted telecommand; false without a key.
    pub fn tag_telemetry(&mut self, on: bool) -> bool {
        let slot = self.last.and_then(|last| last.slot);
        self.ledger.tag_telemetry(slot.filter(|_| on));
        slot.is_some()
    }

    /// Slot and key of the tag of telemetry; `None` for telemetry without a tag.
    pub fn telemetry_key(&self) -> Option<(u8, Key)> {
        let (slot, master) = (self.ledger.telemetry_slot()?, self.master.as_ref()?);
        Some((slot, master.of_slot(slot, self.ledger.slot(slot)?.generation)))
    }
}

impl Default for Uplink {
    /// Without a key.
    fn default() -> Self {
        Self::new(None)
    }
}

/// Accepts the telecommand of a packet, and its counter.
#[inline(never)]
fn read(
    packet: &[u8],
    master: Option<&Key>,
    ledger: &mut Ledger,
    last: Option<Accepted>,
) -> Result<(Command, Accepted), Rejection> {
    let parsed = packet::parse(packet)?;
    if parsed.header.apid != COMMAND {
        return Err(Rejection::Malformed);
    }
    let accepted = |command: Command, slot| {
        let (function, sequence_count) = (command.function(), parsed.header.sequence_count);
        (command, Accepted { function, sequence_count, slot })
    };
    match (parsed.header.secondary, master) {
        (Secondary::Telemetry { .. }, _) => Err(Rejection::Malformed),
        (Secondary::Plain, None) => {
            let command = Command::decode(parsed.data)?;
            check_sequence(last, command, parsed.header.sequence_count)?;
            Ok(accepted(command, None))
        }
        (Secondary::Tagged { slot, counter }, Some(master)) => {
            authenticate(&parsed, master, ledger, slot, counter)?;
            let command = Command::decode(parsed.data)?;
            ledger.accept(slot, counter);
            Ok(accepted(command, Some(slot)))
        }
        (Secondary::Plain, Some(_)) | (Secondary::Tagged { .. }, None) => {
            Err(Rejection::Unauthenticated)
        }
    }
}

/// Checks the counter, then the tag: a recorded telecommand costs no cipher.
fn authenticate(
    parsed: &Parsed<'_>,
    master: &Key,
    ledger: &Ledger,
    slot: u8,
    counter: u32,
) -> Result<(), Rejection> {
    let state = ledger.slot(slot).ok_or(Rejection::WrongTag)?;
    Ledger::check(state, counter)?;
    match parsed.is_authentic(&master.of_slot(slot, state.generation)) {
        true => Ok(()),
        false => Err(Rejection::WrongTag),
    }
}

/// Accepts a command without a tag that is new, or that starts a sequence.
fn check_sequence(
    last: Option<Accepted>,
    command: Command,
    sequence_count: SequenceCount,
) -> Result<(), Rejection> {
    let new = last.is_none_or(|last| packet::is_ahead(sequence_count, last.sequence_count));
    if new || command == Command::StartSequence { Ok(()) } else { Err(Rejection::Replayed) }
}

fn increment(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl From<CounterFault> for Rejection {
    fn from(fault: CounterFault) -> Self {
        match fault {
            CounterFault::Replayed => Self::Replayed,
            CounterFault::FarAhead => Self::FarAhead,
        }
    }
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
