//! The independent watchdog: resets the chip if it isn't fed for 3 to 8 s.
//!
//! Fed only against a [`FeedPermit`], which the loop earns. It runs from an oscillator of its own
//! (LSI, 17 to 47 kHz, DS8626), and can't be stopped but by a reset.
//!
//! The period has to be longer than the longest stall that is no fault: the erasure of a flash
//! sector, at most 2 s (see `flash.rs`), in which the core can't execute. With the fastest LSI
//! 3 s remain, with the slowest it is 8 s.
//!
//! Registers: RM0090, chapter 21 (IWDG). QEMU 7.2 has no such watchdog and never resets.

use super::clocks::wait;
use crate::flight::supervisor::FeedPermit;
use stm32f4::stm32f405::{DBGMCU, IWDG};

/// LSI cycles to a count: the prescaler is set to this.
const PRESCALER: u32 = 64;

/// The fastest LSI, Hz.
const LSI_MAX_HZ: u32 = 47_000;

/// The shortest period that is wanted, milliseconds: an erasure, and a second for the rest. At a start that
/// is all of the flash read, and the gyro started and tested.
const SHORTEST_MS: u32 = 3_000;

/// Counts to a reset.
const RELOAD: u32 = (SHORTEST_MS * (LSI_MAX_HZ / PRESCALER)).div_ceil(1_000);
const _: () = assert!(RELOAD <= 0xfff, "the counter has 12 bits");

/// How often the status is polled: its flags clear within five LSI cycles, 0.3 ms, and a poll
/// takes at least six cycles of at most 168 MHz.
const STATUS_POLLS: u32 = 20_000;

/// The watchdog, asleep until [`Watchdog::start`].
pub struct Watchdog {
    iwdg: IWDG,
}

impl Watchdog {
    /// The watchdog; halts with the core when a debugger halts it.
    pub(super) fn new(iwdg: IWDG, dbgmcu: &DBGMCU) -> Self {
        dbgmcu.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
        Self { iwdg }
    }

    /// Starts it. It must be fed from now on.
    pub fn start(&mut self) {
        self.iwdg.kr().write(|w| w.key().start());
        self.iwdg.kr().write(|w| w.key().unlock());
        self.iwdg.pr().write(|w| w.pr().divide_by64());
        self.iwdg.rlr().write(|w| w.rl().set(RELOAD as u16));
        // If this doesn't come true the period stays the shortest, and the chip resets sooner.
        let _ = wait(STATUS_POLLS, || self.iwdg.sr().read().bits() == 0);
        self.iwdg.kr().write(|w| w.key().feed());
    }

    /// Grants the loop another period.
    pub fn feed(&mut self, _permit: FeedPermit) {
        self.iwdg.kr().write(|w| w.key().feed());
    }
}
