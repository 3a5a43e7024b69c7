//! The equations of motion: a rigid body, balanced wheels driven by motors, and its attitude.
//!
//! Each wheel's own axial momentum `hᵢ = Iₛᵢ (Ωᵢ + aᵢ · ω)` changes by its motor torque alone,
//! `ḣᵢ = uᵢ`. With `J_b = J − Σ Iₛᵢ aᵢ aᵢᵀ`, total momentum is `J_b ω + Σ hᵢ aᵢ`, and
//!
//! `J_b ω̇ = τ − Σ uᵢ aᵢ − ω × (J_b ω + Σ hᵢ aᵢ)`.
//!
//! A motor's torque is its profile's and, where the loop is closed, the controller's.
//!
//! This is another form of the gyrostat equation than the flight core's, on purpose.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::controller::Controller;
use super::integrate::Equations;
use crate::input::scenario::{Scenario, SimulatedWheel};

/// Where the parts of the state vector stand.
const RATE: usize = 0;
const ATTITUDE: usize = 3;
const WHEELS: usize = 7;

/// A scenario's spacecraft as physics.
pub struct Spacecraft<'a> {
    scenario: &'a Scenario,
    controller: Option<Controller<'a>>,
    /// `J`, wheels locked and included, kg m².
    inertia: Matrix3<f64>,
    /// `J_b⁻¹`, 1/(kg m²).
    body_inverse: Matrix3<f64>,
    /// `J_b`, kg m².
    body: Matrix3<f64>,
    /// Mean moment, kg m²: wheel momenta are kept as hᵢ over this, so that every state but the
    /// attitude is of the size of a rate and one tolerance fits all.
    typical_kg_m2: f64,
}

/// The state at one instant, taken apart.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Body rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Rotation that takes body axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
    /// Wheel speeds relative to the body, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Momentum of the wheels relative to the body, `h_w`, body axes, N m s.
    pub wheel_momentum_n_m_s: Vector3<f64>,
}

impl<'a> Spacecraft<'a> {
    /// The scenario's spacecraft. Its inertia has been checked on loading.
    pub fn new(scenario: &'a Scenario) -> Self {
        let [xx, yy, zz, xy, xz, yz] = scenario.spacecraft.inertia_kg_m2;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let body = scenario.wheels.iter().fold(inertia, |j, SimulatedWheel { wheel, .. }| {
            j - wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2
        });
        // Positive definite on loading; a NaN here would be told by the integrator.
        let body_inverse = body.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
        let control = scenario.control.as_ref();
        Self {
            controller: control.map(|control| Controller::new(control, &scenario.wheels)),
            scenario,
            inertia,
            body_inverse,
            body,
            typical_kg_m2: inertia.trace() / 3.0,
        }
    }

    /// `J`, kg m².
    pub fn inertia_kg_m2(&self) -> &Matrix3<f64> {
        &self.inertia
    }

    /// Mean moment of inertia, kg m².
    pub fn typical_kg_m2(&self) -> f64 {
        self.typical_kg_m2
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        WHEELS + self.scenario.wheels.len()
    }

    /// The state at the start.
    pub fn initial_state(&self) -> Vec<f64> {
        let mut state = vec![0.0; self.dimension()];
        let rate = self.scenario.spacecraft.rate_rad_s;
        state[RATE..RATE + 3].copy_from_slice(rate.as_slice());
        let attitude = &self.scenario.spacecraft.attitude;
        state[ATTITUDE] = attitude.w;
        state[ATTITUDE + 1..ATTITUDE + 4].copy_from_slice(attitude.imag().as_slice());
        for (i, SimulatedWheel { wheel, speed_rad_s, .. }) in
            self.scenario.wheels.iter().enumerate()
        {
            let speed = speed_rad_s + wheel.axis.dot(&rate);
            state[WHEELS + i] = wheel.spin_inertia_kg_m2 * speed / self.typical_kg_m2;
        }
        state
    }

    /// Rates, attitude and wheels of a state vector.
    pub fn motion(&self, state: &[f64]) -> Motion {
        let rate = rate(state);
        let mut wheel_momentum = Vector3::zeros();
        let mut speeds = Vec::with_capacity(self.scenario.wheels.len());
        for (i, SimulatedWheel { wheel, .. }) in self.scenario.wheels.iter().enumerate() {
            let axial = state[WHEELS + i] * self.typical_kg_m2 / wheel.spin_inertia_kg_m2;
            let speed = axial - wheel.axis.dot(&rate);
            wheel_momentum += wheel.axis * (wheel.spin_inertia_kg_m2 * speed);
            speeds.push(speed);
        }
        Motion {
            rate_rad_s: rate,
            attitude: UnitQuaternion::new_normalize(attitude(state)),
            wheel_speed_rad_s: speeds,
            wheel_momentum_n_m_s: wheel_momentum,
        }
    }

    /// Torque of each motor on its wheel, N m: what is laid down, and what the controller wants.
    pub fn motor_torque_n_m(&self, time_s: f64, state: &[f64]) -> Vec<f64> {
        let mut torques: Vec<f64> =
            self.scenario.wheels.iter().map(|motor| motor.torque.at(time_s)).collect();
        if let Some(controller) = &self.controller {
            let attitude = UnitQuaternion::new_normalize(attitude(state));
            let wanted = controller.motor_torque_n_m(&attitude, &rate(state));
            for (torque, wanted) in torques.iter_mut().zip(wanted.iter()) {
                *torque += wanted;
            }
        }
        torques
    }

    /// Angular acceleration, rad/s², body axes, with these torques of the motors, N m.
    fn acceleration_rad_s2(
        &self,
        time_s: f64,
        state: &[f64],
        motor_torque_n_m: &[f64],
    ) -> Vector3<f64> {
        let rate = rate(state);
        let mut momentum = self.body * rate;
        let mut torque = self.scenario.torque.at(time_s) + self.scenario.disturbance_torque_n_m;
        for (i, motor) in self.scenario.wheels.iter().enumerate() {
            momentum += motor.wheel.axis * (state[WHEELS + i] * self.typical_kg_m2);
            torque -= motor.wheel.axis * motor_torque_n_m[i];
        }
        self.body_inverse * (torque - rate.cross(&momentum))
    }

    /// Total angular momentum in inertial axes, N m s.
    pub fn inertial_momentum_n_m_s(&self, state: &[f64]) -> Vector3<f64> {
        let motion = self.motion(state);
        motion.attitude * (self.inertia * motion.rate_rad_s + motion.wheel_momentum_n_m_s)
    }

    /// Kinetic energy of body and wheels, J.
    pub fn energy_j(&self, state: &[f64]) -> f64 {
        let rate = rate(state);
        let wheels: f64 = self
            .scenario
            .wheels
            .iter()
            .enumerate()
            .map(|(i, SimulatedWheel { wheel, .. })| {
                let axial = state[WHEELS + i] * self.typical_kg_m2;
                axial * axial / wheel.spin_inertia_kg_m2
            })
            .sum();
        0.5 * (rate.dot(&(self.body * rate)) + wheels)
    }
}

fn rate(state: &[f64]) -> Vector3<f64> {
    Vector3::new(state[RATE], state[RATE + 1], state[RATE + 2])
}

fn attitude(state: &[f64]) -> Quaternion<f64> {
    Quaternion::new(state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3])
}

impl Equations for Spacecraft<'_> {
    fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
        let w = rate(state);
        let motor_torque_n_m = self.motor_torque_n_m(time_s, state);
        let acceleration = self.acceleration_rad_s2(time_s, state, &motor_torque_n_m);
        derivative[RATE..RATE + 3].copy_from_slice(acceleration.as_slice());
        // q̇ = ½ q ⊗ (0, ω), q from body to inertial axes.
        let turn = attitude(state) * Quaternion::from_imag(w) * 0.5;
        derivative[ATTITUDE] = turn.w;
        derivative[ATTITUDE + 1] = turn.i;
        derivative[ATTITUDE + 2] = turn.j;
        derivative[ATTITUDE + 3] = turn.k;
        for (i, torque) in motor_torque_n_m.iter().enumerate() {
            derivative[WHEELS + i] = torque / self.typical_kg_m2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::integrate::advance;
    use std::path::Path;

    /// Required of the truth model over 600 s, relative.
    const DRIFT: f64 = 1e-10;

    #[test]
    fn momentum_and_energy_are_kept_over_600_s_of_tumbling() {
        let scenario = Scenario::from_toml(
            "tumble.toml",
            r#"
            name = "tumble"
            duration_s = 600.0
            [spacecraft]
            inertia_kg_m2 = [0.06, 0.09, 0.11, 0.004, -0.006, 0.003]
            rate_rad_s = [0.3, -0.5, 0.4]
            [[wheel]]
            axis = [1.0, 1.0, 1.0]
            spin_inertia_kg_m2 = 2e-5
            speed_rad_s = 400.0
            [[wheel]]
            axis = [-1.0, 1.0, 1.0]
            spin_inertia_kg_m2 = 2e-5
            speed_rad_s = -250.0
            [gyro]
            rate_hz = 1.0
            noise_rad_s = 1e-4
            "#,
            Path::new(""),
        )
        .unwrap();
        let craft = Spacecraft::new(&scenario);
        let mut state = craft.initial_state();
        let (momentum, energy) = (craft.inertial_momentum_n_m_s(&state), craft.energy_j(&state));
        let mut moved = 0.0f64;
        for second in 0..600 {
            let t = f64::from(second);
            state = advance(&craft, t, t + 1.0, state).unwrap();
            let now = craft.inertial_momentum_n_m_s(&state);
            assert!((now - momentum).norm() < DRIFT * momentum.norm(), "t = {t}");
            assert!((craft.energy_j(&state) / energy - 1.0).abs() < DRIFT, "t = {t}");
            let rate = craft.motion(&state).rate_rad_s;
            moved = moved.max((rate - scenario.spacecraft.rate_rad_s).norm());
        }
        assert!(moved > 0.1, "a tumble, not a steady spin: {moved}");
    }

    #[test]
    fn the_slew_of_kim_2010_is_about_one_axis_and_ends_at_its_target() {
        let scenario = Scenario::load("kim-2010-slew").unwrap();
        let craft = Spacecraft::new(&scenario);
        let mut state = craft.initial_state();
        let axis = -craft.motion(&state).attitude.imag().normalize();
        let angle = |state: &[f64]| craft.motion(state).attitude.angle();
        let before = angle(&state);
        for second in 0..200 {
            let t = f64::from(second);
            state = advance(&craft, t, t + 1.0, state).unwrap();
            assert!(craft.inertial_momentum_n_m_s(&state).norm() < 1e-12, "t = {t}");
            // Gains are proportional to J, and the motors turn J less the wheels: 3e-5 apart.
            let rate = craft.motion(&state).rate_rad_s;
            assert!(rate.cross(&axis).norm() < 1e-4 * 4e-3, "t = {t}: {rate}");
        }
        assert!(angle(&state) < 2e-3 * before);
    }

    #[test]
    fn attitude_stays_a_rotation() {
        let scenario = Scenario::load("stsat3-spin-up").unwrap();
        let craft = Spacecraft::new(&scenario);
        let state = advance(&craft, 0.0, 600.0, craft.initial_state()).unwrap();
        let square: f64 = state[ATTITUDE..WHEELS].iter().map(|q| q * q).sum();
        assert!((square - 1.0).abs() < DRIFT);
    }
}
