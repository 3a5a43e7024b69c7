//! The parts of a flight computer on a tunnel: each sends requests to the simulator.

use super::line::{Port, Tunnel, TunnelError};
use super::message::{
    CAPTURES, CHECKPOINT_BYTES, COUNTER_BYTES, Captures, FLASH_ERASE, FLASH_READ, FLASH_WRITE,
    MAX_TRANSFER, MOTORS, PAGE_BYTES, TRANSFER, WAIT,
};
use super::setup::{Setup, Unfit};
use crate::drivers::gyro::bmi088::Bmi088;
use crate::drivers::gyro::bus::Spi;
use crate::drivers::wheel_tach::{CaptureTimer, Captured, WheelTach};
use crate::flight::computer::{Computer, Health, Housekeeping, Parts, Reporting, Security};
use crate::flight::craft::WHEELS;
use crate::flight::flight_loop::Sensors;
use crate::flight::manoeuvre::Manoeuvre;
use crate::flight::selected::SelectedEstimator;
use crate::flight::sensors::{DataReady, MotorTorque, TorqueCommand, WheelMotors};
use crate::flight::supervisor::FeedPermit;
use crate::link::telemetry::{BrownOutLevel, ClockSource, ResetCause};
use crate::link::wire::{Unreadable, Wire, Writer};
use crate::runtime::failure::LastRun;
use core::marker::PhantomData;
use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorType as SpiErrorType, Operation, SpiDevice};
use embedded_hal_nb::serial::{Read, Write};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use fsw_core::Vec3;

/// Health in place of a board's: equal on processor and host, except for the stack.
pub const HEALTH: Health = Health {
    reset_cause: ResetCause::Unknown,
    clock: ClockSource::Internal,
    watchdog: false,
    brown_out: BrownOutLevel::Unknown,
    option_bytes_as_set: false,
    supply_low: false,
    stack_high_water_bytes: 0,
    serial_errors: 0,
    last_run: LastRun { failure: None, failures: 0, short_lives: 0 },
};

/// Parts of a flight computer with a tunnel on port `P` and the link `L`.
#[derive(Debug, Clone, Copy)]
pub struct Tunnelled<'a, P, L>(PhantomData<(&'a P, L)>);

impl<'a, P, L> Parts for Tunnelled<'a, P, L>
where
    P: Port + 'a,
    L: Read<u8> + Write<u8>,
{
    type DataReady = Samples<'a, P>;
    type Gyro = Bmi088<Spi<Bus<'a, P>>>;
    type Wheels = WheelTach<Timer<'a, P>, WHEELS>;
    type Torque = Samples<'a, P>;
    type Link = L;
    type Flash = Flash<'a, P>;
    type CounterFlash = Flash<'a, P>;
    type Board = NoBoard<'a, P>;
}

/// The flight computer on a tunnel, before its start. Inlined, as [`Computer::new`] is.
///
/// The manoeuvre is for the wheels of the estimator's craft; `stack_high_water_bytes` measures the stack, bytes.
///
/// # Errors
/// See [`Unfit`].
#[inline(always)]
pub fn computer<'a, P, L>(
    tunnel: &'a Tunnel<P>,
    setup: &Setup,
    kept: (&'a mut SelectedEstimator, &'a mut Manoeuvre),
    link: L,
    stack_high_water_bytes: fn() -> u32,
) -> Result<Computer<'a, Tunnelled<'a, P, L>>, Unfit>
where
    P: Port,
    L: Read<u8> + Write<u8>,
{
    let timer = Timer {
        tunnel,
        ticks_per_s: setup.ticks_per_s,
        has_wheels: setup.has_wheels(),
        motor_torque_n_m: [0.0; WHEELS],
    };
    let sensors = Sensors {
        data_ready: Samples { tunnel },
        gyro: Bmi088::new(Spi::new(Bus { tunnel }), setup.gyro()?),
        wheels: setup.tachometers(timer)?,
        torque: Samples { tunnel },
    };
    let motors = Motors { tunnel, has_wheels: setup.has_wheels() };
    let board = NoBoard { clock: Bus { tunnel }, motors, stack_high_water_bytes };
    let flash = Flash { tunnel, start: 0, bytes: CHECKPOINT_BYTES };
    let counters = Flash { tunnel, start: CHECKPOINT_BYTES, bytes: COUNTER_BYTES };
    let security = Security { flash: counters, master: setup.master_key() };
    let reporting = Reporting::EachSample;
    Ok(Computer::new(kept, sensors, link, flash, security, board, reporting))
}

/// Time stamps and external torque of the samples.
#[derive(Debug)]
pub struct Samples<'a, P> {
    tunnel: &'a Tunnel<P>,
}

impl<P: Port> DataReady for Samples<'_, P> {
    /// Requests the next sample, and blocks for the reply.
    fn take_us(&mut self) -> Option<u64> {
        self.tunnel.next()
    }

    fn has_newer(&mut self) -> bool {
        false
    }

    /// No effect: no sample is pending.
    fn discard(&mut self) {}

    fn overruns(&self) -> u32 {
        0
    }
}

impl<P: Port> TorqueCommand for Samples<'_, P> {
    fn torque_n_m(&mut self) -> Vec3<f32> {
        Vec3::from(self.tunnel.torque_n_m())
    }

    /// No effect: the simulator determines the torque.
    fn command(&mut self, _: Vec3<f32>) {}
}

/// Bus of the gyro, and delays of its driver.
#[derive(Debug)]
pub struct Bus<'a, P> {
    tunnel: &'a Tunnel<P>,
}

impl<P> SpiErrorType for Bus<'_, P> {
    type Error = TunnelError;
}

impl<P: Port> SpiDevice for Bus<'_, P> {
    /// Writes, then at most one read: the transactions of register drivers.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), TunnelError> {
        let mut bytes = [0; MAX_TRANSFER];
        let mut writer = Writer::new(&mut bytes);
        let mut into: &mut [u8] = &mut [];
        for operation in operations {
            match operation {
                Operation::Write(data) if into.is_empty() => writer.put(data),
                Operation::Read(buffer) if into.is_empty() => into = buffer,
                _ => return Err(TunnelError::NotTunnelled),
            }
        }
        let length = writer.finish().ok_or(TunnelError::NotTunnelled)?;
        let written = bytes.get(..length).unwrap_or_default();
        let read = u8::try_from(into.len()).map_err(|_| TunnelError::NotTunnelled)?;
        let fields = |fields: &mut Writer<'_>| {
            fields.put(&[read]);
            fields.put(written);
        };
        self.tunnel.request(TRANSFER, fields, |reply| fill(into, reply))
    }
}

/// Fills the buffer from the reply, which must have the same length.
fn fill(into: &mut [u8], reply: &mut crate::link::wire::Reader<'_>) -> Result<(), Unreadable> {
    for byte in into {
        let [value] = reply.take::<1>()?;
        *byte = value;
    }
    reply.end()
}

impl<P: Port> DelayNs for Bus<'_, P> {
    /// Returns at once after an error, which the next transaction reports.
    fn delay_ns(&mut self, ns: u32) {
        let _ = self.tunnel.request(WAIT, |fields| ns.div_ceil(1000).put(fields), |_| Ok(()));
    }
}

/// Wheel timer. Without wheels it sends no request and returns zeros.
#[derive(Debug)]
pub struct Timer<'a, P> {
    tunnel: &'a Tunnel<P>,
    ticks_per_s: u32,
    has_wheels: bool,
    /// Of the last captures, N m.
    motor_torque_n_m: [f32; WHEELS],
}

impl<P: Port> CaptureTimer<WHEELS> for Timer<'_, P> {
    type Error = TunnelError;

    fn ticks_per_s(&self) -> u32 {
        self.ticks_per_s
    }

    fn captured(&mut self) -> Result<[Captured; WHEELS], TunnelError> {
        if !self.has_wheels {
            return Ok([Captured::default(); WHEELS]);
        }
        let captures = self.tunnel.request(CAPTURES, |_| (), Captures::take)?;
        self.motor_torque_n_m = captures.motor_torque_n_m;
        Ok(captures.of_wheels())
    }
}

impl<P: Port> MotorTorque<WHEELS> for Timer<'_, P> {
    fn motor_torque_n_m(&mut self) -> [Option<f32>; WHEELS] {
        self.motor_torque_n_m.map(Some)
    }
}

/// Motors of the simulated wheels. Without wheels there is no request.
#[derive(Debug)]
pub struct Motors<'a, P> {
    tunnel: &'a Tunnel<P>,
    has_wheels: bool,
}

impl<P: Port> WheelMotors<WHEELS> for Motors<'_, P> {
    fn set_torque_n_m(&mut self, torque_n_m: &[f32; WHEELS]) -> bool {
        let put = |fields: &mut Writer<'_>| torque_n_m.put(fields);
        self.has_wheels && self.tunnel.request(MOTORS, put, |reply| reply.end()).is_ok()
    }
}

/// A region of the flash.
#[derive(Debug)]
pub struct Flash<'a, P> {
    tunnel: &'a Tunnel<P>,
    /// Offset of the region in the simulator's flash.
    start: u32,
    /// Size of the region.
    bytes: u32,
}

impl<P> ErrorType for Flash<'_, P> {
    type Error = TunnelError;
}

impl<P: Port> ReadNorFlash for Flash<'_, P> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), TunnelError> {
        let mut offset = self.start.saturating_add(offset);
        for part in bytes.chunks_mut(MAX_TRANSFER) {
            let length = part.len() as u8;
            let fields = |fields: &mut Writer<'_>| {
                offset.put(fields);
                fields.put(&[length]);
            };
            self.tunnel.request(FLASH_READ, fields, |reply| fill(part, reply))?;
            offset = offset.saturating_add(u32::from(length));
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes as usize
    }
}

impl<P: Port> NorFlash for Flash<'_, P> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), TunnelError> {
        let pages = [from, to].map(|offset| self.start.saturating_add(offset));
        self.tunnel.request(FLASH_ERASE, |fields| pages.put(fields), |reply| reply.end())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), TunnelError> {
        let mut offset = self.start.saturating_add(offset);
        for part in bytes.chunks(MAX_TRANSFER) {
            let fields = |fields: &mut Writer<'_>| {
                offset.put(fields);
                fields.put(part);
            };
            self.tunnel.request(FLASH_WRITE, fields, |reply| reply.end())?;
            offset = offset.saturating_add(part.len() as u32);
        }
        Ok(())
    }
}

/// Services in place of a board's: the clock of the samples, the stack measurement, no watchdog.
#[derive(Debug)]
pub struct NoBoard<'a, P> {
    clock: Bus<'a, P>,
    motors: Motors<'a, P>,
    stack_high_water_bytes: fn() -> u32,
}

impl<'a, P: Port> Housekeeping for NoBoard<'a, P> {
    type Delay = Bus<'a, P>;
    type Motors = Motors<'a, P>;

    fn now_us(&mut self) -> u64 {
        self.clock.tunnel.now_us()
    }

    /// No effect: the clock of the simulator runs independently of the computer.
    fn resume_at(&mut self, _: u64) {}

    fn delay(&mut self) -> &mut Bus<'a, P> {
        &mut self.clock
    }

    fn motors(&mut self) -> &mut Motors<'a, P> {
        &mut self.motors
    }

    fn feed(&mut self, _: FeedPermit) {}

    fn health(&mut self) -> Health {
        Health { stack_high_water_bytes: (self.stack_high_water_bytes)(), ..HEALTH }
    }
}
