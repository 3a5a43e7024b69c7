//! Packets as frames on a byte stream: COBS between two zero bytes.
//!
//! Encoder: a packet to the bytes of its frame. Decoder: bytes to a packet or a [`FrameError`].
//!
//! Consistent Overhead Byte Stuffing (Cheshire and Baker, IEEE/ACM Trans. Networking 7, 1999) removes
//! the zeros from a packet at the cost of one byte. A zero therefore always ends a frame, and after
//! any loss the next frame is intact. The leading zero separates a frame from line noise and from an
//! aborted transmission before it.
//!
//! The crate `cobs` provides two state machines without buffers, [`cobs::DecoderState`] and
//! [`cobs::try_encode`]; the latter reports a short buffer. Its functions that panic are not linked.

/// Longest packet, bytes: the limit up to which COBS adds one byte.
pub const MAX_PACKET: usize = 254;

/// Longest frame, bytes: the packet, one byte of COBS, and a zero on either side.
pub const MAX_FRAME: usize = MAX_PACKET + 3;

/// First and last byte of each frame.
pub const DELIMITER: u8 = 0;

/// A packet in its frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    bytes: [u8; MAX_FRAME],
    length: usize,
}

impl Frame {
    /// Frame of a packet; `None` above [`MAX_PACKET`] bytes.
    pub fn of(packet: &[u8]) -> Option<Self> {
        if packet.len() > MAX_PACKET {
            return None;
        }
        let mut bytes = [DELIMITER; MAX_FRAME];
        // The first byte stays a delimiter.
        let (_, after) = bytes.split_first_mut()?;
        let encoded = cobs::try_encode(packet, after).ok()?;
        // The state machine may have written a byte after the last one.
        *after.get_mut(encoded)? = DELIMITER;
        Some(Self { bytes, length: encoded + 2 })
    }

    /// Bytes on the line.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

/// Reason for bytes between two delimiters that are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The delimiter arrived before the end of the data.
    Truncated,
    /// More than the receiver's N bytes. The rest of the frame is skipped.
    Oversized,
}

/// Decoder of packets of at most N bytes from a byte stream.
#[derive(Debug)]
pub struct FrameReceiver<const N: usize> {
    state: cobs::DecoderState,
    packet: [u8; N],
    length: usize,
    skipping: bool,
}

impl<const N: usize> FrameReceiver<N> {
    /// A decoder before its first byte.
    pub const fn new() -> Self {
        Self { state: cobs::DecoderState::Idle, packet: [0; N], length: 0, skipping: false }
    }

    /// Takes the next byte. The last byte of a frame yields the packet; the first byte that cannot
    /// belong to a frame yields the error. Consecutive delimiters yield nothing.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        use cobs::DecodeResult::{DataComplete, DataContinue, DataStart, NoData};

        if self.skipping {
            self.skipping = byte != DELIMITER;
            return None;
        }
        match self.state.feed(byte) {
            Ok(NoData) => None,
            Ok(DataStart) => {
                self.length = 0;
                None
            }
            Ok(DataContinue(decoded)) => self.append(decoded).err().map(Err),
            Ok(DataComplete) => self.packet.get(..self.length).map(Ok),
            // The error of the decoder is an early delimiter, which also starts the next frame.
            Err(_) => Some(Err(FrameError::Truncated)),
        }
    }

    fn append(&mut self, decoded: u8) -> Result<(), FrameError> {
        let Some(place) = self.packet.get_mut(self.length) else {
            self.state = cobs::DecoderState::Idle;
            self.skipping = true;
            return Err(FrameError::Oversized);
        };
        *place = decoded;
        self.length += 1;
        Ok(())
    }
}

impl<const N: usize> Default for FrameReceiver<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    type Found = Result<Vec<u8>, FrameError>;

    fn receive<const N: usize>(bytes: impl IntoIterator<Item = u8>) -> Vec<Found> {
        let mut receiver = FrameReceiver::<N>::new();
        let found = |byte| receiver.push(byte).map(|found| found.map(<[u8]>::to_vec));
        bytes.into_iter().filter_map(found).collect()
    }

    fn frame(packet: &[u8]) -> Vec<u8> {
        Frame::of(packet).unwrap().bytes().to_vec()
    }

    #[test]
    fn stuffing_is_as_published() {
        assert_eq!(frame(&[0]), [0, 1, 1, 0]);
        assert_eq!(frame(&[0x11, 0x22, 0, 0x33]), [0, 3, 0x11, 0x22, 2, 0x33, 0]);
        assert_eq!(frame(&[0x11, 0, 0, 0]), [0, 2, 0x11, 1, 1, 1, 0]);
    }

    #[test]
    fn longest_packet_fits_and_a_longer_one_is_rejected() {
        for fill in [0, 1, 0xff] {
            let packet = [fill; MAX_PACKET];
            let framed = frame(&packet);
            assert!(framed.len() <= MAX_FRAME);
            assert_eq!(receive::<MAX_PACKET>(framed), [Ok(packet.to_vec())]);
        }
        assert!(Frame::of(&[1; MAX_PACKET + 1]).is_none());
    }

    #[test]
    fn truncated_frame_leaves_the_next_one_intact() {
        let good = frame(&[1, 2, 0, 3]);
        let mut line = good[..3].to_vec();
        line.extend(&good);
        assert_eq!(receive::<8>(line), [Err(FrameError::Truncated), Ok([1, 2, 0, 3].to_vec())]);
    }

    #[test]
    fn oversized_frame_is_one_error() {
        let mut line = [7; 1000].to_vec();
        line.extend(frame(&[1, 2, 3]));
        assert_eq!(receive::<8>(line), [Err(FrameError::Oversized), Ok([1, 2, 3].to_vec())]);
    }

    /// The packet of a frame's content, by the definition of COBS; `None` if the last group is incomplete.
    fn unstuffed(content: &[u8]) -> Option<Vec<u8>> {
        let (mut packet, mut rest) = (Vec::new(), content);
        while let Some((code, after)) = rest.split_first() {
            let group = after.get(..usize::from(*code) - 1)?;
            packet.extend(group);
            rest = &after[group.len()..];
            if *code < 0xff && !rest.is_empty() {
                packet.push(0);
            }
        }
        Some(packet)
    }

    /// All 16.6 million contents of one to three bytes: the packet or the error of the definition, one for a frame, the
    /// stuffing of that packet, and an intact frame after it.
    #[test]
    fn every_short_frame_is_that_of_the_definition() {
        let next = frame(&[5, 0, 6]);
        let mut receiver = FrameReceiver::<8>::new();
        let check = |receiver: &mut FrameReceiver<8>, content: &[u8]| {
            let mut found: Option<Found> = None;
            for byte in content.iter().chain(&[0]) {
                if let Some(outcome) = receiver.push(*byte) {
                    assert!(found.is_none(), "two outcomes of {content:?}");
                    found = Some(outcome.map(<[u8]>::to_vec));
                }
            }
            match (found, unstuffed(content)) {
                (Some(Ok(packet)), Some(expected)) => {
                    assert_eq!(packet, expected, "{content:?}");
                    if !packet.is_empty() {
                        assert_eq!(frame(&packet)[1..], [content, &[0]].concat(), "{content:?}");
                    }
                }
                (Some(Err(_)), None) => {}
                (None, Some(expected)) if expected.is_empty() => {}
                other => panic!("{content:?}: {other:?}"),
            }
        };
        for a in 1..=255 {
            check(&mut receiver, &[a]);
            for b in 1..=255 {
                check(&mut receiver, &[a, b]);
                for c in 1..=255 {
                    check(&mut receiver, &[a, b, c]);
                }
                let after: Vec<Found> = (next.iter())
                    .filter_map(|byte| receiver.push(*byte).map(|found| found.map(<[u8]>::to_vec)))
                    .collect();
                assert_eq!(after, [Ok([5, 0, 6].to_vec())], "after {a} {b}");
            }
        }
    }

    #[test]
    fn zeros_between_frames_are_ignored() {
        assert_eq!(receive::<8>([0; 100]), []);
    }

    proptest! {
        #[test]
        fn any_packet_arrives(packet in prop::collection::vec(any::<u8>(), 1..=MAX_PACKET)) {
            let framed = frame(&packet);
            let (ends, inside) = ([framed[0], framed[framed.len() - 1]], &framed[1..framed.len() - 1]);
            prop_assert_eq!(ends, [0, 0]);
            prop_assert!(!inside.contains(&0));
            prop_assert_eq!(receive::<MAX_PACKET>(framed), [Ok(packet)]);
        }

        #[test]
        fn frame_after_any_noise_arrives(
            noise in prop::collection::vec(any::<u8>(), 0..2000),
            packet in prop::collection::vec(any::<u8>(), 1..=64),
        ) {
            let mut line = noise;
            line.extend(frame(&packet));
            prop_assert_eq!(receive::<64>(line).pop(), Some(Ok(packet)));
        }
    }
}
