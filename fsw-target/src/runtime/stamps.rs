//! Time stamps of gyro samples, between the interrupt that takes them and the loop.
//!
//! A gyro's registers hold its newest sample only. So only the newest stamp is of any use: with an
//! older one the newest reading would be paired with a wrong time. A loop that comes late loses
//! the samples in between, and they are counted.

use heapless::spsc::Queue;

/// Stamps that wait, and one place that stays free. More would only be more to throw away.
const PLACES: usize = 4;

/// The stamps.
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
    /// None yet.
    pub const fn new() -> Self {
        Self { queue: Queue::new(), overruns: 0 }
    }

    /// A sample is ready, since `time_us`. If there is no room, the oldest stamp makes it.
    pub fn push(&mut self, time_us: u64) {
        if self.queue.is_full() && self.queue.dequeue().is_some() {
            self.count_overrun();
        }
        // There is room now.
        let _ = self.queue.enqueue(time_us);
    }

    /// The newest stamp, microseconds. Those that were older are counted as overruns.
    pub fn take_newest(&mut self) -> Option<u64> {
        let mut newest = self.queue.dequeue()?;
        while let Some(newer) = self.queue.dequeue() {
            newest = newer;
            self.count_overrun();
        }
        Some(newest)
    }

    /// Throws away what waits, and counts none of it: those were no samples of a gyro that is set up.
    pub fn forget(&mut self) {
        while self.queue.dequeue().is_some() {}
    }

    /// Throws away what waits: its samples are no longer in the gyro.
    pub fn drop_all(&mut self) {
        while self.queue.dequeue().is_some() {
            self.count_overrun();
        }
    }

    /// Whether no stamp waits.
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Stamps that were thrown away since start-up. Stops at its maximum.
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
    fn a_loop_in_time_gets_every_stamp() {
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
    fn what_was_dropped_is_never_taken() {
        let mut stamps = Stamps::new();
        stamps.push(1);
        stamps.push(2);
        stamps.drop_all();
        assert_eq!((stamps.take_newest(), stamps.overruns()), (None, 2));
        stamps.push(3);
        assert_eq!(stamps.take_newest(), Some(3));
        stamps.push(4);
        stamps.forget();
        assert_eq!((stamps.take_newest(), stamps.overruns()), (None, 2));
    }

    #[test]
    fn a_late_loop_gets_the_newest_and_the_others_are_counted() {
        for late in 1..20_u32 {
            let mut stamps = Stamps::new();
            (1..=late).for_each(|sample| stamps.push(u64::from(sample)));
            assert_eq!(stamps.take_newest(), Some(u64::from(late)));
            assert_eq!(stamps.take_newest(), None);
            assert_eq!(stamps.overruns(), late - 1);
        }
    }
}
