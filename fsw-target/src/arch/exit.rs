//! End of an image: with a status, or with a system reset.
//!
//! An image under test ends with a status that QEMU and `probe-rs run` pass on to their caller:
//! [`success`], [`failure`], and [`end_after`] a failure that [`crate::runtime::failure`] has caught. The
//! status is output by semihosting, a breakpoint that a debugger or QEMU answers. Without either, the
//! core locks up at that breakpoint until it is reset; the log has been sent by then.
//!
//! A flight image has no end: [`restart_after`] a failure, the chip is reset, and telemetry reports the
//! failure after the restart.

use crate::runtime::failure::Failure;
use crate::runtime::restart;
use cortex_m::peripheral::SCB;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, ExitStatus, exit};

/// Ends the image with the status of success.
pub fn success() -> ! {
    end(EXIT_SUCCESS)
}

/// Ends the image with the status of a failure, whose reason the log has.
pub fn failure() -> ! {
    end(EXIT_FAILURE)
}

/// Ends the image after a logged failure: for [`crate::ends_by`].
pub fn end_after(_logged: Failure) -> ! {
    failure()
}

/// Records the failure and resets the chip: for [`crate::ends_by`].
pub fn restart_after(failure: Failure) -> ! {
    restart::record(failure);
    SCB::sys_reset()
}

fn end(status: ExitStatus) -> ! {
    exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}
