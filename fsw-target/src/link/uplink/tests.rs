//! The uplink on valid, damaged and random bytes.

extern crate std;
use super::*;
use crate::link::authentication::{MAX_ADVANCE, SLOTS};
use crate::link::command::fixtures::{any_command, one_of_each};
use crate::link::frame::Frame;
use crate::link::packet::{Apid, Header, Packet, PacketType};
use crate::link::wire::Wire;
use fsw_core::Prior;
use proptest::prelude::*;
use std::vec::Vec;

fn framed(command: &Command, sequence_count: u16) -> Vec<u8> {
    let packet = command.packet(SequenceCount::new(sequence_count)).unwrap();
    Frame::of(packet.bytes()).unwrap().bytes().to_vec()
}

const MASTER: Key = Key::new(*b"master key, test");

/// Frame with a tag of the first key of a slot.
fn tagged(command: &Command, slot: u8, counter: u32) -> Vec<u8> {
    tagged_by(&MASTER.of_slot(slot, 0), command, slot, counter)
}

fn tagged_by(key: &Key, command: &Command, slot: u8, counter: u32) -> Vec<u8> {
    let packet = command.tagged_packet(key, slot, counter).unwrap();
    Frame::of(packet.bytes()).unwrap().bytes().to_vec()
}

/// An intact packet of any type, APID and user data.
fn any_packet(packet_type: PacketType, apid: u16, data: &[u8]) -> Vec<u8> {
    let secondary = match packet_type {
        PacketType::Tc => Secondary::Plain,
        PacketType::Tm => Secondary::Telemetry { time_us: 0, slot: None },
    };
    let header = Header { apid: Apid::new(apid), sequence_count: SequenceCount::new(1), secondary };
    let packet = Packet::new(&header, None, &|out| out.put(data)).unwrap();
    Frame::of(packet.bytes()).unwrap().bytes().to_vec()
}

fn push(uplink: &mut Uplink, bytes: &[u8]) -> Vec<Command> {
    bytes.iter().filter_map(|byte| uplink.push(*byte)).collect()
}

fn receive(bytes: &[u8]) -> (Vec<Command>, UplinkCounters) {
    let mut uplink = Uplink::default();
    let commands = push(&mut uplink, bytes);
    (commands, uplink.counters())
}

fn frames(counters: &UplinkCounters) -> u64 {
    let UplinkCounters { accepted, truncated, oversized, wrong_checksum, malformed, .. } =
        *counters;
    let UplinkCounters { unknown_function, refused_argument, replayed, .. } = *counters;
    let UplinkCounters { far_ahead, unauthenticated, wrong_tag, .. } = *counters;
    let frame = [accepted, truncated, oversized, wrong_checksum];
    let packet = [malformed, unknown_function, refused_argument, replayed];
    let tag = [far_ahead, unauthenticated, wrong_tag];
    frame.into_iter().chain(packet).chain(tag).map(u64::from).sum()
}

#[test]
fn each_command_arrives() {
    let mut uplink = Uplink::default();
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
    let mut uplink = Uplink::default();
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
    let mut uplink = Uplink::default();
    for turn in 0..5 * 16_384_u32 / 7 {
        let sequence_count = (turn * 7 % 16_384) as u16;
        let commands = push(&mut uplink, &framed(&Command::Ping, sequence_count));
        assert_eq!(commands, [Command::Ping]);
        assert_eq!(push(&mut uplink, &framed(&Command::Ping, sequence_count)), []);
    }
}

#[test]
fn start_sequence_sets_the_reference_count() {
    let mut uplink = Uplink::default();
    push(&mut uplink, &framed(&Command::Ping, 5000));
    assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), []);
    assert_eq!(push(&mut uplink, &framed(&Command::StartSequence, 0)), [Command::StartSequence]);
    assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), [Command::Reset]);
    assert_eq!(push(&mut uplink, &framed(&Command::Reset, 1)), []);
}

#[test]
fn rejected_command_leaves_the_reference_count() {
    let mut uplink = Uplink::default();
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
        (any_packet(tc, 0x1f0, &[20]), UplinkCounters { unknown_function: 1, ..none }),
        (any_packet(tc, 0x1f0, &[0]), UplinkCounters { unknown_function: 1, ..none }),
        (any_packet(tc, 0x1f0, &[7, 3]), UplinkCounters { refused_argument: 1, ..none }),
        (framed(&torque, 1), UplinkCounters { refused_argument: 1, ..none }),
        (tagged(&Command::Reset, 1, 1), UplinkCounters { unauthenticated: 1, ..none }),
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
        Command::ChangeKey { slot: 0 },
        Command::ChangeKey { slot: SLOTS as u8 },
        Command::AssumeWheelSpeed { wheel: 0, speed_rad_s: None },
        Command::AssumeWheelSpeed { wheel: 5, speed_rad_s: None },
        Command::AssumeWheelSpeed { wheel: 1, speed_rad_s: Some(f32::NAN) },
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
    fn any_user_data_gives_a_valid_command_or_none(data in prop::collection::vec(any::<u8>(), 0..=86)) {
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
        let mut uplink = Uplink::default();
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
    let tagged = one_of_each()
        .map(|command| command.tagged_packet(&MASTER, 0, u32::MAX).unwrap().bytes().len());
    assert_eq!(tagged.into_iter().max(), Some(95));
    assert_eq!(<UplinkCounters as Wire>::BYTES, 44);
}

#[test]
fn tagged_command_has_the_bytes_of_the_documentation() {
    // Example of link.md.
    let master = Key::new(core::array::from_fn(|byte| byte as u8));
    let command = Command::SetTorque([1e-3, -2e-3, 5e-4]);
    let packet = command.tagged_packet(&master.of_slot(1, 0), 1, 5).unwrap();
    let bytes = packet.bytes().iter().map(|byte| std::format!("{byte:02x}")).collect::<Vec<_>>();
    let text = include_str!("../link.md").split_whitespace().collect::<Vec<_>>();
    assert!(text.windows(bytes.len()).any(|words| words == bytes), "{}", bytes.join(" "));
    let key = master.of_slot(1, 0).bytes().map(|byte| std::format!("{byte:02x}")).concat();
    assert!(text.contains(&std::format!("`{key}`").as_str()), "{key}");
    let mut uplink = Uplink::new(Some(master));
    assert_eq!(push(&mut uplink, Frame::of(packet.bytes()).unwrap().bytes()), [command]);
}

#[test]
fn each_command_arrives_with_a_tag() {
    let mut uplink = Uplink::new(Some(MASTER));
    for (counter, command) in (1..).zip(one_of_each()) {
        assert_eq!(push(&mut uplink, &tagged(&command, 1, counter)), [command]);
        assert_eq!(uplink.last_accepted().unwrap().slot, Some(1));
        assert_eq!(uplink.ledger().slots()[1].counter, counter);
    }
}

#[test]
fn with_a_key_every_other_telecommand_is_refused_and_counted() {
    let none = UplinkCounters::NONE;
    let packet = Command::Reset.tagged_packet(&MASTER, 1, 1).unwrap(); // the key of no slot
    let by_master = Frame::of(packet.bytes()).unwrap().bytes().to_vec();
    let of_other_slot = tagged_by(&MASTER.of_slot(2, 0), &Command::Reset, 1, 1);
    let unknown_slot = tagged(&Command::Reset, SLOTS as u8, 1);
    let torque = Command::SetTorque([f32::NAN; 3]);
    for (bytes, counted) in [
        (framed(&Command::Reset, 1), UplinkCounters { unauthenticated: 1, ..none }),
        (framed(&Command::StartSequence, 1), UplinkCounters { unauthenticated: 1, ..none }),
        (by_master, UplinkCounters { wrong_tag: 1, ..none }),
        (of_other_slot, UplinkCounters { wrong_tag: 1, ..none }),
        (unknown_slot, UplinkCounters { wrong_tag: 1, ..none }),
        (tagged(&Command::Reset, 1, 0), UplinkCounters { replayed: 1, ..none }),
        (tagged(&Command::Reset, 1, MAX_ADVANCE + 1), UplinkCounters { far_ahead: 1, ..none }),
        (tagged(&torque, 1, 1), UplinkCounters { refused_argument: 1, ..none }),
    ] {
        let mut uplink = Uplink::new(Some(MASTER));
        assert_eq!(push(&mut uplink, &bytes), []);
        assert_eq!(uplink.counters(), counted);
        assert_eq!(*uplink.ledger(), Ledger::INITIAL, "a refused telecommand changes nothing");
    }
    // A wrong byte of the tag with a right checksum.
    let uplink = &mut Uplink::new(Some(MASTER));
    let wrong_tag = resealed(|packet| packet[15] ^= 1);
    assert_eq!(push(uplink, &wrong_tag), []);
    assert_eq!(uplink.counters(), UplinkCounters { wrong_tag: 1, ..none });
}

/// Counters of the slots are independent: a large value in one does not affect the others.
#[test]
fn every_slot_has_its_own_counter() {
    let mut uplink = Uplink::new(Some(MASTER));
    push(&mut uplink, &tagged(&Command::Ping, 1, MAX_ADVANCE));
    assert_eq!(push(&mut uplink, &tagged(&Command::Reset, 2, 1)), [Command::Reset]);
    assert_eq!(push(&mut uplink, &tagged(&Command::Reset, 1, 1)), []);
    assert_eq!(push(&mut uplink, &tagged(&Command::Reset, 1, MAX_ADVANCE + 1)), [Command::Reset]);
}

#[test]
fn changed_key_refuses_every_telecommand_of_the_old_one() {
    let mut uplink = Uplink::new(Some(MASTER));
    let session: Vec<Vec<u8>> =
        (1..=20).map(|counter| tagged(&Command::Ping, 1, counter)).collect();
    session.iter().for_each(|frame| assert_eq!(push(&mut uplink, frame), [Command::Ping]));
    let change = Command::ChangeKey { slot: 1 };
    // By the slot itself: received, and not permitted.
    assert_eq!(push(&mut uplink, &tagged(&change, 1, 21)), [change]);
    assert!(!uplink.change_key(1));
    assert_eq!(push(&mut uplink, &tagged(&change, 0, 77)), [change]);
    assert!(uplink.change_key(1));
    assert_eq!(
        (uplink.ledger().slots()[1].counter, uplink.ledger().slots()[1].generation),
        (0, 77)
    );
    let wrong_tags = uplink.counters().wrong_tag;
    session.iter().for_each(|frame| assert_eq!(push(&mut uplink, frame), []));
    assert_eq!(uplink.counters().wrong_tag, wrong_tags + 20);
    let key = MASTER.of_slot(1, 77);
    assert_eq!(push(&mut uplink, &tagged_by(&key, &Command::Ping, 1, 1)), [Command::Ping]);
    // The change itself cannot be replayed.
    assert_eq!(push(&mut uplink, &tagged(&change, 0, 77)), []);
}

/// Frame of a telecommand of slot 1 after `change` of the bytes before its checksum, with a right length and
/// checksum.
fn resealed(change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let packet = Command::Reset.tagged_packet(&MASTER.of_slot(1, 0), 1, 1).unwrap();
    let mut packet = packet.bytes()[..packet.bytes().len() - 2].to_vec();
    change(&mut packet);
    let length = (packet.len() + 2).saturating_sub(7) as u16;
    if packet.len() > 5 {
        packet[4..6].copy_from_slice(&length.to_be_bytes());
    }
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740).checksum(&packet);
    packet.extend(crc.to_be_bytes());
    Frame::of(&packet).unwrap().bytes().to_vec()
}

/// Number from an environment variable: the size of the randomised tests below.
fn size_of_test(variable: &str, default: u64) -> u64 {
    std::env::var(variable).map_or(default, |text| text.parse().expect("a number"))
}

/// 64-bit generator of Steele, Lea and Flood (SplitMix64, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// Mutations of a packet without its checksum: bits, bytes, lengths, parts of other packets.
fn mutate(packet: &mut Vec<u8>, others: &[Vec<u8>], random: &mut Random) {
    for _ in 0..=random.below(3) {
        let at = random.below(packet.len());
        match random.below(7) {
            0 | 1 => packet[at] ^= 1 << random.below(8),
            2 => packet[at] = random.next() as u8,
            3 => packet.truncate(at.max(7)),
            4 => packet.insert(at, random.next() as u8),
            5 => packet.extend([0; 3]),
            _ => {
                let other = &others[random.below(others.len())];
                let from = random.below(other.len());
                let length = random.below(17).min(packet.len() - at).min(other.len() - from);
                packet[at..at + length].copy_from_slice(&other[from..from + length]);
            }
        }
    }
    packet.truncate(MAX_COMMAND - 2);
}

/// A ground station sends rightly tagged telecommands; between them come mutations of those sent and of those
/// still to be sent, with valid checksums. Number of mutated frames: `UPLINK_FRAMES`.
#[test]
fn mutated_frames_are_never_obeyed() {
    let frames = size_of_test("UPLINK_FRAMES", 20_000);
    let mut random = Random(1);
    let mut uplink = Uplink::new(Some(MASTER));
    let all = one_of_each();
    let mut counter = 0;
    let raw = |command: &Command, slot, counter| {
        let packet = command.tagged_packet(&MASTER.of_slot(slot, 0), slot, counter).unwrap();
        packet.bytes()[..packet.bytes().len() - 2].to_vec()
    };
    let mut obeyed = 0;
    for round in 0..frames / 10 {
        counter += 1;
        let slot = (round % 3) as u8;
        let command = all[random.below(all.len())];
        // Neither changes the keys of the ground station below.
        let genuine = raw(&command, slot, counter);
        let others = [
            raw(&all[random.below(all.len())], slot, counter),
            raw(&command, (slot + 1) % 3, counter),
            raw(&all[random.below(all.len())], slot, counter.saturating_sub(1)),
        ];
        let genuine_frames: Vec<_> = core::iter::once(&genuine)
            .chain(&others)
            .map(|packet| resealed(|to| to.clone_from(packet)))
            .collect();
        for _ in 0..10 {
            let mut forged = genuine.clone();
            mutate(&mut forged, &others, &mut random);
            let frame = resealed(|packet| *packet = forged);
            // A mutation may restore the packet of a telecommand that the ground could send.
            if genuine_frames.contains(&frame) {
                continue;
            }
            assert_eq!(push(&mut uplink, &frame), [], "round {round}");
        }
        obeyed += push(&mut uplink, &tagged(&command, slot, counter)).len() as u64;
        assert_eq!(obeyed, round + 1, "the ground station is not locked out");
    }
    let counters = uplink.counters();
    assert_eq!(u64::from(counters.accepted), frames / 10);
    assert!(u64::from(counters.wrong_tag) > frames / 2, "{counters:?}");
    std::println!("{frames} mutated frames: {counters:?}");
}

/// Number of random bytes: `UPLINK_NOISE`.
#[test]
fn noise_is_never_obeyed() {
    let bytes = size_of_test("UPLINK_NOISE", 1_000_000);
    let mut random = Random(2);
    let mut uplink = Uplink::new(Some(MASTER));
    for _ in 0..bytes / 8 {
        for byte in random.next().to_le_bytes() {
            assert_eq!(uplink.push(byte), None);
        }
    }
    std::println!("{bytes} bytes of noise: {:?}", uplink.counters());
    assert_eq!(
        push(&mut uplink, &[&[0], &tagged(&Command::Ping, 1, 1)[..]].concat()),
        [Command::Ping]
    );
}

/// A session recorded on the line, played back to the same computer and to a restarted one.
#[test]
fn recorded_session_is_refused_before_and_after_a_restart() {
    let session: Vec<Vec<u8>> = (1..)
        .zip(one_of_each().iter().filter(|command| !matches!(command, Command::ChangeKey { .. })))
        .map(|(counter, command)| tagged(command, 1, counter))
        .collect();
    let mut uplink = Uplink::new(Some(MASTER));
    session.iter().for_each(|frame| assert_eq!(push(&mut uplink, frame).len(), 1));
    session.iter().for_each(|frame| assert_eq!(push(&mut uplink, frame), []));
    let mut restarted = Uplink::new(Some(MASTER));
    restarted.restore(*uplink.ledger());
    session.iter().for_each(|frame| assert_eq!(push(&mut restarted, frame), []));
    let replayed = session.len() as u32;
    assert_eq!((uplink.counters().replayed, restarted.counters().replayed), (replayed, replayed));
}
