//! Hardware around a flight computer, from sample to sample: gyro chip, wheel encoders, flash.

use fsw_target::drivers::wheel_tach::Captured;
use fsw_target::flight::craft::WHEELS;
use fsw_target::stand_in::tunnel::Setup;
use nalgebra::Matrix3;

use super::flash::FlashModel;
use super::mission::Mission;
use super::setup;
use crate::input::scenario::SimulatedGyro;
use crate::sensor::bmi088::{BusFault, Chip, Wire};
use crate::sensor::encoder::{Captures, EncoderData};
use crate::sensor::gyro::Gyro;
use crate::truth::Instant;

/// A sample that is ready.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Announced {
    /// Time of the sample, µs.
    pub time_us: u64,
    /// Commanded external torque, body axes, N m.
    pub torque_n_m: [f32; 3],
}

/// Hardware of one flight. The same mission gives the same bits.
pub struct Hardware<'a> {
    instants: &'a [Instant],
    /// Noise and bias. Quantisation and range are those of the chip.
    gyro: Gyro,
    sensor_from_body: Matrix3<f64>,
    wire: Wire,
    captures: Captures<'a, WHEELS>,
    announced: usize,
    /// Flash. Like the rest of the hardware, it survives a restart of the computer.
    pub flash: FlashModel,
}

impl<'a> Hardware<'a> {
    /// Initial state: before the first sample, chip powered, flash erased.
    pub fn new(mission: &Mission<'a>, setup: &Setup) -> Self {
        let model = SimulatedGyro {
            quantum_rad_s: None,
            range_rad_s: None,
            ..mission.scenario.gyro.clone()
        };
        let data = EncoderData { ticks_per_s: setup.ticks_per_s, ..EncoderData::default() };
        let instants = &mission.flight.instants;
        Self {
            instants,
            gyro: Gyro::new(&model, mission.seed),
            sensor_from_body: setup::body_from_sensor().transpose(),
            wire: Wire::to(Chip::default()),
            captures: Captures::new(data, instants),
            announced: 0,
            flash: FlashModel::default(),
        }
    }

    /// Advances the time to the next sample: the chip has measured it, the wheels have turned. None
    /// at the end of the flight.
    pub fn announce(&mut self) -> Option<Announced> {
        let instant = self.instants.get(self.announced)?;
        if self.announced > 0 {
            let elapsed_us = instant.time_us - self.now_us();
            self.wire.chip().elapse_us(elapsed_us);
            self.captures.advance();
        }
        let rate_rad_s = self.gyro.read(instant.time_us, &instant.rate_rad_s);
        self.wire.chip().sample(&(self.sensor_from_body * rate_rad_s));
        self.announced += 1;
        let torque = instant.torque_n_m;
        let torque_n_m = [torque.x, torque.y, torque.z].map(|element| element as f32);
        Some(Announced { time_us: instant.time_us, torque_n_m })
    }

    /// Number of samples announced.
    pub fn announced(&self) -> usize {
        self.announced
    }

    /// Time of the last sample, µs. Zero before the first.
    pub fn now_us(&self) -> u64 {
        let last = self.announced.checked_sub(1).and_then(|last| self.instants.get(last));
        last.map_or(0, |instant| instant.time_us)
    }

    /// Bus of the gyro chip.
    pub fn wire(&self) -> &Wire {
        &self.wire
    }

    /// A transaction on the chip's bus: writes `written`, then reads `read` bytes.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn transfer(&mut self, written: &[u8], read: u8) -> Result<Vec<u8>, BusFault> {
        let mut bytes = vec![0; usize::from(read)];
        self.wire.chip().spi(written, &mut bytes)?;
        Ok(bytes)
    }

    /// Advances the chip's time during a wait of its driver, µs.
    pub fn wait(&mut self, us: u32) {
        self.wire.chip().elapse_us(u64::from(us));
    }

    /// Captures of the wheels' timer.
    pub fn captured(&self) -> [Captured; WHEELS] {
        self.captures.now()
    }
}
