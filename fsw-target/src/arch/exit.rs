//! How an image ends that has an end: with a status that QEMU and `probe-rs run` pass on to their
//! caller.
//!
//! Whatever goes wrong in a way that the code did not foresee is logged by [`crate::runtime::failure`] and
//! ends here as a failure, never in a silent loop: the caller would wait for ever.
//!
//! The status goes out by semihosting, a breakpoint that a debugger or QEMU answers. Without
//! either the core locks up there until it is reset; the log has gone out by then. The flight
//! image doesn't use this: it restarts ([`crate::runtime::restart`]).

use crate::runtime::failure::Failure;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, ExitStatus, exit};

/// Ends the image, reporting success.
pub fn success() -> ! {
    end(EXIT_SUCCESS)
}

/// Ends the image, reporting failure. Say why in the log before.
pub fn failure() -> ! {
    end(EXIT_FAILURE)
}

/// Ends the image after a failure that has been logged: for [`crate::ends_by`].
pub fn failed(_logged: Failure) -> ! {
    failure()
}

fn end(status: ExitStatus) -> ! {
    exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}
