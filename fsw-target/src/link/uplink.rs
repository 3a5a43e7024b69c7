//! From bytes on the line to commands.
//!
//! In: one byte after the other. Out: a command that arrived intact, is meant for this computer,
//! hasn't been here before, and whose arguments are in range. Anything else is counted by its reason
//! and goes no further: each frame counts once.
//!
//! ```text
//!  byte -> frame -> packet -> checksum -> ours? -> function, arguments -> sequence count -> command
//! ```
//!
//! A packet is new if its sequence count is 1 to 8191 ahead of that of the last accepted one, modulo
//! 2¹⁴. After a reset of the computer nothing is known of counts: the first good packet is accepted,
//! whatever its count. [`Command::StartSequence`] is accepted with any count, as the control commands
//! of COP-1 are (CCSDS 232.1-B): a ground station that has lost count sends it first. The count keeps
//! a packet that the line or an impatient operator doubled from being executed twice; it is no
//! protection against somebody who forges packets.

use super::command::{Command, CommandError, Function, MAX_COMMAND};
use super::frame::{FrameError, FrameReceiver};
use super::packet::{self, COMMAND, PacketError, PacketType, SequenceCount};
use super::wire::record;

record! {
    /// What became of the frames that arrived. The counts stop at their maximum.
    struct UplinkCounters {
        /// Commands handed to the computer.
        accepted: u32, "–";
        /// Ended before they were complete, by COBS or by the packet's length field.
        truncated: u32, "–";
        /// Longer than the longest command.
        oversized: u32, "–";
        /// The checksum wasn't that of the bytes.
        wrong_checksum: u32, "–";
        /// Longer than the packet's length field or the function's arguments, shorter than the arguments, no telecommand, another APID or version, or a segment.
        malformed: u32, "–";
        /// No function has the number.
        unknown_function: u32, "–";
        /// An argument wasn't finite, was out of range, or was of no body.
        refused_argument: u32, "–";
        /// The sequence count wasn't ahead of that of the last accepted command.
        replayed: u32, "–";
    }
}

impl UplinkCounters {
    /// Nothing has arrived.
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
}

/// A command that was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accepted {
    /// What was asked for.
    pub function: Function,
    /// Of its packet.
    pub sequence_count: SequenceCount,
}

/// Why a frame is no command. Each has its counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refusal {
    Truncated,
    Oversized,
    WrongChecksum,
    Malformed,
    UnknownFunction,
    Argument,
    Replayed,
}

/// The receiving end of the line.
#[derive(Debug)]
pub struct Uplink {
    frames: FrameReceiver<MAX_COMMAND>,
    counters: UplinkCounters,
    last: Option<Accepted>,
}

impl Uplink {
    /// An uplink on which nothing has arrived.
    pub const fn new() -> Self {
        Self { frames: FrameReceiver::new(), counters: UplinkCounters::NONE, last: None }
    }

    /// Takes the next byte; the command, if it ends one.
    pub fn push(&mut self, byte: u8) -> Option<Command> {
        let read = self.frames.push(byte)?.map_err(Refusal::from).and_then(read);
        let result = read.and_then(|(command, count)| in_sequence(self.last, command, count));
        let counter = match result {
            Ok((command, accepted)) => {
                self.last = Some(accepted);
                count(&mut self.counters.accepted);
                return Some(command);
            }
            Err(Refusal::Truncated) => &mut self.counters.truncated,
            Err(Refusal::Oversized) => &mut self.counters.oversized,
            Err(Refusal::WrongChecksum) => &mut self.counters.wrong_checksum,
            Err(Refusal::Malformed) => &mut self.counters.malformed,
            Err(Refusal::UnknownFunction) => &mut self.counters.unknown_function,
            Err(Refusal::Argument) => &mut self.counters.refused_argument,
            Err(Refusal::Replayed) => &mut self.counters.replayed,
        };
        count(counter);
        None
    }

    /// What became of the frames so far.
    pub fn counters(&self) -> UplinkCounters {
        self.counters
    }

    /// The last command that was accepted.
    pub fn last_accepted(&self) -> Option<Accepted> {
        self.last
    }
}

impl Default for Uplink {
    fn default() -> Self {
        Self::new()
    }
}

fn read(packet: &[u8]) -> Result<(Command, SequenceCount), Refusal> {
    let (header, data) = packet::parse(packet)?;
    let ours =
        header.packet_type == PacketType::Tc && header.apid == COMMAND && header.time_us.is_none();
    if !ours {
        return Err(Refusal::Malformed);
    }
    Ok((Command::decode(data)?, header.sequence_count))
}

fn in_sequence(
    last: Option<Accepted>,
    command: Command,
    sequence_count: SequenceCount,
) -> Result<(Command, Accepted), Refusal> {
    let new = last.is_none_or(|last| packet::is_ahead(sequence_count, last.sequence_count));
    if new || command == Command::StartSequence {
        Ok((command, Accepted { function: command.function(), sequence_count }))
    } else {
        Err(Refusal::Replayed)
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl From<FrameError> for Refusal {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::Truncated => Self::Truncated,
            FrameError::Oversized => Self::Oversized,
        }
    }
}

impl From<PacketError> for Refusal {
    fn from(error: PacketError) -> Self {
        match error {
            PacketError::Truncated => Self::Truncated,
            PacketError::WrongChecksum => Self::WrongChecksum,
            PacketError::TooLong | PacketError::Unsupported => Self::Malformed,
        }
    }
}

impl From<CommandError> for Refusal {
    fn from(error: CommandError) -> Self {
        match error {
            CommandError::UnknownFunction => Self::UnknownFunction,
            CommandError::WrongLength => Self::Malformed,
            CommandError::Argument(_) => Self::Argument,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::link::command::samples::{any_command, one_of_each};
    use crate::link::frame::Frame;
    use crate::link::packet::{Apid, Header, Packet};
    use crate::link::wire::Wire;
    use fsw_core::Prior;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn framed(command: &Command, sequence_count: u16) -> Vec<u8> {
        let packet = command.packet(SequenceCount::new(sequence_count)).unwrap();
        Frame::of(packet.bytes()).unwrap().bytes().to_vec()
    }

    /// Intact, but not a command that any function here would make.
    fn made_by_hand(packet_type: PacketType, apid: u16, data: &[u8]) -> Vec<u8> {
        let (apid, sequence_count) = (Apid::new(apid), SequenceCount::new(1));
        let header = Header { packet_type, apid, sequence_count, time_us: None };
        let packet = Packet::new(&header, |out| out.put(data)).unwrap();
        Frame::of(packet.bytes()).unwrap().bytes().to_vec()
    }

    fn push(uplink: &mut Uplink, bytes: &[u8]) -> Vec<Command> {
        bytes.iter().filter_map(|byte| uplink.push(*byte)).collect()
    }

    fn receive(bytes: &[u8]) -> (Vec<Command>, UplinkCounters) {
        let mut uplink = Uplink::new();
        let commands = push(&mut uplink, bytes);
        (commands, uplink.counters())
    }

    fn frames(counters: &UplinkCounters) -> u64 {
        let UplinkCounters { accepted, truncated, oversized, wrong_checksum, malformed, .. } =
            *counters;
        let UplinkCounters { unknown_function, refused_argument, replayed, .. } = *counters;
        let frame = [accepted, truncated, oversized, wrong_checksum];
        let packet = [malformed, unknown_function, refused_argument, replayed];
        frame.into_iter().chain(packet).map(u64::from).sum()
    }

    #[test]
    fn each_command_arrives() {
        let mut uplink = Uplink::new();
        for (sequence_count, command) in (1..).zip(one_of_each()) {
            assert_eq!(push(&mut uplink, &framed(&command, sequence_count)), [command]);
            let accepted = uplink.last_accepted().unwrap();
            assert_eq!(accepted.function, command.function());
            assert_eq!(accepted.sequence_count.value(), sequence_count);
        }
        let accepted = one_of_each().len() as u32;
        assert_eq!(uplink.counters(), UplinkCounters { accepted, ..UplinkCounters::NONE });
    }

    #[test]
    fn a_command_in_real_bytes() {
        // The example of link.md.
        let bytes = [
            0x00, 0x05, 0x11, 0xf0, 0xc0, 0x05, 0x11, 0x0e, 0x0b, 0x3a, 0x83, 0x12, 0x6f, 0xbb,
            0x03, 0x12, 0x6f, 0x3a, 0x03, 0x12, 0x6f, 0xe0, 0xde, 0x00,
        ];
        assert_eq!(framed(&Command::SetTorque([1e-3, -2e-3, 5e-4]), 5), bytes);
        assert_eq!(receive(&bytes).0, [Command::SetTorque([1e-3, -2e-3, 5e-4])]);
    }

    #[test]
    fn a_command_is_obeyed_once_and_an_old_one_not_at_all() {
        let mut uplink = Uplink::new();
        for (sequence_count, obeyed) in
            [(100, true), (100, false), (99, false), (101, true), (100 + 8192, true), (101, false)]
        {
            let commands = push(&mut uplink, &framed(&Command::Reset, sequence_count));
            assert_eq!(!commands.is_empty(), obeyed, "count {sequence_count}");
        }
        assert_eq!((uplink.counters().accepted, uplink.counters().replayed), (3, 3));
    }

    #[test]
    fn the_sequence_count_wraps() {
        let mut uplink = Uplink::new();
        for turn in 0..5 * 16_384_u32 / 7 {
            let sequence_count = (turn * 7 % 16_384) as u16;
            let commands = push(&mut uplink, &framed(&Command::Ping, sequence_count));
            assert_eq!(commands, [Command::Ping]);
            assert_eq!(push(&mut uplink, &framed(&Command::Ping, sequence_count)), []);
        }
    }

    #[test]
    fn whoever_has_lost_count_starts_a_new_one() {
        let mut uplink = Uplink::new();
        push(&mut uplink, &framed(&Command::Ping, 5000));
        assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), []);
        assert_eq!(
            push(&mut uplink, &framed(&Command::StartSequence, 0)),
            [Command::StartSequence]
        );
        assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), [Command::Reset]);
        assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), []);
    }

    #[test]
    fn what_was_refused_moves_no_count() {
        let mut uplink = Uplink::new();
        push(&mut uplink, &framed(&Command::Ping, 10));
        push(&mut uplink, &framed(&Command::SetTorque([f32::NAN, 0.0, 0.0]), 12));
        assert_eq!(push(&mut uplink, &framed(&Command::Ping, 11)), [Command::Ping]);
    }

    #[test]
    fn each_way_to_be_wrong_has_its_counter() {
        let none = UplinkCounters::NONE;
        let mut wrong_checksum = framed(&Command::Reset, 1);
        let last = wrong_checksum.len() - 2;
        wrong_checksum[last] ^= if wrong_checksum[last] == 1 { 2 } else { 1 };
        let torque = Command::SetTorque([0.0, f32::INFINITY, 0.0]);
        let (tc, tm) = (PacketType::Tc, PacketType::Tm);
        for (bytes, counted) in [
            (framed(&Command::Reset, 1)[..5].to_vec(), UplinkCounters { ..none }),
            (
                [&framed(&Command::Reset, 1)[..5], &[0]].concat(),
                UplinkCounters { truncated: 1, ..none },
            ),
            ([&[0], &[1; 5][..], &[0]].concat(), UplinkCounters { truncated: 1, ..none }),
            ([&[1; 200][..], &[0]].concat(), UplinkCounters { oversized: 1, ..none }),
            (wrong_checksum, UplinkCounters { wrong_checksum: 1, ..none }),
            (made_by_hand(tm, 0x1f0, &[3]), UplinkCounters { malformed: 1, ..none }),
            (made_by_hand(tc, 0x1f1, &[3]), UplinkCounters { malformed: 1, ..none }),
            (made_by_hand(tc, 0x1f0, &[]), UplinkCounters { malformed: 1, ..none }),
            (made_by_hand(tc, 0x1f0, &[3, 0]), UplinkCounters { malformed: 1, ..none }),
            (made_by_hand(tc, 0x1f0, &[7]), UplinkCounters { malformed: 1, ..none }),
            (made_by_hand(tc, 0x1f0, &[12]), UplinkCounters { unknown_function: 1, ..none }),
            (made_by_hand(tc, 0x1f0, &[0]), UplinkCounters { unknown_function: 1, ..none }),
            (made_by_hand(tc, 0x1f0, &[7, 3]), UplinkCounters { refused_argument: 1, ..none }),
            (framed(&torque, 1), UplinkCounters { refused_argument: 1, ..none }),
        ] {
            assert_eq!(receive(&bytes), (Vec::new(), counted), "{bytes:02x?}");
        }
    }

    #[test]
    fn arguments_out_of_range_are_refused() {
        let good = Prior { inertia_kg_m2: [2.0, 2.0, 3.0, 0.1, 0.0, 0.0], sigma_kg_m2: [1.0; 6] };
        assert_eq!(receive(&framed(&Command::SetPrior(good), 1)).0, [Command::SetPrior(good)]);
        let mut priors = [good; 6];
        priors[0].inertia_kg_m2[2] = 4.5; // more than the two others together
        priors[1].inertia_kg_m2[3] = f32::NAN;
        priors[2].inertia_kg_m2 = [1e30, 1e30, 1e30, 0.0, 0.0, 0.0];
        priors[3].sigma_kg_m2[5] = 0.0;
        priors[4].sigma_kg_m2[0] = f32::INFINITY;
        priors[5].sigma_kg_m2[1] = 1e-30;
        let wrong = priors.map(Command::SetPrior).into_iter().chain([
            Command::SetTelemetryPeriod { ms: 0 },
            Command::SetTelemetryPeriod { ms: 3_600_001 },
            Command::SetTorque([0.0, 0.0, -100.1]),
        ]);
        for command in wrong {
            let (commands, counters) = receive(&framed(&command, 1));
            assert_eq!((commands, counters.refused_argument), (Vec::new(), 1), "{command:?}");
        }
    }

    #[test]
    fn no_wrong_byte_of_a_packet_gets_through() {
        for command in one_of_each() {
            let packet = command.packet(SequenceCount::new(1)).unwrap();
            for at in 0..packet.bytes().len() {
                for bits in 1..=255 {
                    let mut wrong = packet.bytes().to_vec();
                    wrong[at] ^= bits;
                    let frame = Frame::of(&wrong).unwrap();
                    assert_eq!(receive(frame.bytes()).0, [], "{command:?}, byte {at}, {bits:#x}");
                }
            }
        }
    }

    #[test]
    fn no_wrong_byte_of_a_frame_becomes_another_command() {
        for command in one_of_each() {
            let frame = framed(&command, 1);
            for at in 0..frame.len() {
                for bits in 1..=255 {
                    let mut wrong = frame.clone();
                    wrong[at] ^= bits;
                    let (commands, _) = receive(&wrong);
                    // Outside the packet is the first zero: a lone byte there is a frame of its own.
                    assert!(commands.is_empty() || at == 0, "{command:?}, byte {at}, {bits:#x}");
                    assert!(commands.iter().all(|other| *other == command));
                }
            }
        }
    }

    #[test]
    fn counters_stop_at_their_maximum() {
        let mut counter = u32::MAX;
        count(&mut counter);
        assert_eq!(counter, u32::MAX);
    }

    #[derive(Clone, Debug)]
    enum Piece {
        Good(Command),
        Cut(Command, prop::sample::Index),
        Noise(Vec<u8>),
    }

    fn any_piece() -> impl Strategy<Value = Piece> {
        prop_oneof![
            any_command().prop_map(Piece::Good),
            (any_command(), any::<prop::sample::Index>()).prop_map(|(c, at)| Piece::Cut(c, at)),
            prop::collection::vec(any::<u8>(), 0..300).prop_map(Piece::Noise),
        ]
    }

    proptest! {
        #[test]
        fn any_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..4000)) {
            let (commands, counters) = receive(&bytes);
            // Noise that is a command by chance would take a right checksum.
            prop_assert_eq!(commands, []);
            prop_assert!(frames(&counters) <= bytes.len() as u64);
        }

        #[test]
        fn any_user_data_does_no_harm(data in prop::collection::vec(any::<u8>(), 0..=54)) {
            let (commands, counters) = receive(&made_by_hand(PacketType::Tc, 0x1f0, &data));
            prop_assert_eq!(frames(&counters), 1);
            prop_assert!(commands.iter().all(|command| command.check().is_ok()));
        }

        #[test]
        fn any_command_survives_to_the_last_bit(command in any_command(), count in 0_u16..16_384) {
            let line = framed(&command, count);
            let (commands, _) = receive(&line);
            prop_assert_eq!(commands.len(), 1);
            prop_assert_eq!(framed(&commands[0], count), line);
        }

        #[test]
        fn each_good_command_gets_through_between_bad_ones(
            pieces in prop::collection::vec(any_piece(), 0..20),
        ) {
            let mut uplink = Uplink::new();
            let (mut sent, mut arrived) = (Vec::new(), Vec::new());
            for (count, piece) in (1..).zip(&pieces) {
                let bytes = match piece {
                    Piece::Good(command) => {
                        sent.push(*command);
                        framed(command, count)
                    }
                    Piece::Cut(command, at) => {
                        let whole = framed(command, count);
                        // Without its last zero it would be whole by the first zero of the next.
                        whole[..at.index(whole.len() - 1)].to_vec()
                    }
                    Piece::Noise(bytes) => bytes.clone(),
                };
                arrived.extend(push(&mut uplink, &bytes));
            }
            prop_assert_eq!(arrived, sent);
        }

        #[test]
        fn what_arrives_is_what_was_sent_or_nothing(
            command in any_command(),
            hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        ) {
            let mut line = framed(&command, 1);
            for (at, byte) in hits {
                let at = at.index(line.len());
                line[at] = byte;
            }
            let (commands, _) = receive(&line);
            prop_assert!(commands.iter().all(|other| *other == command));
        }
    }

    #[test]
    fn the_longest_command_is_shorter_than_the_receiver_takes() {
        let longest = one_of_each()
            .map(|command| command.packet(SequenceCount::new(0)).unwrap().bytes().len());
        assert!(longest.into_iter().max().unwrap() <= MAX_COMMAND);
        assert_eq!(<UplinkCounters as Wire>::BYTES, 32);
    }
}
