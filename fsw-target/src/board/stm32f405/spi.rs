//! SPI1, the bus of the gyro: master, mode 0, eight bits, at most 10 MHz.
//!
//! Every wait is bounded, and bus errors are returned. After an error the peripheral is in its state after
//! start-up.
//!
//! Each byte is received before the next one is sent, so that an interrupt cannot cause an overrun. The six
//! bytes of a rate take some 15 µs.
//!
//! Registers: RM0090, chapter 28 (SPI).

use super::pins::ChipSelect;
use super::rates::{Clocks, spi_divider};
use super::time::Delay;
use crate::runtime::bounded::wait;
use embedded_hal::spi::{Error, ErrorKind, ErrorType, SpiBus};
use embedded_hal_bus::spi::ExclusiveDevice;
use stm32f4::stm32f405::{SPI1, spi1};

/// Fastest clock of the gyro, Hz (BMI088 data sheet BST-BMI088-DS001, SPI timing).
const LIMIT_HZ: u32 = 10_000_000;

/// Polls of a flag: more than the time of ten bytes. A byte takes at most 256 cycles of the core with the
/// divider of [`LIMIT_HZ`], a poll at least six.
const FLAG_POLLS: u32 = 1_000;

/// Byte sent during a read.
const FILLER: u8 = 0;

/// Error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum SpiFault {
    /// A byte was received before the previous one was read.
    Overrun,
    /// The peripheral left master mode.
    ModeFault,
    /// A byte took more than ten times its duration.
    TimedOut,
}

impl Error for SpiFault {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Overrun => ErrorKind::Overrun,
            Self::ModeFault => ErrorKind::ModeFault,
            Self::TimedOut => ErrorKind::Other,
        }
    }
}

/// SPI1.
pub struct Spi {
    spi: SPI1,
}

/// The bus with the chip select of the gyro, for its driver.
pub type GyroBus = ExclusiveDevice<Spi, ChipSelect, Delay>;

/// Configures SPI1. Its clock must be enabled and its pins configured.
pub fn open(spi: SPI1, chip_select: ChipSelect, clocks: &Clocks) -> GyroBus {
    follow_clocks(&spi, clocks);
    let Ok(bus) = ExclusiveDevice::new(Spi { spi }, chip_select, Delay);
    bus
}

/// Configures the peripheral, at start-up and after a change of the clocks.
pub fn follow_clocks(spi: &spi1::RegisterBlock, clocks: &Clocks) {
    let divider = spi_divider(clocks.apb2_hz, LIMIT_HZ);
    spi.cr1().write(|w| {
        w.cpol().idle_low().cpha().first_edge().mstr().master();
        w.ssm().enabled().ssi().slave_not_selected();
        w.br().set(divider).spe().enabled()
    });
}

impl Spi {
    /// Sends a byte and returns the received one.
    fn exchange(&mut self, byte: u8) -> Result<u8, SpiFault> {
        let received = self.try_exchange(byte);
        if received.is_err() {
            self.recover();
        }
        received
    }

    fn try_exchange(&mut self, byte: u8) -> Result<u8, SpiFault> {
        self.wait_for(|status| status.txe().bit_is_set())?;
        self.spi.dr().write(|w| w.dr().set(u16::from(byte)));
        self.wait_for(|status| status.rxne().bit_is_set())?;
        Ok(self.spi.dr().read().dr().bits() as u8)
    }

    /// Polls the status until `done`.
    ///
    /// # Errors
    /// The error of the status, or [`SpiFault::TimedOut`].
    fn wait_for(&self, done: impl Fn(&spi1::sr::R) -> bool) -> Result<(), SpiFault> {
        let mut status = self.spi.sr().read();
        let in_time = wait(FLAG_POLLS, || {
            status = self.spi.sr().read();
            done(&status) || status.ovr().bit_is_set() || status.modf().bit_is_set()
        });
        if status.ovr().bit_is_set() {
            Err(SpiFault::Overrun)
        } else if status.modf().bit_is_set() {
            Err(SpiFault::ModeFault)
        } else {
            in_time.ok_or(SpiFault::TimedOut)
        }
    }

    /// Clears both error flags and an unread byte (section 28.3.10: reads data and status, then writes the
    /// control register), and restarts the peripheral.
    fn recover(&mut self) {
        let _ = self.spi.dr().read();
        let _ = self.spi.sr().read();
        self.spi.cr1().modify(|_, w| w.spe().disabled());
        self.spi.cr1().modify(|_, w| w.mstr().master().spe().enabled());
    }
}

impl ErrorType for Spi {
    type Error = SpiFault;
}

impl SpiBus for Spi {
    fn read(&mut self, words: &mut [u8]) -> Result<(), SpiFault> {
        words.iter_mut().try_for_each(|word| {
            *word = self.exchange(FILLER)?;
            Ok(())
        })
    }

    fn write(&mut self, words: &[u8]) -> Result<(), SpiFault> {
        words.iter().try_for_each(|&word| self.exchange(word).map(|_| ()))
    }

    fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), SpiFault> {
        let mut received = read.iter_mut();
        let mut sent = write.iter();
        loop {
            let (place, word) = (received.next(), sent.next());
            if place.is_none() && word.is_none() {
                return Ok(());
            }
            let byte = self.exchange(word.copied().unwrap_or(FILLER))?;
            if let Some(place) = place {
                *place = byte;
            }
        }
    }

    fn transfer_in_place(&mut self, words: &mut [u8]) -> Result<(), SpiFault> {
        words.iter_mut().try_for_each(|word| {
            *word = self.exchange(*word)?;
            Ok(())
        })
    }

    fn flush(&mut self) -> Result<(), SpiFault> {
        self.wait_for(|status| status.bsy().bit_is_clear())
    }
}
