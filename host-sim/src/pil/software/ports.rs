//! Connections between the flight computer on the host and its hardware.

use std::cell::{Cell, RefCell, RefMut};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal_nb::{nb, serial};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use fsw_core::Vec3;
use fsw_target::drivers::gyro::{RateGyro, StartFault};
use fsw_target::drivers::wheel_tach::{CaptureTimer, Captured};
use fsw_target::flight::computer::{Health, Housekeeping};
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::sensors::{
    DataReady, Gyro, MotorTorque, TorqueCommand, WheelMotors, WheelTachometers,
};
use fsw_target::flight::supervisor::FeedPermit;
use fsw_target::stand_in::tunnel::parts::HEALTH;

use crate::pil::flash::{FlashModel, OutOfBounds};
use crate::pil::hardware::{Hardware, START_US};
use crate::sensor::bmi088::Wire;

/// Readings of the last sample, in the units of the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Time of the sample since the start of the scenario, µs.
    pub time_us: u64,
    /// Body rate, rad/s.
    pub rate_rad_s: Vec3<f32>,
    /// Speed of each wheel, rad/s.
    pub wheel_speed_rad_s: [f32; WHEELS],
    /// Commanded torque, N m.
    pub torque_n_m: Vec3<f32>,
}

/// State shared by all ports.
pub(super) struct Shared<'a> {
    hardware: Rc<RefCell<Hardware<'a>>>,
    ticks_per_s: u32,
    /// True if the next sample may be announced.
    pub may_sample: Cell<bool>,
    /// Readings of the last sample.
    pub readings: Cell<Readings>,
    /// Bytes on the link to the computer.
    pub to_computer: RefCell<VecDeque<u8>>,
    /// Bytes on the link from the computer.
    pub from_computer: RefCell<VecDeque<u8>>,
}

/// All connections except the gyro's bus, whose clock is `wire`.
#[derive(Clone)]
pub(super) struct Ports<'a> {
    pub shared: Rc<Shared<'a>>,
    pub wire: Wire,
}

impl<'a> Ports<'a> {
    pub fn new(hardware: Rc<RefCell<Hardware<'a>>>, ticks_per_s: u32) -> Self {
        let wire = hardware.borrow().wire().clone();
        let shared = Shared {
            hardware,
            ticks_per_s,
            may_sample: Cell::new(false),
            readings: Cell::default(),
            to_computer: RefCell::default(),
            from_computer: RefCell::default(),
        };
        Self { shared: Rc::new(shared), wire }
    }

    fn flash(&self) -> RefMut<'_, FlashModel> {
        RefMut::map(self.shared.hardware.borrow_mut(), |hardware| &mut hardware.flash)
    }
}

impl DataReady for Ports<'_> {
    fn take_us(&mut self) -> Option<u64> {
        if !self.shared.may_sample.replace(false) {
            return None;
        }
        let announced = self.shared.hardware.borrow_mut().announce()?;
        let torque_n_m = Vec3::from(announced.torque_n_m);
        let time_us = announced.time_us - START_US;
        self.shared.readings.set(Readings { time_us, torque_n_m, ..Readings::default() });
        Some(announced.time_us)
    }

    /// No time passes while a sample is handled.
    fn has_newer(&mut self) -> bool {
        false
    }

    /// A sample is announced on request only: there is none to discard.
    fn discard(&mut self) {}

    fn overruns(&self) -> u32 {
        0
    }
}

impl TorqueCommand for Ports<'_> {
    fn torque_n_m(&mut self) -> Vec3<f32> {
        self.shared.readings.get().torque_n_m
    }

    /// The torque is that of the scenario.
    fn command(&mut self, _: Vec3<f32>) {}
}

impl CaptureTimer<WHEELS> for Ports<'_> {
    type Error = Infallible;

    fn ticks_per_s(&self) -> u32 {
        self.shared.ticks_per_s
    }

    fn captured(&mut self) -> Result<[Captured; WHEELS], Infallible> {
        Ok(self.shared.hardware.borrow().captured())
    }
}

impl MotorTorque<WHEELS> for Ports<'_> {
    fn motor_torque_n_m(&mut self) -> [Option<f32>; WHEELS] {
        self.shared.hardware.borrow().motor_torque_n_m().map(Some)
    }
}

impl WheelMotors<WHEELS> for Ports<'_> {
    fn set_torque_n_m(&mut self, torque_n_m: &[f32; WHEELS]) -> bool {
        self.shared.hardware.borrow_mut().command_motors(torque_n_m)
    }
}

impl serial::ErrorType for Ports<'_> {
    type Error = Infallible;
}

impl serial::Read for Ports<'_> {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        self.shared.to_computer.borrow_mut().pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl serial::Write for Ports<'_> {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        self.shared.from_computer.borrow_mut().push_back(byte);
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        Ok(())
    }
}

/// A region of the flash.
pub(super) struct Flash<'a> {
    pub ports: Ports<'a>,
    /// Offset of the region, bytes.
    pub start: u32,
    /// Size of the region, bytes.
    pub bytes: u32,
}

impl ErrorType for Flash<'_> {
    type Error = OutOfBounds;
}

impl ReadNorFlash for Flash<'_> {
    const READ_SIZE: usize = FlashModel::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfBounds> {
        self.ports.flash().read(self.start + offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.bytes as usize
    }
}

impl NorFlash for Flash<'_> {
    const WRITE_SIZE: usize = FlashModel::WRITE_SIZE;
    const ERASE_SIZE: usize = FlashModel::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfBounds> {
        self.ports.flash().erase(self.start + from, self.start + to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfBounds> {
        self.ports.flash().write(self.start + offset, bytes)
    }
}

impl Housekeeping for Ports<'_> {
    type Delay = Wire;
    type Motors = Self;

    fn now_us(&mut self) -> u64 {
        self.shared.hardware.borrow().now_us()
    }

    /// The clock of the hardware continues during a restart.
    fn resume_at(&mut self, _: u64) {}

    fn delay(&mut self) -> &mut Wire {
        &mut self.wire
    }

    fn motors(&mut self) -> &mut Self {
        self
    }

    fn feed(&mut self, _: FeedPermit) {}

    fn health(&mut self) -> Health {
        HEALTH
    }
}

/// A sensor whose readings are stored.
pub(super) struct Logged<'a, P> {
    pub part: P,
    pub ports: Ports<'a>,
}

impl<P: Gyro> Gyro for Logged<'_, P> {
    type Error = P::Error;

    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, P::Error> {
        let rate_rad_s = self.part.rate_rad_s()?;
        let readings = &self.ports.shared.readings;
        readings.set(Readings { rate_rad_s, ..readings.get() });
        Ok(rate_rad_s)
    }

    fn delay_us(&self) -> u32 {
        self.part.delay_us()
    }
}

impl<P: RateGyro<StartError: Into<StartFault>>> RateGyro for Logged<'_, P> {
    const IDENTITY: u8 = P::IDENTITY;
    type StartError = P::StartError;
    type SelfTestError = P::SelfTestError;

    fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), P::StartError> {
        self.part.restart(delay)
    }

    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), P::SelfTestError> {
        self.part.self_test(delay)
    }

    fn range_rad_s(&self) -> f32 {
        self.part.range_rad_s()
    }

    fn quantum_rad_s(&self) -> f32 {
        self.part.quantum_rad_s()
    }
}

impl<P: WheelTachometers<WHEELS>> WheelTachometers<WHEELS> for Logged<'_, P> {
    type Error = P::Error;

    fn speed_rad_s(&mut self) -> Result<[f32; WHEELS], P::Error> {
        let wheel_speed_rad_s = self.part.speed_rad_s()?;
        let readings = &self.ports.shared.readings;
        readings.set(Readings { wheel_speed_rad_s, ..readings.get() });
        Ok(wheel_speed_rad_s)
    }

    fn motor_torque_n_m(&mut self) -> [Option<f32>; WHEELS] {
        self.part.motor_torque_n_m()
    }

    fn are_valid(&self) -> [bool; WHEELS] {
        self.part.are_valid()
    }

    fn assume(&mut self, wheel: usize, speed_rad_s: Option<f32>) -> bool {
        self.part.assume(wheel, speed_rad_s)
    }
}
