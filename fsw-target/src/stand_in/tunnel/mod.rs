//! Sensors, flash and clock of a simulator on a serial line: the processor in the loop.
//!
//! The flight computer sends requests, the simulator replies: spacecraft data, time of the next sample,
//! result of a transaction on the bus of the gyro, captures of the wheel timer, content of the flash.
//! Computer, drivers, conversions and estimators are those of the flight image, on its processor; only the
//! pins are not involved. The simulator waits for requests: both run in lock-step.
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
//! | [`NEXT`] | – | µs since the last sample, u32; [`NEXT_WITH_TORQUE`]: and N m, 3 × f32; [`IDLE`]: no sample yet; NO: end of the flight |
//! | [`TRANSFER`] | bytes to read, bytes to write | the bytes read; NO: bus error |
//! | [`WAIT`] | µs, u32 | – |
//! | [`CAPTURES`] | – | [`Captures`] |
//! | [`FLASH_READ`] | offset, u32; bytes to read | the bytes; NO: out of range |
//! | [`FLASH_WRITE`] | offset, u32; bytes | –; NO: out of range |
//! | [`FLASH_ERASE`] | from, to, u32 | –; NO: out of range |
//! | [`FAILED`] | reason, as text | none |
//!
//! Fields are big-endian, as in [`crate::link::wire`]. Messages are short, since each byte to the computer
//! takes tens of microseconds in QEMU. Either end stops at an incomplete frame: a line that loses bytes
//! would make a transmission error look like an error of the computer.
//!
//! 1. This file: the messages, for both ends.
//! 2. [`setup`]: spacecraft data.
//! 3. [`Tunnel`]: requests and replies, at the computer's end.
//! 4. [`parts`]: the parts of a [`crate::flight::computer::Computer`], each by requests.

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

/// Version of the protocol; changes with the meaning of any message.
pub const VERSION: u8 = 2;

include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// Request: spacecraft data. The first one.
pub const HELLO: u8 = 1;
/// Request: the next sample, after the last one has been processed.
pub const NEXT: u8 = 2;
/// Request: a transaction on the bus of the gyro.
pub const TRANSFER: u8 = 3;
/// Request: a delay of the gyro driver.
pub const WAIT: u8 = 4;
/// Request: captures of the wheel timer.
pub const CAPTURES: u8 = 5;
/// Request: content of the flash.
pub const FLASH_READ: u8 = 6;
/// Request: programs the flash, clearing bits.
pub const FLASH_WRITE: u8 = 7;
/// Request: erases pages of the flash, setting all bits.
pub const FLASH_ERASE: u8 = 8;
/// Message: the flight computer stops after an error.
pub const FAILED: u8 = 9;
/// Reply to [`NEXT`]: a sample, and a new external torque, body axes.
pub const NEXT_WITH_TORQUE: u8 = 10;
/// Reply to [`NEXT`]: no sample yet. The computer continues with its other tasks and repeats the request.
pub const IDLE: u8 = 0xFE;
/// Reply to any request that cannot be fulfilled.
pub const NO: u8 = 0xFF;

/// Largest number of bytes per direction of a transaction on the bus or with the flash. A reading of the
/// gyro has six.
pub const MAX_TRANSFER: usize = 64;

/// Size of the flash, bytes: two halves, each for a checkpoint of the largest estimator.
pub const FLASH_BYTES: u32 = 64 * 1024;
/// Size of a page, the unit of an erasure, bytes.
pub const PAGE_BYTES: u32 = 4 * 1024;

/// CRC-16 of telemetry: polynomial 0x1021, start value 0xffff.
static CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

record! {
    /// Captures of the wheel timer at the time of a sample.
    struct Captures {
        /// Count of the timer at the sample.
        now_ticks: u32, "ticks";
        /// Position of each wheel at its last edge, two's complement.
        edges: [u32; WHEELS], "edges";
        /// Count of the timer at that edge.
        last_edge_ticks: [u32; WHEELS], "ticks";
    }
}

impl Captures {
    /// From captures of all wheels at the same instant.
    pub fn new(captured: &[Captured; WHEELS]) -> Self {
        Self {
            now_ticks: captured.first().map_or(0, |captured| captured.now_ticks),
            edges: captured.map(|captured| captured.edges.cast_unsigned()),
            last_edge_ticks: captured.map(|captured| captured.last_edge_ticks),
        }
    }

    /// The captures, in the form of the driver.
    pub fn of_wheels(&self) -> [Captured; WHEELS] {
        let mut captured = [Captured { now_ticks: self.now_ticks, ..Captured::default() }; WHEELS];
        let fields = self.edges.iter().zip(&self.last_edge_ticks);
        for (captured, (edges, last_edge_ticks)) in captured.iter_mut().zip(fields) {
            captured.edges = edges.cast_signed();
            captured.last_edge_ticks = *last_edge_ticks;
        }
        captured
    }
}

/// A message of either end.
#[derive(Debug)]
pub struct Message {
    bytes: [u8; MAX_PACKET],
    /// `None` if the fields are too long.
    length: Option<usize>,
}

impl Message {
    /// A message with the fields written by `fields`.
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

    /// Appends the checksum and returns the new length.
    fn seal(&mut self) -> Option<usize> {
        let (written, unused) = self.bytes.split_at_mut_checked(self.length?)?;
        let checksum = CHECKSUM.checksum(written).to_be_bytes();
        *unused.first_chunk_mut()? = checksum;
        Some(written.len() + checksum.len())
    }

    /// The frame on the line; `None` if the message is too long.
    pub fn frame(&self) -> Option<Frame> {
        Frame::of(self.bytes.get(..self.length?)?)
    }

    /// Kind and fields of a packet; `None` if its checksum is wrong.
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
    fn a_message_is_received_as_sent() {
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
    fn any_wrong_bit_is_detected() {
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
