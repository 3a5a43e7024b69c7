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

/// Shortest time between two samples, µs: half the interval of the fastest gyro, at 2000 samples/s.
const SHORTEST_US: u64 = 250;

/// Time for which a line that chatters stays closed, µs. With one edge when it opens and one that closes it
/// again, a line costs at most 200 interrupts a second.
const CLOSED_US: u64 = 10_000;

/// Limit of the interrupts of a line: closes it after two edges in too short a time.
///
/// A broken or floating line may raise interrupts without pause, which would leave no time to the loop.
#[derive(Debug, Default)]
pub struct ChatterGuard {
    /// Time of the last edge, µs.
    last_us: Option<u64>,
    /// Time at which the line was closed, µs.
    closed_us: Option<u64>,
    chatters: u32,
}

impl ChatterGuard {
    /// An open line.
    pub const fn new() -> Self {
        Self { last_us: None, closed_us: None, chatters: 0 }
    }

    /// Takes an edge. False if it follows the last one too soon: it is no sample, and the line must be
    /// closed.
    pub fn accepts(&mut self, time_us: u64) -> bool {
        let since_us = self.last_us.replace(time_us).map(|last_us| time_us.saturating_sub(last_us));
        let is_chatter = since_us.is_some_and(|since_us| since_us < SHORTEST_US);
        if is_chatter {
            self.closed_us = Some(time_us);
            self.chatters = self.chatters.saturating_add(1);
        }
        !is_chatter
    }

    /// True once, when the line may be opened again.
    pub fn opens(&mut self, now_us: u64) -> bool {
        let is_over =
            self.closed_us.is_some_and(|closed_us| now_us.saturating_sub(closed_us) >= CLOSED_US);
        if is_over {
            self.closed_us = None;
        }
        is_over
    }

    /// Closings since start-up; saturates.
    pub const fn chatters(&self) -> u32 {
        self.chatters
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
    fn samples_of_every_data_rate_pass() {
        for interval_us in [500, 1_000, 2_500, 5_000, 10_000] {
            let mut guard = ChatterGuard::new();
            assert!((1..1_000).all(|sample| guard.accepts(sample * interval_us)));
            assert!(!guard.opens(1_000_000), "never closed");
        }
    }

    #[test]
    fn line_that_chatters_costs_a_bounded_number_of_interrupts() {
        let (mut guard, mut closed, mut interrupts) = (ChatterGuard::new(), false, 0);
        // An edge each microsecond, for one second.
        for time_us in 0..1_000_000 {
            if closed && guard.opens(time_us) {
                closed = false;
            }
            if !closed {
                interrupts += 1;
                closed = !guard.accepts(time_us);
            }
        }
        assert!((100..=202).contains(&interrupts), "{interrupts}");
        assert!(guard.chatters() >= 99);
        // A line that is repaired works again.
        assert!(guard.opens(1_020_000));
        assert!(guard.accepts(1_030_000) && guard.accepts(1_040_000));
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
