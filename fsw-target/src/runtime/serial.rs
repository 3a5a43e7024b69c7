//! Serial ports, for any UART with an interrupt per received byte.
//!
//! The interrupt of a port queues received bytes, so that a loop that is busy for up to 22 ms at 115200 baud
//! (256 bytes) loses none. Lost bytes are counted; the CRC of the packet detects them. [`Write::write`] never
//! blocks: it accepts a byte if the transmitter is free.

use super::bounded::wait;
use super::shared::Shared;
use crate::stand_in::tunnel;
use core::convert::Infallible;
use embedded_hal_nb::nb;
use embedded_hal_nb::serial::{ErrorType, Read, Write};
use heapless::spsc::Queue;

/// Size of the receive queue, bytes: 22 ms of line time at 115200 baud, less one free place.
const RECEIVED: usize = 256;

/// Bytes lost by a port since start-up; each count saturates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, defmt::Format)]
pub struct SerialCounters {
    /// Bytes lost to a late interrupt or a late loop.
    pub overruns: u32,
    /// Bytes discarded after noise on the line, a wrong stop bit or a break.
    pub line_errors: u32,
}

/// Reception of one byte.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reception {
    /// The byte, valid or not; `None` if there was none.
    pub byte: Option<u8>,
    /// Another byte was lost.
    pub is_overrun: bool,
    /// The byte is not valid: noise, a wrong stop bit or a break.
    pub is_line_error: bool,
}

/// Registers of a UART.
pub trait Uart: Send {
    /// Takes the received byte, and ends its interrupt.
    fn take(&mut self) -> Reception;

    /// Sends a byte; false if the transmitter is not free.
    fn send(&mut self, byte: u8) -> bool;

    /// True if all bytes have left the transmitter.
    fn is_sent(&mut self) -> bool;
}

/// A UART, with the state that its interrupt and the loop share.
pub struct Port<U> {
    uart: U,
    received: Queue<u8, RECEIVED>,
    counters: SerialCounters,
}

impl<U: Uart> Port<U> {
    /// Queues the received byte: the work of the interrupt.
    pub fn receive(&mut self) {
        let Reception { byte, is_overrun, is_line_error } = self.uart.take();
        if is_overrun {
            count(&mut self.counters.overruns);
        }
        if is_line_error {
            count(&mut self.counters.line_errors);
        } else if byte.is_some_and(|byte| self.received.enqueue(byte).is_err()) {
            count(&mut self.counters.overruns);
        }
    }
}

/// Bytes lost by the port, independent of its owner.
pub fn counters_of<U: Uart>(shared: &Shared<Port<U>>) -> SerialCounters {
    shared.with(|port| port.counters).unwrap_or_default()
}

/// A port as the loop uses it.
pub struct SerialPort<U: 'static> {
    shared: &'static Shared<Port<U>>,
}

impl<U: Uart> SerialPort<U> {
    /// Opens the port of a configured UART, whose interrupt calls [`Port::receive`] on `shared`.
    pub fn open(uart: U, shared: &'static Shared<Port<U>>) -> Self {
        shared.put(Port { uart, received: Queue::new(), counters: SerialCounters::default() });
        Self { shared }
    }

    /// Bytes lost since start-up.
    pub fn counters(&self) -> SerialCounters {
        counters_of(self.shared)
    }
}

/// Sends one byte of the log by polling, up to `attempts` times; drops it if the port does not take it.
pub fn log<U: Uart>(shared: &'static Shared<Port<U>>, attempts: u32, byte: u8) {
    let mut port = SerialPort { shared };
    let _ = wait(attempts, || port.write(byte).is_ok());
}

/// A read has no error: lost bytes are counted in [`SerialPort::counters`].
impl<U> ErrorType for SerialPort<U> {
    type Error = Infallible;
}

impl<U: Uart> Read for SerialPort<U> {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        let byte = self.shared.with(|port| port.received.dequeue()).flatten();
        byte.ok_or(nb::Error::WouldBlock)
    }
}

impl<U: Uart> Write for SerialPort<U> {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        let sent = self.shared.with(|port| port.uart.send(byte));
        if sent == Some(true) { Ok(()) } else { Err(nb::Error::WouldBlock) }
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        let sent = self.shared.with(|port| port.uart.is_sent());
        if sent == Some(false) { Err(nb::Error::WouldBlock) } else { Ok(()) }
    }
}

/// The core sleeps while it waits, so that QEMU leaves the processor of the host to the simulator.
impl<U: Uart> tunnel::Port for SerialPort<U> {
    fn listen(&mut self) -> nb::Result<u8, Infallible> {
        // An interrupt after the read ends the sleep; its handler runs once interrupts are unmasked.
        critical_section::with(|_| {
            let read = self.read();
            if read.is_err() {
                cortex_m::asm::wfi();
            }
            read
        })
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
