//! Time stamps of gyro samples, from the interrupt to the flight loop.
//!
//! The gyro's registers hold its newest sample alone, so only the newest stamp belongs to a reading.
//! Samples before it are lost to a late loop and count as overruns.

use heapless::spsc::Queue;

/// Length of the ring: three stamps, and the slot that the queue keeps free. Only the newest stamp
/// is used, so that more capacity has no effect.
const PLACES: usize = 4;

/// Queue of time stamps.
#[derive(Debug)]
pub struct Stamps {
    queue: Queue<u64, PLACES>,
    overruns: u32,
}

impl Default for Stamps {
    fn default() -> Self {
        Self::new()
    }
}

impl Stamps {
    /// An empty queue.
    pub const fn new() -> Self {
        Self { queue: Queue::new(), overruns: 0 }
    }

    /// Adds the stamp of a new sample. A full queue discards its oldest stamp as an overrun.
    pub fn push(&mut self, time_us: u64) {
        if self.queue.is_full() && self.queue.dequeue().is_some() {
            self.count_overrun();
        }
        // The queue has a free place here.
        let _ = self.queue.enqueue(time_us);
    }

    /// Takes the newest stamp, µs. Older stamps count as overruns.
    pub fn take_newest(&mut self) -> Option<u64> {
        let mut newest = self.queue.dequeue()?;
        while let Some(newer) = self.queue.dequeue() {
            newest = newer;
            self.count_overrun();
        }
        Some(newest)
    }

    /// Empties the queue without counting: stamps from before the gyro was configured.
    pub fn discard(&mut self) {
        while self.queue.dequeue().is_some() {}
    }

    /// Empties the queue and counts every stamp as an overrun: their samples have been overwritten in
    /// the gyro.
    pub fn discard_as_overruns(&mut self) {
        while self.queue.dequeue().is_some() {
            self.count_overrun();
        }
    }

    /// True if the queue is empty.
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Discarded stamps since start-up; saturates.
    pub const fn overruns(&self) -> u32 {
        self.overruns
    }

    fn count_overrun(&mut self) {
        self.overruns = self.overruns.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loop_in_time_gets_every_stamp() {
        let mut stamps = Stamps::new();
        for time_us in (0..100).map(|sample| sample * 10_000) {
            stamps.push(time_us);
            assert!(!stamps.is_empty());
            assert_eq!(stamps.take_newest(), Some(time_us));
            assert_eq!(stamps.take_newest(), None);
        }
        assert_eq!(stamps.overruns(), 0);
    }

    #[test]
    fn discarded_stamps_are_never_taken() {
        let mut stamps = Stamps::new();
        stamps.push(1);
        stamps.push(2);
        stamps.discard_as_overruns();
        assert_eq!((stamps.take_newest(), stamps.overruns()), (None, 2));
        stamps.push(3);
        assert_eq!(stamps.take_newest(), Some(3));
        stamps.push(4);
        stamps.discard();
        assert_eq!((stamps.take_newest(), stamps.overruns()), (None, 2));
    }

    #[test]
    fn late_loop_gets_the_newest_stamp_and_counts_the_others() {
        for late in 1..20_u32 {
            let mut stamps = Stamps::new();
            (1..=late).for_each(|sample| stamps.push(u64::from(sample)));
            assert_eq!(stamps.take_newest(), Some(u64::from(late)));
            assert_eq!(stamps.take_newest(), None);
            assert_eq!(stamps.overruns(), late - 1);
        }
    }
}
