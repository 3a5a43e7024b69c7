//! Serial ports, 115200 baud 8N1: USART1 is the link to the ground, USART2 the sensor tunnel of the
//! processor in the loop.
//!
//! Queues, counters and the traits of the ports: [`crate::runtime::serial`].
//!
//! [`Link::into_log_output`] makes USART1 the output of the log, for images that have no telemetry.
//!
//! Registers: RM0090, chapter 30 (USART).

use super::rates::{Clocks, baud_divider};
use crate::runtime::serial::{self, Port, Reception, SerialCounters, SerialPort, Uart};
use crate::runtime::shared::Shared;
use core::ops::Deref;
use stm32f4::stm32f405::{USART1, USART2, interrupt, usart1};

/// Baud rate of both ports.
const BAUD: u32 = 115_200;

/// Owned registers of a USART.
pub trait Registers: Deref<Target = usart1::RegisterBlock> + Send {}
impl<U: Deref<Target = usart1::RegisterBlock> + Send> Registers for U {}

/// A USART.
pub struct Usart<U>(U);

static PORT_1: Shared<Port<Usart<USART1>>> = Shared::new();
static PORT_2: Shared<Port<Usart<USART2>>> = Shared::new();

#[interrupt]
fn USART1() {
    PORT_1.with(Port::receive);
}

#[interrupt]
fn USART2() {
    PORT_2.with(Port::receive);
}

impl<U: Registers> Uart for Usart<U> {
    fn take(&mut self) -> Reception {
        let status = self.0.sr().read();
        if status.rxne().bit_is_clear() && status.ore().bit_is_clear() {
            return Reception::default();
        }
        // Reading the data after the status clears the flags (section 30.6.1).
        let byte = self.0.dr().read().dr().bits() as u8;
        Reception {
            byte: status.rxne().bit_is_set().then_some(byte),
            is_overrun: status.ore().bit_is_set(), // the next byte is lost
            is_line_error: status.fe().bit_is_set() || status.nf().bit_is_set(),
        }
    }

    fn send(&mut self, byte: u8) -> bool {
        let has_room = self.0.sr().read().txe().bit_is_set();
        if has_room {
            self.0.dr().write(|w| w.dr().set(u16::from(byte)));
        }
        has_room
    }

    fn is_sent(&mut self) -> bool {
        self.0.sr().read().tc().bit_is_set()
    }
}

/// Port of telemetry and telecommands.
pub type Link = SerialPort<Usart<USART1>>;
/// Port of the processor in the loop to its simulator.
pub type Tunnel = SerialPort<Usart<USART2>>;

/// Bytes lost by [`Link`], independent of its owner.
pub fn link_counters() -> SerialCounters {
    serial::counters_of(&PORT_1)
}

/// Configures USART1 and USART2. Their clocks must be enabled and their pins configured.
pub fn open(usart_1: USART1, usart_2: USART2, clocks: &Clocks) -> (Link, Tunnel) {
    follow_clocks(&usart_1, &usart_2, clocks);
    (open_port(usart_1, &PORT_1), open_port(usart_2, &PORT_2))
}

fn open_port<U: Registers>(
    usart: U,
    shared: &'static Shared<Port<Usart<U>>>,
) -> SerialPort<Usart<U>> {
    usart.cr3().write(|w| w.eie().enabled());
    usart.cr1().write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
    SerialPort::open(Usart(usart), shared)
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

/// Attempts to send one byte before it is dropped. A byte takes 14,600 cycles at 168 MHz and an attempt
/// at least ten, so that the limit is more than the time of ten bytes: the port is dead.
const ATTEMPTS: u32 = 16_000;

impl Link {
    /// Makes this port the output of the log. The function sends one byte by polling; it drops the byte if
    /// the port does not take it in [`ATTEMPTS`].
    pub fn into_log_output(self) -> fn(u8) {
        |byte| serial::log(&PORT_1, ATTEMPTS, byte)
    }
}
