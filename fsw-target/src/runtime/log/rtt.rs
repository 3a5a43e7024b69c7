//! Target side of SEGGER's Real-Time Transfer: a ring buffer in RAM that a debug probe reads while the core
//! runs.
//!
//! One up channel, named `defmt` so that `probe-rs run` decodes it. The probe finds the control block by its
//! symbol, `_SEGGER_RTT`, and advances `read`; the target advances `write`. A frame that does not fit is
//! dropped as a whole, so that the decoder never receives a part of one.
//!
//! The published crates do not fit: defmt-rtt is a logger itself and cannot copy to a serial port, and the
//! set-up macro of rtt-target links panicking code. Built of atomics, this module needs no unsafe access.

use core::sync::atomic::{AtomicPtr, AtomicU8, AtomicU32, Ordering};

/// Size of the ring, bytes, one of them unused: the longest burst of the log between two reads of the
/// probe.
const SIZE: usize = 1024;

/// Ring of the channel.
pub static BUFFER: Ring = [const { AtomicU8::new(0) }; SIZE];

/// Control block, found by the probe.
#[allow(unsafe_code, reason = "the probe finds the control block by this symbol")]
// SAFETY: no other item of the image has this name.
#[unsafe(export_name = "_SEGGER_RTT")]
#[used]
pub static CONTROL_BLOCK: ControlBlock = ControlBlock::new(&BUFFER);

/// Bytes of a channel.
pub type Ring = [AtomicU8; SIZE];

/// Control block in the layout of SEGGER: a header, one up channel, no down channel.
#[repr(C)]
pub struct ControlBlock {
    id: [u8; 16],
    up_channels: u32,
    down_channels: u32,
    name: AtomicPtr<u8>,
    buffer: AtomicPtr<u8>,
    size: u32,
    write: AtomicU32,
    read: AtomicU32,
    /// Behaviour for a full ring, as set by the probe. Ignored: flight never waits for a probe.
    flags: AtomicU32,
}

impl ControlBlock {
    const fn new(ring: &'static Ring) -> Self {
        Self {
            id: *b"SEGGER RTT\0\0\0\0\0\0",
            up_channels: 1,
            down_channels: 0,
            name: AtomicPtr::new(c"defmt".as_ptr().cast_mut().cast()),
            buffer: AtomicPtr::new(ring.as_ptr().cast_mut().cast()),
            size: SIZE as u32,
            write: AtomicU32::new(0),
            read: AtomicU32::new(0),
            flags: AtomicU32::new(0),
        }
    }
}

/// Writer of the current frame.
pub struct UpWriter {
    /// Index of the next byte, published to the probe by `commit`.
    write: usize,
    /// The frame does not fit.
    overrun: bool,
}

impl UpWriter {
    pub const fn new() -> Self {
        Self { write: 0, overrun: false }
    }

    /// Starts a frame.
    pub fn begin(&mut self) {
        self.overrun = false;
    }

    /// Adds a byte to the frame.
    pub fn push(&mut self, block: &ControlBlock, ring: &Ring, byte: u8) {
        let next = if self.write + 1 < SIZE { self.write + 1 } else { 0 };
        let full = next as u32 == block.read.load(Ordering::Acquire);
        match ring.get(self.write) {
            Some(cell) if !full && !self.overrun => {
                cell.store(byte, Ordering::Relaxed);
                self.write = next;
            }
            _ => self.overrun = true,
        }
    }

    /// Publishes the frame to the probe, or discards it if it does not fit.
    pub fn commit(&mut self, block: &ControlBlock) {
        if self.overrun {
            self.write = block.write.load(Ordering::Relaxed) as usize;
        } else {
            block.write.store(self.write as u32, Ordering::Release);
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::{boxed::Box, vec::Vec};

    /// The channel of one test, with the probe's side.
    struct Channel {
        ring: &'static Ring,
        block: ControlBlock,
        writer: UpWriter,
    }

    impl Channel {
        fn new() -> Self {
            let ring: &'static Ring = Box::leak(Box::new([const { AtomicU8::new(0) }; SIZE]));
            Self { ring, block: ControlBlock::new(ring), writer: UpWriter::new() }
        }

        fn send(&mut self, frame: &[u8]) {
            self.writer.begin();
            for &byte in frame {
                self.writer.push(&self.block, self.ring, byte);
            }
            self.writer.commit(&self.block);
        }

        fn probe_reads(&mut self) -> Vec<u8> {
            let write = self.block.write.load(Ordering::Acquire) as usize;
            let mut read = self.block.read.load(Ordering::Acquire) as usize;
            let mut bytes = Vec::new();
            while read != write {
                bytes.push(self.ring[read].load(Ordering::Relaxed));
                read = (read + 1) % SIZE;
            }
            self.block.read.store(read as u32, Ordering::Release);
            bytes
        }
    }

    #[test]
    fn frames_are_read_in_order_across_the_wrap() {
        let mut channel = Channel::new();
        for start in 0..30 {
            let frame: Vec<u8> = (start..start + 100).collect();
            channel.send(&frame);
            assert_eq!(channel.probe_reads(), frame);
        }
    }

    #[test]
    fn a_frame_that_does_not_fit_is_dropped_as_a_whole() {
        let mut channel = Channel::new();
        channel.send(&[1; 1000]);
        channel.send(&[2; 100]);
        channel.send(&[3; 10]);
        let bytes = channel.probe_reads();
        assert_eq!(bytes.len(), 1010);
        assert!(!bytes.contains(&2));
    }

    #[test]
    fn without_a_probe_nothing_blocks() {
        let mut channel = Channel::new();
        for _ in 0..100 {
            channel.send(&[7; 100]);
        }
        assert_eq!(channel.probe_reads().len(), 1000);
    }

    #[test]
    fn the_control_block_has_the_layout_of_segger() {
        use core::mem::{offset_of, size_of};
        assert_eq!(offset_of!(ControlBlock, up_channels), 16);
        assert_eq!(offset_of!(ControlBlock, name), 24);
        assert_eq!(offset_of!(ControlBlock, size), 24 + 2 * size_of::<usize>());
    }
}
