//! A flight computer's sensors at the other end of a serial line: the processor in the loop.
//!
//! The flight computer asks, a simulator answers: what spacecraft it is, when the next sample is, what
//! a transaction on the gyro's bus returns, what the wheels' timer has captured, what is in the flash.
//! So the computer, its drivers, conversions and estimators are those that fly, on the processor that
//! flies them; only the pins are missing. In lock-step: nothing happens while nobody asks.
//!
//! ```text
//!  flight computer                                              simulator
//!  Tunnel  ── request: kind, fields, CRC-16, as a COBS frame ──►
//!          ◄── reply: kind or NO, fields, CRC-16, as a frame ──
//! ```
//!
//! | request | fields | reply |
//! |---|---|---|
//! | [`HELLO`] | version of this protocol; [`SOURCES`], u64 | [`Setup`] |
//! | [`NEXT`] | – | µs since the last sample, u32; [`NEXT_WITH_TORQUE`]: and N m, 3 × f32; [`IDLE`]: not yet; NO: the flight is over |
//! | [`TRANSFER`] | bytes to read, bytes to write | the bytes read; NO: the bus failed |
//! | [`WAIT`] | µs, u32 | – |
//! | [`CAPTURES`] | – | [`Captures`] |
//! | [`FLASH_READ`] | offset, u32; bytes to read | the bytes; NO: out of range |
//! | [`FLASH_WRITE`] | offset, u32; bytes | –; NO: out of range |
//! | [`FLASH_ERASE`] | from, to, u32 | –; NO: out of range |
//! | [`FAILED`] | why, as text | none |
//!
//! Fields are big-endian, as in [`crate::link::wire`]. Few bytes, and few of them twice: in QEMU each byte
//! to the computer takes tens of microseconds. Whoever gets a frame that isn't whole gives up:
//! a line that loses bytes would make a wrong bit look like one of the computer's.
//!
//! 1. This file: the messages, for both ends.
//! 2. [`setup`]: what spacecraft it is.
//! 3. [`line`](Tunnel): asking.
//! 4. [`parts`]: what plays the parts of a board for [`crate::flight::computer::Computer`].

mod line;
pub mod parts;
pub mod setup;

pub use line::{Port, Tunnel, TunnelError};
pub use setup::Setup;

use crate::drivers::wheel_tach::Captured;
use crate::flight::craft::WHEELS;
use crate::link::frame::{Frame, MAX_PACKET};
use crate::link::wire::{Reader, Writer, record};
use crc::{CRC_16_IBM_3740, Crc};

/// Changes with the meaning of any message.
pub const VERSION: u8 = 2;

include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// Who are we? The first request.
pub const HELLO: u8 = 1;
/// The next sample, please; the last one has been handled.
pub const NEXT: u8 = 2;
/// A transaction on the gyro's bus.
pub const TRANSFER: u8 = 3;
/// Time passes for the gyro.
pub const WAIT: u8 = 4;
/// What the wheels' timer holds.
pub const CAPTURES: u8 = 5;
/// What is in the flash.
pub const FLASH_READ: u8 = 6;
/// Clears bits of the flash.
pub const FLASH_WRITE: u8 = 7;
/// Sets all bits of pages of the flash.
pub const FLASH_ERASE: u8 = 8;
/// The flight computer gives up.
pub const FAILED: u8 = 9;
/// In place of [`NEXT`] in a reply: a sample, and the torque from now on, body axes.
pub const NEXT_WITH_TORQUE: u8 = 10;
/// In place of [`NEXT`] in a reply: no sample yet. The computer does its other work, and asks again.
pub const IDLE: u8 = 0xFE;
/// In place of the request's kind in a reply: it can't be.
pub const NO: u8 = 0xFF;

/// Bytes in a transaction on a bus or with the flash, either way. A reading of the gyro takes six.
pub const MAX_TRANSFER: usize = 64;

/// Bytes of the flash: two halves that each hold a checkpoint of the largest estimator.
pub const FLASH_BYTES: u32 = 64 * 1024;
/// Bytes that are erased together.
pub const PAGE_BYTES: u32 = 4 * 1024;

/// CRC-16 with polynomial 0x1021 and start value 0xffff, as the telemetry has.
static CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

record! {
    /// What the wheels' timer holds, at the sample's time.
    struct Captures {
        /// The sample's time, as the timer counts.
        now_ticks: u32, "ticks";
        /// Position of each wheel at its last edge, two's complement.
        edges: [u32; WHEELS], "edges";
        /// When that was.
        last_edge_ticks: [u32; WHEELS], "ticks";
    }
}

impl Captures {
    /// From the wheels, which were all captured at the same instant.
    pub fn new(captured: &[Captured; WHEELS]) -> Self {
        Self {
            now_ticks: captured.first().map_or(0, |captured| captured.now_ticks),
            edges: captured.map(|captured| captured.edges.cast_unsigned()),
            last_edge_ticks: captured.map(|captured| captured.last_edge_ticks),
        }
    }

    /// As the driver wants it.
    pub fn of_wheels(&self) -> [Captured; WHEELS] {
        let mut captured = [Captured { now_ticks: self.now_ticks, ..Captured::default() }; WHEELS];
        let held = self.edges.iter().zip(&self.last_edge_ticks);
        for (captured, (edges, last_edge_ticks)) in captured.iter_mut().zip(held) {
            captured.edges = edges.cast_signed();
            captured.last_edge_ticks = *last_edge_ticks;
        }
        captured
    }
}

/// A message of either side.
#[derive(Debug)]
pub struct Message {
    bytes: [u8; MAX_PACKET],
    /// None: its fields are too long.
    length: Option<usize>,
}

impl Message {
    /// A message whose fields `fields` writes.
    pub fn new(kind: u8, fields: impl FnOnce(&mut Writer<'_>)) -> Self {
        let mut bytes = [0; MAX_PACKET];
        let mut writer = Writer::new(&mut bytes);
        writer.put(&[kind]);
        fields(&mut writer);
        let length = writer.finish();
        let mut message = Self { bytes, length };
        message.length = message.seal();
        message
    }

    /// Adds the checksum.
    fn seal(&mut self) -> Option<usize> {
        let (written, room) = self.bytes.split_at_mut_checked(self.length?)?;
        let checksum = CHECKSUM.checksum(written).to_be_bytes();
        *room.first_chunk_mut()? = checksum;
        Some(written.len() + checksum.len())
    }

    /// As it goes over the line, between two delimiters; `None` where it doesn't fit.
    pub fn frame(&self) -> Option<Frame> {
        Frame::of(self.bytes.get(..self.length?)?)
    }

    /// Kind and fields of a packet; `None` where its checksum is wrong.
    pub fn open(packet: &[u8]) -> Option<(u8, Reader<'_>)> {
        let (written, checksum) = packet.split_last_chunk::<2>()?;
        if CHECKSUM.checksum(written) != u16::from_be_bytes(*checksum) {
            return None;
        }
        let (kind, fields) = written.split_first()?;
        Some((*kind, Reader::new(fields)))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::link::frame::FrameReceiver;
    use crate::link::wire::Wire;
    use std::vec::Vec;

    fn packet(message: &Message) -> Vec<u8> {
        let mut receiver = FrameReceiver::<MAX_PACKET>::new();
        let frame = message.frame().unwrap();
        let packets = frame
            .bytes()
            .iter()
            .filter_map(|byte| receiver.push(*byte).map(|packet| packet.unwrap().to_vec()));
        packets.last().unwrap()
    }

    #[test]
    fn a_message_goes_there_and_back() {
        let captured = [-3, 0, 7, i32::MIN].map(|edges| Captured {
            edges,
            last_edge_ticks: 0xDEAD_BEEF,
            now_ticks: 12,
        });
        let sent = packet(&Message::new(CAPTURES, |out| Captures::new(&captured).put(out)));
        let (kind, mut fields) = Message::open(&sent).unwrap();
        assert_eq!(kind, CAPTURES);
        assert_eq!(Captures::take(&mut fields).unwrap().of_wheels(), captured);
        assert_eq!(fields.end(), Ok(()));
    }

    #[test]
    fn a_wrong_bit_is_noticed_wherever_it_is() {
        let sent = packet(&Message::new(WAIT, |out| out.put(&[0, 0, 0x75, 0x30])));
        for bit in 0..8 * sent.len() {
            let mut garbled = sent.clone();
            garbled[bit / 8] ^= 1 << (bit % 8);
            assert!(Message::open(&garbled).is_none(), "bit {bit}");
        }
        assert!(Message::open(&[]).is_none());
    }

    #[test]
    fn a_message_that_is_too_long_has_no_frame() {
        assert!(Message::new(FAILED, |out| out.put(&[1; MAX_PACKET])).frame().is_none());
        assert!(Message::new(FAILED, |out| out.put(&[1; MAX_PACKET - 2])).frame().is_none());
        assert!(Message::new(FAILED, |out| out.put(&[1; MAX_PACKET - 3])).frame().is_some());
    }
}
