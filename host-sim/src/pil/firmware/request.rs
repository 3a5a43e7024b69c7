//! Requests of the firmware for its sensors and its flash.

use fsw_target::flight::craft::WHEELS;
use fsw_target::link::wire::{Unreadable, Wire};
use fsw_target::stand_in::tunnel::{self, Message};

use super::line::LineFailed;

/// A request of the firmware.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Craft data, at the start.
    Hello,
    /// Stated errors of the hardware, at the start.
    Hardware,
    /// Next sample.
    Next,
    /// Transaction on the gyro's bus.
    Transfer {
        /// Bytes to the chip.
        written: Vec<u8>,
        /// Number of bytes to read.
        read: u8,
    },
    /// Wait of a driver.
    Wait {
        /// Duration, µs.
        us: u32,
    },
    /// Captures of the wheels' timer.
    Captures,
    /// Torque of the wheels' motors.
    Motors {
        /// Torque of each motor on its wheel, N m.
        torque_n_m: [f32; WHEELS],
    },
    /// Read from the flash.
    FlashRead {
        /// Offset of the first byte.
        offset: u32,
        /// Number of bytes.
        length: u8,
    },
    /// Clear bits of the flash.
    FlashWrite {
        /// Offset of the first byte.
        offset: u32,
        /// Bits to keep.
        bytes: Vec<u8>,
    },
    /// Set all bits of pages of the flash.
    FlashErase {
        /// Offset of the first byte.
        from: u32,
        /// Offset after the last byte.
        to: u32,
    },
}

impl Request {
    /// Decodes a packet of the sensor tunnel.
    ///
    /// # Errors
    /// A packet that is not a request of this version and build, or an abort of the firmware.
    pub(super) fn decode(packet: &[u8]) -> Result<Self, LineFailed> {
        let (kind, mut fields) =
            Message::open(packet).ok_or(LineFailed::Malformed("wrong checksum"))?;
        let unreadable = |_: Unreadable| LineFailed::Malformed("unreadable message");
        match kind {
            tunnel::HELLO => match fields.take().map_err(unreadable)? {
                [tunnel::VERSION] => match Wire::take(&mut fields).map_err(unreadable)? {
                    tunnel::SOURCES => Ok(Self::Hello),
                    _ => Err(LineFailed::OtherSources),
                },
                [other] => Err(LineFailed::OtherVersion(other)),
            },
            tunnel::HARDWARE => Ok(Self::Hardware),
            tunnel::NEXT => Ok(Self::Next),
            tunnel::TRANSFER => {
                let [read] = fields.take().map_err(unreadable)?;
                Ok(Self::Transfer { written: fields.rest().to_vec(), read })
            }
            tunnel::WAIT => Ok(Self::Wait { us: Wire::take(&mut fields).map_err(unreadable)? }),
            tunnel::CAPTURES => Ok(Self::Captures),
            tunnel::MOTORS => {
                Ok(Self::Motors { torque_n_m: Wire::take(&mut fields).map_err(unreadable)? })
            }
            tunnel::FLASH_READ => {
                let offset = Wire::take(&mut fields).map_err(unreadable)?;
                let [length] = fields.take().map_err(unreadable)?;
                Ok(Self::FlashRead { offset, length })
            }
            tunnel::FLASH_WRITE => {
                let offset = Wire::take(&mut fields).map_err(unreadable)?;
                Ok(Self::FlashWrite { offset, bytes: fields.rest().to_vec() })
            }
            tunnel::FLASH_ERASE => {
                let [from, to] = Wire::take(&mut fields).map_err(unreadable)?;
                Ok(Self::FlashErase { from, to })
            }
            tunnel::FAILED => {
                Err(LineFailed::Aborted(String::from_utf8_lossy(fields.rest()).into_owned()))
            }
            _ => Err(LineFailed::Malformed("unknown kind")),
        }
    }
}
