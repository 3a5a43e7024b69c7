//! Hardware around a flight computer, from sample to sample: gyro chip, wheel encoders, flash.
//!
//! The errors of a scenario's gyro and wheels are those of `run`. The chip's low-pass filter acts too, as one of
//! first order with the sum of both time constants, on the motion between the samples. The encoders
//! measure the true wheels; errors of tachometer and clock have no counterpart.

use std::borrow::Cow;

use fsw_target::drivers::wheel_tach::Captured;
use fsw_target::flight::craft::WHEELS;
use fsw_target::stand_in::tunnel::Setup;
use nalgebra::{Matrix3, Vector3};

use super::answering::{self, Motion};
use super::flash::FlashModel;
use super::mission::Mission;
use super::setup;
use crate::input::Scenario;
use crate::input::scenario::{SimulatedGyro, SimulatedWheel};
use crate::sensor::bmi088::{BusFault, Chip, Wire};
use crate::sensor::encoder::{Captures, EncoderData};
use crate::sensor::gyro::Gyro;
use crate::simulation::Observed;
use crate::truth::{Flight, Instant};

/// On-board time at the start of a scenario, µs: a computer has started before its first sample.
pub const START_US: u64 = 1_000_000;

/// A sample that is ready.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Announced {
    /// On-board time of the announcement, µs.
    pub time_us: u64,
    /// Commanded external torque, body axes, N m.
    pub torque_n_m: [f32; 3],
}

/// Hardware of one flight. The same mission gives the same bits.
pub struct Hardware<'a> {
    scenario: &'a Scenario,
    /// Wheels as they are.
    wheels: Vec<SimulatedWheel>,
    flight: &'a Flight,
    /// States at the samples; with answering wheels those up to the present one.
    instants: Cow<'a, [Instant]>,
    /// Wheels that answer.
    motion: Option<Motion>,
    /// Motion through the chip's filter. Its bandwidth is known from the first sample on.
    observed: Option<Observed<'a>>,
    /// Noise, bias and axes. Quantisation and range are those of the chip.
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
        let all = mission.flight.instants.as_slice();
        let motion = mission.answering.map(|faults| Motion::new(mission.scenario, faults));
        let instants = match motion {
            Some(_) => Cow::Owned(all.iter().take(1).cloned().collect()),
            None => Cow::Borrowed(all),
        };
        let errors = &mission.scenario.true_hardware.gyro;
        Self {
            scenario: mission.scenario,
            wheels: mission.scenario.true_wheels(),
            flight: mission.flight,
            captures: Captures::new(data, instants.clone()),
            instants,
            motion,
            observed: None,
            gyro: Gyro::with_errors(&model, errors, mission.seed),
            sensor_from_body: setup::body_from_sensor().transpose(),
            wire: Wire::to(Chip::default()),
            announced: 0,
            flash: FlashModel::default(),
        }
    }

    /// Advances the time to the next sample: the chip has measured it, the wheels have turned. None
    /// at the end of the flight.
    pub fn announce(&mut self) -> Option<Announced> {
        let lost = self.motion.as_ref().and_then(|motion| motion.faults.lost);
        while answering::has(lost, self.announced) {
            self.reach()?;
        }
        let instant = self.reach()?;
        let observed_rad_s = self.observed_rate_rad_s(&instant);
        let rate_rad_s = self.gyro.read(instant.time_us, &observed_rad_s);
        self.wire.chip().sample(&(self.sensor_from_body * rate_rad_s));
        let faults = self.motion.as_ref().map(|motion| motion.faults);
        if answering::has(faults.and_then(|faults| faults.bus_errors), self.announced - 1) {
            self.wire.chip().fail_next_transaction();
        }
        let torque = instant.torque_n_m;
        let torque_n_m = [torque.x, torque.y, torque.z].map(|element| element as f32);
        Some(Announced { time_us: START_US + instant.time_us, torque_n_m })
    }

    /// Advances to the next sample, announced or not. None at the end of the flight.
    fn reach(&mut self) -> Option<Instant> {
        let time_us = self.flight.instants.get(self.announced)?.time_us;
        if let (Some(motion), Some(now)) = (&mut self.motion, self.instants.last())
            && self.announced > 0
        {
            let next = motion.advance(now, time_us).ok()?;
            self.captures.add(next.clone());
            self.instants.to_mut().push(next);
        }
        if self.announced > 0 {
            let elapsed_us = START_US + time_us - self.now_us();
            self.wire.chip().elapse_us(elapsed_us);
            self.captures.advance();
        }
        let instant = self.instants.get(self.announced)?.clone();
        self.announced += 1;
        Some(instant)
    }

    /// Sets the torque of each motor on its wheel, N m. False if the wheels follow the scenario.
    pub fn command_motors(&mut self, torque_n_m: &[f32; WHEELS]) -> bool {
        let motion = self.motion.as_mut();
        motion.map(|motion| motion.command(torque_n_m)).is_some()
    }

    /// True wheel speeds at the present sample, rad/s.
    pub fn wheel_speed_rad_s(&self) -> &[f64] {
        let now = self.announced.checked_sub(1).and_then(|index| self.instants.get(index));
        now.map_or(&[], |now| &now.wheel_speed_rad_s)
    }

    /// Rate at a sample through delay, filters and averaging of the gyro, rad/s.
    fn observed_rate_rad_s(&mut self, instant: &Instant) -> Vector3<f64> {
        let trajectory = self.flight.trajectory.as_ref().filter(|_| self.motion.is_none());
        let Some(trajectory) = trajectory else { return instant.rate_rad_s };
        let (scenario, wire) = (self.scenario, &self.wire);
        let observed = self.observed.get_or_insert_with(|| {
            let lag_s = scenario.true_hardware.gyro.lag_s + wire.chip().lag_s();
            Observed::with_lag(scenario, trajectory, lag_s)
        });
        observed.rate_rad_s(instant.time_us as f64 * 1e-6)
    }

    /// Number of samples announced.
    pub fn announced(&self) -> usize {
        self.announced
    }

    /// On-board time of the last sample, µs; [`START_US`] before the first.
    pub fn now_us(&self) -> u64 {
        let last = self.announced.checked_sub(1).and_then(|last| self.instants.get(last));
        START_US + last.map_or(0, |instant| instant.time_us)
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

    /// Mean torque of each motor on its wheel since the last sample, N m: `Iₛ (ΔΩ + a · Δω) / Δt`, since the motor alone
    /// changes the axial momentum of a wheel. Zero before the second sample.
    pub fn motor_torque_n_m(&self) -> [f32; WHEELS] {
        let at = |back: usize| self.instants.get(self.announced.checked_sub(back)?);
        let (Some(now), Some(before)) = (at(1), at(2)) else { return [0.0; WHEELS] };
        let elapsed_s = (now.time_us - before.time_us) as f64 * 1e-6;
        let rate_rad_s = now.rate_rad_s - before.rate_rad_s;
        let torque_n_m = |index: usize| {
            let wheel = &self.wheels.get(index)?.wheel;
            let speeds = (now.wheel_speed_rad_s.get(index)?, before.wheel_speed_rad_s.get(index)?);
            let change_rad_s = speeds.0 - speeds.1 + wheel.axis.dot(&rate_rad_s);
            Some((wheel.spin_inertia_kg_m2 * change_rad_s / elapsed_s) as f32)
        };
        std::array::from_fn(|index| torque_n_m(index).unwrap_or(0.0))
    }

    /// Captures of the wheels' timer.
    pub fn captured(&self) -> [Captured; WHEELS] {
        self.captures.now()
    }
}

#[cfg(test)]
mod tests {
    use fsw_target::drivers::gyro::bmi088::{Bmi088, Settings};
    use fsw_target::drivers::gyro::bus::Spi;
    use fsw_target::flight::selected::EstimatorId;

    use super::*;
    use crate::truth::Flight;

    /// Readings of the flight driver in body axes, rad/s.
    fn readings(scenario: &Scenario, flight: &Flight) -> Vec<Vector3<f64>> {
        let mission = Mission {
            scenario,
            flight,
            seed: 3,
            estimator: EstimatorId::Window,
            restart_at: None,
            commands: &[],
            answering: None,
        };
        let mut hardware = Hardware::new(&mission, &setup::of(&mission).unwrap());
        let mut wire = hardware.wire().clone();
        let mut driver =
            Bmi088::start(Spi::new(wire.clone()), Settings::default(), &mut wire).unwrap();
        let mut readings = Vec::new();
        while hardware.announce().is_some() {
            let sensor = Vector3::from(driver.rate_rad_s().unwrap().map(f64::from));
            readings.push(setup::body_from_sensor() * sensor);
        }
        readings
    }

    #[test]
    fn chip_reads_an_imperfect_gyro_through_its_filter() {
        let mut ideal = Scenario::load("cubesat-pyramid").unwrap();
        ideal.duration_s = 20.0;
        let mut imperfect = ideal.clone();
        imperfect.true_hardware.gyro.scale = Vector3::new(0.1, 0.0, -0.1);
        imperfect.true_hardware.gyro.delay_s = 0.02;
        let flight = Flight::simulate(&imperfect).unwrap();
        let clean = readings(&ideal, &Flight::simulate(&ideal).unwrap());
        let found = readings(&imperfect, &flight);
        // The driver's default filter has 32 Hz.
        let lag_s = 1.0 / (std::f64::consts::TAU * 32.0);
        let along = flight.trajectory.as_ref().unwrap();
        // The noise of both flights is the same.
        let scale = Vector3::new(1.1, 1.0, 0.9);
        for (k, instant) in flight.instants.iter().enumerate().skip(1) {
            let (piece, s) = along.locate(instant.time_us as f64 * 1e-6 - 0.02 - lag_s);
            let late = along.pieces()[piece].rate_rad_s.at(s);
            let expected = clean[k] + scale.component_mul(&late) - instant.rate_rad_s;
            // A count of 6.7e-5 rad/s is rounded on three axes of both.
            assert!((found[k] - expected).norm() < 1.2e-4, "{k}: {} {expected}", found[k]);
        }
    }
}
