//! Errors of the two lines to the firmware: sensors and ground link.

use std::io;
use std::time::Duration;

use fsw_target::stand_in::tunnel;
use thiserror::Error;

/// A line to the firmware failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LineFailed {
    /// No request within the time limit.
    #[error("no request from the firmware for {} s", .0.as_secs())]
    Silent(Duration),
    /// The other end is closed.
    #[error("the connection to the firmware is closed (QEMU stopped)")]
    Ended,
    /// Bytes that are not a request.
    #[error("malformed request from the firmware: {0}")]
    Malformed(&'static str),
    /// Another version of the sensor tunnel.
    #[error(
        "the firmware has version {0} of the sensor tunnel, this program version {ours}",
        ours = tunnel::VERSION
    )]
    OtherVersion(u8),
    /// Another build.
    #[error("the image was built from other sources than this program: rebuild both")]
    OtherSources,
    /// No telemetry within the time limit.
    #[error("expected telemetry did not arrive within {} s", .0.as_secs())]
    NoTelemetry(Duration),
    /// Bytes on the ground link that are not telemetry.
    #[error("bytes on the ground link are not telemetry: {0}")]
    NotTelemetry(String),
    /// A second start of the firmware within a flight.
    #[error("the firmware restarted during the flight: it failed")]
    Restarted,
    /// The firmware aborted with this reason.
    #[error("the firmware aborted: {0}")]
    Aborted(String),
    /// Error of the socket.
    #[error("the connection to the firmware failed: {0}")]
    Socket(io::ErrorKind),
}

/// Failure of a line by the error of its socket. None if the socket has no data yet.
pub(super) fn failure(error: &io::Error) -> Option<LineFailed> {
    match error.kind() {
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted => None,
        io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => Some(LineFailed::Ended),
        kind => Some(LineFailed::Socket(kind)),
    }
}
