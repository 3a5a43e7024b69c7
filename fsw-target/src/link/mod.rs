//! Telemetry and telecommands: CCSDS space packets over a serial line.
//!
//! ```text
//!  telecommand   bytes -> frame (COBS) -> packet (CCSDS, CRC-16) -> counter, tag -> Command
//!  telemetry     report -> packet -> frame -> queue -> bytes
//! ```
//!
//! 1. [`frame`]: packets as COBS frames on a byte stream.
//! 2. [`packet`]: CCSDS space packets with a checksum.
//! 3. [`authentication`]: tags, key slots and counters.
//! 4. [`command`]: telecommands and the valid range of their arguments. [`uplink`]: the receiver.
//! 5. [`telemetry`]: reports. [`downlink`]: the transmitter with its queue.
//! 6. [`wire`]: fields as bytes, from one list for writer, reader and documentation.
//!
//! The ground uses the same code: [`Command::packet`] and [`frame::Frame`] produce the input of
//! [`Uplink`], and [`Receiver`] reads the output of [`Downlink`].
//!
//! The interface to a ground station follows.
#![doc = include_str!("link.md")]

pub mod authentication;
pub mod command;
#[cfg(test)]
mod documentation;
pub mod downlink;
pub mod frame;
#[cfg(test)]
mod ground;
pub mod packet;
pub mod telemetry;
pub mod uplink;
pub mod wire;

pub use command::Command;
pub use downlink::Downlink;
pub use uplink::Uplink;

use authentication::Key;
use core::fmt;
use frame::{FrameError, FrameReceiver, MAX_PACKET};
use telemetry::{Received, Telemetry, TelemetryError};

/// Receiving end of the downlink, on the ground.
#[derive(Debug, Default)]
pub struct Receiver {
    frames: FrameReceiver<MAX_PACKET>,
    key: Option<Key>,
}

/// Reason for bytes that are not telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiveError {
    /// Not a frame.
    Frame(FrameError),
    /// A frame without a valid telemetry packet.
    Packet(TelemetryError),
    /// An intact packet without a tag, or with a wrong one.
    NotAuthentic,
}

impl fmt::Display for ReceiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(FrameError::Truncated) => f.write_str("truncated frame, or not COBS"),
            Self::Frame(FrameError::Oversized) => {
                write!(f, "frame longer than {MAX_PACKET} bytes")
            }
            Self::Packet(why) => why.fmt(f),
            Self::NotAuthentic => f.write_str("packet without a tag of this key"),
        }
    }
}

impl core::error::Error for ReceiveError {}

impl Receiver {
    /// A receiver of packets with a tag of this key only.
    pub fn with_key(key: Key) -> Self {
        Self { key: Some(key), ..Self::default() }
    }

    /// Takes the next byte. The last byte of a frame yields its packet, or the error.
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, ReceiveError>> {
        let Self { frames, key } = self;
        let packet = frames.push(byte)?.map_err(ReceiveError::Frame);
        Some(packet.and_then(|packet| {
            let received = Telemetry::decode(packet).map_err(ReceiveError::Packet)?;
            let is_authentic =
                |key: &Key| packet::parse(packet).is_ok_and(|parsed| parsed.is_authentic(key));
            match key.as_ref().is_none_or(is_authentic) {
                true => Ok(received),
                false => Err(ReceiveError::NotAuthentic),
            }
        }))
    }
}
