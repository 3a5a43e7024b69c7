//! How the flight image ends: it doesn't, it restarts, and says why afterwards.
//!
//! After a failure the chip is reset. What failed is kept in a part of the RAM that a reset and
//! start-up leave alone; only power-off loses it, which the record's check tells.

use crate::runtime::failure::{Failure, LastLife, Words};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use cortex_m::peripheral::SCB;

/// A place that start-up doesn't initialise.
struct Kept(UnsafeCell<MaybeUninit<Words>>);

#[allow(unsafe_code, reason = "shared with itself after the restart")]
// SAFETY: accessed only by `read` and `write`: at start-up before interrupts are served, and after
// a failure with all else stopped.
unsafe impl Sync for Kept {}

#[allow(unsafe_code, reason = "the section that start-up leaves alone")]
// SAFETY: cortex-m-rt's linker script has this section, in RAM.
#[unsafe(link_section = ".uninit.restart")]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

fn read() -> LastLife {
    // SAFETY: any bits make words, and the compiler can't know what a volatile read finds.
    #[allow(unsafe_code, reason = "memory that an earlier life wrote")]
    let words = unsafe { KEPT.0.get().cast::<Words>().read_volatile() };
    LastLife::from_words(words).unwrap_or_default()
}

fn write(life: &LastLife) {
    // SAFETY: see `Kept`.
    #[allow(unsafe_code, reason = "memory that a later life reads")]
    unsafe {
        KEPT.0.get().cast::<Words>().write_volatile(life.to_words());
    }
}

/// What the last life left behind. Call it once, at start-up, before anything can fail: the
/// failure is forgotten, so that it isn't told again after a reset of another cause.
pub fn take_last_life() -> LastLife {
    let life = read();
    write(&LastLife { failure: None, ..life });
    life
}

/// Ends the flight image: keeps the failure and resets the chip.
pub fn failed(failure: Failure) -> ! {
    write(&read().followed_by(failure));
    SCB::sys_reset()
}
