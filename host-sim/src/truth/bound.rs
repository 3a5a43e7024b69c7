//! The Cramér-Rao bound of a flight, by variational equations along the true motion.
//!
//! For given motion, noise and unknowns no unbiased estimator beats
//! `C = (Σₖ Sₖᵀ R⁻¹ Sₖ)⁻¹`, `Sₖ = ∂z(tₖ)/∂(unknowns)`. The unknowns are the initial rate and the
//! inertia, and the disturbance torque and gyro bias where they are estimated too. The wheels'
//! speeds are measured and so known functions of time, in a closed loop too: what the controller
//! would have done with another inertia doesn't matter, since what the wheels did is known. Then
//!
//! `J Ṡ = ([J ω + h_w]^× − ω^× J − J̇) S − [G(ω̇) + ω^× G(ω)] E_j + E_τ`.
//!
//! After a sudden change of the inertia all begins anew: the bound is of what the flight shows from
//! then on, to whoever knows nothing of before. Where the inertia drifts, the unknown is a constant
//! added to its course, which is the same at the end as at any time: the bound is of whoever knows how
//! it drifts. Nobody on board does, so that an estimate may well be above it by some factor, and NEES
//! is what it is judged by.

use nalgebra::{DMatrix, Matrix3x6, Vector3};

use super::integrate::Equations;
use super::spacecraft::{Spacecraft, inverse};
use super::unmodelled::{Columns, TorqueEffect};
use crate::input::scenario::Scenario;

/// A direction or element is unseen when the bound leaves its sigma above this many mean moments
/// of inertia: a number as uncertain as the body is large says nothing.
pub(super) const UNSEEN_SIGMA: f64 = 1.0;
/// Where there is no information at all, sigma is cut off here, so that sums stay finite.
pub(super) const NO_INFORMATION_SIGMA: f64 = 1e6;

/// Where inertia and torque stand among the unknowns: first comes the rate.
const INERTIA: usize = 3;
const TORQUE: usize = 9;

/// What is estimated, and so what the bound allows for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknowns {
    /// A constant disturbance torque.
    pub torque: bool,
    /// A constant gyro bias.
    pub gyro_bias: bool,
}

impl Unknowns {
    /// As the scenario asks.
    pub fn of(scenario: &Scenario) -> Self {
        let asked = &scenario.solve_for;
        Self { torque: asked.torque, gyro_bias: asked.gyro_bias }
    }

    /// Names, in the order of the bound's rows.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names = vec!["rate_x", "rate_y", "rate_z"];
        names.extend(["jxx", "jyy", "jzz", "jxy", "jxz", "jyz"]);
        if self.torque {
            names.extend(["torque_x", "torque_y", "torque_z"]);
        }
        if self.gyro_bias {
            names.extend(["gyro_bias_x", "gyro_bias_y", "gyro_bias_z"]);
        }
        names
    }

    /// Columns of the sensitivities that follow a differential equation: all but the bias.
    fn dynamic(&self) -> usize {
        if self.torque { 12 } else { 9 }
    }

    fn count(&self) -> usize {
        self.dynamic() + if self.gyro_bias { 3 } else { 0 }
    }
}

/// The motion and its sensitivities as one system. Inertia and torque are counted in units of
/// the mean moment of inertia (per s²), so that all sensitivities are of the size of a rate.
pub struct Sensitivities<'a> {
    craft: &'a Spacecraft<'a>,
    unknowns: Unknowns,
}

impl<'a> Sensitivities<'a> {
    /// Sensitivities of this spacecraft's motion.
    pub fn new(craft: &'a Spacecraft<'a>, unknowns: Unknowns) -> Self {
        Self { craft, unknowns }
    }

    /// This motion, and `S = [1 0 …]`.
    pub fn from_motion(&self, mut state: Vec<f64>) -> Vec<f64> {
        let start = self.craft.dimension();
        state.resize(start + 3 * self.unknowns.dynamic(), 0.0);
        for i in 0..3 {
            state[start + 3 * i + i] = 1.0;
        }
        state
    }

    /// `∂z/∂(unknowns)`, 3 rows, in the scaled units.
    pub fn of_rate(&self, state: &[f64]) -> DMatrix<f64> {
        let columns = self.unknowns.dynamic();
        let mut s = DMatrix::zeros(3, self.unknowns.count());
        s.columns_mut(0, columns).copy_from_slice(&state[self.craft.dimension()..]);
        for i in columns..self.unknowns.count() {
            s[(i - columns, i)] = 1.0;
        }
        s
    }

    /// Nothing seen yet.
    pub fn empty_information(&self) -> Information {
        let count = self.unknowns.count();
        Information {
            unknowns: self.unknowns,
            typical_kg_m2: self.craft.typical_kg_m2(),
            factor: DMatrix::zeros(count, count),
            pending: Vec::new(),
        }
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
            * -self.craft.typical_kg_m2();
        for column in 0..self.unknowns.dynamic() {
            let at = start + 3 * column;
            let s = Vector3::new(state[at], state[at + 1], state[at + 2]);
            let mut slope = by_rate * s;
            match column {
                0..3 => {}
                3..9 => slope += by_inertia.column(column - 3),
                _ => slope += inverse.column(column - 9) * self.craft.typical_kg_m2(),
            }
            derivative[at..at + 3].copy_from_slice(slope.as_slice());
        }
    }
}

/// `J v = G(v) j`. Written here again rather than taken from the flight core: the yardstick
/// shares no code with what it measures.
fn regressor(v: &Vector3<f64>) -> Matrix3x6<f64> {
    Matrix3x6::new(
        v.x, 0.0, 0.0, v.y, v.z, 0.0, //
        0.0, v.y, 0.0, v.x, 0.0, v.z, //
        0.0, 0.0, v.z, 0.0, v.x, v.y,
    )
}

/// Sensitivities gathered into a triangular factor, so that a motion of condition 1e7 keeps its
/// digits.
pub struct Information {
    unknowns: Unknowns,
    typical_kg_m2: f64,
    factor: DMatrix<f64>,
    pending: Vec<f64>,
}

/// Rows gathered before each factorisation: a trade of memory for speed, nothing else.
const BATCH_ROWS: usize = 300;

impl Information {
    /// Takes in the sensitivities of one sample, 3 × unknowns.
    pub fn add(&mut self, sensitivities: &DMatrix<f64>) {
        self.pending.extend_from_slice(sensitivities.transpose().as_slice());
        if self.pending.len() >= BATCH_ROWS * self.unknowns.count() {
            self.fold();
        }
    }

    fn fold(&mut self) {
        let count = self.unknowns.count();
        let rows = self.pending.len() / count;
        let mut stacked = DMatrix::zeros(count + rows, count);
        stacked.rows_mut(0, count).copy_from(&self.factor);
        stacked.rows_mut(count, rows).copy_from(&DMatrix::from_row_slice(
            rows,
            count,
            &self.pending,
        ));
        self.factor = stacked.qr().r();
        self.pending.clear();
    }

    /// The bound for gyro noise of this variance per sample and axis, rad²/s².
    pub fn finish(mut self, noise_variance_rad2_s2: f64) -> Bound {
        self.fold();
        let svd = self.factor.clone().svd(false, true);
        let sigma = noise_variance_rad2_s2.sqrt();
        let deviations: Vec<f64> = svd.singular_values.iter().map(|s| sigma / s).collect();
        let v_t = svd.v_t.unwrap_or_else(|| DMatrix::from_element(0, 0, f64::NAN));
        // Covariance in scaled units; directions without information stand out by their size.
        let mut covariance = DMatrix::zeros(self.unknowns.count(), self.unknowns.count());
        for (deviation, direction) in deviations.iter().zip(v_t.row_iter()) {
            let bounded = deviation.min(NO_INFORMATION_SIGMA);
            covariance += direction.transpose() * direction * (bounded * bounded);
        }
        let scaled = covariance.view((INERTIA, INERTIA), (6, 6)).into_owned();
        let directions = scaled.clone().symmetric_eigenvalues();
        let observed = directions.iter().filter(|v| v.max(0.0).sqrt() < UNSEEN_SIGMA).count();
        let typical = self.typical_kg_m2;
        let element = |i: usize| {
            let deviation = scaled[(i, i)].max(0.0).sqrt();
            (deviation < UNSEEN_SIGMA).then_some(deviation * typical)
        };
        let sigma_kg_m2: [Option<f64>; 6] = std::array::from_fn(element);
        Bound {
            unknowns: self.unknowns,
            sigma_kg_m2,
            observed_directions: observed,
            torque: self.unknowns.torque.then(|| {
                let columns = Columns { inertia: INERTIA, torque: TORQUE };
                TorqueEffect::new(&self.factor, &columns, sigma, typical)
            }),
        }
    }
}

/// What no unbiased estimator can beat.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// What else than rate and inertia is unknown.
    pub unknowns: Unknowns,
    /// One sigma of each element, kg m², or none where the motion doesn't show it.
    pub sigma_kg_m2: [Option<f64>; 6],
    /// Directions of the inertia that the motion shows, 0 to 6.
    pub observed_directions: usize,
    /// What a constant torque does, if it is among the unknowns.
    pub torque: Option<TorqueEffect>,
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Matrix3;

    use super::*;
    use crate::input::scenario::change::Stretch;
    use crate::truth::Flight;
    use crate::truth::integrate::advance;

    /// The spin-up of STSAT-3, one sigma in per cent of each element, derived independently.
    const STSAT_3_PERCENT: [f64; 6] = [0.0194, 0.0144, 0.0157, 1.294, 1.196, 0.142];

    #[test]
    fn stsat_3_is_bounded_as_known() {
        let scenario = Scenario::load("stsat3-spin-up").unwrap();
        let bound = Flight::simulate(&scenario).unwrap().bound;
        assert_eq!(bound.observed_directions, 6);
        for i in 0..6 {
            let percent =
                100.0 * bound.sigma_kg_m2[i].unwrap() / scenario.spacecraft.inertia_kg_m2[i];
            assert!((percent / STSAT_3_PERCENT[i] - 1.0).abs() < 0.02, "element {i}: {percent} %");
        }
    }

    /// A body of another inertia beside the true one, with the wheel momentum of the true flight,
    /// `J' ω̇' = −ḣ_w − ω' × (J' ω' + h_w)`: what the wheels do is measured, not computed again.
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
                // ḣ_w of a wheel: its axial momentum less the part that turns with the body.
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
    fn sensitivities_of_a_closed_loop_are_differences_between_flights_of_the_same_wheels() {
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
            let [_, _, _, xx, yy, zz, xy, xz, yz] = unknowns.map(|u| u * craft.typical_kg_m2());
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
            // Third derivatives times the step squared, and rounding over the step.
            assert!(error < 1e-7 * expected.column(column).norm().max(1e-2), "{column}: {error}");
        }
    }

    #[test]
    fn sensitivities_of_a_drifting_body_are_differences_between_flights_of_the_same_drift() {
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
                inertia_kg_m2[element] += sign * step * craft.typical_kg_m2();
                let neighbour =
                    Spacecraft::of_stretch(&scenario, &Stretch { inertia_kg_m2, ..stretch });
                let end = advance(&neighbour, 0.0, end_s, craft.initial_state()).unwrap();
                craft.motion(&end).rate_rad_s
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
            let expected = expected.column(3 + element);
            let error = (slope - expected).norm();
            // Third derivatives times the step squared, and rounding over the step.
            assert!(error < 1e-7 * expected.norm().max(1e-2), "{element}: {error}");
        }
    }

    #[test]
    fn sensitivities_to_a_disturbance_torque_are_differences_between_flights_that_feel_it() {
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
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step_n_m) * craft.typical_kg_m2();
            let expected = expected.column(9 + axis);
            let error = (slope - expected).norm();
            // Third derivatives times the step squared, and rounding over the step.
            assert!(error < 1e-5 * expected.norm(), "{axis}: {error} of {}", expected.norm());
        }
    }

    #[test]
    fn who_must_find_a_disturbance_too_finds_the_inertia_less_well() {
        let mut scenario = Scenario::load("microsat-slew").unwrap();
        scenario.disturbance_torque_n_m = Vector3::new(1e-5, -1e-5, 0.0);
        let alone = Flight::simulate(&scenario).unwrap().bound;
        scenario.solve_for.torque = true;
        let both = Flight::simulate(&scenario).unwrap().bound;
        assert_eq!(both.unknowns.names().len(), 12);
        for i in 0..6 {
            let ratio = both.sigma_kg_m2[i].unwrap() / alone.sigma_kg_m2[i].unwrap();
            assert!(ratio > 1.01, "element {i}: {ratio}");
        }
    }

    /// A body that is shaken during these times, s, and whatever else happens to it.
    fn shaken(duration_s: f64, during_s: &str, other: &str) -> Scenario {
        let text = format!(
            r#"
            name = "shaken"
            duration_s = {duration_s}
            [spacecraft]
            inertia_kg_m2 = [3, 4, 5.25, 0.1, 0.2, -0.1]
            [gyro]
            rate_hz = 4
            noise_rad_s = 1e-4
            [torque]
            kind = "multisine"
            amplitude_n_m = [[0.05], [0.05], [0.05]]
            frequency_hz = [[0.05], [0.1], [0.15]]
            phase_rad = [[0], [0], [0]]
            during_s = {during_s}
            [disturbance]
            gyro_bias = true
            {other}
            "#
        );
        Scenario::from_toml("s.toml", &text, Path::new("")).unwrap()
    }

    #[test]
    fn after_a_sudden_change_the_bound_is_that_of_a_flight_that_begins_there() {
        let change = "[[change]]\ntime_s = 40\ninertia_kg_m2 = [3, 4, 5.25, 0.1, 0.2, -0.1]\n";
        let mut scenario = shaken(110.0, "[[0, 20], [50, 110]]", change);
        scenario.spacecraft.inertia_kg_m2 = [3.0, 4.0, 5.0, 0.0, 0.0, 0.0];
        let flight = Flight::simulate(&scenario).unwrap();
        let mut fresh = shaken(70.0, "[[10, 70]]", "");
        let at_change = flight.instants.iter().find(|instant| instant.time_us == 40_000_000);
        fresh.spacecraft.rate_rad_s = at_change.unwrap().rate_rad_s;
        let fresh = Flight::simulate(&fresh).unwrap();
        for i in 0..6 {
            let ratio = flight.bound.sigma_kg_m2[i].unwrap() / fresh.bound.sigma_kg_m2[i].unwrap();
            assert!((ratio - 1.0).abs() < 1e-9, "element {i}: {ratio}");
        }
    }

    #[test]
    fn a_slew_about_one_axis_shows_three_directions_and_one_that_wanders_shows_six() {
        let bound = |name| Flight::simulate(&Scenario::load(name).unwrap()).unwrap().bound;
        assert_eq!(bound("kim-2010-slew").observed_directions, 3);
        let microsat = bound("microsat-slew");
        assert_eq!(microsat.observed_directions, 6);
        let scenario = Scenario::load("microsat-slew").unwrap();
        for i in 0..6 {
            let share = microsat.sigma_kg_m2[i].unwrap() / scenario.spacecraft.inertia_kg_m2[i];
            assert!(share.abs() < 0.05, "element {i}: {share}");
        }
    }
}
