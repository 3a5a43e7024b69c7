//! Readers of the link: telecommands on board, telemetry on the ground.

use fsw_target::link::authentication::{KEY_BYTES, Key};
use fsw_target::link::command::Command;
use fsw_target::link::frame::Frame;
use fsw_target::link::{Receiver, Uplink};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{Executed, once_in, one_of};

/// Frames of a case.
const FRAMES: usize = 50;

/// Telecommands to a computer with a key: noise, and frames of which bytes were changed. A telecommand is obeyed only
/// if it was sent with a right tag, and once: with its frame, or later where a byte of a further one completes a truncated
/// frame.
pub fn uplink(random: &mut Pcg64) -> Executed {
    let master = Key::new(random.random::<[u8; KEY_BYTES]>());
    let other = Key::new(random.random::<[u8; KEY_BYTES]>());
    let mut uplink = Uplink::new(Some(master));
    let mut bytes_read = 0;
    // Sent with a right tag and not obeyed yet, in the order of their counters.
    let mut pending = Vec::new();
    for counter in 1..=FRAMES as u32 {
        // Values differ, so that a repetition is not taken for the next telecommand of its kind.
        let command = match one_of(random, &COMMANDS) {
            Command::SetTelemetryPeriod { ms } => Command::SetTelemetryPeriod { ms: ms + counter },
            Command::SetTorque(torque) => {
                Command::SetTorque(torque.map(|x| x * counter as f32 / FRAMES as f32))
            }
            other => other,
        };
        let key = if once_in(random, 4) { &other } else { &master };
        let Some(packet) = command.tagged_packet(&key.of_slot(1, 0), 1, counter) else { continue };
        let Some(frame) = Frame::of(packet.bytes()) else { continue };
        let mut bytes = frame.bytes().to_vec();
        if random.random::<bool>() {
            // Outside the frame too, which leaves the telecommand as it was.
            change(random, &mut bytes);
        }
        if std::ptr::eq(key, &master) {
            pending.push(command);
        }
        // A second time: a replay.
        for _ in 0..2 {
            bytes_read += bytes.len() as u64;
            for byte in &bytes {
                let Some(obeyed) = uplink.push(*byte) else { continue };
                // Counters rise: none before it is obeyed any more.
                match pending.iter().position(|sent| *sent == obeyed) {
                    Some(index) => drop(pending.drain(..=index)),
                    None => return Err(format!("{obeyed:?} obeyed, {pending:?} sent, {bytes:?}")),
                }
            }
        }
    }
    Ok(bytes_read)
}

/// Telecommands of the frames.
const COMMANDS: [Command; 5] = [
    Command::Ping,
    Command::Reset,
    Command::SaveCheckpoint,
    Command::SetTelemetryPeriod { ms: 500 },
    Command::SetTorque([0.1, -0.2, 0.3]),
];

/// Bytes of any content to a receiver of telemetry, with frame ends among them.
pub fn downlink(random: &mut Pcg64) -> Executed {
    let mut receiver = match random.random::<bool>() {
        true => Receiver::default(),
        false => Receiver::with_key(Key::new(random.random::<[u8; KEY_BYTES]>())),
    };
    let mut bytes_read = 0;
    for _ in 0..FRAMES {
        // A telecommand is framed as telemetry is: header, length and checksum are right.
        let command = one_of(random, &COMMANDS);
        let frame = command.packet(arbitrary_count(random)).and_then(|p| Frame::of(p.bytes()));
        let mut bytes = frame.map_or(Vec::new(), |frame| frame.bytes().to_vec());
        change(random, &mut bytes);
        bytes_read += bytes.len() as u64;
        for byte in bytes {
            // Its text is written to a terminal.
            if let Some(Err(error)) = receiver.push(byte) {
                let _ = error.to_string();
            }
        }
    }
    Ok(bytes_read)
}

fn arbitrary_count(random: &mut Pcg64) -> fsw_target::link::packet::SequenceCount {
    fsw_target::link::packet::SequenceCount::new(random.random_range(0..0x4000))
}

/// Changes bytes of a frame.
fn change(random: &mut Pcg64, bytes: &mut Vec<u8>) {
    match random.random_range(0..5) {
        0 => {
            for _ in 0..one_of(random, &[1, 1, 2, 8]) {
                let at = random.random_range(0..bytes.len().max(1));
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << random.random_range(0..8);
                }
            }
        }
        1 => bytes.truncate(random.random_range(0..=bytes.len())),
        2 => {
            let at = random.random_range(0..=bytes.len());
            bytes.insert(at, random.random());
        }
        3 => {
            let length = random.random_range(0..600);
            *bytes = (0..length).map(|_| random.random()).collect();
        }
        _ => {
            let at = random.random_range(0..=bytes.len());
            let tail = bytes.split_off(at);
            bytes.extend(tail.iter().rev());
        }
    }
}
