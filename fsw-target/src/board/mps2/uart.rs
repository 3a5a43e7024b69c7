//! Serial ports, 115200 baud 8N1: UART0 is the link to the ground, UART1 the sensor tunnel of the processor in the
//! loop.
//!
//! Queues, counters and the traits of the ports: [`crate::runtime::serial`]. This UART reports no noise and no wrong stop
//! bit.
//!
//! Registers: DDI0479, APB UART.

use super::fpga_image::CLOCK_HZ;
use super::registers::{self, control, interrupt, state};
use crate::runtime::serial::{self, Port, Reception, SerialPort, Uart};
use crate::runtime::shared::Shared;

/// Baud rate of both ports.
const BAUD: u32 = 115_200;

/// Divider, rounded: within 0.01 % of the baud rate at 25 MHz, 0.3 % at 20 MHz.
const DIVIDER: u32 = (CLOCK_HZ + BAUD / 2) / BAUD;

/// UART `N`.
pub struct Cmsdk<const N: usize>(());

/// Port of telemetry and telecommands.
pub type Link = SerialPort<Cmsdk<0>>;
/// Port of the processor in the loop to its simulator.
pub type Tunnel = SerialPort<Cmsdk<1>>;

static LINK: Shared<Port<Cmsdk<0>>> = Shared::new();
static TUNNEL: Shared<Port<Cmsdk<1>>> = Shared::new();

/// Interrupt of UART0.
pub extern "C" fn link_received() {
    LINK.with(Port::receive);
}

/// Interrupt of UART1.
pub extern "C" fn tunnel_received() {
    TUNNEL.with(Port::receive);
}

/// Configures both UARTs. Called once, by `Board::take`.
pub(super) fn open() -> (Link, Tunnel) {
    (SerialPort::open(Cmsdk::start(), &LINK), SerialPort::open(Cmsdk::start(), &TUNNEL))
}

impl<const N: usize> Cmsdk<N> {
    fn start() -> Self {
        let uart = registers::uart::<N>();
        uart.divider.set(DIVIDER);
        uart.control.set(control::TRANSMIT | control::RECEIVE | control::RECEIVE_INTERRUPT);
        Self(())
    }
}

impl<const N: usize> Uart for Cmsdk<N> {
    fn take(&mut self) -> Reception {
        let uart = registers::uart::<N>();
        // Before the byte is read: the interrupt of the next byte stays.
        uart.interrupt.set(interrupt::RECEIVED);
        let found = uart.state.get();
        let is_overrun = found & state::RECEIVER_OVERRUN != 0;
        if is_overrun {
            uart.state.set(state::RECEIVER_OVERRUN);
        }
        let byte = (found & state::RECEIVER_FULL != 0).then(|| uart.data.get() as u8);
        Reception { byte, is_overrun, is_line_error: false }
    }

    fn send(&mut self, byte: u8) -> bool {
        let has_room = self.is_sent();
        if has_room {
            registers::uart::<N>().data.set(u32::from(byte));
        }
        has_room
    }

    fn is_sent(&mut self) -> bool {
        registers::uart::<N>().state.get() & state::TRANSMITTER_FULL == 0
    }
}

/// Attempts to send one byte of the log before it is dropped. A byte takes 2,170 cycles at 25 MHz and an attempt at
/// least ten: the limit is more than the time of ten bytes.
const ATTEMPTS: u32 = 16_000;

impl Link {
    /// Makes this port the output of the log. The function sends one byte by polling; it drops the byte if
    /// the port does not take it in [`ATTEMPTS`].
    pub fn into_log_output(self) -> fn(u8) {
        |byte| serial::log(&LINK, ATTEMPTS, byte)
    }
}
