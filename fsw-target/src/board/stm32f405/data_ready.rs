//! The gyro's data-ready line, PC4: its rising edge is an interrupt that takes the time.
//!
//! Output: the stamps of the samples, as [`DataReady`] wants them. The edge is stamped within
//! microseconds, unless interrupts are masked for longer: see `flash.rs` for the one case.
//!
//! Where the sample is then handled is the image's choice. The flight image's main loop looks for
//! it: it has nothing else to do, and the stamp makes up for its being late. An image whose main
//! loop is somebody else's calls [`GyroDataReady::also_pend_sv`], and flies in the exception PendSV:
//! below all interrupts, so that it delays none, and above the main loop.
//!
//! Registers: RM0090, chapters 9 (SYSCFG) and 12 (EXTI).

use super::captures;
use super::time::now_us;
use crate::flight::sensors::DataReady;
use crate::runtime::shared::Shared;
use crate::runtime::stamps::Stamps;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::{NVIC, SCB};
use stm32f4::stm32f405::{EXTI, Interrupt, SYSCFG, interrupt};

/// The line's peripheral, and the stamps between interrupt and loop.
struct Line {
    exti: EXTI,
    stamps: Stamps,
}

static LINE: Shared<Line> = Shared::new();

/// Whether a sample pends PendSV.
static PENDS_SV: AtomicBool = AtomicBool::new(false);

#[interrupt]
fn EXTI4() {
    let time_us = now_us();
    captures::mark_sample();
    LINE.with(|line| {
        line.exti.pr().write(|w| w.pr4().clear());
        line.stamps.push(time_us);
    });
    if PENDS_SV.load(Ordering::Relaxed) {
        SCB::set_pendsv();
    }
}

/// After interrupts were masked for long: forgets the stamps from before, whose samples newer ones
/// have replaced, and the edge that waits to be served, since nobody knows when it came.
pub(super) fn drop_pending() {
    drop_with(Stamps::drop_all);
}

fn drop_with(drop_stamps: fn(&mut Stamps)) {
    LINE.with(|line| {
        line.exti.pr().write(|w| w.pr4().clear());
        drop_stamps(&mut line.stamps);
    });
    NVIC::unpend(Interrupt::EXTI4);
}

/// The loop's side of the line.
pub struct GyroDataReady {
    opened: (),
}

/// Opens the line, whose pin must be set up and whose clock on.
pub fn open(exti: EXTI, syscfg: &SYSCFG) -> GyroDataReady {
    syscfg.exticr2().modify(|_, w| w.exti4().pc());
    exti.rtsr().modify(|_, w| w.tr4().enabled());
    exti.pr().write(|w| w.pr4().clear());
    exti.imr().modify(|_, w| w.mr4().unmasked());
    let line = Line { exti, stamps: Stamps::new() };
    LINE.put(line);
    GyroDataReady { opened: () }
}

impl GyroDataReady {
    /// From now on each sample also pends the exception PendSV, for which the image must have a
    /// handler.
    pub fn also_pend_sv(&self) {
        PENDS_SV.store(true, Ordering::Relaxed);
    }

    /// Makes the interrupt by software, as if the gyro had sampled: for bring-up.
    pub fn trigger() {
        NVIC::pend(Interrupt::EXTI4);
        // It is served before these are over.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }
}

impl DataReady for GyroDataReady {
    fn take_us(&mut self) -> Option<u64> {
        LINE.with(|line| line.stamps.take_newest()).flatten()
    }

    fn has_newer(&mut self) -> bool {
        LINE.with(|line| !line.stamps.is_empty()).unwrap_or_default()
    }

    fn forget(&mut self) {
        drop_with(Stamps::forget);
    }

    fn overruns(&self) -> u32 {
        let () = self.opened;
        LINE.with(|line| line.stamps.overruns()).unwrap_or_default()
    }
}
