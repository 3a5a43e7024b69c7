//! The ground's end of the flight computer's serial line.
//!
//! In: bytes as they come. Out: telemetry packets, what was damaged among them, and what is missing
//! between them by their sequence counts. Frames and packets are read by the code that flies,
//! [`fsw_target::link`].

use std::fmt;

use fsw_target::link::frame::DELIMITER;
use fsw_target::link::packet::{SequenceCount, next};
use fsw_target::link::telemetry::{Received, Telemetry};
use fsw_target::link::{ReceiveError, Receiver};

/// What came of a byte.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// It ended a packet.
    Packet(Box<Received>),
    /// It ended something that is no packet.
    Damaged(Damaged),
}

/// Bytes that are no telemetry packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damaged {
    /// Bytes of the stream up to where that became clear.
    pub at_byte: u64,
    /// What is wrong.
    pub why: ReceiveError,
}

impl fmt::Display for Damaged {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "byte {}: {}", self.at_byte, self.why)
    }
}

/// Listens to one line.
#[derive(Debug, Default)]
pub struct Listener {
    receiver: Receiver,
    bytes: u64,
    packets: u64,
    expected: [Option<SequenceCount>; 3],
}

impl Listener {
    /// Takes the next byte.
    pub fn hear(&mut self, byte: u8) -> Option<Heard> {
        self.bytes += 1;
        Some(match self.receiver.push(byte)? {
            Ok(packet) => {
                self.packets += 1;
                Heard::Packet(Box::new(packet))
            }
            Err(why) => Heard::Damaged(Damaged { at_byte: self.bytes, why }),
        })
    }

    /// That nothing follows: what was damaged, if the last frame wasn't complete.
    pub fn end(&mut self) -> Option<Damaged> {
        let why = self.receiver.push(DELIMITER)?.err()?;
        Some(Damaged { at_byte: self.bytes, why })
    }

    /// Packets of the same kind that are missing between the last one and this one, modulo 2¹⁴. None
    /// before the first. A computer that started anew begins at 0 again, and misses nothing.
    pub fn missing_before(&mut self, packet: &Received) -> u16 {
        let kind = match packet.telemetry {
            Telemetry::Estimate(_) => 0,
            Telemetry::Status(_) => 1,
            Telemetry::Checkpoint(_) => 2,
        };
        let expected = self.expected[kind].replace(next(packet.sequence_count));
        match (expected, packet.sequence_count.value()) {
            (None, _) | (Some(_), 0) => 0,
            (Some(expected), _) => packet.sequence_count.wrapping_sub(expected).value(),
        }
    }

    /// Bytes heard.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Packets heard.
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
        let packet = part.packet(5, SequenceCount::new(sequence_count)).unwrap();
        Frame::of(packet.bytes()).unwrap().bytes().to_vec()
    }

    fn hear(listener: &mut Listener, bytes: &[u8]) -> Vec<Heard> {
        bytes.iter().filter_map(|byte| listener.hear(*byte)).collect()
    }

    #[test]
    fn gaps_are_seen_across_the_wrap_and_none_after_a_restart() {
        let mut listener = Listener::default();
        let counts = [16_380, 16_381, 16_383, 2, 3, 0, 1];
        let missing = counts.map(|count| {
            let Heard::Packet(packet) = hear(&mut listener, &frame(count)).remove(0) else {
                panic!("a good frame is no packet");
            };
            listener.missing_before(&packet)
        });
        assert_eq!(missing, [0, 0, 1, 2, 0, 0, 0]);
        assert_eq!(listener.packets(), 7);
    }

    #[test]
    fn damage_is_told_with_its_place() {
        let mut listener = Listener::default();
        let good = frame(1);
        let cut = [&good[..9], &good[..]].concat();
        let heard = hear(&mut listener, &cut);
        let [Heard::Damaged(damaged), Heard::Packet(_)] = &heard[..] else {
            panic!("{heard:?}");
        };
        assert_eq!(damaged.at_byte, 10);
        assert_eq!(listener.bytes(), cut.len() as u64);
        assert_eq!(listener.end(), None);
        hear(&mut listener, &good[..9]);
        assert_eq!(listener.end().map(|damaged| damaged.at_byte), Some(cut.len() as u64 + 9));
    }
}
