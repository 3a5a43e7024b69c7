//! The flight computer on the host: the firmware's own parts, compiled here, on a bench of their own,
//! wired to the chip directly.

use std::cell::{Cell, RefCell, RefMut};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::marker::PhantomData;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal_nb::{nb, serial};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use fsw_core::Vec3;
use fsw_target::drivers::gyro::bmi088::Bmi088;
use fsw_target::drivers::gyro::bus::Spi;
use fsw_target::drivers::gyro::{RateGyro, StartFault};
use fsw_target::drivers::wheel_tach::{CaptureTimer, Captured, WheelTach};
use fsw_target::flight::computer::{Computer, Health, Housekeeping, Parts, Reporting};
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::flight_loop::Sensors;
use fsw_target::flight::selected::SelectedEstimator;
use fsw_target::flight::sensors::{DataReady, Gyro, TorqueCommand, WheelTachometers};
use fsw_target::flight::supervisor::FeedPermit;
use fsw_target::link::Receiver;
use fsw_target::link::telemetry::Received;
use fsw_target::stand_in::tunnel::Setup;
use fsw_target::stand_in::tunnel::parts::HEALTH;
use fsw_target::stand_in::tunnel::setup::Unfit;

use super::bench::Bench;
use super::flash::{FlashModel, OutOfBounds};
use crate::sensor::bmi088::Wire;

/// What the sensors said of the last sample, in the units that the estimator gets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Time stamp, µs.
    pub time_us: u64,
    /// Body rate, rad/s.
    pub rate_rad_s: Vec3<f32>,
    /// Speed of each wheel, rad/s.
    pub wheel_speed_rad_s: [f32; WHEELS],
    /// Commanded torque, N m.
    pub torque_n_m: Vec3<f32>,
}

/// A flight computer on the host.
pub struct Software<'o, 'a> {
    computer: Computer<'o, OnBench<'a>>,
    lines: Lines<'a>,
    receiver: Receiver,
}

impl<'o, 'a> Software<'o, 'a> {
    /// A computer that has just started.
    ///
    /// # Errors
    /// The flight software's.
    pub fn start(
        bench: &Rc<RefCell<Bench<'a>>>,
        setup: &Setup,
        onboard: &'o mut SelectedEstimator,
    ) -> Result<Self, Unfit> {
        let lines = Lines::new(Rc::clone(bench), setup.ticks_per_s);
        let gyro = Bmi088::new(Spi::new(lines.wire.clone()), setup.gyro()?);
        let sensors = Sensors {
            data_ready: lines.clone(),
            gyro: Noted { part: gyro, lines: lines.clone() },
            wheels: Noted { part: setup.tachometers(lines.clone())?, lines: lines.clone() },
            torque: lines.clone(),
        };
        let (link, flash, board) = (lines.clone(), lines.clone(), lines.clone());
        let reporting = Reporting::EachSample;
        let mut computer = Computer::new(onboard, sensors, link, flash, board, reporting);
        computer.start();
        Ok(Self { computer, lines, receiver: Receiver::default() })
    }

    /// Handles the next sample; what the ground is told of it.
    pub fn fly_sample(&mut self) -> Vec<Received> {
        self.lines.world.may_sample.set(true);
        self.computer.poll();
        self.told()
    }

    /// Takes a command; what the ground is told of it, which may be many packets.
    pub fn obey(&mut self, frame: &[u8]) -> Vec<Received> {
        self.lines.world.to_computer.borrow_mut().extend(frame);
        let mut all = Vec::new();
        loop {
            self.computer.poll();
            let told = self.told();
            if told.is_empty() && self.lines.world.to_computer.borrow().is_empty() {
                return all;
            }
            all.extend(told);
        }
    }

    fn told(&mut self) -> Vec<Received> {
        let bytes = self.lines.world.from_computer.borrow_mut().drain(..).collect::<Vec<u8>>();
        let received = bytes.into_iter().filter_map(|byte| self.receiver.push(byte));
        // The computer's own packets, straight from its port.
        received.filter_map(Result::ok).collect()
    }

    /// What the sensors said of the last sample.
    pub fn readings(&self) -> Readings {
        self.lines.world.readings.get()
    }

    /// The estimators.
    pub fn onboard(&self) -> &SelectedEstimator {
        self.computer.estimator()
    }
}

/// The parts of a computer on a bench.
struct OnBench<'a>(PhantomData<&'a ()>);

impl<'a> Parts for OnBench<'a> {
    type DataReady = Lines<'a>;
    type Gyro = Noted<'a, Bmi088<Spi<Wire>>>;
    type Wheels = Noted<'a, WheelTach<Lines<'a>, WHEELS>>;
    type Torque = Lines<'a>;
    type Link = Lines<'a>;
    type Flash = Lines<'a>;
    type Board = Lines<'a>;
}

/// What the parts share.
struct World<'a> {
    bench: Rc<RefCell<Bench<'a>>>,
    ticks_per_s: u32,
    /// Time goes on only when told.
    may_sample: Cell<bool>,
    readings: Cell<Readings>,
    to_computer: RefCell<VecDeque<u8>>,
    from_computer: RefCell<VecDeque<u8>>,
}

/// All lines between computer and bench but the gyro's bus, whose clock comes along.
#[derive(Clone)]
struct Lines<'a> {
    world: Rc<World<'a>>,
    wire: Wire,
}

impl<'a> Lines<'a> {
    fn new(bench: Rc<RefCell<Bench<'a>>>, ticks_per_s: u32) -> Self {
        let wire = bench.borrow().wire().clone();
        let world = World {
            bench,
            ticks_per_s,
            may_sample: Cell::new(false),
            readings: Cell::default(),
            to_computer: RefCell::default(),
            from_computer: RefCell::default(),
        };
        Self { world: Rc::new(world), wire }
    }

    fn flash(&self) -> RefMut<'_, FlashModel> {
        RefMut::map(self.world.bench.borrow_mut(), |bench| &mut bench.flash)
    }
}

impl DataReady for Lines<'_> {
    fn take_us(&mut self) -> Option<u64> {
        if !self.world.may_sample.replace(false) {
            return None;
        }
        let announced = self.world.bench.borrow_mut().announce()?;
        let torque_n_m = Vec3::from(announced.torque_n_m);
        let time_us = announced.time_us;
        self.world.readings.set(Readings { time_us, torque_n_m, ..Readings::default() });
        Some(time_us)
    }

    /// Time stands still while a sample is handled.
    fn has_newer(&mut self) -> bool {
        false
    }

    /// None is announced but when it is asked for.
    fn discard(&mut self) {}

    fn overruns(&self) -> u32 {
        0
    }
}

impl TorqueCommand for Lines<'_> {
    fn torque_n_m(&mut self) -> Vec3<f32> {
        self.world.readings.get().torque_n_m
    }

    /// The scenario commands.
    fn command(&mut self, _: Vec3<f32>) {}
}

impl CaptureTimer<WHEELS> for Lines<'_> {
    type Error = Infallible;

    fn ticks_per_s(&self) -> u32 {
        self.world.ticks_per_s
    }

    fn captured(&mut self) -> Result<[Captured; WHEELS], Infallible> {
        Ok(self.world.bench.borrow().captured())
    }
}

impl serial::ErrorType for Lines<'_> {
    type Error = Infallible;
}

impl serial::Read for Lines<'_> {
    fn read(&mut self) -> nb::Result<u8, Infallible> {
        self.world.to_computer.borrow_mut().pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl serial::Write for Lines<'_> {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        self.world.from_computer.borrow_mut().push_back(byte);
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        Ok(())
    }
}

impl ErrorType for Lines<'_> {
    type Error = OutOfBounds;
}

impl ReadNorFlash for Lines<'_> {
    const READ_SIZE: usize = FlashModel::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfBounds> {
        self.flash().read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.flash().capacity()
    }
}

impl NorFlash for Lines<'_> {
    const WRITE_SIZE: usize = FlashModel::WRITE_SIZE;
    const ERASE_SIZE: usize = FlashModel::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfBounds> {
        self.flash().erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfBounds> {
        self.flash().write(offset, bytes)
    }
}

impl Housekeeping for Lines<'_> {
    type Delay = Wire;

    fn now_us(&mut self) -> u64 {
        self.world.bench.borrow().now_us()
    }

    /// The bench's clock doesn't stop with the computer.
    fn resume_at(&mut self, _: u64) {}

    fn delay(&mut self) -> &mut Wire {
        &mut self.wire
    }

    fn feed(&mut self, _: FeedPermit) {}

    fn health(&mut self) -> Health {
        HEALTH
    }
}

/// A sensor whose readings are noted.
struct Noted<'a, P> {
    part: P,
    lines: Lines<'a>,
}

impl<P: Gyro> Gyro for Noted<'_, P> {
    type Error = P::Error;

    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, P::Error> {
        let rate_rad_s = self.part.rate_rad_s()?;
        let readings = &self.lines.world.readings;
        readings.set(Readings { rate_rad_s, ..readings.get() });
        Ok(rate_rad_s)
    }
}

impl<P: RateGyro<StartError: Into<StartFault>>> RateGyro for Noted<'_, P> {
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

impl<P: WheelTachometers<WHEELS>> WheelTachometers<WHEELS> for Noted<'_, P> {
    type Error = P::Error;

    fn speed_rad_s(&mut self) -> Result<[f32; WHEELS], P::Error> {
        let wheel_speed_rad_s = self.part.speed_rad_s()?;
        let readings = &self.lines.world.readings;
        readings.set(Readings { wheel_speed_rad_s, ..readings.get() });
        Ok(wheel_speed_rad_s)
    }
}
