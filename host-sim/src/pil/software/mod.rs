//! The flight computer on the host: the firmware's code compiled for this machine, on hardware of its
//! own, connected to the gyro chip without the tunnel.

mod ports;

use std::cell::RefCell;
use std::marker::PhantomData;
use std::rc::Rc;

use fsw_target::drivers::gyro::bmi088::Bmi088;
use fsw_target::drivers::gyro::bus::Spi;
use fsw_target::drivers::wheel_tach::WheelTach;
use fsw_target::flight::computer::{Computer, Parts, Reporting, Security};
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::flight_loop::Sensors;
use fsw_target::flight::manoeuvre::Manoeuvre;
use fsw_target::flight::selected::SelectedEstimator;
use fsw_target::link::Receiver;
use fsw_target::link::telemetry::Received;
use fsw_target::stand_in::tunnel::setup::Unfit;
use fsw_target::stand_in::tunnel::{CHECKPOINT_BYTES, COUNTER_BYTES, Setup};

use super::hardware::Hardware;
use crate::sensor::bmi088::Wire;
pub use ports::Readings;
use ports::{Flash, Logged, Ports};

/// A flight computer on the host.
pub struct Software<'o, 'a> {
    computer: Computer<'o, HostParts<'a>>,
    ports: Ports<'a>,
    receiver: Receiver,
}

impl<'o, 'a> Software<'o, 'a> {
    /// Starts the computer.
    ///
    /// # Errors
    /// Craft data that the flight software rejects.
    pub fn start(
        hardware: &Rc<RefCell<Hardware<'a>>>,
        setup: &Setup,
        kept: (&'o mut SelectedEstimator, &'o mut Manoeuvre),
    ) -> Result<Self, Unfit> {
        let ports = Ports::new(Rc::clone(hardware), setup.ticks_per_s);
        let gyro = Bmi088::new(Spi::new(ports.wire.clone()), setup.gyro()?);
        let wheels = setup.tachometers(ports.clone())?;
        let sensors = Sensors {
            data_ready: ports.clone(),
            gyro: Logged { part: gyro, ports: ports.clone() },
            wheels: Logged { part: wheels, ports: ports.clone() },
            torque: ports.clone(),
        };
        let (link, board) = (ports.clone(), ports.clone());
        let flash = Flash { ports: ports.clone(), start: 0, bytes: CHECKPOINT_BYTES };
        let counters =
            Flash { ports: ports.clone(), start: CHECKPOINT_BYTES, bytes: COUNTER_BYTES };
        let security = Security { flash: counters, master: setup.master_key() };
        let reporting = Reporting::EachSample;
        let mut computer = Computer::new(kept, sensors, link, flash, security, board, reporting);
        computer.start();
        Ok(Self { computer, ports, receiver: Receiver::default() })
    }

    /// Processes the next sample. Output: the telemetry sent.
    pub fn fly_sample(&mut self) -> Vec<Received> {
        self.ports.shared.may_sample.set(true);
        self.computer.poll();
        self.telemetry()
    }

    /// Executes a telecommand. Output: the telemetry sent, which may be several packets.
    pub fn execute(&mut self, frame: &[u8]) -> Vec<Received> {
        self.ports.shared.to_computer.borrow_mut().extend(frame);
        let mut all = Vec::new();
        loop {
            self.computer.poll();
            let telemetry = self.telemetry();
            if telemetry.is_empty() && self.ports.shared.to_computer.borrow().is_empty() {
                return all;
            }
            all.extend(telemetry);
        }
    }

    /// Telemetry sent since the last call. Packets from the computer's own port have no errors.
    fn telemetry(&mut self) -> Vec<Received> {
        let bytes = self.ports.shared.from_computer.borrow_mut().drain(..).collect::<Vec<u8>>();
        let received = bytes.into_iter().filter_map(|byte| self.receiver.push(byte));
        received.filter_map(Result::ok).collect()
    }

    /// Readings of the last sample.
    pub fn readings(&self) -> Readings {
        self.ports.shared.readings.get()
    }

    /// Estimators of the computer.
    pub fn estimator(&self) -> &SelectedEstimator {
        self.computer.estimator()
    }
}

/// Parts of the flight computer on the host.
struct HostParts<'a>(PhantomData<&'a ()>);

impl<'a> Parts for HostParts<'a> {
    type DataReady = Ports<'a>;
    type Gyro = Logged<'a, Bmi088<Spi<Wire>>>;
    type Wheels = Logged<'a, WheelTach<Ports<'a>, WHEELS>>;
    type Torque = Ports<'a>;
    type Link = Ports<'a>;
    type Flash = Flash<'a>;
    type CounterFlash = Flash<'a>;
    type Board = Ports<'a>;
}
