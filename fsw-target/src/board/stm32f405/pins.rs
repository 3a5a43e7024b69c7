//! Pins: the wiring table of the board (`mod.rs`) in registers.
//!
//! Inputs are pulled to their idle level, so that an unconnected part is inactive: serial lines and open
//! collectors idle high, the interrupt of the gyro low.
//!
//! Registers: RM0090, chapter 8 (GPIO); alternate functions: DS8626, table 9.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use stm32f4::stm32f405::{GPIOA, GPIOB, GPIOC, RCC};

/// Chip select of the gyro, PA4.
pub struct ChipSelect {
    gpioa: GPIOA,
}

/// Levels of both channels of the wheel sensors.
pub struct TachLevels {
    gpiob: GPIOB,
    gpioc: GPIOC,
}

/// Configures all pins.
pub fn configure(rcc: &RCC, gpioa: GPIOA, gpiob: GPIOB, gpioc: GPIOC) -> (ChipSelect, TachLevels) {
    rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled().gpioben().enabled().gpiocen().enabled());
    let _ = rcc.ahb1enr().read(); // delay for the peripheral's clock, see `mod.rs`
    let mut chip_select = ChipSelect { gpioa };
    let Ok(()) = chip_select.set_high(); // before the pin is an output: no edge
    configure_port_a(&chip_select.gpioa);
    configure_port_b(&gpiob);
    configure_port_c(&gpioc);
    (chip_select, TachLevels { gpiob, gpioc })
}

fn configure_port_a(gpioa: &GPIOA) {
    gpioa.pupdr().modify(|_, w| {
        w.pupdr0().pull_up().pupdr1().pull_up(); // tachometers 1 and 2
        w.pupdr3().pull_up().pupdr10().pull_up(); // serial lines
        w.pupdr6().pull_up() // MISO
    });
    gpioa.ospeedr().modify(|_, w| w.ospeedr5().high_speed().ospeedr7().high_speed());
    gpioa.afrl().modify(|_, w| {
        w.afrl0().af1().afrl1().af1(); // TIM2
        w.afrl2().af7().afrl3().af7(); // USART2
        w.afrl5().af5().afrl6().af5().afrl7().af5() // SPI1
    });
    gpioa.afrh().modify(|_, w| w.afrh9().af7().afrh10().af7()); // USART1
    gpioa.moder().modify(|_, w| {
        w.moder0().alternate().moder1().alternate().moder2().alternate().moder3().alternate();
        w.moder4().output();
        w.moder5().alternate().moder6().alternate().moder7().alternate();
        w.moder9().alternate().moder10().alternate()
    });
}

fn configure_port_b(gpiob: &GPIOB) {
    gpiob.pupdr().modify(|_, w| w.pupdr10().pull_up().pupdr11().pull_up()); // tachometers 3 and 4
    gpiob.afrh().modify(|_, w| w.afrh10().af1().afrh11().af1()); // TIM2
    gpiob.moder().modify(|_, w| w.moder10().alternate().moder11().alternate());
}

fn configure_port_c(gpioc: &GPIOC) {
    // All pins are inputs after reset.
    gpioc.pupdr().modify(|_, w| {
        w.pupdr0().pull_up().pupdr1().pull_up().pupdr2().pull_up().pupdr3().pull_up();
        w.pupdr4().pull_down() // data ready
    });
}

impl ErrorType for ChipSelect {
    type Error = Infallible;
}

impl OutputPin for ChipSelect {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.gpioa.bsrr().write(|w| w.br4().set_bit());
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.gpioa.bsrr().write(|w| w.bs4().set_bit());
        Ok(())
    }
}

impl TachLevels {
    /// Levels of channels A and B of each wheel, wheel 1 first.
    pub fn read(&self) -> [(bool, bool); 4] {
        // SAFETY: reading the inputs of a port has no side effect.
        #[allow(unsafe_code, reason = "the chip select owns port A")]
        let port_a = unsafe { &*GPIOA::ptr() }.idr().read();
        let port_b = self.gpiob.idr().read();
        let port_c = self.gpioc.idr().read();
        [
            (port_a.idr0().bit(), port_c.idr0().bit()),
            (port_a.idr1().bit(), port_c.idr1().bit()),
            (port_b.idr10().bit(), port_c.idr2().bit()),
            (port_b.idr11().bit(), port_c.idr3().bit()),
        ]
    }
}
