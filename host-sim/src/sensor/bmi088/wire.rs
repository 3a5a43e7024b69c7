//! Wires of the chip: its bus by the traits of embedded-hal, and a clock that runs while the driver
//! waits.

use std::cell::{RefCell, RefMut};
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{self, I2c, NoAcknowledgeSource};
use embedded_hal::spi::{self, Operation, SpiDevice};
use fsw_target::drivers::gyro::bmi088::I2C_ADDRESS;

use super::chip::Chip;
use super::faults::BusFault;

/// Chip on SPI. Clones share the chip.
#[derive(Clone, Debug, Default)]
pub struct Wire(Rc<RefCell<Chip>>);

impl Wire {
    /// Wires of this chip.
    pub fn to(chip: Chip) -> Self {
        Self(Rc::new(RefCell::new(chip)))
    }

    /// The chip.
    pub fn chip(&self) -> RefMut<'_, Chip> {
        self.0.borrow_mut()
    }
}

impl DelayNs for Wire {
    fn delay_ns(&mut self, ns: u32) {
        self.chip().elapse_us(u64::from(ns.div_ceil(1000)));
    }
}

impl spi::Error for BusFault {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl spi::ErrorType for Wire {
    type Error = BusFault;
}

impl SpiDevice for Wire {
    /// Half duplex only: writes first, then one read, as the chip's protocol has it.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFault> {
        let mut written = Vec::new();
        for operation in operations.iter() {
            if let Operation::Write(bytes) = operation {
                written.extend_from_slice(bytes);
            }
        }
        let mut read = operations.iter_mut().filter_map(|operation| match operation {
            Operation::Read(bytes) => Some(bytes),
            _ => None,
        });
        match read.next() {
            Some(bytes) => self.chip().spi(&written, bytes),
            None => self.chip().spi(&written, &mut []),
        }
    }
}

impl i2c::Error for BusFault {
    fn kind(&self) -> i2c::ErrorKind {
        i2c::ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown)
    }
}

/// Chip on I²C, with its pin SDO2 at ground.
#[derive(Clone, Debug, Default)]
pub struct I2cWire(pub Wire);

impl i2c::ErrorType for I2cWire {
    type Error = BusFault;
}

impl I2c for I2cWire {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [i2c::Operation<'_>],
    ) -> Result<(), BusFault> {
        let mut chip = self.0.chip();
        chip.begin()?;
        if address != I2C_ADDRESS || chip.faults.is_dead {
            return Err(BusFault);
        }
        let mut first = 0;
        for operation in operations {
            match operation {
                i2c::Operation::Write(bytes) => {
                    if let Some((register, data)) = bytes.split_first() {
                        first = *register;
                        chip.write(first, data);
                    }
                }
                i2c::Operation::Read(bytes) => chip.read(first, bytes),
            }
        }
        Ok(())
    }
}

impl DelayNs for I2cWire {
    fn delay_ns(&mut self, ns: u32) {
        self.0.delay_ns(ns);
    }
}
