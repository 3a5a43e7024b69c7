//! The board: an STM32F405RG (Cortex-M4F, LQFP64) with an 8 MHz crystal, a rate gyro on SPI and
//! four wheels.
//!
//! # Wiring
//!
//! | pin | function | setting | to |
//! |---|---|---|---|
//! | PH0, PH1 | HSE | 8 MHz crystal | |
//! | PA9 | USART1 TX | AF7, 115200 baud 8N1 | ground: telemetry; log of images without telemetry |
//! | PA10 | USART1 RX | AF7, pulled up | ground: telecommands |
//! | PA4 | output | idles high | gyro: chip select (BMI088 CSB2) |
//! | ground | | | BMI088 PS: selects SPI |
//! | VDDIO | | | BMI088 CSB1: the accelerometer stays off the bus |
//! | PA5 | SPI1 SCK | AF5, at most 10 MHz, mode 0 | gyro: SCK |
//! | PA6 | SPI1 MISO | AF5, pulled up | gyro: SDO2 |
//! | PA7 | SPI1 MOSI | AF5 | gyro: SDI |
//! | PC4 | EXTI4, rising edge | pulled down | gyro: data ready (BMI088 INT3, active high) |
//! | PA0, PA1 | TIM2 CH1, CH2 | AF1, pulled up | wheels 1 and 2: channel A of the sensor |
//! | PB10, PB11 | TIM2 CH3, CH4 | AF1, pulled up | wheels 3 and 4: channel A |
//! | PC0 to PC3 | input | pulled up | wheels 1 to 4: channel B, a quarter behind A |
//! | PA2, PA3 | USART2 TX, RX | AF7, 115200 baud 8N1 | simulator: processor in the loop |
//! | PA13, PA14 | SWD | as after reset | debug probe |
//!
//! # Files
//!
//! [`rates`]: divider arithmetic; [`clocks`]: clock tree; [`pins`]: the wiring table in registers; then one
//! file per peripheral. TIM5 is the on-board clock ([`time`]), TIM2 captures the wheel edges.
//!
//! # Rules of all files
//!
//! - Every wait is bounded: QEMU reads most registers as 0, and a failing chip may do the same.
//! - State that an interrupt shares with the loop is in a mutex of critical sections.
//! - A peripheral is ready two cycles after its enable bit is set (device errata ES0182, "delay after an
//!   RCC peripheral clock enabling"): reading the register back takes longer.
//! - All rates are derived from the current clocks. Each file that has one sets it again in
//!   `follow_clocks`, when the clocks change in flight.

pub mod captures;
mod clock_failure;
pub mod clocks;
pub mod data_ready;
pub mod flash;
pub mod option_bytes;
pub mod pins;
mod rates;
mod reset;
pub mod services;
pub mod spi;
pub mod supply;
pub mod time;
pub mod usart;
pub mod watchdog;

pub use captures::{CaptureInputs, NotStarted, WheelCaptures};
pub use clocks::ClockFault;
pub use data_ready::GyroDataReady;
pub use flash::{FlashFault, SectorPair};
pub use option_bytes::OptionBytes;
pub use rates::{ClockSource, Clocks};
pub use reset::ResetCause;
pub use services::Services;
pub use spi::{GyroBus, SpiFault};
pub use time::{Delay, SleepTick, now_us};
pub use usart::{Link, Tunnel};
pub use watchdog::Watchdog;

use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use stm32f4::stm32f405::{Interrupt, Peripherals};

/// Enabled interrupts and their priorities: 0 is the most urgent of 16. A time stamp has no slack; an edge
/// has until the next edge of its wheel, a byte 87 µs.
const INTERRUPTS: [(Interrupt, u8); 4] =
    [(Interrupt::EXTI4, 0), (Interrupt::TIM2, 1), (Interrupt::USART1, 2), (Interrupt::USART2, 2)];

/// Priority of PendSV, below all interrupts: see `data_ready.rs`.
const LOWEST_LEVEL: u8 = 15;

/// The chip implements the upper four of a priority's eight bits.
const PRIORITY_SHIFT: u8 = 4;

/// Result of the start of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub struct BoardReport {
    /// Cause of the last reset.
    pub reset_cause: ResetCause,
    /// Clock source in use.
    pub clock_source: ClockSource,
    /// Reason for a clock source other than the crystal.
    pub clock_fault: Option<ClockFault>,
    /// Option bytes.
    pub options: OptionBytes,
}

/// Parts of the board.
pub struct Board {
    /// Serial port of telemetry and telecommands.
    pub link: Link,
    /// Serial port to the simulator of the processor in the loop.
    pub tunnel: Tunnel,
    /// SPI bus of the gyro.
    pub gyro_bus: GyroBus,
    /// Data-ready line of the gyro.
    pub data_ready: GyroDataReady,
    /// Inputs of the wheel sensors, before their start.
    pub captures: CaptureInputs,
    /// Flash of the checkpoints.
    pub flash: SectorPair,
    /// Flash of the counters of telecommands.
    pub counter_flash: SectorPair,
    /// Watchdog, before its start.
    pub watchdog: Watchdog,
    /// SysTick, free for measurements.
    pub syst: SYST,
    reset_cause: ResetCause,
    options: OptionBytes,
}

impl Board {
    /// Starts the board; `None` after the first call.
    pub fn take() -> Option<Self> {
        let chip = Peripherals::take()?;
        let mut core = cortex_m::Peripherals::take()?;

        let reset_cause = reset::take_cause(&chip.RCC);
        let options = OptionBytes::new(chip.FLASH.optcr().read().bits());
        // First: one that runs from reset on leaves 0.35 s.
        let watchdog = Watchdog::new(chip.IWDG, &chip.DBGMCU, options.has_hardware_watchdog());
        let revision = chip.DBGMCU.idcode().read().rev_id().bits();
        let clocks = clocks::start(&chip.RCC, &chip.PWR, &chip.FLASH, revision);
        supply::start(&chip.RCC, &chip.PWR);
        chip.RCC.apb1enr().modify(|_, w| w.usart2en().enabled());
        chip.RCC
            .apb2enr()
            .modify(|_, w| w.usart1en().enabled().spi1en().enabled().syscfgen().enabled());
        let _ = chip.RCC.apb2enr().read();
        let (chip_select, levels) = pins::configure(&chip.RCC, chip.GPIOA, chip.GPIOB, chip.GPIOC);

        time::start(chip.TIM5, &chip.RCC, &clocks);
        let (link, tunnel) = usart::open(chip.USART1, chip.USART2, &clocks);
        let (flash, counter_flash) = SectorPair::both(chip.FLASH);
        let board = Self {
            link,
            tunnel,
            gyro_bus: spi::open(chip.SPI1, chip_select, &clocks),
            data_ready: data_ready::open(chip.EXTI, &chip.SYSCFG),
            captures: CaptureInputs::new(chip.TIM2, levels, &chip.RCC, &clocks),
            flash,
            counter_flash,
            watchdog,
            syst: core.SYST,
            reset_cause,
            options,
        };
        enable_interrupts(&mut core.NVIC, &mut core.SCB);
        Some(board)
    }

    /// Result of the start, and the current clocks.
    pub fn report(&self) -> BoardReport {
        BoardReport {
            reset_cause: self.reset_cause,
            clock_source: clocks::in_force().source,
            clock_fault: clocks::fault(),
            options: self.options,
        }
    }
}

/// Enables the interrupts, after the state that their handlers share is in place.
fn enable_interrupts(nvic: &mut NVIC, scb: &mut SCB) {
    // SAFETY: as below.
    #[allow(unsafe_code, reason = "can break critical sections that rely on priorities")]
    unsafe {
        scb.set_priority(SystemHandler::PendSV, LOWEST_LEVEL << PRIORITY_SHIFT);
    }
    for (interrupt, level) in INTERRUPTS {
        // SAFETY: no critical section relies on priorities or masks of single interrupts.
        #[allow(unsafe_code, reason = "both can break such critical sections")]
        unsafe {
            nvic.set_priority(interrupt, level << PRIORITY_SHIFT);
            NVIC::unmask(interrupt);
        }
    }
}
