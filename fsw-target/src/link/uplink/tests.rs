//! The uplink on valid, damaged and random bytes.

extern crate std;
use super::*;
use crate::link::command::fixtures::{any_command, one_of_each};
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

/// An intact packet of any type, APID and user data.
fn any_packet(packet_type: PacketType, apid: u16, data: &[u8]) -> Vec<u8> {
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
fn command_has_the_bytes_of_the_documentation() {
    // Example of link.md.
    let bytes = [
        0x00, 0x05, 0x11, 0xf0, 0xc0, 0x05, 0x11, 0x0e, 0x0b, 0x3a, 0x83, 0x12, 0x6f, 0xbb, 0x03,
        0x12, 0x6f, 0x3a, 0x03, 0x12, 0x6f, 0xe0, 0xde, 0x00,
    ];
    assert_eq!(framed(&Command::SetTorque([1e-3, -2e-3, 5e-4]), 5), bytes);
    assert_eq!(receive(&bytes).0, [Command::SetTorque([1e-3, -2e-3, 5e-4])]);
}

#[test]
fn repeated_and_old_commands_are_rejected() {
    let mut uplink = Uplink::new();
    for (sequence_count, accepted) in
        [(100, true), (100, false), (99, false), (101, true), (100 + 8192, true), (101, false)]
    {
        let commands = push(&mut uplink, &framed(&Command::Reset, sequence_count));
        assert_eq!(!commands.is_empty(), accepted, "count {sequence_count}");
    }
    assert_eq!((uplink.counters().accepted, uplink.counters().replayed), (3, 3));
}

#[test]
fn sequence_count_wraps() {
    let mut uplink = Uplink::new();
    for turn in 0..5 * 16_384_u32 / 7 {
        let sequence_count = (turn * 7 % 16_384) as u16;
        let commands = push(&mut uplink, &framed(&Command::Ping, sequence_count));
        assert_eq!(commands, [Command::Ping]);
        assert_eq!(push(&mut uplink, &framed(&Command::Ping, sequence_count)), []);
    }
}

#[test]
fn start_sequence_sets_the_reference_count() {
    let mut uplink = Uplink::new();
    push(&mut uplink, &framed(&Command::Ping, 5000));
    assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), []);
    assert_eq!(push(&mut uplink, &framed(&Command::StartSequence, 0)), [Command::StartSequence]);
    assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), [Command::Reset]);
    assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), []);
}

#[test]
fn rejected_command_leaves_the_reference_count() {
    let mut uplink = Uplink::new();
    push(&mut uplink, &framed(&Command::Ping, 10));
    push(&mut uplink, &framed(&Command::SetTorque([f32::NAN, 0.0, 0.0]), 12));
    assert_eq!(push(&mut uplink, &framed(&Command::Ping, 11)), [Command::Ping]);
}

#[test]
fn every_rejection_has_its_counter() {
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
        (any_packet(tm, 0x1f0, &[3]), UplinkCounters { malformed: 1, ..none }),
        (any_packet(tc, 0x1f1, &[3]), UplinkCounters { malformed: 1, ..none }),
        (any_packet(tc, 0x1f0, &[]), UplinkCounters { malformed: 1, ..none }),
        (any_packet(tc, 0x1f0, &[3, 0]), UplinkCounters { malformed: 1, ..none }),
        (any_packet(tc, 0x1f0, &[7]), UplinkCounters { malformed: 1, ..none }),
        (any_packet(tc, 0x1f0, &[12]), UplinkCounters { unknown_function: 1, ..none }),
        (any_packet(tc, 0x1f0, &[0]), UplinkCounters { unknown_function: 1, ..none }),
        (any_packet(tc, 0x1f0, &[7, 3]), UplinkCounters { refused_argument: 1, ..none }),
        (framed(&torque, 1), UplinkCounters { refused_argument: 1, ..none }),
    ] {
        assert_eq!(receive(&bytes), (Vec::new(), counted), "{bytes:02x?}");
    }
}

#[test]
fn arguments_out_of_range_are_rejected() {
    let good = Prior { inertia_kg_m2: [2.0, 2.0, 3.0, 0.1, 0.0, 0.0], sigma_kg_m2: [1.0; 6] };
    assert_eq!(receive(&framed(&Command::SetPrior(good), 1)).0, [Command::SetPrior(good)]);
    let mut priors = [good; 6];
    priors[0].inertia_kg_m2[2] = 4.5; // above the sum of the two others
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
fn packet_with_a_wrong_byte_is_rejected() {
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
fn frame_with_a_wrong_byte_is_no_other_command() {
    for command in one_of_each() {
        let frame = framed(&command, 1);
        for at in 0..frame.len() {
            for bits in 1..=255 {
                let mut wrong = frame.clone();
                wrong[at] ^= bits;
                let (commands, _) = receive(&wrong);
                // The leading zero is outside the packet: another byte there forms a frame of its own.
                assert!(commands.is_empty() || at == 0, "{command:?}, byte {at}, {bits:#x}");
                assert!(commands.iter().all(|other| *other == command));
            }
        }
    }
}

#[test]
fn counters_saturate() {
    let mut counter = u32::MAX;
    increment(&mut counter);
    assert_eq!(counter, u32::MAX);
}

#[derive(Clone, Debug)]
enum Piece {
    Valid(Command),
    Cut(Command, prop::sample::Index),
    Noise(Vec<u8>),
}

fn any_piece() -> impl Strategy<Value = Piece> {
    prop_oneof![
        any_command().prop_map(Piece::Valid),
        (any_command(), any::<prop::sample::Index>()).prop_map(|(c, at)| Piece::Cut(c, at)),
        prop::collection::vec(any::<u8>(), 0..300).prop_map(Piece::Noise),
    ]
}

proptest! {
    #[test]
    fn any_bytes_are_rejected_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..4000)) {
        let (commands, counters) = receive(&bytes);
        // Noise has no valid checksum here.
        prop_assert_eq!(commands, []);
        prop_assert!(frames(&counters) <= bytes.len() as u64);
    }

    #[test]
    fn any_user_data_gives_a_valid_command_or_none(data in prop::collection::vec(any::<u8>(), 0..=54)) {
        let (commands, counters) = receive(&any_packet(PacketType::Tc, 0x1f0, &data));
        prop_assert_eq!(frames(&counters), 1);
        prop_assert!(commands.iter().all(|command| command.check().is_ok()));
    }

    #[test]
    fn command_is_bit_exact(command in any_command(), count in 0_u16..16_384) {
        let line = framed(&command, count);
        let (commands, _) = receive(&line);
        prop_assert_eq!(commands.len(), 1);
        prop_assert_eq!(framed(&commands[0], count), line);
    }

    #[test]
    fn valid_commands_between_invalid_frames_arrive(
        pieces in prop::collection::vec(any_piece(), 0..20),
    ) {
        let mut uplink = Uplink::new();
        let (mut sent, mut arrived) = (Vec::new(), Vec::new());
        for (count, piece) in (1..).zip(&pieces) {
            let bytes = match piece {
                Piece::Valid(command) => {
                    sent.push(*command);
                    framed(command, count)
                }
                Piece::Cut(command, at) => {
                    let whole = framed(command, count);
                    // Cut before its last byte: the leading zero of the next frame completes a frame.
                    whole[..at.index(whole.len() - 1)].to_vec()
                }
                Piece::Noise(bytes) => bytes.clone(),
            };
            arrived.extend(push(&mut uplink, &bytes));
        }
        prop_assert_eq!(arrived, sent);
    }

    #[test]
    fn corrupted_line_gives_the_command_sent_or_none(
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
fn longest_command_fits_the_receiver() {
    let longest =
        one_of_each().map(|command| command.packet(SequenceCount::new(0)).unwrap().bytes().len());
    assert!(longest.into_iter().max().unwrap() <= MAX_COMMAND);
    assert_eq!(<UplinkCounters as Wire>::BYTES, 32);
}
