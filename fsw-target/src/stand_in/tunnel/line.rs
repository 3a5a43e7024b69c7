//! Requests and replies: each request is answered by its reply, or the tunnel ends.

use super::message::{
    FAILED, HARDWARE, HELLO, IDLE, Message, NEXT, NEXT_WITH_TORQUE, NO, SOURCES, VERSION,
};
use super::setup::{Setup, Stated};
use crate::link::frame::{FrameReceiver, MAX_FRAME, MAX_PACKET};
use crate::link::wire::{Reader, Unreadable, Wire, Writer};
use core::cell::{Cell, RefCell};
use embedded_hal::spi;
use embedded_hal_nb::nb;
use embedded_hal_nb::serial::{Read, Write};
use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind};

/// Attempts to send or receive a byte before the simulator counts as silent: one minute at 168 MHz and
/// twenty cycles each, longer in an emulator or with a port that sleeps. The simulator takes milliseconds.
const ATTEMPTS: u32 = 500_000_000;

/// Serial port to the simulator.
pub trait Port: Read<u8> + Write<u8> {
    /// [`Read::read`], which may sleep until the next interrupt if there is no byte.
    fn listen(&mut self) -> nb::Result<u8, Self::Error> {
        self.read()
    }
}

/// Reason for a missing reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum TunnelError {
    /// The simulator no longer receives or sends.
    Silent,
    /// The received message is no reply to the request.
    Garbled,
    /// The request cannot be fulfilled: bus error, address outside the flash, or end of the flight.
    No,
    /// Too many bytes for a message, or an operation outside the protocol.
    NotTunnelled,
}

impl spi::Error for TunnelError {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl NorFlashError for TunnelError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::No => NorFlashErrorKind::OutOfBounds,
            Self::Silent | Self::Garbled | Self::NotTunnelled => NorFlashErrorKind::Other,
        }
    }
}

/// The line to the simulator, with the received data that several parts share.
#[derive(Debug)]
pub struct Tunnel<P> {
    line: RefCell<Line<P>>,
    now_us: Cell<u64>,
    torque_n_m: Cell<[f32; 3]>,
    /// No sample is requested while telemetry is pending.
    is_paused: Cell<bool>,
    end: Cell<Option<TunnelError>>,
}

#[derive(Debug)]
struct Line<P> {
    port: P,
    frames: FrameReceiver<MAX_PACKET>,
}

impl<P: Port> Tunnel<P> {
    /// A tunnel through this port.
    pub fn new(port: P) -> Self {
        Self {
            line: RefCell::new(Line { port, frames: FrameReceiver::new() }),
            now_us: Cell::new(0),
            torque_n_m: Cell::new([0.0; 3]),
            is_paused: Cell::new(false),
            end: Cell::new(None),
        }
    }

    /// Requests the spacecraft data. The first request.
    ///
    /// # Errors
    /// See [`TunnelError`].
    pub fn hello(&self) -> Result<Setup, TunnelError> {
        let version = |fields: &mut Writer<'_>| {
            fields.put(&[VERSION]);
            SOURCES.put(fields);
        };
        let setup = self.request(HELLO, version, Setup::take)?;
        self.now_us.set(setup.now_us);
        Ok(setup)
    }

    /// Requests the stated errors of the hardware.
    ///
    /// # Errors
    /// See [`TunnelError`].
    pub fn hardware(&self) -> Result<Stated, TunnelError> {
        self.request(HARDWARE, |_| (), Stated::take)
    }

    /// Sends the reason why the flight computer stops.
    ///
    /// # Errors
    /// [`TunnelError::Silent`].
    pub fn report_failure(&self, reason: &str) -> Result<(), TunnelError> {
        let mut line = self.line.try_borrow_mut().map_err(|_| TunnelError::NotTunnelled)?;
        line.send(FAILED, &|fields| fields.put(reason.as_bytes()))
    }

    /// Pauses or resumes the requests of samples.
    pub fn pause(&self, is_paused: bool) {
        self.is_paused.set(is_paused);
    }

    /// Reason for the end of samples: [`TunnelError::No`] at the end of the flight.
    pub fn end(&self) -> Option<TunnelError> {
        self.end.get()
    }

    /// Time of the last sample, µs; constant between samples.
    pub fn now_us(&self) -> u64 {
        self.now_us.get()
    }

    /// External torque at the last sample, body axes, N m.
    pub fn torque_n_m(&self) -> [f32; 3] {
        self.torque_n_m.get()
    }

    /// Requests the next sample and returns its time stamp, µs; `None` if there is none now.
    pub(super) fn next(&self) -> Option<u64> {
        if self.is_paused.get() || self.end.get().is_some() {
            return None;
        }
        let announced = self.exchange(NEXT, |_| (), announced);
        match announced {
            Ok(None) => None,
            Ok(Some((elapsed_us, torque_n_m))) => {
                let now_us = self.now_us.get().saturating_add(u64::from(elapsed_us));
                self.now_us.set(now_us);
                if let Some(torque_n_m) = torque_n_m {
                    self.torque_n_m.set(torque_n_m);
                }
                Some(now_us)
            }
            Err(error) => {
                self.end.set(Some(error));
                None
            }
        }
    }

    /// Sends a request and reads the fields of its reply.
    pub(super) fn request<R>(
        &self,
        kind: u8,
        fields: impl Fn(&mut Writer<'_>),
        take: impl FnOnce(&mut Reader<'_>) -> Result<R, Unreadable>,
    ) -> Result<R, TunnelError> {
        self.exchange(kind, fields, |answered, fields| match answered {
            _ if answered == kind => take(fields).map_err(|_| TunnelError::Garbled),
            _ => Err(TunnelError::Garbled),
        })
    }

    fn exchange<R>(
        &self,
        kind: u8,
        fields: impl Fn(&mut Writer<'_>),
        take: impl FnOnce(u8, &mut Reader<'_>) -> Result<R, TunnelError>,
    ) -> Result<R, TunnelError> {
        let mut line = self.line.try_borrow_mut().map_err(|_| TunnelError::NotTunnelled)?;
        line.send(kind, &fields)?;
        line.receive(|packet| {
            let (answered, mut fields) = Message::open(packet).ok_or(TunnelError::Garbled)?;
            if answered == NO {
                return Err(TunnelError::No);
            }
            take(answered, &mut fields)
        })
    }
}

/// Reply to [`NEXT`]: time since the last sample, µs, and a new external torque, N m.
type Announced = Option<(u32, Option<[f32; 3]>)>;

fn announced(kind: u8, fields: &mut Reader<'_>) -> Result<Announced, TunnelError> {
    let garbled = |_: Unreadable| TunnelError::Garbled;
    if kind == IDLE {
        return Ok(None);
    }
    let elapsed_us = Wire::take(fields).map_err(garbled)?;
    let torque_n_m = match kind {
        NEXT => None,
        NEXT_WITH_TORQUE => Some(Wire::take(fields).map_err(garbled)?),
        _ => return Err(TunnelError::Garbled),
    };
    Ok(Some((elapsed_us, torque_n_m)))
}

impl<P: Port> Line<P> {
    // Not inlined: message and frame take half a kilobyte of the stack, which is released before the
    // reply is read.
    #[inline(never)]
    fn send(&mut self, kind: u8, fields: &dyn Fn(&mut Writer<'_>)) -> Result<(), TunnelError> {
        let message = Message::new(kind, fields);
        let Some(frame) = message.frame() else { return Err(TunnelError::NotTunnelled) };
        for byte in frame.bytes() {
            repeat(|| self.port.write(*byte))?;
        }
        Ok(())
    }

    fn receive<R>(
        &mut self,
        take: impl FnOnce(&[u8]) -> Result<R, TunnelError>,
    ) -> Result<R, TunnelError> {
        // A reply is one frame: bounds the time on a noisy line.
        for _ in 0..MAX_FRAME {
            let byte = repeat(|| self.port.listen())?;
            if let Some(found) = self.frames.push(byte) {
                return found.map_err(|_| TunnelError::Garbled).and_then(take);
            }
        }
        Err(TunnelError::Garbled)
    }
}

/// Repeats an attempt until it succeeds, up to [`ATTEMPTS`].
fn repeat<R, E>(mut attempt: impl FnMut() -> nb::Result<R, E>) -> Result<R, TunnelError> {
    for _ in 0..ATTEMPTS {
        match attempt() {
            Ok(done) => return Ok(done),
            Err(nb::Error::WouldBlock) => {}
            Err(nb::Error::Other(_)) => return Err(TunnelError::Garbled),
        }
    }
    Err(TunnelError::Silent)
}
