//! Serial ports, 115200 baud 8N1: USART1 is the link to the ground, USART2 the sensor tunnel of the
//! processor in the loop.
//!
//! The interrupt of a port queues received bytes, so that a loop that is busy for up to 22 ms (256 bytes)
//! loses none. Lost bytes are counted; the CRC of the packet detects them. [`Write::write`] never blocks:
//! it accepts a byte if the transmitter is free.
//!
//! [`Link::into_log_output`] makes USART1 the output of the log, for images that have no telemetry.
//!
//! Registers: RM0090, chapter 30 (USART).

use super::clocks::wait;
use super::rates::{Clocks, baud_divider};
use crate::runtime::shared::Shared;
use crate::stand_in::tunnel;
use core::convert::Infallible;
use core::ops::Deref;
use embedded_hal_nb::nb;
use embedded_hal_nb::serial::{ErrorType, Read, Write};
use heapless::spsc::Queue;
use stm32f4::stm32f405::{USART1, USART2, interrupt, usart1};

/// Baud rate of both ports.
const BAUD: u32 = 115_200;

/// Size of the receive queue, bytes: 22 ms of line time, less one free place.
const RECEIVED: usize = 256;

/// Bytes lost by a port since start-up; each count saturates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, defmt::Format)]
pub struct SerialCounters {
    /// Bytes lost to a late interrupt or a late loop.
    pub overruns: u32,
    /// Bytes discarded after noise on the line, a wrong stop bit or a break.
    pub line_errors: u32,
}

/// Owned registers of a USART.
pub trait Registers: Deref<Target = usart1::RegisterBlock> + Send {}
impl<U: Deref<Target = usart1::RegisterBlock> + Send> Registers for U {}

/// A USART, with the state that its interrupt and the loop share.
struct Port<U> {
    usart: U,
    received: Queue<u8, RECEIVED>,
    counters: SerialCounters,
}

static PORT_1: Shared<Port<USART1>> = Shared::new();
static PORT_2: Shared<Port<USART2>> = Shared::new();

#[interrupt]
fn USART1() {
    PORT_1.with(Port::receive);
}

#[interrupt]
fn USART2() {
    PORT_2.with(Port::receive);
}

impl<U: Registers> Port<U> {
    /// Queues the received byte.
    fn receive(&mut self) {
        let status = self.usart.sr().read();
        if status.rxne().bit_is_clear() && status.ore().bit_is_clear() {
            return;
        }
        // Reading the data after the status clears the flags (section 30.6.1).
        let byte = self.usart.dr().read().dr().bits() as u8;
        if status.ore().bit_is_set() {
            // The next byte is lost.
            count(&mut self.counters.overruns);
        }
        if status.fe().bit_is_set() || status.nf().bit_is_set() {
            count(&mut self.counters.line_errors);
        } else if status.rxne().bit_is_set() && self.received.enqueue(byte).is_err() {
            count(&mut self.counters.overruns);
        }
    }
}

/// A port as the loop uses it.
pub struct SerialPort<U: 'static> {
    shared: &'static Shared<Port<U>>,
}

/// Port of telemetry and telecommands.
pub type Link = SerialPort<USART1>;
/// Port of the processor in the loop to its simulator.
pub type Tunnel = SerialPort<USART2>;

/// Bytes lost by [`Link`], independent of its owner.
pub fn link_counters() -> SerialCounters {
    PORT_1.with(|port| port.counters).unwrap_or_default()
}

/// Configures USART1 and USART2. Their clocks must be enabled and their pins configured.
pub fn open(usart_1: USART1, usart_2: USART2, clocks: &Clocks) -> (Link, Tunnel) {
    follow_clocks(&usart_1, &usart_2, clocks);
    (SerialPort::open(usart_1, &PORT_1), SerialPort::open(usart_2, &PORT_2))
}

/// Sets both baud rates, at start-up and after a change of the clocks.
pub fn follow_clocks(
    usart_1: &usart1::RegisterBlock,
    usart_2: &usart1::RegisterBlock,
    clocks: &Clocks,
) {
    for (usart, bus_hz) in [(usart_1, clocks.apb2_hz), (usart_2, clocks.apb1_hz)] {
        let divider = baud_divider(bus_hz, BAUD);
        usart.brr().write(|w| {
            w.div_mantissa().set((divider >> 4) as u16).div_fraction().set((divider & 0xf) as u8)
        });
    }
}

impl<U: Registers> SerialPort<U> {
    fn open(usart: U, shared: &'static Shared<Port<U>>) -> Self {
        usart.cr3().write(|w| w.eie().enabled());
        usart.cr1().write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
        let port = Port { usart, received: Queue::new(), counters: SerialCounters::default() };
        shared.put(port);
        Self { shared }
    }

    /// Bytes lost since start-up.
    pub fn counters(&self) -> SerialCounters {
        self.shared.with(|port| port.counters).unwrap_or_default()
    }
}

/// A read has no error: lost bytes are counted in [`SerialPort::counters`].
impl<U> ErrorType for SerialPort<U> {
    type Error = Infallible;
}

impl<U: Registers> Read for SerialPort<U> {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        let byte = self.shared.with(|port| port.received.dequeue()).flatten();
        byte.ok_or(nb::Error::WouldBlock)
    }
}

impl<U: Registers> Write for SerialPort<U> {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        let sent = self.shared.with(|port| {
            let has_room = port.usart.sr().read().txe().bit_is_set();
            if has_room {
                port.usart.dr().write(|w| w.dr().set(u16::from(byte)));
            }
            has_room
        });
        if sent == Some(true) { Ok(()) } else { Err(nb::Error::WouldBlock) }
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        let sent = self.shared.with(|port| port.usart.sr().read().tc().bit_is_set());
        if sent == Some(false) { Err(nb::Error::WouldBlock) } else { Ok(()) }
    }
}

/// The core sleeps while it waits, so that QEMU leaves the processor of the host to the simulator.
impl<U: Registers> tunnel::Port for SerialPort<U> {
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

/// Attempts to send one byte before it is dropped. A byte takes 14,600 cycles at 168 MHz and an attempt
/// at least ten, so that the limit is more than the time of ten bytes: the port is dead.
const ATTEMPTS: u32 = 16_000;

impl Link {
    /// Makes this port the output of the log. The function sends one byte by polling; it drops the byte if
    /// the port does not take it in [`ATTEMPTS`].
    pub fn into_log_output(self) -> fn(u8) {
        |byte| {
            let mut port = Self { shared: &PORT_1 };
            let _ = wait(ATTEMPTS, || port.write(byte).is_ok());
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
