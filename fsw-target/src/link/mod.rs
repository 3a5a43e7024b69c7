//! Telemetry and telecommands: CCSDS space packets over a serial line.
//!
//! ```text
//!  telecommand   bytes -> frame (COBS) -> packet (CCSDS, CRC-16) -> sequence check -> Command
//!  telemetry     report -> packet -> frame -> queue -> bytes
//! ```
//!
//! 1. [`frame`]: packets as COBS frames on a byte stream.
//! 2. [`packet`]: CCSDS space packets with a checksum.
//! 3. [`command`]: telecommands and the valid range of their arguments. [`uplink`]: the receiver.
//! 4. [`telemetry`]: reports. [`downlink`]: the transmitter with its queue.
//! 5. [`wire`]: fields as bytes, from one list for writer, reader and documentation.
//!
//! The ground uses the same code: [`Command::packet`] and [`frame::Frame`] produce the input of
//! [`Uplink`], and [`Receiver`] reads the output of [`Downlink`].
//!
//! The interface to a ground station follows.
#![doc = include_str!("link.md")]

pub mod command;
#[cfg(test)]
mod documentation;
pub mod downlink;
pub mod frame;
pub mod packet;
pub mod telemetry;
pub mod uplink;
pub mod wire;

pub use command::Command;
pub use downlink::Downlink;
pub use uplink::Uplink;

use core::fmt;
use frame::{FrameError, FrameReceiver, MAX_PACKET};
use telemetry::{Received, Telemetry, TelemetryError};

/// Receiving end of the downlink, on the ground.
#[derive(Debug, Default)]
pub struct Receiver {
    frames: FrameReceiver<MAX_PACKET>,
}

/// Reason for bytes that are not telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiveError {
    /// Not a frame.
    Frame(FrameError),
    /// A frame without a valid telemetry packet.
    Packet(TelemetryError),
}

impl fmt::Display for ReceiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(FrameError::Truncated) => f.write_str("truncated frame, or not COBS"),
            Self::Frame(FrameError::Oversized) => {
                write!(f, "frame longer than {MAX_PACKET} bytes")
            }
            Self::Packet(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for ReceiveError {}

impl Receiver {
    /// Takes the next byte. The last byte of a frame yields its packet, or the error.
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, ReceiveError>> {
        let packet = self.frames.push(byte)?.map_err(ReceiveError::Frame);
        Some(packet.and_then(|packet| Telemetry::decode(packet).map_err(ReceiveError::Packet)))
    }
}
