//! On-board time, in microseconds, and delays.
//!
//! TIM5 counts microseconds in 32 bits; [`now_us`] extends them to 64. It must be called at least once per
//! wrap of the counter, 71 minutes: the loop calls it thousands of times per second, or the watchdog
//! resets the chip.
//!
//! The timers of QEMU count a clock of 1 GHz, independent of the clock tree: on-board time runs 62.5 times
//! as fast as the time of QEMU. Every wait has a bound beside it.
//!
//! Registers: RM0090, chapter 18 (TIM2 to TIM5).

use super::rates::{Clocks, timer_prescaler};
use crate::runtime::bounded;
use crate::runtime::shared_time::SharedTime;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use embedded_hal::delay::DelayNs;
use stm32f4::stm32f405::{RCC, TIM5, tim5};

/// Rate of the counter, ticks per second.
const TICKS_PER_S: u32 = 1_000_000;

static TIME: SharedTime = SharedTime::new(count_us);

/// Starts the counter.
pub fn start(timer: TIM5, rcc: &RCC, clocks: &Clocks) {
    rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
    let _ = rcc.apb1enr().read(); // delay for the peripheral's clock, see `mod.rs`
    timer.arr().write(|w| w.arr().set(u32::MAX));
    timer.cr1().write(|w| w.urs().counter_only().cen().enabled());
    follow_clocks(&timer, clocks);
}

/// Keeps rate and count of the counter after a change of the clocks.
pub fn follow_clocks(timer: &tim5::RegisterBlock, clocks: &Clocks) {
    let prescaler = timer_prescaler(clocks.timer_hz(), TICKS_PER_S);
    timer.psc().write(|w| w.psc().set(prescaler));
    // The prescaler takes effect with an update, which also clears the counter.
    let count = timer.cnt().read().cnt().bits();
    timer.egr().write(|w| w.ug().update());
    timer.cnt().write(|w| w.cnt().set(count));
}

/// The counter, µs, wrapping.
fn count_us() -> u32 {
    // SAFETY: reading the counter has no side effect, and only `follow_clocks` writes it.
    #[allow(unsafe_code, reason = "also read by interrupt handlers, which cannot own it")]
    let timer = unsafe { &*TIM5::ptr() };
    timer.cnt().read().cnt().bits()
}

/// On-board time, µs: monotonic, also across interrupt handlers.
pub fn now_us() -> u64 {
    TIME.now_us()
}

/// Polls `done` for up to `limit_us`, or somewhat longer with a stopped counter; `None` if it stays
/// false.
pub fn wait_at_most(limit_us: u32, done: impl FnMut() -> bool) -> Option<()> {
    let polls_per_us = super::clocks::in_force().core_hz / TICKS_PER_S;
    bounded::wait_at_most(limit_us, polls_per_us, count_us, done)
}

/// Advances on-board time to at least `time_us`: to the next time with the current bits of the counter, up
/// to 71 minutes later.
pub fn resume_at(time_us: u64) {
    TIME.resume_at(time_us);
}

/// Sleep of the loop between two rounds, ended by any interrupt.
///
/// SysTick interrupts it once a millisecond at 168 MHz, so that telemetry and time-outs need no interrupt
/// of their own; a sample ends it at once. The image defines the handler of SysTick, which has
/// nothing to do.
pub struct SleepTick {
    started: (),
}

/// Rate of SysTick, 1/s.
const SLEEPS_PER_S: u32 = 1_000;

impl SleepTick {
    /// Starts SysTick.
    pub fn start(mut syst: SYST) -> Self {
        syst.set_clock_source(SystClkSource::Core);
        syst.set_reload(super::clocks::in_force().core_hz / SLEEPS_PER_S - 1);
        syst.clear_current();
        syst.enable_counter();
        syst.enable_interrupt();
        Self { started: () }
    }

    /// Sleeps until the next interrupt: for at most a millisecond at 168 MHz, ten after the loss of the
    /// crystal. An interrupt between the round and the sleep is served at once, and what it has brought is
    /// taken with the next round.
    pub fn sleep(&self) {
        let () = self.started;
        cortex_m::asm::wfi();
    }
}

/// Delay, bounded also with a stopped counter.
#[derive(Debug, Clone, Copy, Default)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // Part of the first microsecond has passed.
        let _ = wait_at_most(ns.div_ceil(1_000).saturating_add(1), || false);
    }
}
