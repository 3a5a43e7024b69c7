//! Data-ready line of the gyro, PC4: its rising edge raises an interrupt, which stamps the sample.
//!
//! Output: time stamps ([`DataReady`]), within microseconds of the edge unless interrupts are masked for
//! longer; the one such case is an erasure of the flash (`flash.rs`).
//!
//! A line that chatters is closed for 10 ms ([`ChatterGuard`]); each closing counts as an overrun.
//!
//! The image chooses the context of the flight loop. The flight image polls in its main loop, which has no
//! other work; the stamp makes its latency irrelevant. An image with another main loop calls
//! [`GyroDataReady::also_pend_sv`] and runs the flight loop in the exception PendSV: below all
//! interrupts, which it does not delay, and above the main loop.
//!
//! Registers: RM0090, chapters 9 (SYSCFG) and 12 (EXTI).

use super::captures;
use super::time::now_us;
use crate::flight::sensors::DataReady;
use crate::runtime::shared::Shared;
use crate::runtime::stamps::{ChatterGuard, Stamps};
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::{NVIC, SCB};
use stm32f4::stm32f405::{EXTI, Interrupt, SYSCFG, interrupt};

/// Peripheral of the line, and the stamps between interrupt and loop.
struct Line {
    exti: EXTI,
    stamps: Stamps,
    guard: ChatterGuard,
}

static LINE: Shared<Line> = Shared::new();

/// True if a sample also pends PendSV.
static PENDS_SV: AtomicBool = AtomicBool::new(false);

#[interrupt]
fn EXTI4() {
    let time_us = now_us();
    captures::mark_sample();
    LINE.with(|line| {
        line.exti.pr().write(|w| w.pr4().clear());
        if line.guard.accepts(time_us) {
            line.stamps.push(time_us);
        } else {
            line.exti.imr().modify(|_, w| w.mr4().masked());
        }
    });
    if PENDS_SV.load(Ordering::Relaxed) {
        SCB::set_pendsv();
    }
}

/// Discards pending stamps and a pending edge after interrupts were masked for long: newer samples have
/// overwritten those of the stamps, and the time of the edge is unknown.
pub(super) fn drop_pending() {
    clear_with(Stamps::discard_as_overruns);
}

fn clear_with(clear_stamps: fn(&mut Stamps)) {
    LINE.with(|line| {
        line.exti.pr().write(|w| w.pr4().clear());
        clear_stamps(&mut line.stamps);
    });
    NVIC::unpend(Interrupt::EXTI4);
}

/// The line as the loop reads it.
pub struct GyroDataReady {
    opened: (),
}

/// Enables the line. Its pin must be configured, and the clock of SYSCFG enabled.
pub fn open(exti: EXTI, syscfg: &SYSCFG) -> GyroDataReady {
    syscfg.exticr2().modify(|_, w| w.exti4().pc());
    exti.rtsr().modify(|_, w| w.tr4().enabled());
    exti.pr().write(|w| w.pr4().clear());
    exti.imr().modify(|_, w| w.mr4().unmasked());
    let line = Line { exti, stamps: Stamps::new(), guard: ChatterGuard::new() };
    LINE.put(line);
    GyroDataReady { opened: () }
}

impl GyroDataReady {
    /// Makes each sample also pend the exception PendSV, for which the image must define a handler.
    pub fn also_pend_sv(&self) {
        PENDS_SV.store(true, Ordering::Relaxed);
    }

    /// Raises the interrupt by software, for bring-up.
    pub fn trigger() {
        NVIC::pend(Interrupt::EXTI4);
        // The handler has run after these barriers.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }
}

impl DataReady for GyroDataReady {
    fn take_us(&mut self) -> Option<u64> {
        let now_us = now_us();
        LINE.with(|line| {
            if line.guard.opens(now_us) {
                line.exti.pr().write(|w| w.pr4().clear());
                line.exti.imr().modify(|_, w| w.mr4().unmasked());
            }
            line.stamps.take_newest()
        })
        .flatten()
    }

    fn has_newer(&mut self) -> bool {
        LINE.with(|line| !line.stamps.is_empty()).unwrap_or_default()
    }

    fn discard(&mut self) {
        clear_with(Stamps::discard);
    }

    fn overruns(&self) -> u32 {
        let () = self.opened;
        let lost = |line: &mut Line| line.stamps.overruns().saturating_add(line.guard.chatters());
        LINE.with(lost).unwrap_or_default()
    }
}
