//! On-board time, in microseconds, and delays, by the counter of the FPGA.

use super::fpga_image::CLOCK_HZ;
use super::registers::fpga_io;
use crate::runtime::bounded;
use crate::runtime::shared_time::SharedTime;
use embedded_hal::delay::DelayNs;

/// Clocks of a microsecond.
const CLOCKS_PER_US: u32 = CLOCK_HZ / 1_000_000;

static TIME: SharedTime = SharedTime::new(count_us);

/// Starts the counter.
pub(super) fn start() {
    fpga_io().prescale.set(CLOCKS_PER_US - 1);
}

/// The counter, µs, wrapping after 71 minutes.
fn count_us() -> u32 {
    fpga_io().counter.get()
}

/// On-board time, µs: monotonic, also across interrupt handlers. Zero at an earlier reset of the FPGA.
pub fn now_us() -> u64 {
    TIME.now_us()
}

/// Advances on-board time to at least `time_us`: to the next time with the current bits of the counter, up
/// to 71 minutes later.
pub fn resume_at(time_us: u64) {
    TIME.resume_at(time_us);
}

/// Delay, bounded also with a stopped counter.
#[derive(Debug, Clone, Copy, Default)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // Part of the first microsecond has passed.
        let limit_us = ns.div_ceil(1_000).saturating_add(1);
        let _ = bounded::wait_at_most(limit_us, CLOCKS_PER_US, count_us, || false);
    }
}
