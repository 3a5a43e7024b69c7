//! The board: an STM32F405RG (Cortex-M4F, LQFP64) with an 8 MHz crystal, a rate gyro on SPI and
//! four wheels.
//!
//! # Wiring
//!
//! | pin | function | setting | to |
//! |---|---|---|---|
//! | PH0, PH1 | HSE | 8 MHz crystal | |
//! | PA9 | USART1 TX | AF7, 115200 baud 8N1 | ground: telemetry; the log of images that end |
//! | PA10 | USART1 RX | AF7, pulled up | ground: commands |
//! | PA4 | output | idles high | gyro: chip select (BMI088 CSB2) |
//! | PA5 | SPI1 SCK | AF5, at most 10 MHz, mode 0 | gyro: SCK |
//! | PA6 | SPI1 MISO | AF5, pulled up | gyro: SDO2 |
//! | PA7 | SPI1 MOSI | AF5 | gyro: SDI |
//! | PC4 | EXTI4, rising edge | pulled down | gyro: data ready (BMI088 INT3, active high) |
//! | PA0, PA1 | TIM2 CH1, CH2 | AF1, pulled up | wheels 1 and 2: channel A of the sensor |
//! | PB10, PB11 | TIM2 CH3, CH4 | AF1, pulled up | wheels 3 and 4: channel A |
//! | PC0 to PC3 | input | pulled up | wheels 1 to 4: channel B, a quarter behind A |
//! | PA2, PA3 | USART2 TX, RX | AF7, 115200 baud 8N1 | only for the processor in the loop |
//! | PA13, PA14 | SWD | as after reset | debug probe |
//!
//! # Files
//!
//! [`rates`] is arithmetic, [`clocks`] the clock tree, [`pins`] this table in registers, then one
//! file for each peripheral. TIM5 is the clock ([`time`]), TIM2 times the wheels.
//!
//! # Rules that all files keep
//!
//! - No wait without a bound. QEMU reads most registers as 0, and so may a chip that is dying.
//! - What an interrupt shares with the loop is in a critical section's mutex.
//! - A peripheral is awake two cycles after its enable bit is set (device errata ES0182, "delay
//!   after an RCC peripheral clock enabling"): reading the register back takes longer than that.
//! - All rates follow from the clocks in force, and each file that has one can
//!   `follow_clocks` when they change in flight.

pub mod captures;
pub mod clocks;
pub mod data_ready;
pub mod flash;
pub mod pins;
mod rates;
mod reset;
pub mod services;
pub mod spi;
pub mod time;
pub mod usart;
pub mod watchdog;

pub use captures::{CaptureInputs, EdgesLost, WheelCaptures};
pub use clocks::ClockFault;
pub use data_ready::GyroDataReady;
pub use flash::{CheckpointFlash, FlashFault};
pub use rates::{ClockSource, Clocks};
pub use reset::ResetCause;
pub use services::Services;
pub use spi::{GyroBus, SpiFault};
pub use time::{Delay, now_us};
pub use usart::{Link, SerialCounters, Tunnel};
pub use watchdog::Watchdog;

use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use stm32f4::stm32f405::{Interrupt, Peripherals};

/// The interrupts that are served, and their levels: 0 is the most urgent of 16. A stamp must not
/// wait; an edge may until its wheel's next one; a byte for 87 µs.
const INTERRUPTS: [(Interrupt, u8); 4] =
    [(Interrupt::EXTI4, 0), (Interrupt::TIM2, 1), (Interrupt::USART1, 2), (Interrupt::USART2, 2)];

/// The level of PendSV, below all interrupts: see `data_ready.rs`.
const LOWEST_LEVEL: u8 = 15;

/// The chip implements the upper four of a priority's eight bits.
const PRIORITY_SHIFT: u8 = 4;

/// What the board found when it came up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub struct BoardReport {
    /// Why the chip was reset.
    pub reset_cause: ResetCause,
    /// What the clocks come from now.
    pub clock_source: ClockSource,
    /// Why that isn't the crystal, if so.
    pub clock_fault: Option<ClockFault>,
}

/// What the board offers to an image.
pub struct Board {
    /// The serial port of telemetry and commands.
    pub link: Link,
    /// The serial port of the processor in the loop.
    pub tunnel: Tunnel,
    /// The bus of the gyro.
    pub gyro_bus: GyroBus,
    /// The gyro's data-ready line.
    pub data_ready: GyroDataReady,
    /// The wheels' sensors, not yet started.
    pub captures: CaptureInputs,
    /// The flash for checkpoints.
    pub flash: CheckpointFlash,
    /// The watchdog, not yet started.
    pub watchdog: Watchdog,
    /// The core's timer, free for measurements.
    pub syst: SYST,
    reset_cause: ResetCause,
}

impl Board {
    /// Brings the board up; `None` if that has been done before.
    pub fn take() -> Option<Self> {
        let chip = Peripherals::take()?;
        let mut core = cortex_m::Peripherals::take()?;

        let reset_cause = reset::take_cause(&chip.RCC);
        let clocks = clocks::start(&chip.RCC, &chip.PWR, &chip.FLASH);
        chip.RCC.apb1enr().modify(|_, w| w.usart2en().enabled());
        chip.RCC
            .apb2enr()
            .modify(|_, w| w.usart1en().enabled().spi1en().enabled().syscfgen().enabled());
        let _ = chip.RCC.apb2enr().read();
        let (chip_select, levels) = pins::set_up(&chip.RCC, chip.GPIOA, chip.GPIOB, chip.GPIOC);

        time::start(chip.TIM5, &chip.RCC, &clocks);
        let (link, tunnel) = usart::open(chip.USART1, chip.USART2, &clocks);
        let board = Self {
            link,
            tunnel,
            gyro_bus: spi::open(chip.SPI1, chip_select, &clocks),
            data_ready: data_ready::open(chip.EXTI, &chip.SYSCFG),
            captures: CaptureInputs::new(chip.TIM2, levels, &chip.RCC, &clocks),
            flash: CheckpointFlash::new(chip.FLASH),
            watchdog: Watchdog::new(chip.IWDG, &chip.DBGMCU),
            syst: core.SYST,
            reset_cause,
        };
        serve_interrupts(&mut core.NVIC, &mut core.SCB);
        Some(board)
    }

    /// What the board found, and what its clocks are now.
    pub fn report(&self) -> BoardReport {
        BoardReport {
            reset_cause: self.reset_cause,
            clock_source: clocks::in_force().source,
            clock_fault: clocks::fault(),
        }
    }
}

/// Lets the interrupts in, now that all that they need is in place.
fn serve_interrupts(nvic: &mut NVIC, scb: &mut SCB) {
    // SAFETY: as below.
    #[allow(unsafe_code, reason = "can break critical sections that are built on priorities")]
    unsafe {
        scb.set_priority(SystemHandler::PendSV, LOWEST_LEVEL << PRIORITY_SHIFT);
    }
    for (interrupt, level) in INTERRUPTS {
        // SAFETY: no critical section is built on priorities or masks of single interrupts.
        #[allow(unsafe_code, reason = "both can break such critical sections")]
        unsafe {
            nvic.set_priority(interrupt, level << PRIORITY_SHIFT);
            NVIC::unmask(interrupt);
        }
    }
}

/// Sets every rate anew. Called by the non-maskable interrupt when the clocks have changed.
fn follow_clocks(chip: &Peripherals, clocks: &Clocks) {
    time::follow_clocks(&chip.TIM5, clocks);
    captures::follow_clocks(&chip.TIM2, clocks);
    usart::follow_clocks(&chip.USART1, &chip.USART2, clocks);
    spi::follow_clocks(&chip.SPI1, clocks);
}
