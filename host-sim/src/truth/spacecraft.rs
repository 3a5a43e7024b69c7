//! Equation of motion of a gyrostat: a rigid body with balanced wheels driven by motors.
//!
//! The axial momentum of wheel i, `hᵢ = Iₛᵢ (Ωᵢ + aᵢ · ω)`, changes by its motor torque alone,
//! `ḣᵢ = uᵢ`. With `J_b = J − Σ Iₛᵢ aᵢ aᵢᵀ`, the total momentum is `J_b ω + Σ hᵢ aᵢ`, and
//!
//! ```text
//! J_b ω̇ = τ − Σ uᵢ aᵢ − J̇ ω − ω × (J_b ω + Σ hᵢ aᵢ)
//! q̇     = ½ q ⊗ (0, ω)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `ω` | body rate relative to inertial space, body axes | rad/s |
//! | `J` | inertia about the centre of mass, wheels locked and included | kg m² |
//! | `J̇` | drift of the inertia | kg m²/s |
//! | `aᵢ`, `Iₛᵢ`, `Ωᵢ` | axis, spin inertia, and speed relative to the body of wheel i | 1, kg m², rad/s |
//! | `uᵢ` | motor torque on wheel i: its profile, and the controller's in a closed loop | N m |
//! | `τ` | external torque: commanded, and the disturbance | N m |
//! | `q` | rotation from body axes to inertial axes | 1 |
//!
//! Wheels are the true ones, with the errors of [`hardware`](crate::input::scenario::hardware). Its
//! further effects add terms: oscillators ([`flexible`](super::flexible)), torques of the
//! [`environment`](super::environment), pulses, and the imbalance of a wheel at angle `θ` and speed
//! `Ω`, `r × U Ω² û + U_d Ω² a × û` with `û = cos θ e₁ + sin θ e₂`, the static imbalance `U`, kg m, at
//! `r`, m, and the dynamic one `U_d`, kg m².
//!
//! At a sudden change of the inertia, total momentum, each `hᵢ` and the momentum `q̇ + d · ω` of each
//! oscillator are conserved, hence `J_b′ ω′ = J_b ω` without oscillators; see [`change`](crate::input::scenario::change) for the assumptions.
//!
//! The flight core uses the form with wheel momentum relative to the body, `J ω̇ + ω × (J ω + h_w) +
//! ḣ_w = τ`. The two forms check each other.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::controller::Controller;
use super::environment;
use super::flexible::Oscillator;
use super::integrate::Equations;
use super::state::{ATTITUDE, RATE, WHEELS, attitude, rate};
use crate::input::craft::hardware::tilt_directions;
use crate::input::scenario::change::Stretch;
use crate::input::scenario::{Scenario, SimulatedWheel};

/// Spacecraft of a scenario, from one sudden change of its inertia to the next.
pub struct Spacecraft<'a> {
    scenario: &'a Scenario,
    /// Wheels with their true axes and spin inertias.
    wheels: Vec<SimulatedWheel>,
    oscillators: Vec<Oscillator>,
    has_imbalance: bool,
    controller: Option<Controller<'a>>,
    /// Start of the stretch, s.
    from_s: f64,
    /// `J` at the start of the stretch, kg m².
    inertia: Matrix3<f64>,
    /// `J_b` at the start of the stretch, kg m².
    body_with_modes: Matrix3<f64>,
    /// `J_b − Σ D Dᵀ` at the start of the stretch, kg m².
    body: Matrix3<f64>,
    /// `J̇`, kg m²/s.
    slope: Matrix3<f64>,
    /// Mean moment of inertia at the start of the flight, kg m². The state holds `hᵢ` over this
    /// moment, so that all of the state but the attitude has the size of a rate and one tolerance
    /// fits all.
    mean_moment_kg_m2: f64,
}

/// Motion at one instant.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Body rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Rotation from body axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
    /// Wheel speeds relative to the body, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Momentum of the wheels relative to the body, `h_w = Σ Iₛᵢ Ωᵢ aᵢ`, body axes, N m s.
    pub wheel_momentum_n_m_s: Vector3<f64>,
}

impl<'a> Spacecraft<'a> {
    /// Spacecraft at the start of the flight. Its inertia was checked on loading.
    pub fn new(scenario: &'a Scenario) -> Self {
        Self::of_stretch(scenario, &scenario.stretch(0))
    }

    /// Spacecraft over one stretch of the scenario.
    pub fn of_stretch(scenario: &'a Scenario, stretch: &Stretch) -> Self {
        let inertia = tensor(&stretch.inertia_kg_m2);
        let wheels = scenario.true_wheels();
        let body_with_modes = wheels.iter().fold(inertia, |j, SimulatedWheel { wheel, .. }| {
            j - wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2
        });
        let at_start = tensor(&scenario.spacecraft.inertia_kg_m2);
        let mean_moment_kg_m2 = at_start.trace() / 3.0;
        let modes = scenario.true_hardware.modes.iter();
        let oscillators: Vec<_> =
            modes.filter_map(|mode| Oscillator::new(mode, &at_start, mean_moment_kg_m2)).collect();
        let body = oscillators
            .iter()
            .fold(body_with_modes, |j, oscillator| j - oscillator.inertia() * mean_moment_kg_m2);
        let control = scenario.control.as_ref();
        Self {
            controller: control.map(|control| Controller::new(control, &scenario.wheels)),
            scenario,
            wheels,
            oscillators,
            has_imbalance: scenario.true_hardware.has_imbalance(),
            from_s: stretch.from_s,
            inertia,
            body_with_modes,
            body,
            slope: tensor(&stretch.slope_kg_m2_s),
            mean_moment_kg_m2,
        }
    }

    /// State just after the inertia of this spacecraft changes to that of `next`:
    /// `(J_b′ − Σ D Dᵀ) ω′ = (J_b − Σ D Dᵀ) ω`, and `q̇′ = q̇ − d · (ω′ − ω)` of each oscillator.
    pub fn becomes(&self, next: &Self, state: &[f64]) -> Vec<f64> {
        let momentum = self.body_kg_m2(next.from_s) * rate(state);
        let mut after = state.to_vec();
        let rate_after = inverse(&next.body) * momentum;
        after[RATE..RATE + 3].copy_from_slice(rate_after.as_slice());
        let jump = rate_after - rate(state);
        for (k, oscillator) in self.oscillators.iter().enumerate() {
            after[self.velocity(k)] -= oscillator.coupling.dot(&jump);
        }
        after
    }

    /// Inertia `J`, kg m².
    pub fn inertia_kg_m2(&self, time_s: f64) -> Matrix3<f64> {
        self.inertia + self.slope * (time_s - self.from_s)
    }

    /// Drift of the inertia `J̇`, kg m²/s.
    pub fn inertia_slope_kg_m2_s(&self) -> &Matrix3<f64> {
        &self.slope
    }

    fn body_kg_m2(&self, time_s: f64) -> Matrix3<f64> {
        self.body + self.slope * (time_s - self.from_s)
    }

    /// Mean moment of inertia at the start of the flight, kg m².
    pub fn mean_moment_kg_m2(&self) -> f64 {
        self.mean_moment_kg_m2
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.first_angle() + if self.has_imbalance { self.wheels.len() } else { 0 }
    }

    /// Index of the deflection of an oscillator.
    fn deflection(&self, oscillator: usize) -> usize {
        WHEELS + self.wheels.len() + 2 * oscillator
    }

    /// Index of the rate of its deflection.
    fn velocity(&self, oscillator: usize) -> usize {
        self.deflection(oscillator) + 1
    }

    /// Index of the angle of the first wheel, or the end of the state.
    fn first_angle(&self) -> usize {
        self.deflection(self.oscillators.len())
    }

    /// True wheels.
    pub fn wheels(&self) -> &[SimulatedWheel] {
        &self.wheels
    }

    /// State vector at the start of the flight.
    pub fn initial_state(&self) -> Vec<f64> {
        let mut state = vec![0.0; self.dimension()];
        let rate = self.scenario.spacecraft.rate_rad_s;
        state[RATE..RATE + 3].copy_from_slice(rate.as_slice());
        let attitude = &self.scenario.spacecraft.attitude;
        state[ATTITUDE] = attitude.w;
        state[ATTITUDE + 1..ATTITUDE + 4].copy_from_slice(attitude.imag().as_slice());
        for (i, SimulatedWheel { wheel, speed_rad_s, .. }) in self.wheels.iter().enumerate() {
            let speed = speed_rad_s + wheel.axis.dot(&rate);
            state[WHEELS + i] = wheel.spin_inertia_kg_m2 * speed / self.mean_moment_kg_m2;
        }
        state
    }

    /// Motion of a state vector.
    pub fn motion(&self, state: &[f64]) -> Motion {
        let rate = rate(state);
        let mut wheel_momentum = Vector3::zeros();
        let mut speeds = Vec::with_capacity(self.wheels.len());
        for (i, SimulatedWheel { wheel, .. }) in self.wheels.iter().enumerate() {
            let speed = self.wheel_speed_rad_s(i, state);
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

    /// Speed of a wheel relative to the body, rad/s.
    fn wheel_speed_rad_s(&self, index: usize, state: &[f64]) -> f64 {
        let wheel = &self.wheels[index].wheel;
        let axial = state[WHEELS + index] * self.mean_moment_kg_m2 / wheel.spin_inertia_kg_m2;
        axial - wheel.axis.dot(&rate(state))
    }

    /// Angular acceleration of the body, rad/s², and slope of each wheel's speed relative to the body,
    /// rad/s².
    pub fn slopes(&self, time_s: f64, state: &[f64]) -> (Vector3<f64>, Vec<f64>) {
        let motor_torque_n_m = self.motor_torque_n_m(time_s, state);
        let acceleration = self.acceleration_rad_s2(time_s, state, &motor_torque_n_m);
        let wheels = self.wheels.iter().zip(&motor_torque_n_m);
        let speed_slopes = wheels
            .map(|(SimulatedWheel { wheel, .. }, torque)| {
                torque / wheel.spin_inertia_kg_m2 - wheel.axis.dot(&acceleration)
            })
            .collect();
        (acceleration, speed_slopes)
    }

    /// Torque of each motor on its wheel, N m: its profile plus the controller's torque.
    pub fn motor_torque_n_m(&self, time_s: f64, state: &[f64]) -> Vec<f64> {
        let mut torques: Vec<f64> =
            self.wheels.iter().map(|motor| motor.torque.at(time_s)).collect();
        if let Some(controller) = &self.controller {
            let attitude = UnitQuaternion::new_normalize(attitude(state));
            let controlled = controller.motor_torque_n_m(&attitude, &rate(state));
            for (torque, controlled) in torques.iter_mut().zip(controlled.iter()) {
                *torque += controlled;
            }
        }
        torques
    }

    /// Angular acceleration `ω̇`, body axes, rad/s², under these motor torques, N m.
    fn acceleration_rad_s2(
        &self,
        time_s: f64,
        state: &[f64],
        motor_torque_n_m: &[f64],
    ) -> Vector3<f64> {
        let rate = rate(state);
        let body = self.body_kg_m2(time_s);
        let mut momentum = body * rate;
        let mut torque = self.external_torque_n_m(time_s, state);
        torque -= self.slope * rate;
        for (i, motor) in self.wheels.iter().enumerate() {
            momentum += motor.wheel.axis * (state[WHEELS + i] * self.mean_moment_kg_m2);
            torque -= motor.wheel.axis * motor_torque_n_m[i];
        }
        for (k, oscillator) in self.oscillators.iter().enumerate() {
            let (deflection, velocity) = (state[self.deflection(k)], state[self.velocity(k)]);
            // J_b ω includes the oscillators at rest; their relative momentum is J̄ d q̇.
            let relative = oscillator.coupling.dot(&rate) + velocity;
            momentum += oscillator.coupling * (relative * self.mean_moment_kg_m2);
            let restoring = oscillator.restoring_rad_s2(deflection, velocity);
            torque += oscillator.coupling * (restoring * self.mean_moment_kg_m2);
        }
        inverse(&body) * (torque - rate.cross(&momentum))
    }

    /// External torque: commanded and disturbance, environment, pulses, imbalance; body axes, N m.
    fn external_torque_n_m(&self, time_s: f64, state: &[f64]) -> Vector3<f64> {
        let (scenario, hardware) = (self.scenario, &self.scenario.true_hardware);
        let commanded = scenario.torque.at(time_s) * (1.0 + hardware.torque_scale);
        let mut torque = commanded + scenario.disturbance_torque_n_m;
        if let Some(orbit) = &hardware.orbit {
            let attitude = UnitQuaternion::new_normalize(attitude(state));
            let inertia = self.inertia_kg_m2(time_s);
            torque += environment::torque_n_m(orbit, time_s, &attitude, &inertia);
        }
        for pulse in &hardware.pulses {
            if (pulse.time_s..pulse.time_s + pulse.duration_s).contains(&time_s) {
                torque += pulse.torque_n_m;
            }
        }
        if self.has_imbalance {
            torque += self.imbalance_torque_n_m(state);
        }
        torque
    }

    /// Torque of the wheels' imbalance, body axes, N m.
    fn imbalance_torque_n_m(&self, state: &[f64]) -> Vector3<f64> {
        let of_wheel = |(i, motor): (usize, &SimulatedWheel)| {
            let errors = self.scenario.true_hardware.wheel(i);
            let axis = &motor.wheel.axis;
            let [first, second] = tilt_directions(axis);
            let (sin, cos) = state[self.first_angle() + i].sin_cos();
            let outward = first * cos + second * sin;
            let square = self.wheel_speed_rad_s(i, state).powi(2);
            let force_n = outward * (errors.static_imbalance_kg_m * square);
            let couple = axis.cross(&outward) * (errors.dynamic_imbalance_kg_m2 * square);
            errors.position_m.cross(&force_n) + couple
        };
        self.wheels.iter().enumerate().map(of_wheel).sum()
    }

    /// Total angular momentum `J ω + h_w + Σ D η̇` in inertial axes, N m s.
    pub fn inertial_momentum_n_m_s(&self, time_s: f64, state: &[f64]) -> Vector3<f64> {
        let motion = self.motion(state);
        let modes: Vector3<f64> = (self.oscillators.iter().enumerate())
            .map(|(k, mode)| mode.coupling * (state[self.velocity(k)] * self.mean_moment_kg_m2))
            .sum();
        motion.attitude
            * (self.inertia_kg_m2(time_s) * motion.rate_rad_s + motion.wheel_momentum_n_m_s + modes)
    }

    /// Energy `½ (ωᵀ J_b ω + Σ hᵢ²/Iₛᵢ)` of body and wheels, and `½ (η̇² + Ω² η²) + η̇ D · ω` of each
    /// oscillator, J.
    pub fn energy_j(&self, time_s: f64, state: &[f64]) -> f64 {
        let rate = rate(state);
        let wheels: f64 = self
            .wheels
            .iter()
            .enumerate()
            .map(|(i, SimulatedWheel { wheel, .. })| {
                let axial = state[WHEELS + i] * self.mean_moment_kg_m2;
                axial * axial / wheel.spin_inertia_kg_m2
            })
            .sum();
        let modes: f64 = (self.oscillators.iter().enumerate())
            .map(|(k, mode)| {
                let (deflection, velocity) = (state[self.deflection(k)], state[self.velocity(k)]);
                let spring = mode.frequency_rad_s * deflection;
                let twice =
                    velocity * (velocity + 2.0 * mode.coupling.dot(&rate)) + spring * spring;
                twice * self.mean_moment_kg_m2
            })
            .sum();
        let body = self.body_with_modes + self.slope * (time_s - self.from_s);
        0.5 * (rate.dot(&(body * rate)) + wheels + modes)
    }
}

/// Symmetric tensor of the elements `jxx jyy jzz jxy jxz jyz`.
fn tensor(elements: &[f64; 6]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = *elements;
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Inverse of a tensor that was checked on loading to be positive definite. The integrator reports
/// the NaN of a singular one.
pub(super) fn inverse(tensor: &Matrix3<f64>) -> Matrix3<f64> {
    tensor.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN))
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
            derivative[WHEELS + i] = torque / self.mean_moment_kg_m2;
        }
        for (k, oscillator) in self.oscillators.iter().enumerate() {
            let (deflection, velocity) = (state[self.deflection(k)], state[self.velocity(k)]);
            derivative[self.deflection(k)] = velocity;
            derivative[self.velocity(k)] =
                oscillator.acceleration_rad_s2(deflection, velocity, &acceleration);
        }
        if self.has_imbalance {
            for i in 0..self.wheels.len() {
                derivative[self.first_angle() + i] = self.wheel_speed_rad_s(i, state);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::scenario::hardware::Pulse;
    use crate::truth::integrate::advance;
    use std::path::Path;

    /// Largest relative drift of a conserved quantity over 600 s.
    const MAX_DRIFT: f64 = 1e-10;

    #[test]
    fn momentum_and_energy_are_conserved_over_600_s_of_tumbling() {
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
        let (momentum, energy) =
            (craft.inertial_momentum_n_m_s(0.0, &state), craft.energy_j(0.0, &state));
        let mut moved = 0.0f64;
        for second in 0..600 {
            let t = f64::from(second);
            state = advance(&craft, t, t + 1.0, state).unwrap();
            let now = craft.inertial_momentum_n_m_s(t + 1.0, &state);
            assert!((now - momentum).norm() < MAX_DRIFT * momentum.norm(), "t = {t}");
            assert!((craft.energy_j(t + 1.0, &state) / energy - 1.0).abs() < MAX_DRIFT, "t = {t}");
            let rate = craft.motion(&state).rate_rad_s;
            moved = moved.max((rate - scenario.spacecraft.rate_rad_s).norm());
        }
        assert!(moved > 0.1, "the rate changes: {moved}");
    }

    #[test]
    fn slew_of_kim_2010_is_about_one_axis_and_reaches_its_target() {
        let scenario = Scenario::load("kim-2010-slew").unwrap();
        let craft = Spacecraft::new(&scenario);
        let mut state = craft.initial_state();
        let axis = -craft.motion(&state).attitude.imag().normalize();
        let angle = |state: &[f64]| craft.motion(state).attitude.angle();
        let before = angle(&state);
        for second in 0..200 {
            let t = f64::from(second);
            state = advance(&craft, t, t + 1.0, state).unwrap();
            assert!(craft.inertial_momentum_n_m_s(t + 1.0, &state).norm() < 1e-12, "t = {t}");
            // Gains are proportional to J, and the motors turn J without the wheels: 3e-5 apart.
            let rate = craft.motion(&state).rate_rad_s;
            assert!(rate.cross(&axis).norm() < 1e-4 * 4e-3, "t = {t}: {rate}");
        }
        assert!(angle(&state) < 2e-3 * before);
    }

    const CHANGING: &str = r#"
        name = "changing"
        duration_s = 7200.0
        [spacecraft]
        inertia_kg_m2 = [0.06, 0.09, 0.11, 0.004, -0.006, 0.003]
        rate_rad_s = [0.03, -0.05, 0.04]
        [[wheel]]
        axis = [1.0, 1.0, 1.0]
        spin_inertia_kg_m2 = 2e-5
        speed_rad_s = 400.0
        [[wheel]]
        axis = [-1.0, 1.0, 1.0]
        spin_inertia_kg_m2 = 2e-5
        speed_rad_s = -250.0
        torque = { kind = "multisine", amplitude_n_m = [1e-5], frequency_hz = [0.01], phase_rad = [0] }
        [gyro]
        rate_hz = 1.0
        noise_rad_s = 1e-4
        "#;

    #[test]
    fn momentum_is_conserved_across_a_sudden_change() {
        let text = format!(
            "{CHANGING}[[change]]\ntime_s = 60.0\ninertia_kg_m2 = [0.09, 0.1, 0.13, 0, 0.01, 0.01]"
        );
        let scenario = Scenario::from_toml("s.toml", &text, Path::new("")).unwrap();
        let [before, after] =
            [0, 1].map(|index| Spacecraft::of_stretch(&scenario, &scenario.stretch(index)));
        let state = advance(&before, 0.0, 60.0, before.initial_state()).unwrap();
        let next = before.becomes(&after, &state);
        let momentum = before.inertial_momentum_n_m_s(60.0, &state);
        let change = after.inertial_momentum_n_m_s(60.0, &next) - momentum;
        assert!(change.norm() < 1e-15 * momentum.norm().max(1.0), "{change}");

        // The rate jumps, and each wheel's speed relative to the body by the opposite along its axis.
        let (old, new) = (before.motion(&state), after.motion(&next));
        let jump = new.rate_rad_s - old.rate_rad_s;
        assert!(jump.norm() > 0.01, "{jump}");
        assert_eq!(old.attitude, new.attitude);
        for (i, SimulatedWheel { wheel, .. }) in scenario.wheels.iter().enumerate() {
            let speed = new.wheel_speed_rad_s[i] - old.wheel_speed_rad_s[i];
            assert!((speed + wheel.axis.dot(&jump)).abs() < 1e-12 * 400.0, "{speed}");
        }
    }

    /// Total momentum in body axes and wheel momenta as the state: `ḣ = −ω × h`,
    /// `J(t) ω = h − h_w`, with `J` instead of `J_b`, and without `J̇`.
    struct MomentumAlone<'a> {
        scenario: &'a Scenario,
    }

    impl MomentumAlone<'_> {
        fn inertia(&self, time_s: f64) -> Matrix3<f64> {
            let start = tensor(&self.scenario.spacecraft.inertia_kg_m2);
            let share = tensor(&self.scenario.changes.drift_per_hour) * (time_s / 3600.0);
            start + start.component_mul(&share)
        }

        /// Solves `J ω = h − h_w` with `h_w = Σ (hᵢ − Iₛᵢ aᵢ · ω) aᵢ`.
        fn rate(&self, time_s: f64, state: &[f64]) -> Vector3<f64> {
            let mut momentum = Vector3::from_column_slice(&state[..3]);
            let mut body = self.inertia(time_s);
            for (SimulatedWheel { wheel, .. }, axial) in
                self.scenario.wheels.iter().zip(&state[3..])
            {
                momentum -= wheel.axis * *axial;
                body -= wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2;
            }
            body.lu().solve(&momentum).unwrap()
        }
    }

    impl Equations for MomentumAlone<'_> {
        fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
            let momentum = Vector3::from_column_slice(&state[..3]);
            let turn = -self.rate(time_s, state).cross(&momentum);
            derivative[..3].copy_from_slice(turn.as_slice());
            for (i, motor) in self.scenario.wheels.iter().enumerate() {
                derivative[3 + i] = motor.torque.at(time_s);
            }
        }
    }

    #[test]
    fn drift_agrees_with_conservation_of_momentum() {
        let text =
            format!("{CHANGING}[drift]\ninertia_rate_per_hour = [0.2, -0.1, 0.15, 1.0, 0, -0.5]");
        let scenario = Scenario::from_toml("s.toml", &text, Path::new("")).unwrap();
        let (craft, alone) = (Spacecraft::new(&scenario), MomentumAlone { scenario: &scenario });
        let mut state = craft.initial_state();
        let motion = craft.motion(&state);
        let start = craft.inertia_kg_m2(0.0) * motion.rate_rad_s + motion.wheel_momentum_n_m_s;
        let axial = state[WHEELS..].iter().map(|h| h * craft.mean_moment_kg_m2());
        let mut other: Vec<f64> = start.iter().copied().chain(axial).collect();
        let without = Scenario { changes: Default::default(), ..scenario.clone() };
        let steady = Spacecraft::new(&without);
        let mut undrifted = state.clone();
        for minute in 0..20 {
            let (from_s, to_s) = (60.0 * f64::from(minute), 60.0 * f64::from(minute + 1));
            state = advance(&craft, from_s, to_s, state).unwrap();
            other = advance(&alone, from_s, to_s, other).unwrap();
            undrifted = advance(&steady, from_s, to_s, undrifted).unwrap();
            let apart = rate(&state) - alone.rate(to_s, &other);
            assert!(apart.norm() < MAX_DRIFT * 0.07, "t = {to_s}: {apart}");
            let turned = craft.inertial_momentum_n_m_s(to_s, &state) - start;
            assert!(turned.norm() < MAX_DRIFT * start.norm(), "t = {to_s}: {turned}");
        }
        assert!((rate(&undrifted) - rate(&state)).norm() > 0.01, "the drift has an effect");
    }

    /// A heavy body with one wheel along z, and this error of the wheel.
    fn unbalanced(error: &str) -> Scenario {
        let text = format!(
            "name = 'wheel'\nduration_s = 10\n[spacecraft]\n\
             inertia_kg_m2 = [30, 40, 50, 0, 0, 0]\n[gyro]\nrate_hz = 10\nnoise_rad_s = 1e-4\n\
             [[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1e-3\nspeed_rad_s = 200\n\
             [hardware]\n[[hardware.wheel]]\n{error}\n"
        );
        Scenario::from_toml("s.toml", &text, Path::new("")).unwrap()
    }

    #[test]
    fn imbalance_shakes_the_body_at_the_wheel_speed() {
        for (error, torque_n_m) in [
            ("static_imbalance_kg_m = 1e-6\nposition_m = [0, 0, 0.2]", 1e-6 * 200.0 * 200.0 * 0.2),
            ("dynamic_imbalance_kg_m2 = 3e-7", 3e-7 * 200.0 * 200.0),
        ] {
            let scenario = unbalanced(error);
            let craft = Spacecraft::new(&scenario);
            let (mut state, period_s) = (craft.initial_state(), std::f64::consts::TAU / 200.0);
            let mut angles = Vec::new();
            for k in 0..40 {
                let t = f64::from(k) * period_s / 8.0;
                let torque = craft.imbalance_torque_n_m(&state);
                assert!((torque.norm() / torque_n_m - 1.0).abs() < 1e-3, "{torque}");
                assert!(torque.z.abs() < 1e-15);
                angles.push(torque.y.atan2(torque.x));
                state = advance(&craft, t, t + period_s / 8.0, state).unwrap();
            }
            for pair in angles.windows(2) {
                let turned = (pair[1] - pair[0]).rem_euclid(std::f64::consts::TAU);
                assert!((turned - std::f64::consts::TAU / 8.0).abs() < 1e-3, "{turned}");
            }
        }
    }

    #[test]
    fn true_wheels_differ_from_the_stated_by_their_errors() {
        let scenario = unbalanced("spin_inertia = 0.01\naxis_deg = [0.2, 0]");
        let (stated, found) = (&scenario.wheels[0].wheel, &scenario.true_wheels()[0].wheel);
        assert!((found.spin_inertia_kg_m2 / stated.spin_inertia_kg_m2 - 1.01).abs() < 1e-12);
        assert!((found.axis.angle(&stated.axis).to_degrees() - 0.2).abs() < 1e-5);
        assert_eq!(scenario.craft().wheels[0], *stated);
        // e₁ = z × x = y.
        assert!(found.axis.y > 0.0 && found.axis.x == 0.0);
    }

    #[test]
    fn pulse_changes_the_momentum_by_its_impulse() {
        let mut scenario = unbalanced("spin_inertia = 0");
        scenario.true_hardware.pulses = vec![Pulse {
            time_s: 1.02,
            duration_s: 0.05,
            torque_n_m: Vector3::new(0.1, -0.2, 0.3),
        }];
        let flight = crate::truth::Flight::simulate(&scenario).unwrap();
        let [before, after] = [10, 11].map(|index: usize| {
            let instant = &flight.instants[index];
            let h_w = scenario.wheels[0].wheel.spin_inertia_kg_m2 * instant.wheel_speed_rad_s[0];
            let body = tensor(&instant.inertia_kg_m2) * instant.rate_rad_s;
            instant.attitude * (body + Vector3::z() * h_w)
        });
        let impulse = Vector3::new(0.1, -0.2, 0.3) * 0.05;
        // The body turns by about 1e-4 rad meanwhile.
        assert!((after - before - impulse).norm() < 1e-4 * impulse.norm(), "{}", after - before);
    }

    #[test]
    fn attitude_stays_a_rotation() {
        let scenario = Scenario::load("stsat3-spin-up").unwrap();
        let craft = Spacecraft::new(&scenario);
        let state = advance(&craft, 0.0, 600.0, craft.initial_state()).unwrap();
        let square: f64 = state[ATTITUDE..WHEELS].iter().map(|q| q * q).sum();
        assert!((square - 1.0).abs() < MAX_DRIFT);
    }
}
