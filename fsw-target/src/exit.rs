//! How an image ends: with a status that QEMU and `probe-rs run` pass on to their caller.
//!
//! Whatever goes wrong in a way that the code did not foresee (a panic, a fault, an interrupt
//! without a handler) is logged and ends as a failure, never in a silent loop: the caller would
//! wait for ever.
//!
//! The status goes out by semihosting, a breakpoint that a debugger or QEMU answers. Without
//! either the core locks up there until it is reset; the log has gone out by then.

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, ExitStatus, exit};

/// Ends the image, reporting success.
pub fn success() -> ! {
    end(EXIT_SUCCESS)
}

/// Ends the image, reporting failure. Say why in the log before.
pub fn failure() -> ! {
    end(EXIT_FAILURE)
}

fn end(status: ExitStatus) -> ! {
    exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    // The place is enough to find it; the message would bring all of core::fmt into the image.
    match info.location() {
        Some(place) => defmt::error!("panicked at {=str}:{=u32}", place.file(), place.line()),
        None => defmt::error!("panicked"),
    }
    failure()
}

/// Where `defmt::panic!` and its like end. Without it defmt links a panic of `core`, which would
/// be the only one in an image that has none (the feature `avoid-default-panic` leaves it out).
#[defmt::panic_handler]
fn defmt_panic() -> ! {
    failure()
}

#[allow(unsafe_code, reason = "cortex-m-rt asks for an unsafe handler")]
// SAFETY: called by the hardware only, and does not return to what faulted.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    failure()
}

#[allow(unsafe_code, reason = "cortex-m-rt asks for an unsafe handler")]
// SAFETY: called by the hardware only, and does not return to what was interrupted.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) -> ! {
    defmt::error!("interrupt {=i16} has no handler", interrupt);
    failure()
}
