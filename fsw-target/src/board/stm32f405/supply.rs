//! Supply detector: reports a supply below 2.9 V, at which flash operations are refused.
//!
//! Programming with 32-bit parallelism holds at 2.7 to 3.6 V (DS8626, flash memory characteristics). The
//! highest threshold of the detector, nominally 2.9 V, leaves a margin; the brown-out reset at 2.7 V
//! (`option_bytes.rs`) ends an operation that the supply leaves in between.
//!
//! Registers: RM0090, chapter 5 (PWR). QEMU reads 0: never low.

use stm32f4::stm32f405::{PWR, RCC};

/// Threshold of the detector: 2.9 V (PWR_CR, PLS).
const HIGHEST: u8 = 7;

/// Starts the detector.
pub fn start(rcc: &RCC, pwr: &PWR) {
    rcc.apb1enr().modify(|_, w| w.pwren().enabled());
    let _ = rcc.apb1enr().read(); // delay for the peripheral's clock, see `mod.rs`
    pwr.cr().modify(|_, w| w.pls().set(HIGHEST).pvde().set_bit());
}

/// True if the supply is below the threshold.
pub fn is_low() -> bool {
    // SAFETY: reading the status has no side effect, and only `start` and `clocks` write the control.
    #[allow(unsafe_code, reason = "read by the flash driver, which does not own it")]
    let pwr = unsafe { &*PWR::ptr() };
    pwr.csr().read().pvdo().bit_is_set()
}
