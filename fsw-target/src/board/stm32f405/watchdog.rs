//! Independent watchdog: resets the chip 3 to 8 s after it was last fed.
//!
//! Feeding requires a [`FeedPermit`]. The watchdog has its own oscillator (LSI, 17 to 47 kHz, DS8626), and
//! only a reset stops it.
//!
//! The period exceeds the longest regular stall of the core: the erasure of a flash sector, at most 2 s
//! (`flash.rs`). It is 3 s with the fastest LSI and 8 s with the slowest.
//!
//! Registers: RM0090, chapter 21 (IWDG). QEMU 7.2 has no such watchdog: its registers read 0,
//! and telemetry reports that none runs.

use super::time::wait_at_most;
use crate::flight::supervisor::FeedPermit;
use stm32f4::stm32f405::{DBGMCU, IWDG};

/// Prescaler: LSI cycles per count.
const PRESCALER: u32 = 64;

/// Fastest LSI, Hz.
const LSI_MAX_HZ: u32 = 47_000;

/// Shortest period, ms: an erasure, and one second for other work. The start feeds it after each stage
/// ([`crate::flight::supervisor::Stage`]).
const SHORTEST_MS: u32 = 3_000;

/// Counts until the reset.
const RELOAD: u32 = (SHORTEST_MS * (LSI_MAX_HZ / PRESCALER)).div_ceil(1_000);
const _: () = assert!(RELOAD <= 0xfff, "the counter has 12 bits");

/// Time limit of a change of the period, µs. The flags clear within five LSI cycles of the prescaler in
/// force: 1.2 ms at the 4 of a reset, 19 ms at [`PRESCALER`], with the slowest LSI.
const STATUS_LIMIT_US: u32 = 48_000;

/// The watchdog, inactive until [`Watchdog::start`].
pub struct Watchdog {
    iwdg: IWDG,
}

impl Watchdog {
    /// The watchdog; a debugger that halts the core halts it too.
    /// One that runs from reset on (`option_bytes.rs`) gets its period here: that after a reset is 0.35 to
    /// 1 s.
    pub(super) fn new(iwdg: IWDG, dbgmcu: &DBGMCU, is_running: bool) -> Self {
        dbgmcu.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
        // A probe reads the log while the loop sleeps.
        dbgmcu.cr().modify(|_, w| w.dbg_sleep().set_bit());
        let mut watchdog = Self { iwdg };
        if is_running {
            watchdog.set_period();
        }
        watchdog
    }

    /// Starts the watchdog, which must be fed from now on. On-board time must run.
    pub fn start(&mut self) {
        self.iwdg.kr().write(|w| w.key().start());
        self.set_period();
    }

    /// Sets the period of a watchdog that runs, and restarts it.
    fn set_period(&mut self) {
        self.iwdg.kr().write(|w| w.key().unlock());
        self.iwdg.pr().write(|w| w.pr().divide_by64());
        self.iwdg.rlr().write(|w| w.rl().set(RELOAD as u16));
        // Without this confirmation the period stays the old one, and the chip may reset sooner.
        let _ = wait_at_most(STATUS_LIMIT_US, || self.iwdg.sr().read().bits() == 0);
        self.iwdg.kr().write(|w| w.key().feed());
    }

    /// True if the period reads back, which it does only where the watchdog is there and runs.
    pub fn is_running(&self) -> bool {
        self.iwdg.pr().read().pr().is_divide_by64()
            && u32::from(self.iwdg.rlr().read().rl().bits()) == RELOAD
            && self.iwdg.sr().read().bits() == 0
    }

    /// Restarts the period.
    pub fn feed(&mut self, _permit: FeedPermit) {
        self.iwdg.kr().write(|w| w.key().feed());
    }
}
