//! Wheel sensors with two channels each: TIM2 captures both edges of channel A, and its interrupt reads the
//! levels of A and B for the direction.
//!
//! The hardware captures the time of an edge. Interrupt latency up to one edge interval costs no
//! accuracy. A longer one loses an edge, which the timer flags for each wheel: that wheel is initialised again,
//! and its next reading says so.
//!
//! The timer counts at 4 MHz, a rate of both clocks of the board, and wraps after 18 minutes.
//!
//! Registers: RM0090, chapter 18 (TIM2 to TIM5).

use super::pins::TachLevels;
use super::rates::{Clocks, timer_prescaler};
use crate::drivers::wheel_tach::{CaptureTimer, Captured, EdgeFilter};
use crate::flight::sensors::MotorTorque;
use crate::runtime::shared::Shared;
use core::sync::atomic::{AtomicU32, Ordering};
use stm32f4::stm32f405::{RCC, TIM2, interrupt, tim2};

/// Rate of the timer, ticks per second.
pub const TICKS_PER_S: u32 = 4_000_000;

/// Wheels: channels of the timer.
const WHEELS: usize = 4;

/// The timer has not been started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub struct NotStarted;

/// The timer, and the state of its interrupt.
struct Wheels {
    timer: TIM2,
    levels: TachLevels,
    new_filter: EdgeFilter,
    filters: [EdgeFilter; WHEELS],
    /// True for each wheel that has lost edges since the last reading.
    lost: [bool; WHEELS],
}

static CAPTURES: Shared<Wheels> = Shared::new();

/// Count of the timer at the last data-ready of the gyro.
static AT_SAMPLE: AtomicU32 = AtomicU32::new(0);

#[interrupt]
fn TIM2() {
    CAPTURES.with(Wheels::take_edges);
}

/// Stores the count of a gyro sample: the instant of the next reading.
pub(super) fn mark_sample() {
    AT_SAMPLE.store(count(), Ordering::Relaxed);
}

/// The count, ticks.
fn count() -> u32 {
    // SAFETY: reading the counter has no side effect, and only `follow_clocks` writes it.
    #[allow(unsafe_code, reason = "also read by the data-ready interrupt, which cannot own it")]
    let timer = unsafe { &*TIM2::ptr() };
    timer.cnt().read().cnt().bits()
}

/// Discards the edges captured while interrupts were masked for long: other edges were lost between
/// them.
pub(super) fn drop_pending() {
    CAPTURES.with(|wheels| {
        let _ = wheels.take_captured();
        wheels.restart([true; WHEELS]);
    });
}

impl Wheels {
    /// Passes each new edge to the filter of its wheel.
    fn take_edges(&mut self) {
        let captured = self.take_captured();
        let levels = self.levels.read();
        for ((filter, ticks), (a, b)) in self.filters.iter_mut().zip(captured).zip(levels) {
            if let Some(ticks) = ticks {
                filter.edge(ticks, a, b);
            }
        }
    }

    /// Time of the new edge of each wheel, ticks; `None` without one.
    fn take_captured(&mut self) -> [Option<u32>; WHEELS] {
        let timer = &self.timer;
        let status = timer.sr().read();
        let lost = [
            status.cc1of().bit_is_set(),
            status.cc2of().bit_is_set(),
            status.cc3of().bit_is_set(),
            status.cc4of().bit_is_set(),
        ];
        if lost.contains(&true) {
            // Writes of 1 leave a flag, so that only those above are cleared.
            timer.sr().write(|w| {
                w.cc1of().bit(!lost[0]).cc2of().bit(!lost[1]);
                w.cc3of().bit(!lost[2]).cc4of().bit(!lost[3])
            });
            self.restart(lost);
        }
        // Reading a capture clears its flag (TIMx_SR).
        let timer = &self.timer;
        [
            status.cc1if().bit_is_set().then(|| timer.ccr1().read().bits()),
            status.cc2if().bit_is_set().then(|| timer.ccr2().read().bits()),
            status.cc3if().bit_is_set().then(|| timer.ccr3().read().bits()),
            status.cc4if().bit_is_set().then(|| timer.ccr4().read().bits()),
        ]
    }

    /// Starts wheels again after lost edges.
    fn restart(&mut self, which: [bool; WHEELS]) {
        let wheels = self.filters.iter_mut().zip(&mut self.lost).zip(which);
        for ((filter, lost), _) in wheels.filter(|(_, restarts)| *restarts) {
            (*filter, *lost) = (self.new_filter, true);
        }
    }
}

/// The started timer, for the tachometer driver.
pub struct WheelCaptures {
    opened: (),
}

/// Timer and inputs, before their start.
pub struct CaptureInputs {
    timer: TIM2,
    levels: TachLevels,
}

impl CaptureInputs {
    pub(super) fn new(timer: TIM2, levels: TachLevels, rcc: &RCC, clocks: &Clocks) -> Self {
        rcc.apb1enr().modify(|_, w| w.tim2en().enabled());
        let _ = rcc.apb1enr().read(); // delay for the peripheral's clock, see `mod.rs`
        timer.arr().write(|w| w.arr().set(u32::MAX));
        timer.cr1().write(|w| w.urs().counter_only().cen().enabled());
        follow_clocks(&timer, clocks);
        Self { timer, levels }
    }

    /// Starts the captures. `shortest_s`: shortest time between two edges of a wheel, s; see
    /// [`EdgeFilter::new`].
    pub fn start(self, shortest_s: f32) -> WheelCaptures {
        let Self { timer, levels } = self;
        let new_filter = EdgeFilter::new((shortest_s * TICKS_PER_S as f32) as u32);
        // Input filter: eight equal samples, 16 timer clocks apart: 1.5 µs, or 8 µs on the slow clock. All
        // captures are late by this time.
        timer.ccmr1_input().write(|w| {
            w.cc1s().ti1().cc2s().ti2();
            w.ic1f().fdts_div16_n8().ic2f().fdts_div16_n8()
        });
        timer.ccmr2_input().write(|w| {
            w.cc3s().ti3().cc4s().ti4();
            w.ic3f().fdts_div16_n8().ic4f().fdts_div16_n8()
        });
        timer.ccer().write(|w| {
            // Both bits of the polarity: both edges.
            w.cc1p().set_bit().cc1np().set_bit().cc2p().set_bit().cc2np().set_bit();
            w.cc3p().set_bit().cc3np().set_bit().cc4p().set_bit().cc4np().set_bit();
            w.cc1e().set_bit().cc2e().set_bit().cc3e().set_bit().cc4e().set_bit()
        });
        timer
            .dier()
            .write(|w| w.cc1ie().enabled().cc2ie().enabled().cc3ie().enabled().cc4ie().enabled());
        let filters = [new_filter; WHEELS];
        CAPTURES.put(Wheels { timer, levels, new_filter, filters, lost: [false; WHEELS] });
        WheelCaptures { opened: () }
    }
}

/// Keeps rate and count of the timer after a change of the clocks.
pub fn follow_clocks(timer: &tim2::RegisterBlock, clocks: &Clocks) {
    let prescaler = timer_prescaler(clocks.timer_hz(), TICKS_PER_S);
    timer.psc().write(|w| w.psc().set(prescaler));
    // The prescaler takes effect with an update, which also clears the counter.
    let count = timer.cnt().read().cnt().bits();
    timer.egr().write(|w| w.ug().update());
    timer.cnt().write(|w| w.cnt().set(count));
}

/// The motors belong to another unit: their torque is unknown.
impl MotorTorque<WHEELS> for WheelCaptures {}

impl CaptureTimer<WHEELS> for WheelCaptures {
    type Error = NotStarted;

    fn ticks_per_s(&self) -> u32 {
        let () = self.opened;
        TICKS_PER_S
    }

    fn captured(&mut self) -> Result<[Captured; WHEELS], NotStarted> {
        let now_ticks = AT_SAMPLE.load(Ordering::Relaxed);
        let captured = CAPTURES.with(|wheels| {
            let mut lost = core::mem::take(&mut wheels.lost).into_iter();
            wheels.filters.each_ref().map(|filter| {
                let lost = lost.next().unwrap_or(false);
                Captured { lost, ..filter.captured(now_ticks) }
            })
        });
        captured.ok_or(NotStarted)
    }
}
