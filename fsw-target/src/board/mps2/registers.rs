//! Layouts of the registers in use. No register crate of these FPGA images is maintained.

use super::fpga_image::{FPGAIO, UARTS};
use vcell::VolatileCell;

/// UART of the Cortex-M System Design Kit: DDI0479, APB UART.
#[repr(C)]
pub struct UartBlock {
    /// Received byte; byte to send.
    pub data: VolatileCell<u32>,
    /// See [`state`].
    pub state: VolatileCell<u32>,
    /// See [`control`].
    pub control: VolatileCell<u32>,
    /// Pending interrupts, see [`interrupt`]; a written 1 clears its bit.
    pub interrupt: VolatileCell<u32>,
    /// Divider from the clock to the baud rate, 16 or more.
    pub divider: VolatileCell<u32>,
}

/// Bits of [`UartBlock::state`].
pub mod state {
    /// The transmitter holds a byte.
    pub const TRANSMITTER_FULL: u32 = 1 << 0;
    /// The receiver holds a byte.
    pub const RECEIVER_FULL: u32 = 1 << 1;
    /// A received byte was lost; a written 1 clears it.
    pub const RECEIVER_OVERRUN: u32 = 1 << 3;
}

/// Bits of [`UartBlock::control`].
pub mod control {
    /// Transmitter.
    pub const TRANSMIT: u32 = 1 << 0;
    /// Receiver.
    pub const RECEIVE: u32 = 1 << 1;
    /// Interrupt of a received byte.
    pub const RECEIVE_INTERRUPT: u32 = 1 << 3;
}

/// Bits of [`UartBlock::interrupt`].
pub mod interrupt {
    /// A byte was received.
    pub const RECEIVED: u32 = 1 << 1;
}

/// System control and I/O of the FPGA: application notes AN500 and AN505, FPGA system control and I/O.
#[repr(C)]
pub struct FpgaIo {
    _leds_buttons_and_slow_clocks: [u32; 6],
    /// Counts wraps of the prescaler, 32 bits.
    pub counter: VolatileCell<u32>,
    /// Reload value of the prescaler: clocks of a count, less one.
    pub prescale: VolatileCell<u32>,
}

const _: () = assert!(core::mem::offset_of!(UartBlock, divider) == 0x10);
const _: () = assert!(core::mem::offset_of!(FpgaIo, counter) == 0x18);

/// The registers of UART `N`.
pub fn uart<const N: usize>() -> &'static UartBlock {
    // SAFETY: the address is that of the registers, and each access is volatile.
    #[allow(unsafe_code, reason = "registers at a fixed address")]
    unsafe {
        &*(UARTS[N] as *const UartBlock)
    }
}

/// The registers of the FPGA.
pub fn fpga_io() -> &'static FpgaIo {
    // SAFETY: as above.
    #[allow(unsafe_code, reason = "registers at a fixed address")]
    unsafe {
        &*(FPGAIO as *const FpgaIo)
    }
}
