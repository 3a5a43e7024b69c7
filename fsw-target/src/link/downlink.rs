//! Transmitter: reports to bytes on the line.
//!
//! Input: reports of the flight computer. Output: their frames, byte by byte, at the rate of the
//! serial port. The flight loop never waits for the line. A packet that does not fit in the queue is dropped
//! whole and counted. A byte lost by the port invalidates its packet on the ground.
//!
//! Each APID has a sequence count, which includes dropped packets: a loss is visible as a gap.

use super::authentication::Key;
use super::frame::Frame;
use super::packet::{self, Apid, SequenceCount};
use super::telemetry::Report;
use embedded_hal_nb::{nb, serial};
use heapless::Deque;

/// Transmitting end of the line, with a queue of N bytes.
#[derive(Debug)]
pub struct Downlink<const N: usize> {
    queue: Deque<u8, N>,
    estimates: SequenceCount,
    statuses: SequenceCount,
    checkpoints: SequenceCount,
    manoeuvres: SequenceCount,
    dropped: u32,
    port_errors: u32,
}

impl<const N: usize> Downlink<N> {
    /// A downlink before its first packet.
    pub const fn new() -> Self {
        let zero = SequenceCount::new(0);
        Self {
            queue: Deque::new(),
            estimates: zero,
            statuses: zero,
            checkpoints: zero,
            manoeuvres: zero,
            dropped: 0,
            port_errors: 0,
        }
    }

    // Not inlined: the packet occupies a quarter of a kilobyte of stack in this function only.
    /// Queues a report made at on-board time `time_us`, with a tag if `key` is a slot with its key. Returns
    /// false if the queue is too full.
    #[inline(never)]
    pub fn send<R: Report>(&mut self, time_us: u64, report: &R, key: Option<&(u8, Key)>) -> bool {
        let count = self.count(R::APID);
        let sequence_count = *count;
        *count = packet::next(sequence_count);
        let packet = report.packet(time_us, sequence_count, key);
        let sent = packet.as_ref().is_some_and(|packet| self.queue_packet(packet.bytes()));
        if !sent {
            self.dropped = self.dropped.saturating_add(1);
        }
        sent
    }

    /// True if a frame of `bytes` bytes fits in the queue.
    pub fn has_room_for(&self, bytes: usize) -> bool {
        bytes <= N.saturating_sub(self.queue.len())
    }

    /// Writes to the port until it is busy or the queue is empty.
    pub fn drain(&mut self, port: &mut impl serial::Write<u8>) {
        while let Some(&byte) = self.queue.front() {
            match port.write(byte) {
                Ok(()) => {}
                Err(nb::Error::WouldBlock) => return,
                // A failed byte is dropped: repeating it could block the line for good.
                Err(nb::Error::Other(_)) => self.port_errors = self.port_errors.saturating_add(1),
            }
            self.queue.pop_front();
        }
    }

    /// Bytes in the queue.
    pub fn waiting(&self) -> usize {
        self.queue.len()
    }

    /// Packets dropped because the queue was full; saturates.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Bytes rejected by the port with an error; saturates.
    pub fn port_errors(&self) -> u32 {
        self.port_errors
    }

    fn count(&mut self, apid: Apid) -> &mut SequenceCount {
        match apid {
            packet::STATUS => &mut self.statuses,
            packet::CHECKPOINT => &mut self.checkpoints,
            packet::MANOEUVRE => &mut self.manoeuvres,
            _ => &mut self.estimates,
        }
    }

    /// Queues the frame of a packet. Not inlined: the frame is not on the stack while a packet is tagged.
    #[inline(never)]
    fn queue_packet(&mut self, packet: &[u8]) -> bool {
        Frame::of(packet).is_some_and(|frame| self.queue_whole(frame.bytes()))
    }

    fn queue_whole(&mut self, frame: &[u8]) -> bool {
        let fits = self.has_room_for(frame.len());
        if fits {
            for byte in frame {
                let _ = self.queue.push_back(*byte);
            }
        }
        fits
    }
}

impl<const N: usize> Default for Downlink<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::link::Receiver;
    use crate::link::telemetry::fixtures::{estimate, status};
    use crate::link::telemetry::{Received, Telemetry};
    use embedded_hal_nb::serial::{ErrorKind, ErrorType, Write};
    use std::vec::Vec;

    /// A port that takes `takes` bytes and is busy then. Every byte equal to `broken` is an error.
    #[derive(Default)]
    struct Port {
        bytes: Vec<u8>,
        takes: usize,
        broken: Option<u8>,
    }

    impl ErrorType for Port {
        type Error = ErrorKind;
    }

    impl Write for Port {
        fn write(&mut self, byte: u8) -> nb::Result<(), ErrorKind> {
            if self.takes == 0 {
                return Err(nb::Error::WouldBlock);
            }
            self.takes -= 1;
            if self.broken == Some(byte) {
                return Err(nb::Error::Other(ErrorKind::Other));
            }
            self.bytes.push(byte);
            Ok(())
        }

        fn flush(&mut self) -> nb::Result<(), ErrorKind> {
            Ok(())
        }
    }

    fn received(bytes: &[u8]) -> Vec<Received> {
        let mut receiver = Receiver::default();
        let packets = bytes.iter().filter_map(|byte| receiver.push(*byte));
        packets.collect::<Result<_, _>>().unwrap()
    }

    #[test]
    fn reports_arrive_in_order_on_a_slow_line() {
        let mut downlink = Downlink::<600>::new();
        let mut port = Port::default();
        for k in 0..50 {
            assert!(downlink.send(k, &estimate(), None));
            while downlink.waiting() > 100 {
                port.takes = 7;
                downlink.drain(&mut port);
            }
        }
        port.takes = usize::MAX;
        downlink.drain(&mut port);
        let received = received(&port.bytes);
        assert_eq!(received.len(), 50);
        for (k, packet) in (0..).zip(received) {
            assert_eq!((packet.time_us, packet.sequence_count.value()), (k, k as u16));
            assert_eq!(packet.telemetry, Telemetry::Estimate(estimate()));
        }
    }

    #[test]
    fn packet_that_does_not_fit_is_dropped_whole_and_counted() {
        let mut downlink = Downlink::<200>::new();
        let mut port = Port { takes: usize::MAX, ..Port::default() };
        assert!(downlink.send(0, &estimate(), None));
        assert!(!downlink.send(1, &estimate(), None));
        assert!(!downlink.send(2, &status(), None));
        downlink.drain(&mut port);
        assert!(downlink.send(3, &estimate(), None));
        downlink.drain(&mut port);
        let counts: Vec<_> =
            received(&port.bytes).iter().map(|packet| packet.sequence_count.value()).collect();
        assert_eq!((counts, downlink.dropped(), downlink.waiting()), ([0, 2].to_vec(), 2, 0));
    }

    #[test]
    fn each_kind_has_its_own_sequence_count() {
        let mut downlink = Downlink::<2000>::new();
        let mut port = Port { takes: usize::MAX, ..Port::default() };
        downlink.send(0, &estimate(), None);
        downlink.send(0, &estimate(), None);
        downlink.send(0, &status(), None);
        downlink.drain(&mut port);
        let counts: Vec<_> = received(&port.bytes)
            .iter()
            .map(|packet| (packet.telemetry.kind(), packet.sequence_count.value()))
            .collect();
        assert_eq!(counts, [("estimate", 0), ("estimate", 1), ("status", 0)]);
    }

    #[test]
    fn broken_port_does_not_block_the_line() {
        let mut downlink = Downlink::<300>::new();
        let mut port = Port { takes: usize::MAX, broken: Some(0), ..Port::default() };
        assert!(downlink.send(0, &estimate(), None));
        downlink.drain(&mut port);
        assert_eq!((downlink.waiting(), downlink.port_errors()), (0, 2));
    }
}
