//! Cause of a reset.
//!
//! Registers: RM0090, section 7.3.21 (RCC_CSR).

use stm32f4::stm32f405::RCC;

/// Cause of the last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum ResetCause {
    /// Power-on.
    PowerOn,
    /// Supply voltage below the brown-out level.
    BrownOut,
    /// Reset pin: a debug probe or a button.
    Pin,
    /// System reset by software.
    Software,
    /// Independent watchdog.
    IndependentWatchdog,
    /// Window watchdog.
    WindowWatchdog,
    /// Entry of a low-power mode that the option bytes forbid.
    LowPower,
    /// No flag set, as in QEMU.
    Unknown,
}

/// Reads the cause and clears its flags, so that the next reset sets its own alone.
pub fn take_cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().clear());
    // Every reset also sets the flag of the pin, and power-on that of the brown-out: tested last.
    if flags.lpwrrstf().bit_is_set() {
        ResetCause::LowPower
    } else if flags.wwdgrstf().bit_is_set() {
        ResetCause::WindowWatchdog
    } else if flags.wdgrstf().bit_is_set() {
        ResetCause::IndependentWatchdog
    } else if flags.sftrstf().bit_is_set() {
        ResetCause::Software
    } else if flags.porrstf().bit_is_set() {
        ResetCause::PowerOn
    } else if flags.borrstf().bit_is_set() {
        ResetCause::BrownOut
    } else if flags.padrstf().bit_is_set() {
        ResetCause::Pin
    } else {
        ResetCause::Unknown
    }
}
