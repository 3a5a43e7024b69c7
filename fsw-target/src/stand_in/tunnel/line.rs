//! Asking: a request goes out, and what comes back is its reply, or the tunnel has ended.

use super::{FAILED, HELLO, IDLE, Message, NEXT, NEXT_WITH_TORQUE, NO, SOURCES, Setup, VERSION};
use crate::link::frame::{FrameReceiver, MAX_FRAME, MAX_PACKET};
use crate::link::wire::{Reader, Unreadable, Wire, Writer};
use core::cell::{Cell, RefCell};
use embedded_hal::spi;
use embedded_hal_nb::nb;
use embedded_hal_nb::serial::{Read, Write};
use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind};

/// How often a byte is offered, or looked for, before the simulator is given up: a minute at 168 MHz and
/// twenty cycles each, and more than that in an emulator, or with a port that sleeps. The simulator takes
/// milliseconds.
const PATIENCE: u32 = 500_000_000;

/// A serial port to the simulator.
pub trait Port: Read<u8> + Write<u8> {
    /// Reads a byte, as [`Read::read`]; if there is none, it may sleep until something happens.
    fn listen(&mut self) -> nb::Result<u8, Self::Error> {
        self.read()
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum TunnelError {
    /// The simulator doesn't take or send any more.
    Silent,
    /// What came isn't a reply to the request.
    Garbled,
    /// The simulator says no: a bus that fails, a place that the flash hasn't, or no further sample.
    No,
    /// More bytes than a message holds, or an operation that no driver here uses.
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

/// The line to the simulator, and what several parts share of what came over it.
#[derive(Debug)]
pub struct Tunnel<P> {
    line: RefCell<Line<P>>,
    now_us: Cell<u64>,
    torque_n_m: Cell<[f32; 3]>,
    /// While the ground hasn't got all that it is to be told, no sample is asked for.
    is_held: Cell<bool>,
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
            is_held: Cell::new(false),
            end: Cell::new(None),
        }
    }

    /// What spacecraft this is. The first request.
    ///
    /// # Errors
    /// Why there is no answer.
    pub fn hello(&self) -> Result<Setup, TunnelError> {
        let introduction = |fields: &mut Writer<'_>| {
            fields.put(&[VERSION]);
            SOURCES.put(fields);
        };
        let setup = self.ask(HELLO, introduction, Setup::take)?;
        self.now_us.set(setup.now_us);
        Ok(setup)
    }

    /// Tells that the flight computer gives up, and why.
    ///
    /// # Errors
    /// [`TunnelError::Silent`].
    pub fn give_up(&self, why: &str) -> Result<(), TunnelError> {
        let mut line = self.line.try_borrow_mut().map_err(|_| TunnelError::NotTunnelled)?;
        line.send(FAILED, &|fields| fields.put(why.as_bytes()))
    }

    /// No sample is asked for while this is so.
    pub fn hold(&self, is_held: bool) {
        self.is_held.set(is_held);
    }

    /// Why there are no further samples: [`TunnelError::No`] if the flight is over.
    pub fn end(&self) -> Option<TunnelError> {
        self.end.get()
    }

    /// The time of the last sample, µs: between samples time stands still.
    pub fn now_us(&self) -> u64 {
        self.now_us.get()
    }

    /// The torque that was commanded at the last sample, body axes, N m.
    pub fn torque_n_m(&self) -> [f32; 3] {
        self.torque_n_m.get()
    }

    /// The next sample, if there is one now.
    pub(super) fn next(&self) -> Option<u64> {
        if self.is_held.get() || self.end.get().is_some() {
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

    /// Asks, and takes the reply's fields.
    pub(super) fn ask<R>(
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

/// What a reply to [`NEXT`] says: time since the last sample, and the torque where it is another one.
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
    // Not inlined: message and frame take half a kilobyte of the stack, which is free again while the reply
    // is waited for and taken.
    #[inline(never)]
    fn send(&mut self, kind: u8, fields: &dyn Fn(&mut Writer<'_>)) -> Result<(), TunnelError> {
        let message = Message::new(kind, fields);
        let Some(frame) = message.frame() else { return Err(TunnelError::NotTunnelled) };
        for byte in frame.bytes() {
            patiently(|| self.port.write(*byte))?;
        }
        Ok(())
    }

    fn receive<R>(
        &mut self,
        take: impl FnOnce(&[u8]) -> Result<R, TunnelError>,
    ) -> Result<R, TunnelError> {
        // A reply is one frame, so that noise can't be listened to without end.
        for _ in 0..MAX_FRAME {
            let byte = patiently(|| self.port.listen())?;
            if let Some(found) = self.frames.push(byte) {
                return found.map_err(|_| TunnelError::Garbled).and_then(take);
            }
        }
        Err(TunnelError::Garbled)
    }
}

/// Tries until it is done, or for too long.
fn patiently<R, E>(mut attempt: impl FnMut() -> nb::Result<R, E>) -> Result<R, TunnelError> {
    for _ in 0..PATIENCE {
        match attempt() {
            Ok(done) => return Ok(done),
            Err(nb::Error::WouldBlock) => {}
            Err(nb::Error::Other(_)) => return Err(TunnelError::Garbled),
        }
    }
    Err(TunnelError::Silent)
}
