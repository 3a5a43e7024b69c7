//! Registers of eight bits behind SPI or I²C.
//!
//! A driver reads and writes registers and doesn't know which bus it is on. The bus error passes
//! through untouched.

use embedded_hal::i2c::{I2c, SevenBitAddress};
use embedded_hal::spi::{Operation, SpiDevice};

/// A chip's registers.
pub trait RegisterBus {
    /// The error of the bus.
    type Error;

    /// Reads registers from `register` upwards in one transaction: what belongs together stays
    /// together.
    fn read(&mut self, register: u8, into: &mut [u8]) -> Result<(), Self::Error>;

    /// Writes one register.
    fn write(&mut self, register: u8, value: u8) -> Result<(), Self::Error>;
}

/// Bit 7 of the first byte on SPI: read, rather than write.
const SPI_READ: u8 = 0x80;

/// Registers on SPI: the first byte is the register's number with bit 7 set to read, and data
/// follows at once, without the dummy byte that some parts send.
#[derive(Debug, Clone, Copy)]
pub struct Spi<D> {
    device: D,
}

impl<D> Spi<D> {
    /// The registers of the chip that `device` selects.
    pub fn new(device: D) -> Self {
        Self { device }
    }

    /// The device again.
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

/// Registers on I²C: the register's number is written, then data read or written.
#[derive(Debug, Clone, Copy)]
pub struct TwoWire<B> {
    bus: B,
    address: SevenBitAddress,
}

impl<B> TwoWire<B> {
    /// The registers of the chip at `address`.
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
