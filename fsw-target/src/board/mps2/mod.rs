//! MPS2 boards of Arm: serial ports and a timer, for the images `replay`, `pil` and `failures`.
//!
//! The core of an MPS2 is in its FPGA: the FPGA image of an application note decides core, memories and
//! addresses. QEMU emulates both images here.
//!
//! | feature | FPGA image | core | QEMU machine |
//! |---|---|---|---|
//! | `mps2-an500` | AN500 | Cortex-M7 | `mps2-an500` |
//! | `mps2-an505` | AN505 | Cortex-M33, in secure state | `mps2-an505` |
//!
//! | part | function |
//! |---|---|
//! | UART0 | ground: telemetry and telecommands; log of images without telemetry |
//! | UART1 | simulator: processor in the loop |
//! | FPGAIO COUNTER | on-board time |
//!
//! Neither bus nor inputs for sensors, no flash and no watchdog are supported: the images `flight` and `bringup` are not
//! built for these boards. Not run on hardware.
//!
//! # Files
//!
//! `an500` and `an505`: addresses and interrupt numbers; `registers`: layouts; `interrupts`: vector table; one file per
//! peripheral.

#[cfg(feature = "mps2-an500")]
#[path = "an500/mod.rs"]
mod fpga_image;
#[cfg(feature = "mps2-an505")]
#[path = "an505/mod.rs"]
mod fpga_image;
mod interrupts;
mod registers;
pub mod time;
pub mod uart;

pub use time::{Delay, now_us};
pub use uart::{Link, Tunnel};

use cortex_m::peripheral::SYST;

/// Parts of the board.
pub struct Board {
    /// Serial port of telemetry and telecommands.
    pub link: Link,
    /// Serial port to the simulator of the processor in the loop.
    pub tunnel: Tunnel,
    /// SysTick, free for measurements.
    pub syst: SYST,
}

impl Board {
    /// Starts the board; `None` after the first call.
    pub fn take() -> Option<Self> {
        let core = cortex_m::Peripherals::take()?;
        time::start();
        let (link, tunnel) = uart::open();
        interrupts::enable();
        Some(Self { link, tunnel, syst: core.SYST })
    }
}
