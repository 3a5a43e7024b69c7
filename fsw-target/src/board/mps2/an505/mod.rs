//! FPGA image AN505, Cortex-M33: Arm, Application Note AN505 (DAI0505), memory map and interrupts. Same numbers as
//! QEMU 7.2, `hw/arm/mps2-tz.c`.
//!
//! The core starts in secure state and stays in it: addresses of the secure aliases, where bit 28 is set. After reset all
//! peripherals and memories behind a protection controller are secure.

/// Clock of core, UARTs and FPGAIO, Hz.
pub const CLOCK_HZ: u32 = 20_000_000;

/// UART0 and UART1.
pub const UARTS: [usize; 2] = [0x5020_0000, 0x5020_1000];
/// Interrupts of a received byte, UART0 and UART1.
pub const RECEIVED: [usize; 2] = [32, 34];

/// System control and I/O of the FPGA.
pub const FPGAIO: usize = 0x5030_2000;

/// Number of interrupts: 32 of the subsystem, 92 of the FPGA.
pub const INTERRUPTS: usize = 124;
