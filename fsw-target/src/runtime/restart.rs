//! Restart record: the failure that ended the last run, in RAM that reset and start-up leave
//! unchanged.
//!
//! Power-off clears the record, which its check detects.

use crate::runtime::failure::{Failure, LastRun, Words};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// Memory that start-up does not initialise.
struct Record(UnsafeCell<MaybeUninit<Words>>);

#[allow(unsafe_code, reason = "read again after the restart")]
// SAFETY: accessed only by `read` and `write`: at start-up before interrupts are served, and after
// a failure, when no other code runs.
unsafe impl Sync for Record {}

#[allow(unsafe_code, reason = "the section that start-up leaves unchanged")]
// SAFETY: cortex-m-rt's linker script has this section, in RAM.
#[unsafe(link_section = ".uninit.restart")]
static RECORD: Record = Record(UnsafeCell::new(MaybeUninit::uninit()));

fn read() -> LastRun {
    // SAFETY: any bits are valid words, and a volatile read is opaque to the compiler.
    #[allow(unsafe_code, reason = "memory that an earlier run wrote")]
    let words = unsafe { RECORD.0.get().cast::<Words>().read_volatile() };
    LastRun::from_words(words).unwrap_or_default()
}

fn write(run: &LastRun) {
    // SAFETY: see `Record`.
    #[allow(unsafe_code, reason = "memory that a later run reads")]
    unsafe {
        RECORD.0.get().cast::<Words>().write_volatile(run.to_words());
    }
}

/// The record of the last run. Call it once, at start-up, before anything can fail: it clears the
/// failure, which is not reported again after a reset of another cause. `by_watchdog`: the watchdog has
/// reset the chip.
pub fn take_last_run(by_watchdog: bool) -> LastRun {
    let run = read().at_start(by_watchdog);
    write(&LastRun { failure: None, ..run });
    run
}

/// Records that this run is long.
pub fn note_long_life() {
    write(&read().of_long_life());
}

/// Records the failure that ends this run, before a reset.
pub fn record(failure: Failure) {
    write(&read().followed_by(failure));
}
