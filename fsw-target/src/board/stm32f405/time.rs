//! Mission time: microseconds since start-up, and delays.
//!
//! TIM5 counts microseconds in 32 bits, by the clocks in force; [`now_us`] carries them on to 64.
//! It has to be called at least once in the 71 minutes that the counter takes to wrap, which the
//! loop does thousands of times a second, or else the watchdog ends it.
//!
//! In QEMU the timers count a clock of 1 GHz, whatever the chip's: there mission time runs 62.5
//! times as fast as QEMU's own. Nothing waits on it without a bound.
//!
//! Registers: RM0090, chapter 18 (TIM2 to TIM5).

use super::rates::{Clocks, timer_prescaler};
use crate::runtime::extended_time::ExtendedTime;
use core::cell::Cell;
use critical_section::Mutex;
use embedded_hal::delay::DelayNs;
use stm32f4::stm32f405::{RCC, TIM5, tim5};

/// Ticks of the counter a second.
const TICKS_PER_S: u32 = 1_000_000;

static TIME: Mutex<Cell<ExtendedTime>> = Mutex::new(Cell::new(ExtendedTime::START));

/// Starts the counter; it is this module's from then on.
pub fn start(timer: TIM5, rcc: &RCC, clocks: &Clocks) {
    rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
    let _ = rcc.apb1enr().read(); // as long as a clock takes to arrive, see `mod.rs`
    timer.arr().write(|w| w.arr().set(u32::MAX));
    timer.cr1().write(|w| w.urs().counter_only().cen().enabled());
    follow_clocks(&timer, clocks);
}

/// Goes on counting microseconds after the clocks have changed, from the same count.
pub fn follow_clocks(timer: &tim5::RegisterBlock, clocks: &Clocks) {
    let prescaler = timer_prescaler(clocks.timer_hz(), TICKS_PER_S);
    timer.psc().write(|w| w.psc().set(prescaler));
    // The prescaler takes effect with an update, which also clears the counter.
    let count = timer.cnt().read().cnt().bits();
    timer.egr().write(|w| w.ug().update());
    timer.cnt().write(|w| w.cnt().set(count));
}

/// The counter, microseconds, wrapping.
fn count_us() -> u32 {
    // SAFETY: reading the counter changes nothing, and it is written only by `follow_clocks`.
    #[allow(unsafe_code, reason = "read by interrupt handlers too, which can't own it")]
    let timer = unsafe { &*TIM5::ptr() };
    timer.cnt().read().cnt().bits()
}

/// Mission time, microseconds since start-up. Never goes back, whichever interrupt asks.
pub fn now_us() -> u64 {
    critical_section::with(|section| {
        let cell = TIME.borrow(section);
        let time = cell.get().advanced_to(count_us());
        cell.set(time);
        time.us()
    })
}

/// Polls `done` for at most `limit_us`, or somewhat longer if the counter stands still; `None` if
/// it never was.
pub fn wait_at_most(limit_us: u32, mut done: impl FnMut() -> bool) -> Option<()> {
    // A poll takes several cycles, so as many polls as cycles are always long enough.
    let polls = limit_us.saturating_mul(super::clocks::in_force().core_hz / TICKS_PER_S);
    let start = count_us();
    let mut in_time = None;
    super::clocks::wait(polls, || {
        if done() {
            in_time = Some(());
        }
        in_time.is_some() || count_us().wrapping_sub(start) >= limit_us
    });
    in_time
}

/// Mission time goes on from here, if it is behind that: at the next time at which the counter has
/// the bits that it has now, so up to 71 minutes later.
pub fn resume_at(time_us: u64) {
    critical_section::with(|section| {
        let cell = TIME.borrow(section);
        cell.set(cell.get().advanced_to(count_us()).resumed_at(time_us));
    });
}

/// Waits that have an end even if the counter stands still.
#[derive(Debug, Clone, Copy, Default)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // The first microsecond has partly gone by.
        let _ = wait_at_most(ns.div_ceil(1_000).saturating_add(1), || false);
    }
}
