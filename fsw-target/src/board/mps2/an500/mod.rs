//! FPGA image AN500, Cortex-M7: Arm, Application Note AN500 (DAI0500), memory map and interrupts. Same numbers as
//! QEMU 7.2, `hw/arm/mps2.c`.

/// Clock of core, UARTs and FPGAIO, Hz.
pub const CLOCK_HZ: u32 = 25_000_000;

/// UART0 and UART1.
pub const UARTS: [usize; 2] = [0x4000_4000, 0x4000_5000];
/// Interrupts of a received byte, UART0 and UART1.
pub const RECEIVED: [usize; 2] = [0, 2];

/// System control and I/O of the FPGA.
pub const FPGAIO: usize = 0x4002_8000;

/// Number of interrupts.
pub const INTERRUPTS: usize = 32;
