//! Why the chip was reset.
//!
//! Registers: RM0090, section 7.3.21 (RCC_CSR).

use stm32f4::stm32f405::RCC;

/// What reset the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum ResetCause {
    /// The power came on.
    PowerOn,
    /// The power sagged.
    BrownOut,
    /// The reset pin: a probe or a button.
    Pin,
    /// The software asked for it.
    Software,
    /// The independent watchdog was not fed.
    IndependentWatchdog,
    /// The window watchdog was not fed.
    WindowWatchdog,
    /// A low-power mode was entered that is forbidden.
    LowPower,
    /// No flag is set, as in QEMU.
    Unknown,
}

/// Reads the cause, and clears it so that the next reset's stands alone.
pub fn take_cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().clear());
    // Every reset sets the pin's flag too, and power-on sets that of the brown-out: those last.
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
