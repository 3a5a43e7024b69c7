//! Independent watchdog: resets the chip 3 to 8 s after it was last fed.
//!
//! Feeding requires a [`FeedPermit`]. The watchdog has its own oscillator (LSI, 17 to 47 kHz, DS8626), and
//! only a reset stops it.
//!
//! The period exceeds the longest regular stall of the core: the erasure of a flash sector, at most 2 s
//! (`flash.rs`). It is 3 s with the fastest LSI and 8 s with the slowest.
//!
//! Registers: RM0090, chapter 21 (IWDG). QEMU 7.2 has no such watchdog and never resets.

use super::clocks::wait;
use crate::flight::supervisor::FeedPermit;
use stm32f4::stm32f405::{DBGMCU, IWDG};

/// Prescaler: LSI cycles per count.
const PRESCALER: u32 = 64;

/// Fastest LSI, Hz.
const LSI_MAX_HZ: u32 = 47_000;

/// Shortest period, ms: an erasure, and one second for other work, at a start the reading of all of the
/// flash with start and self-test of the gyro.
const SHORTEST_MS: u32 = 3_000;

/// Counts until the reset.
const RELOAD: u32 = (SHORTEST_MS * (LSI_MAX_HZ / PRESCALER)).div_ceil(1_000);
const _: () = assert!(RELOAD <= 0xfff, "the counter has 12 bits");

/// Polls of the status: its flags clear within five LSI cycles, 0.3 ms, and a poll takes at least six
/// cycles of at most 168 MHz.
const STATUS_POLLS: u32 = 20_000;

/// The watchdog, inactive until [`Watchdog::start`].
pub struct Watchdog {
    iwdg: IWDG,
}

impl Watchdog {
    /// The watchdog; a debugger that halts the core halts it too.
    pub(super) fn new(iwdg: IWDG, dbgmcu: &DBGMCU) -> Self {
        dbgmcu.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
        Self { iwdg }
    }

    /// Starts the watchdog, which must be fed from now on.
    pub fn start(&mut self) {
        self.iwdg.kr().write(|w| w.key().start());
        self.iwdg.kr().write(|w| w.key().unlock());
        self.iwdg.pr().write(|w| w.pr().divide_by64());
        self.iwdg.rlr().write(|w| w.rl().set(RELOAD as u16));
        // Without this confirmation the period stays the shortest, and the chip resets sooner.
        let _ = wait(STATUS_POLLS, || self.iwdg.sr().read().bits() == 0);
        self.iwdg.kr().write(|w| w.key().feed());
    }

    /// Restarts the period.
    pub fn feed(&mut self, _permit: FeedPermit) {
        self.iwdg.kr().write(|w| w.key().feed());
    }
}
