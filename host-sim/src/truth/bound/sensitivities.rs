//! Sensitivities of the body rate to the unknowns, by the variational equations of the motion.
//!
//! With the gyrostat equation `J ω̇ + J̇ ω + ω × (J ω + h_w) + ḣ_w = τ` and known wheel momentum
//! `h_w(t)`, the sensitivity `S = ∂ω/∂θ` follows
//!
//! ```text
//! J Ṡ = ([J ω + h_w]^× − ω^× J − J̇) S − [G(ω̇) + ω^× G(ω)] E_J + E_τ,   S(0) = [1 0 …]
//! ```
//!
//! with `J` the inertia, kg m²; `ω` the body rate, rad/s; `h_w` the wheel momentum relative to the
//! body, N m s; `[·]^×` the cross-product matrix; `G(v)` the regressor, `J v = G(v) j`; `E_J` and `E_τ`
//! the columns of inertia and torque. The sensitivity to the gyro bias is the identity.

use nalgebra::{DMatrix, Matrix3x6, Vector3};

use super::unknowns::{INERTIA, TORQUE, Unknowns};
use crate::truth::integrate::Equations;
use crate::truth::spacecraft::{Spacecraft, inverse};

/// Motion and sensitivities as one system of equations: the state vector of the spacecraft, then the
/// columns of `S` in the scaled units of [`unknowns`](super::unknowns).
pub struct Sensitivities<'a> {
    craft: &'a Spacecraft<'a>,
    unknowns: Unknowns,
}

impl<'a> Sensitivities<'a> {
    /// Sensitivities of the motion of this spacecraft.
    pub fn new(craft: &'a Spacecraft<'a>, unknowns: Unknowns) -> Self {
        Self { craft, unknowns }
    }

    /// State vector of the system at the start: this motion, and `S = [1 0 …]`.
    pub fn from_motion(&self, mut state: Vec<f64>) -> Vec<f64> {
        let start = self.craft.dimension();
        state.resize(start + 3 * self.unknowns.dynamic(), 0.0);
        for i in 0..3 {
            state[start + 3 * i + i] = 1.0;
        }
        state
    }

    /// `∂z/∂θ` of the measured rate, 3 × unknowns, in the scaled units.
    pub fn of_rate(&self, state: &[f64]) -> DMatrix<f64> {
        let columns = self.unknowns.dynamic();
        let mut s = DMatrix::zeros(3, self.unknowns.count());
        s.columns_mut(0, columns).copy_from_slice(&state[self.craft.dimension()..]);
        for i in columns..self.unknowns.count() {
            s[(i - columns, i)] = 1.0;
        }
        s
    }
}

impl Equations for Sensitivities<'_> {
    fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
        let start = self.craft.dimension();
        self.craft.derivative(time_s, &state[..start], &mut derivative[..start]);
        let motion = self.craft.motion(&state[..start]);
        let w = motion.rate_rad_s;
        let acceleration = Vector3::new(derivative[0], derivative[1], derivative[2]);
        let j = self.craft.inertia_kg_m2(time_s);
        let inverse = inverse(&j);
        let momentum = j * w + motion.wheel_momentum_n_m_s;
        let by_rate = inverse
            * (momentum.cross_matrix() - w.cross_matrix() * j - self.craft.inertia_slope_kg_m2_s());
        let by_inertia = inverse
            * (regressor(&acceleration) + w.cross_matrix() * regressor(&w))
            * -self.craft.mean_moment_kg_m2();
        for column in 0..self.unknowns.dynamic() {
            let at = start + 3 * column;
            let s = Vector3::new(state[at], state[at + 1], state[at + 2]);
            let mut slope = by_rate * s;
            match column {
                0..INERTIA => {}
                INERTIA..TORQUE => slope += by_inertia.column(column - INERTIA),
                _ => slope += inverse.column(column - TORQUE) * self.craft.mean_moment_kg_m2(),
            }
            derivative[at..at + 3].copy_from_slice(slope.as_slice());
        }
    }
}

/// Regressor `G(v)` of the inertia, `J v = G(v) j`. A second implementation beside the flight
/// core's: the bound shares no code with the estimators it judges.
pub(super) fn regressor(v: &Vector3<f64>) -> Matrix3x6<f64> {
    Matrix3x6::new(
        v.x, 0.0, 0.0, v.y, v.z, 0.0, //
        0.0, v.y, 0.0, v.x, 0.0, v.z, //
        0.0, 0.0, v.z, 0.0, v.x, v.y,
    )
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::input::scenario::Scenario;
    use crate::input::scenario::change::Stretch;
    use crate::truth::integrate::advance;

    /// A body with another inertia `J′` and the wheel momentum of the true flight,
    /// `J′ ω̇′ = −ḣ_w − ω′ × (J′ ω′ + h_w)`, since the wheel speeds are measured.
    struct Neighbour<'a> {
        craft: &'a Spacecraft<'a>,
        scenario: &'a Scenario,
        inertia: Matrix3<f64>,
    }

    impl Equations for Neighbour<'_> {
        fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
            let end = self.craft.dimension();
            self.craft.derivative(time_s, &state[..end], &mut derivative[..end]);
            let acceleration = Vector3::new(derivative[0], derivative[1], derivative[2]);
            let motors = self.craft.motor_torque_n_m(time_s, &state[..end]);
            let mut torque = Vector3::zeros();
            for (motor, driven) in motors.iter().zip(&self.scenario.wheels) {
                // ḣ_w of a wheel: slope of its axial momentum less that of the part turning with the body.
                let wheel = &driven.wheel;
                let with_body = wheel.spin_inertia_kg_m2 * wheel.axis.dot(&acceleration);
                torque -= wheel.axis * (motor - with_body);
            }
            let h_w = self.craft.motion(&state[..end]).wheel_momentum_n_m_s;
            let w = Vector3::new(state[end], state[end + 1], state[end + 2]);
            let slope =
                self.inertia.try_inverse().unwrap() * (torque - w.cross(&(self.inertia * w + h_w)));
            derivative[end..].copy_from_slice(slope.as_slice());
        }
    }

    #[test]
    fn closed_loop_sensitivities_match_finite_differences_at_equal_wheel_momentum() {
        let scenario = Scenario::load("microsat-slew").unwrap();
        let craft = Spacecraft::new(&scenario);
        let equations = Sensitivities::new(&craft, Unknowns::of(&scenario));
        let end_s = 60.0;
        let state = {
            let start = equations.from_motion(craft.initial_state());
            advance(&equations, 0.0, end_s, start)
        }
        .unwrap();
        let expected = equations.of_rate(&state);
        let end_rate = |unknowns: [f64; 9]| {
            let [_, _, _, xx, yy, zz, xy, xz, yz] = unknowns.map(|u| u * craft.mean_moment_kg_m2());
            let change = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            let inertia = craft.inertia_kg_m2(0.0) + change;
            let neighbour = Neighbour { craft: &craft, scenario: &scenario, inertia };
            let mut state = craft.initial_state();
            let rate: Vec<f64> = (0..3).map(|i| state[i] + unknowns[i]).collect();
            state.extend(rate);
            let end = advance(&neighbour, 0.0, end_s, state).unwrap();
            Vector3::from_column_slice(&end[craft.dimension()..])
        };
        let step = 1e-5;
        for column in 0..9 {
            let at = |sign: f64| {
                end_rate(std::array::from_fn(|i| if i == column { sign * step } else { 0.0 }))
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
            let error = (slope - expected.column(column)).norm();
            // Truncation (third derivative times step²) and rounding over the step.
            assert!(error < 1e-7 * expected.column(column).norm().max(1e-2), "{column}: {error}");
        }
    }

    #[test]
    fn drift_sensitivities_match_finite_differences() {
        let mut scenario = Scenario::load("stsat3-spin-up").unwrap();
        scenario.changes.drift_per_hour = [0.5, -0.5, 0.3, 4.0, 4.0, -2.0];
        let stretch = scenario.stretch(0);
        let craft = Spacecraft::new(&scenario);
        let equations = Sensitivities::new(&craft, Unknowns::of(&scenario));
        let end_s = 600.0;
        let start = equations.from_motion(craft.initial_state());
        let expected = equations.of_rate(&advance(&equations, 0.0, end_s, start).unwrap());
        let step = 1e-5;
        for element in 0..6 {
            let at = |sign: f64| {
                let mut inertia_kg_m2 = stretch.inertia_kg_m2;
                inertia_kg_m2[element] += sign * step * craft.mean_moment_kg_m2();
                let neighbour =
                    Spacecraft::of_stretch(&scenario, &Stretch { inertia_kg_m2, ..stretch });
                let end = advance(&neighbour, 0.0, end_s, craft.initial_state()).unwrap();
                craft.motion(&end).rate_rad_s
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
            let expected = expected.column(3 + element);
            let error = (slope - expected).norm();
            // Truncation (third derivative times step²) and rounding over the step.
            assert!(error < 1e-7 * expected.norm().max(1e-2), "{element}: {error}");
        }
    }

    #[test]
    fn torque_sensitivities_match_finite_differences() {
        let mut scenario = Scenario::load("stsat3-spin-up").unwrap();
        scenario.solve_for.torque = true;
        let craft = Spacecraft::new(&scenario);
        let equations = Sensitivities::new(&craft, Unknowns::of(&scenario));
        let end_s = 600.0;
        let start = equations.from_motion(craft.initial_state());
        let expected = equations.of_rate(&advance(&equations, 0.0, end_s, start).unwrap());
        let step_n_m = 1e-6;
        for axis in 0..3 {
            let at = |sign: f64| {
                let mut disturbed = scenario.clone();
                disturbed.disturbance_torque_n_m[axis] = sign * step_n_m;
                let craft = Spacecraft::new(&disturbed);
                let end = advance(&craft, 0.0, end_s, craft.initial_state()).unwrap();
                craft.motion(&end).rate_rad_s
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step_n_m) * craft.mean_moment_kg_m2();
            let expected = expected.column(9 + axis);
            let error = (slope - expected).norm();
            // Truncation (third derivative times step²) and rounding over the step.
            assert!(error < 1e-5 * expected.norm(), "{axis}: {error} of {}", expected.norm());
        }
    }
}
