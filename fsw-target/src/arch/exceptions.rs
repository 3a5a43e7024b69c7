//! Exceptions and interrupts without a handler of their own.

use crate::runtime::failure::{Failure, Kind, end_image};
use cortex_m_rt::exception;

#[allow(unsafe_code, reason = "cortex-m-rt requires an unsafe handler")]
// SAFETY: called by the hardware only, and does not return to the interrupted code.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) -> ! {
    defmt::error!("interrupt {=i16} has no handler", interrupt);
    let at = u32::from(interrupt.unsigned_abs());
    end_image(Failure { kind: Kind::UnservedInterrupt, at, from: 0 })
}
