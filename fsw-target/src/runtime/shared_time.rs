//! On-board time from the microsecond counter of a board, for the loop and for interrupt handlers.

use crate::runtime::extended_time::ExtendedTime;
use core::cell::Cell;
use critical_section::Mutex;

/// On-board time. Each call must come within one wrap of the counter after the last (71 minutes).
pub struct SharedTime {
    time: Mutex<Cell<ExtendedTime>>,
    /// The counter of the board, µs, 32 bits, wrapping.
    count_us: fn() -> u32,
}

impl SharedTime {
    /// Time zero.
    pub const fn new(count_us: fn() -> u32) -> Self {
        Self { time: Mutex::new(Cell::new(ExtendedTime::START)), count_us }
    }

    /// On-board time, µs: monotonic, also across interrupt handlers.
    pub fn now_us(&self) -> u64 {
        self.update(|time| time).us()
    }

    /// Advances on-board time to at least `time_us`: to the next time with the current bits of the counter, up
    /// to 71 minutes later.
    pub fn resume_at(&self, time_us: u64) {
        self.update(|time| time.resumed_at(time_us));
    }

    fn update(&self, change: impl FnOnce(ExtendedTime) -> ExtendedTime) -> ExtendedTime {
        critical_section::with(|section| {
            let cell = self.time.borrow(section);
            let time = change(cell.get().advanced_to((self.count_us)()));
            cell.set(time);
            time
        })
    }
}
