//! Packets as frames on a line of bytes: COBS, between two bytes of zero.
//!
//! In: a packet, or bytes as they come. Out: the bytes of its frame, or a packet, or why there is
//! none. Consistent Overhead Byte Stuffing (Cheshire and Baker, IEEE/ACM Trans. Networking 7, 1999)
//! takes the zeros out of a packet for one byte more, so that a zero on the line always ends a
//! frame: whatever is lost, the next frame is whole again. A frame also begins with a zero, which
//! cuts off what noise or a transmitter that stopped halfway left before it.
//!
//! By the crate `cobs`, of which only the two state machines without a buffer are used:
//! [`cobs::DecoderState`], and [`cobs::try_encode`], which reports a short buffer; the functions that
//! panic there aren't linked.

/// Bytes of the longest packet. COBS adds one byte to a packet of at most 254.
pub const MAX_PACKET: usize = 254;

/// Bytes of the longest frame: the packet, one byte of COBS, a zero on either side.
pub const MAX_FRAME: usize = MAX_PACKET + 3;

/// Ends each frame, and begins it.
pub const DELIMITER: u8 = 0;

/// A packet with all that goes around it.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    bytes: [u8; MAX_FRAME],
    length: usize,
}

impl Frame {
    /// The frame of a packet; `None` where it is longer than [`MAX_PACKET`].
    pub fn of(packet: &[u8]) -> Option<Self> {
        if packet.len() > MAX_PACKET {
            return None;
        }
        let mut bytes = [DELIMITER; MAX_FRAME];
        // All bytes but the first, which stays a delimiter.
        let (_, after) = bytes.split_first_mut()?;
        let encoded = cobs::try_encode(packet, after).ok()?;
        // The state machine may have prepared a byte after the last one.
        *after.get_mut(encoded)? = DELIMITER;
        Some(Self { bytes, length: encoded + 2 })
    }

    /// As they go over the line.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

/// Why bytes between two delimiters are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// It ended before it was complete.
    Truncated,
    /// It has more than the N bytes that the receiver takes. The rest of it is skipped.
    Oversized,
}

/// Finds packets of at most N bytes in a stream of bytes.
#[derive(Debug)]
pub struct FrameReceiver<const N: usize> {
    state: cobs::DecoderState,
    packet: [u8; N],
    length: usize,
    skipping: bool,
}

impl<const N: usize> FrameReceiver<N> {
    /// A receiver that waits for a frame.
    pub const fn new() -> Self {
        Self { state: cobs::DecoderState::Idle, packet: [0; N], length: 0, skipping: false }
    }

    /// Takes the next byte. Where it ends a frame, the packet; where it makes one impossible, why.
    /// Delimiters in a row are no frame and no error.
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
            Ok(DataContinue(decoded)) => self.keep(decoded).err().map(Err),
            Ok(DataComplete) => self.packet.get(..self.length).map(Ok),
            // Only a delimiter can be wrong, and it ends what it interrupts.
            Err(_) => Some(Err(FrameError::Truncated)),
        }
    }

    fn keep(&mut self, decoded: u8) -> Result<(), FrameError> {
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
    fn bytes_are_stuffed_as_published() {
        assert_eq!(frame(&[0]), [0, 1, 1, 0]);
        assert_eq!(frame(&[0x11, 0x22, 0, 0x33]), [0, 3, 0x11, 0x22, 2, 0x33, 0]);
        assert_eq!(frame(&[0x11, 0, 0, 0]), [0, 2, 0x11, 1, 1, 1, 0]);
    }

    #[test]
    fn the_longest_packet_fits_and_no_longer_one() {
        for fill in [0, 1, 0xff] {
            let packet = [fill; MAX_PACKET];
            let framed = frame(&packet);
            assert!(framed.len() <= MAX_FRAME);
            assert_eq!(receive::<MAX_PACKET>(framed), [Ok(packet.to_vec())]);
        }
        assert!(Frame::of(&[1; MAX_PACKET + 1]).is_none());
    }

    #[test]
    fn a_frame_without_an_end_costs_the_next_one_nothing() {
        let good = frame(&[1, 2, 0, 3]);
        let mut line = good[..3].to_vec();
        line.extend(&good);
        assert_eq!(receive::<8>(line), [Err(FrameError::Truncated), Ok([1, 2, 0, 3].to_vec())]);
    }

    #[test]
    fn an_oversized_frame_is_one_error_however_long() {
        let mut line = [7; 1000].to_vec();
        line.extend(frame(&[1, 2, 3]));
        assert_eq!(receive::<8>(line), [Err(FrameError::Oversized), Ok([1, 2, 3].to_vec())]);
    }

    #[test]
    fn silence_between_frames_is_no_error() {
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
        fn after_any_bytes_the_next_frame_arrives(
            noise in prop::collection::vec(any::<u8>(), 0..2000),
            packet in prop::collection::vec(any::<u8>(), 1..=64),
        ) {
            let mut line = noise;
            line.extend(frame(&packet));
            prop_assert_eq!(receive::<64>(line).pop(), Some(Ok(packet)));
        }
    }
}
