//! Ground end of the flight computer's serial line.
//!
//! Input: bytes of the line. Output: telemetry packets, damaged packets, and the number of missing
//! packets by their sequence counts. Frames and packets are decoded by the flight software,
//! [`fsw_target::link`].

use std::fmt;

use fsw_target::link::authentication::Key;
use fsw_target::link::frame::DELIMITER;
use fsw_target::link::packet::{SequenceCount, next};
use fsw_target::link::telemetry::{Received, Telemetry};
use fsw_target::link::{ReceiveError, Receiver};

/// Result of a byte that completes a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Reception {
    /// A packet.
    Packet(Box<Received>),
    /// A frame that is not a packet.
    Damaged(Damaged),
}

/// Bytes that are not a telemetry packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damaged {
    /// Number of bytes received when the error was detected.
    pub at_byte: u64,
    /// Error.
    pub error: ReceiveError,
}

impl fmt::Display for Damaged {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "byte {}: {}", self.at_byte, self.error)
    }
}

/// Receiver of one line.
#[derive(Debug, Default)]
pub struct GroundReceiver {
    receiver: Receiver,
    bytes: u64,
    packets: u64,
    /// Next sequence count of each kind of packet.
    expected: [Option<SequenceCount>; 4],
}

impl GroundReceiver {
    /// A receiver of packets with a tag of this key only; the others are damaged.
    pub fn with_key(key: Key) -> Self {
        Self { receiver: Receiver::with_key(key), ..Self::default() }
    }

    /// Receives the next byte.
    pub fn push(&mut self, byte: u8) -> Option<Reception> {
        self.bytes += 1;
        Some(match self.receiver.push(byte)? {
            Ok(packet) => {
                self.packets += 1;
                Reception::Packet(Box::new(packet))
            }
            Err(error) => Reception::Damaged(Damaged { at_byte: self.bytes, error }),
        })
    }

    /// Ends the line. Output: the last frame, if it is incomplete.
    pub fn end(&mut self) -> Option<Damaged> {
        let error = self.receiver.push(DELIMITER)?.err()?;
        Some(Damaged { at_byte: self.bytes, error })
    }

    /// Number of missing packets between the last packet of the same kind and this one, modulo 2¹⁴.
    ///
    /// Zero for the first packet, and for a sequence count of zero, at which a restarted computer
    /// begins.
    pub fn missing_before(&mut self, packet: &Received) -> u16 {
        let kind = match packet.telemetry {
            Telemetry::Estimate(_) => 0,
            Telemetry::Status(_) => 1,
            Telemetry::Checkpoint(_) => 2,
            Telemetry::Manoeuvre(_) => 3,
        };
        let expected = self.expected[kind].replace(next(packet.sequence_count));
        match (expected, packet.sequence_count.value()) {
            (None, _) | (Some(_), 0) => 0,
            (Some(expected), _) => packet.sequence_count.wrapping_sub(expected).value(),
        }
    }

    /// Number of bytes received.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Number of packets received.
    pub fn packets(&self) -> u64 {
        self.packets
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_target::link::frame::Frame;
    use fsw_target::link::telemetry::{CheckpointPart, Report};

    fn frame(sequence_count: u16) -> Vec<u8> {
        let part = CheckpointPart::new(0, 1, &[1, 2, 3]).unwrap();
        let packet = part.packet(5, SequenceCount::new(sequence_count), None).unwrap();
        Frame::of(packet.bytes()).unwrap().bytes().to_vec()
    }

    fn push(ground: &mut GroundReceiver, bytes: &[u8]) -> Vec<Reception> {
        bytes.iter().filter_map(|byte| ground.push(*byte)).collect()
    }

    #[test]
    fn missing_packets_are_counted_across_the_wrap_and_not_after_a_restart() {
        let mut ground = GroundReceiver::default();
        let counts = [16_380, 16_381, 16_383, 2, 3, 0, 1];
        let missing = counts.map(|count| {
            let Reception::Packet(packet) = push(&mut ground, &frame(count)).remove(0) else {
                panic!("an intact frame is a packet");
            };
            ground.missing_before(&packet)
        });
        assert_eq!(missing, [0, 0, 1, 2, 0, 0, 0]);
        assert_eq!(ground.packets(), 7);
    }

    #[test]
    fn forged_packet_is_damaged_for_a_receiver_with_a_key() {
        let (key, other) = (Key::new([1; 16]), Key::new([2; 16]));
        let tagged = |key: Key| {
            let part = CheckpointPart::new(0, 1, &[1, 2, 3]).unwrap();
            let packet = part.packet(5, SequenceCount::new(0), Some(&(1, key))).unwrap();
            Frame::of(packet.bytes()).unwrap().bytes().to_vec()
        };
        let line = [tagged(key), tagged(other), frame(1)].concat();
        let receptions = push(&mut GroundReceiver::with_key(key), &line);
        let [Reception::Packet(packet), Reception::Damaged(_), Reception::Damaged(forged)] =
            &receptions[..]
        else {
            panic!("{receptions:?}");
        };
        assert_eq!(packet.slot, Some(1));
        assert_eq!(forged.error, ReceiveError::NotAuthentic);
    }

    #[test]
    fn damaged_frame_is_reported_with_its_position() {
        let mut ground = GroundReceiver::default();
        let good = frame(1);
        let truncated = [&good[..9], &good[..]].concat();
        let receptions = push(&mut ground, &truncated);
        let [Reception::Damaged(damaged), Reception::Packet(_)] = &receptions[..] else {
            panic!("{receptions:?}");
        };
        assert_eq!(damaged.at_byte, 10);
        assert_eq!(ground.bytes(), truncated.len() as u64);
        assert_eq!(ground.end(), None);
        push(&mut ground, &good[..9]);
        assert_eq!(ground.end().map(|damaged| damaged.at_byte), Some(truncated.len() as u64 + 9));
    }
}
