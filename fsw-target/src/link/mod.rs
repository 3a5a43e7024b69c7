//! Telemetry and telecommands: CCSDS space packets over a serial line.
//!
//! ```text
//!  commands    bytes -> frame (COBS) -> packet (CCSDS, CRC-16) -> command -> in sequence? -> Command
//!  telemetry   report -> packet -> frame -> queue -> bytes
//! ```
//!
//! 1. [`frame`]: packets between zeros on a line of bytes.
//! 2. [`packet`]: who sends what, in which order, and a checksum.
//! 3. [`command`]: what the ground may ask for. [`uplink`]: what of it is new and in range.
//! 4. [`telemetry`]: what the ground is told. [`downlink`]: in which order, and what if the line is
//!    slow.
//! 5. [`wire`]: single values as bytes, the same list for writer, reader and documentation.
//!
//! The ground uses the same code: [`Command::packet`] and [`frame::Frame`] make what
//! [`Uplink`] takes, and [`Receiver`] reads what [`Downlink`] sends.
//!
//! What follows is all that a ground station needs to know.
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

/// The ground's end of the downlink.
#[derive(Debug, Default)]
pub struct Receiver {
    frames: FrameReceiver<MAX_PACKET>,
}

/// Why bytes from the line are no telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiveError {
    /// No frame.
    Frame(FrameError),
    /// A frame, but no telemetry packet in it.
    Packet(TelemetryError),
}

impl fmt::Display for ReceiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(FrameError::Truncated) => {
                f.write_str("the frame ends before it is complete, or isn't COBS")
            }
            Self::Frame(FrameError::Oversized) => {
                write!(f, "more than {MAX_PACKET} bytes without a zero between frames")
            }
            Self::Packet(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for ReceiveError {}

impl Receiver {
    /// Takes the next byte. Where it ends a packet, the packet; where something is wrong, what.
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, ReceiveError>> {
        let packet = self.frames.push(byte)?.map_err(ReceiveError::Frame);
        Some(packet.and_then(|packet| Telemetry::decode(packet).map_err(ReceiveError::Packet)))
    }
}
