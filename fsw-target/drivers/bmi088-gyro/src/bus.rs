//! 8-bit registers behind SPI or I²C.
//!
//! A driver reads and writes registers through [`RegisterBus`], independent of the bus. Bus errors
//! pass through unchanged.

use embedded_hal::i2c::{I2c, SevenBitAddress};
use embedded_hal::spi::{Operation, SpiDevice};

/// Registers of a chip.
pub trait RegisterBus {
    /// Error of the bus.
    type Error;

    /// Reads consecutive registers from `register` upwards in one transaction, so that the bytes of
    /// one sample belong together.
    fn read(&mut self, register: u8, into: &mut [u8]) -> Result<(), Self::Error>;

    /// Writes one register.
    fn write(&mut self, register: u8, value: u8) -> Result<(), Self::Error>;
}

/// Bit 7 of the first byte on SPI: 1 for a read, 0 for a write.
const SPI_READ: u8 = 0x80;

/// Registers on SPI. The first byte is the register number with bit 7 as the read flag; data follows
/// without a dummy byte.
#[derive(Debug, Clone, Copy)]
pub struct Spi<D> {
    device: D,
}

impl<D> Spi<D> {
    /// Registers of the chip that `device` selects.
    pub fn new(device: D) -> Self {
        Self { device }
    }

    /// The SPI device.
    pub fn into_device(self) -> D {
        self.device
    }
}

impl<D: SpiDevice> RegisterBus for Spi<D> {
    type Error = D::Error;

    fn read(&mut self, register: u8, into: &mut [u8]) -> Result<(), D::Error> {
        let command = [register | SPI_READ];
        self.device.transaction(&mut [Operation::Write(&command), Operation::Read(into)])
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), D::Error> {
        self.device.write(&[register & !SPI_READ, value])
    }
}

/// Registers on I²C: the register number is written, then data is read or written.
#[derive(Debug, Clone, Copy)]
pub struct TwoWire<B> {
    bus: B,
    address: SevenBitAddress,
}

impl<B> TwoWire<B> {
    /// Registers of the chip at `address`.
    pub fn new(bus: B, address: SevenBitAddress) -> Self {
        Self { bus, address }
    }
}

impl<B: I2c> RegisterBus for TwoWire<B> {
    type Error = B::Error;

    fn read(&mut self, register: u8, into: &mut [u8]) -> Result<(), B::Error> {
        self.bus.write_read(self.address, &[register], into)
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), B::Error> {
        self.bus.write(self.address, &[register, value])
    }
}
