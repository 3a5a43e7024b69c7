//! Vector table of the interrupts: one for each received byte of a UART.

use super::fpga_image::{INTERRUPTS, RECEIVED};
use super::uart;
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;

/// Handler of an interrupt.
type Vector = unsafe extern "C" fn();

#[allow(unsafe_code, reason = "handler of all other interrupts")]
unsafe extern "C" {
    /// That of `arch/exceptions.rs`.
    fn DefaultHandler();
}

const fn vectors() -> [Vector; INTERRUPTS] {
    let mut vectors: [Vector; INTERRUPTS] = [DefaultHandler; INTERRUPTS];
    vectors[RECEIVED[0]] = uart::link_received;
    vectors[RECEIVED[1]] = uart::tunnel_received;
    vectors
}

/// The vectors, by the name that the vector table of cortex-m-rt requires.
#[allow(unsafe_code, reason = "part of the vector table")]
// SAFETY: no other item has this name, and the section is that of the interrupts.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".vector_table.interrupts")]
#[used]
pub static __INTERRUPTS: [Vector; INTERRUPTS] = vectors();

/// Number of an interrupt.
#[derive(Clone, Copy)]
struct Number(u16);

#[allow(unsafe_code, reason = "an unsafe trait")]
// SAFETY: constants of the FPGA image, fixed for each value.
unsafe impl InterruptNumber for Number {
    fn number(self) -> u16 {
        self.0
    }
}

/// Enables the interrupts, after the state that their handlers share is in place. Their priority is the same.
pub fn enable() {
    for number in RECEIVED {
        // SAFETY: no critical section relies on masks of single interrupts.
        #[allow(unsafe_code, reason = "can break such critical sections")]
        unsafe {
            NVIC::unmask(Number(number as u16));
        }
    }
}
