//! Failure of the crystal in flight, detected by the clock security system.
//!
//! The hardware switches the core to the internal oscillator and raises the non-maskable interrupt. The
//! handler removes the dividers of the buses and sets all derived rates again (baud rates, SPI, both
//! timers), so that the board continues at a tenth of its speed, with telemetry, time and captures in the
//! same units. Limits:
//!
//! * A byte on the line at that instant is lost; its packet fails the CRC.
//! * Timers run at the wrong rate between the failure and the end of the handler, some microseconds.
//! * The crystal stays unused until the next reset.
//!
//! Registers: RM0090, section 7.3.4 (RCC_CIR).

use super::rates::Clocks;
use super::{captures, clocks, spi, time, usart};
use cortex_m_rt::exception;
use stm32f4::stm32f405::Peripherals;

#[allow(unsafe_code, reason = "cortex-m-rt requires an unsafe handler")]
// SAFETY: called by the hardware only. It shares registers with the code that it interrupts, and no
// memory other than atomics.
#[exception]
unsafe fn NonMaskableInt() {
    // SAFETY: writes registers of rates only, each in one store; no other code writes them after
    // start-up.
    let chip = unsafe { Peripherals::steal() };
    if chip.RCC.cir().read().cssf().bit_is_clear() {
        return;
    }
    chip.RCC.cir().modify(|_, w| w.cssc().clear());
    clocks::follow_loss_of_crystal(&chip.RCC);
    follow_clocks(&chip, &Clocks::INTERNAL);
}

/// Sets all derived rates again.
fn follow_clocks(chip: &Peripherals, clocks: &Clocks) {
    time::follow_clocks(&chip.TIM5, clocks);
    captures::follow_clocks(&chip.TIM2, clocks);
    usart::follow_clocks(&chip.USART1, &chip.USART2, clocks);
    spi::follow_clocks(&chip.SPI1, clocks);
}
