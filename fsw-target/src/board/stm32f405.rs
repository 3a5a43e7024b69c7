//! Bring-up of the STM32F405 (Cortex-M4F), as far as it is needed now: the log's serial port.
//!
//! | pin | function | setting |
//! |---|---|---|
//! | PA9 | USART1 TX, the log | AF7, 115200 baud, 8N1 |
//!
//! The core stays on the internal 16 MHz oscillator (HSI) that it runs on after reset. Nothing
//! here waits without a bound: QEMU doesn't model the clock unit (it reads 0), and a flight board
//! may not hang on a crystal that is dead.
//!
//! Registers: RM0090, chapters 7 (RCC of the STM32F405), 8 (GPIO) and 30 (USART).

use stm32f4::stm32f405::{GPIOA, Peripherals, RCC, USART1};

/// Clock of the core and of all buses after reset, Hz.
const HSI_HZ: u32 = 16_000_000;

/// Baud rate of the log.
const LOG_BAUD: u32 = 115_200;

/// USART1 bit time in sixteenths: with oversampling by 16, BRR is clock / baud, here rounded
/// (138.9 to 139, 0.1 % slow).
const LOG_BRR: u32 = (HSI_HZ + LOG_BAUD / 2) / LOG_BAUD;

/// How often the transmit register is polled before a byte is given up. A byte takes 1390 cycles
/// and a poll at least four, so this is more than ten bytes' time: the port is dead.
const TRANSMIT_POLLS: u32 = 4_000;

/// What the board offers to an image.
pub struct Board {
    /// Where the log goes, besides the debug probe.
    pub log_port: LogPort,
}

impl Board {
    /// Brings the board up; `None` if that has been done before.
    pub fn take() -> Option<Self> {
        let chip = Peripherals::take()?;
        Some(Self { log_port: LogPort::new(chip.USART1, &chip.GPIOA, &chip.RCC) })
    }
}

/// USART1, transmit only.
pub struct LogPort {
    usart: USART1,
}

impl LogPort {
    fn new(usart: USART1, gpioa: &GPIOA, rcc: &RCC) -> Self {
        rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled());
        rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
        // The clock reaches a peripheral two cycles after its enable bit (device errata, "delay
        // after an RCC peripheral clock enabling"): reading back takes longer than that.
        let _ = rcc.apb2enr().read();

        gpioa.afrh().modify(|_, w| w.afrh9().af7());
        gpioa.moder().modify(|_, w| w.moder9().alternate());

        usart.brr().write(|w| {
            w.div_mantissa().set((LOG_BRR >> 4) as u16).div_fraction().set((LOG_BRR & 0xf) as u8)
        });
        usart.cr1().write(|w| w.ue().enabled().te().enabled());
        Self { usart }
    }

    /// Sends one byte, or drops it if the port takes none in [`TRANSMIT_POLLS`] polls.
    pub fn send(&mut self, byte: u8) {
        for _ in 0..TRANSMIT_POLLS {
            if self.usart.sr().read().txe().bit_is_set() {
                self.usart.dr().write(|w| w.dr().set(u16::from(byte)));
                return;
            }
        }
    }
}
