//! Wheels that answer the torques of the flight computer, and faults at stated samples.
//!
//! Each torque is constant from a sample to the next, as the motors keep it. Truth is the equation of motion of the
//! scenario with these torques in place of the scenario's own. The gyro reads the rate at the sample: its filter, which
//! needs the motion on both sides, is left out.

use nalgebra::Vector3;

use crate::input::Scenario;
use crate::input::scenario::TorqueProfile;
use crate::truth::integrate::advance;
use crate::truth::spacecraft::Spacecraft;
use crate::truth::{Instant, IntegrationFailed};

/// Faults of a flight with answering wheels. Ranges of samples: the first, and the first after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answering {
    /// Readings of the gyro end in a bus error.
    pub bus_errors: Option<[usize; 2]>,
    /// Samples are not announced.
    pub lost: Option<[usize; 2]>,
}

/// True if a range has this sample.
pub(super) fn has(range: Option<[usize; 2]>, sample: usize) -> bool {
    range.is_some_and(|[from, to]| (from..to).contains(&sample))
}

/// Motion under the torques of the flight computer.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    scenario: Scenario,
    state: Vec<f64>,
    pub faults: Answering,
}

impl Motion {
    pub fn new(scenario: &Scenario, faults: Answering) -> Self {
        let mut scenario = scenario.clone();
        scenario.wheels.iter_mut().for_each(|wheel| wheel.torque = TorqueProfile::ZERO);
        let state = Spacecraft::new(&scenario).initial_state();
        Self { scenario, state, faults }
    }

    /// Sets the torque of each motor on its wheel, N m.
    pub fn command(&mut self, torque_n_m: &[f32]) {
        for (wheel, torque) in self.scenario.wheels.iter_mut().zip(torque_n_m) {
            wheel.torque = TorqueProfile::Constant { value_n_m: f64::from(*torque) };
        }
    }

    /// State at a sample after the present one.
    pub fn advance(&mut self, now: &Instant, to_us: u64) -> Result<Instant, IntegrationFailed> {
        let craft = Spacecraft::new(&self.scenario);
        let [from_s, to_s] = [now.time_us, to_us].map(|us| us as f64 * 1e-6);
        let state = advance(&craft, from_s, to_s, self.state.clone())?;
        let motion = craft.motion(&state);
        self.state = state;
        Ok(Instant {
            time_us: to_us,
            rate_rad_s: motion.rate_rad_s,
            inertia_kg_m2: now.inertia_kg_m2,
            attitude: motion.attitude,
            wheel_speed_rad_s: motion.wheel_speed_rad_s,
            torque_n_m: Vector3::zeros(),
        })
    }
}
