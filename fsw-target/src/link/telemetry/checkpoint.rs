//! Checkpoint report: the bytes of a checkpoint in flash ([`crate::store`]), in parts.

use super::Report;
use crate::link::packet::{Apid, CHECKPOINT};
use crate::link::wire::{Reader, Unreadable, Wire, Writer};

/// Checkpoint bytes per packet. A checkpoint of 38 KiB takes 203 packets, 4.1 s at 115,200 baud.
pub const PART_BYTES: usize = 192;

/// Part of a checkpoint, as stored in flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckpointPart {
    /// Index of the part, from 0.
    pub index: u16,
    /// Number of parts. All but the last have [`PART_BYTES`] bytes.
    pub parts: u16,
    bytes: [u8; PART_BYTES],
    length: usize,
}

impl CheckpointPart {
    /// Part `index` of `parts`; `None` for more than [`PART_BYTES`] bytes.
    pub fn new(index: u16, parts: u16, bytes: &[u8]) -> Option<Self> {
        let mut part = Self { index, parts, bytes: [0; PART_BYTES], length: bytes.len() };
        let mut writer = Writer::new(&mut part.bytes);
        writer.put(bytes);
        writer.finish()?;
        Some(part)
    }

    /// Bytes of the part.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

impl Report for CheckpointPart {
    const APID: Apid = CHECKPOINT;

    fn put(&self, out: &mut Writer<'_>) {
        self.index.put(out);
        self.parts.put(out);
        out.put(self.bytes());
    }

    fn decode(data: &[u8]) -> Result<Self, Unreadable> {
        let mut from = Reader::new(data);
        let (index, parts) = (Wire::take(&mut from)?, Wire::take(&mut from)?);
        let bytes = from.rest();
        Self::new(index, parts, bytes).ok_or(Unreadable::TooLong(bytes.len()))
    }
}
