//! Bound with stated errors of the hardware: considered, or solved with their prior.
//!
//! The reading is `z = (1 + E) ω(t − d) + b`, and the wheel momentum `h_w = Σ Iₛᵢ Ωᵢ aᵢ` has errors of
//! each `Iₛᵢ` and `aᵢ` while `Ωᵢ(t)` is measured. To first order about zero error, with `A` the matrix
//! of [`sensitivities`](super::sensitivities):
//!
//! ```text
//! gyro scale, axes      ∂z_i/∂E_ij = ω_j
//! delay                 ∂z/∂d      = −ω̇
//! wheel errors, p       J Ṡ = A S − ω × ∂h/∂p − ∂ḣ/∂p,   ∂h/∂p = Iₛ Ω a, Iₛ Ω e₁, Iₛ Ω e₂, or Σ Iₛ Ω a
//! torque scale          J Ṡ = A S + τ_commanded
//! clock                 J Ṡ = A S − J ω̇ − ḣ,   in its time, from (1 + ε) (J ω' + h') + ω × (J ω + h) = τ
//! mode, element k       J Ṡ = A S − E_k ξ̈ − ω × E_k ξ̇,   ξ̈ + 2 ζ Ω ξ̇ + Ω² ξ = −ω̇
//! ```
//!
//! `E_k` is the symmetric matrix of one element of the modal inertia `D Dᵀ`: the relative momentum of an
//! oscillator is `D η̇ = D Dᵀ ξ̇`.
//!
//! With the triangular factor `R` of `[S_x S_p]/σ` (see [`information`](super::information)), unknowns
//! `x` first and parameters `p` of covariance `Σ` last, and `C = R_xx⁻¹ R_xx⁻ᵀ`, `Γ = −R_xx⁻¹ R_xp`
//! (S. F. Schmidt, *Application of state-space
//! methods to navigation problems*, Advances in Control Systems 3, 1966):
//!
//! ```text
//! considered   C + Γ Σ Γᵀ
//! solved       first block of (Rᵀ R + diag(0, Σ⁻¹))⁻¹
//! ```
//!
//! Stated sigmas of torque and bias are prior information of these unknowns in both. Modal inertias are
//! unknowns in both.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::sensitivities::regressor;
use super::unknowns::{INERTIA, NO_INFORMATION_SIGMA, UNOBSERVED_SIGMA, Unknowns};
use crate::input::craft::Mode;
use crate::input::craft::hardware::tilt_directions;
use crate::input::scenario::Scenario;
use crate::truth::integrate::Equations;
use crate::truth::spacecraft::{Motion, Spacecraft, inverse};

/// Rows collected before each decomposition.
const BATCH_ROWS: usize = 300;
/// Elements of a modal inertia.
const MODAL: usize = 6;
/// Prior sigma of a modal inertia, mean moments of inertia: that of `window`.
const MODAL_SIGMA: f64 = 0.1;

/// An error of the hardware, and its column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Error {
    WheelInertia(usize),
    /// Wheel, direction 0 or 1.
    WheelAxis(usize, usize),
    CommonWheelInertia,
    TorqueScale,
    /// Rate of the clock that stamps the samples.
    Clock,
    GyroScale(usize),
    /// Row and column of `E`.
    GyroAxes(usize, usize),
    Delay,
}

/// Off-diagonal elements of `E` in the order of the files.
const OFF_DIAGONAL: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
const AXES: [&str; 3] = ["x", "y", "z"];

impl Error {
    /// Name of the error.
    pub(crate) fn name(self) -> String {
        match self {
            Self::WheelInertia(wheel) => format!("wheel_{}_spin_inertia", wheel + 1),
            Self::WheelAxis(wheel, direction) => {
                format!("wheel_{}_axis_{}", wheel + 1, direction + 1)
            }
            Self::CommonWheelInertia => "common_spin_inertia".to_owned(),
            Self::TorqueScale => "torque_scale".to_owned(),
            Self::Clock => "clock".to_owned(),
            Self::GyroScale(axis) => format!("gyro_scale_{}", AXES[axis]),
            Self::GyroAxes(row, column) => format!("gyro_axes_{}{}", AXES[row], AXES[column]),
            Self::Delay => "delay".to_owned(),
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::WheelAxis(..) | Self::GyroAxes(..) => "rad",
            Self::Delay => "s",
            _ => "",
        }
    }

    /// The sensitivity follows a differential equation.
    pub(crate) fn is_dynamic(self) -> bool {
        !matches!(self, Self::GyroScale(_) | Self::GyroAxes(..) | Self::Delay)
    }
}

/// Stated errors of a scenario with a sigma above zero: those with a differential equation first.
pub(crate) fn errors(scenario: &Scenario) -> Vec<(Error, f64)> {
    let stated = &scenario.hardware;
    let sigma = |sigmas: &[f64], wheel: usize| sigmas.get(wheel).copied().unwrap_or(0.0);
    let mut all = Vec::new();
    for wheel in 0..scenario.wheels.len() {
        let inertia = sigma(&stated.wheel_spin_inertia_sigma, wheel);
        let tilt = sigma(&stated.wheel_axis_sigma_rad, wheel);
        all.push((Error::WheelInertia(wheel), inertia));
        all.extend([0, 1].map(|direction| (Error::WheelAxis(wheel, direction), tilt)));
    }
    if !scenario.wheels.is_empty() {
        all.push((Error::CommonWheelInertia, stated.common_spin_inertia_sigma));
    }
    all.push((Error::TorqueScale, stated.torque_scale_sigma));
    all.push((Error::Clock, stated.clock_sigma));
    all.extend([0, 1, 2].map(|axis| (Error::GyroScale(axis), stated.gyro_scale_sigma)));
    let tilts = OFF_DIAGONAL.map(|(row, column)| Error::GyroAxes(row, column));
    all.extend(tilts.map(|error| (error, stated.gyro_axes_sigma_rad)));
    all.push((Error::Delay, stated.gyro_delay_sigma_s));
    all.retain(|(_, sigma)| *sigma > 0.0);
    all
}

/// Effect of one error.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Name, as `gyro_scale_x`.
    pub name: String,
    /// Unit of the sigma; empty for a share.
    pub unit: &'static str,
    /// Stated sigma.
    pub sigma: f64,
    /// Change of each estimated element by an unmodelled error of one sigma, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Sigma after the data over the stated sigma, if the error is solved for.
    pub posterior_over_prior: f64,
}

/// Bound with the stated errors.
#[derive(Clone, Debug, PartialEq)]
pub struct HardwareBound {
    /// One sigma of each element with the errors considered, kg m²; none where it is unobserved.
    pub considered_kg_m2: [Option<f64>; 6],
    /// The same with the errors among the unknowns, their sigmas as prior.
    pub solved_kg_m2: [Option<f64>; 6],
    /// Effect of each error.
    pub effects: Vec<Effect>,
}

/// Motion, oscillators `ξ`, and sensitivities to unknowns and errors as one system of equations.
pub struct HardwareSensitivities<'a> {
    craft: &'a Spacecraft<'a>,
    scenario: &'a Scenario,
    unknowns: Unknowns,
    errors: Vec<(Error, f64)>,
}

impl<'a> HardwareSensitivities<'a> {
    /// Sensitivities of the motion of this spacecraft; none without a stated error or mode.
    pub fn new(craft: &'a Spacecraft<'a>, scenario: &'a Scenario) -> Option<Self> {
        let errors = errors(scenario);
        if errors.is_empty() && scenario.hardware.modes.is_empty() {
            return None;
        }
        Some(Self { craft, scenario, unknowns: Unknowns::of(scenario), errors })
    }

    fn modes(&self) -> &[Mode] {
        &self.scenario.hardware.modes
    }

    /// Columns with a differential equation: rate, inertia, torque; modes; errors.
    fn dynamic(&self) -> usize {
        let errors = self.errors.iter().filter(|(error, _)| error.is_dynamic()).count();
        self.unknowns.dynamic() + MODAL * self.modes().len() + errors
    }

    /// Number of unknowns: those of the bound, and the modal inertias.
    fn unknown(&self) -> usize {
        self.unknowns.count() + MODAL * self.modes().len()
    }

    /// Index of the first sensitivity in the state.
    fn first_column(&self) -> usize {
        self.craft.dimension() + 6 * self.modes().len()
    }

    /// State vector at the start: this motion, oscillators at rest, and `S = [1 0 …]`.
    pub fn from_motion(&self, mut state: Vec<f64>) -> Vec<f64> {
        let start = self.first_column();
        state.resize(start + 3 * self.dynamic(), 0.0);
        for i in 0..3 {
            state[start + 3 * i + i] = 1.0;
        }
        state
    }

    /// `∂z/∂(x, p)` at a time, 3 × (unknowns + errors), in scaled units.
    fn of_reading(&self, time_s: f64, state: &[f64]) -> DMatrix<f64> {
        let start = self.first_column();
        let column = |index: usize| {
            let at = start + 3 * index;
            Vector3::new(state[at], state[at + 1], state[at + 2])
        };
        let motion = self.craft.motion(&state[..self.craft.dimension()]);
        let rate = motion.rate_rad_s;
        let (acceleration, _) = self.craft.slopes(time_s, &state[..self.craft.dimension()]);
        let dynamic = self.unknowns.dynamic();
        let modal = MODAL * self.modes().len();
        let mut columns: Vec<Vector3<f64>> = (0..dynamic).map(column).collect();
        let units = [Vector3::x(), Vector3::y(), Vector3::z()];
        columns.extend(&units[..self.unknowns.count() - dynamic]);
        columns.extend((dynamic..dynamic + modal).map(column));
        for (index, (error, _)) in self.errors.iter().enumerate() {
            columns.push(match *error {
                Error::GyroScale(axis) => units[axis] * rate[axis],
                Error::GyroAxes(row, other) => units[row] * rate[other],
                Error::Delay => -acceleration,
                // Errors with an equation come first.
                _ => column(dynamic + modal + index),
            });
        }
        DMatrix::from_fn(3, columns.len(), |row, index| columns[index][row])
    }

    /// Torque that one sigma-less unit of an error adds to `J Ṡ − A S`, N m, for accelerations of body and wheels.
    fn torque_n_m(
        &self,
        error: Error,
        time_s: f64,
        motion: &Motion,
        (acceleration, slopes): (&Vector3<f64>, &[f64]),
    ) -> Vector3<f64> {
        let wheels = self.craft.wheels();
        let of_wheel = |index: usize, direction: &Vector3<f64>| {
            let inertia = wheels[index].wheel.spin_inertia_kg_m2;
            let momentum = direction * (inertia * motion.wheel_speed_rad_s[index]);
            -motion.rate_rad_s.cross(&momentum) - direction * (inertia * slopes[index])
        };
        match error {
            Error::WheelInertia(index) => of_wheel(index, &wheels[index].wheel.axis),
            Error::WheelAxis(index, direction) => {
                of_wheel(index, &tilt_directions(&wheels[index].wheel.axis)[direction])
            }
            Error::CommonWheelInertia => {
                let all = wheels.iter().enumerate();
                all.map(|(index, motor)| of_wheel(index, &motor.wheel.axis)).sum()
            }
            Error::TorqueScale => self.scenario.torque.at(time_s),
            Error::Clock => {
                let of_wheels = wheels.iter().zip(slopes).map(|(motor, slope)| {
                    motor.wheel.axis * (motor.wheel.spin_inertia_kg_m2 * *slope)
                });
                -(self.craft.inertia_kg_m2(time_s) * acceleration) - of_wheels.sum::<Vector3<f64>>()
            }
            Error::GyroScale(_) | Error::GyroAxes(..) | Error::Delay => Vector3::zeros(),
        }
    }
}

impl Equations for HardwareSensitivities<'_> {
    fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
        let end = self.craft.dimension();
        self.craft.derivative(time_s, &state[..end], &mut derivative[..end]);
        let motion = self.craft.motion(&state[..end]);
        let (acceleration, slopes) = self.craft.slopes(time_s, &state[..end]);
        let w = motion.rate_rad_s;
        let j = self.craft.inertia_kg_m2(time_s);
        let inverse = inverse(&j);
        let momentum = j * w + motion.wheel_momentum_n_m_s;
        let by_rate = inverse
            * (momentum.cross_matrix() - w.cross_matrix() * j - self.craft.inertia_slope_kg_m2_s());
        let unit = self.craft.mean_moment_kg_m2();
        let mut torques = vec![Vector3::zeros(); 3];
        let by_inertia = regressor(&acceleration) + w.cross_matrix() * regressor(&w);
        torques.extend(by_inertia.column_iter().map(|column| -column * unit));
        if self.unknowns.has_torque() {
            torques.extend([Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis * unit));
        }
        for (k, mode) in self.modes().iter().enumerate() {
            let at = end + 6 * k;
            let xi = Vector3::from_column_slice(&state[at..at + 3]);
            let velocity = Vector3::from_column_slice(&state[at + 3..at + 6]);
            let frequency = std::f64::consts::TAU * mode.frequency_hz;
            let restoring = velocity * (2.0 * mode.damping * frequency) + xi * frequency.powi(2);
            let xi_acceleration = -acceleration - restoring;
            derivative[at..at + 3].copy_from_slice(velocity.as_slice());
            derivative[at + 3..at + 6].copy_from_slice(xi_acceleration.as_slice());
            let modal = regressor(&xi_acceleration) + w.cross_matrix() * regressor(&velocity);
            torques.extend(modal.column_iter().map(|column| -column * unit));
        }
        let dynamic = self.errors.iter().filter(|(error, _)| error.is_dynamic());
        torques.extend(
            dynamic.map(|(error, _)| {
                self.torque_n_m(*error, time_s, &motion, (&acceleration, &slopes))
            }),
        );
        write_columns(&by_rate, &inverse, &torques, self.first_column(), state, derivative);
    }
}

/// `Ṡ = A S + J⁻¹ τ` of each column.
fn write_columns(
    by_rate: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
    torques: &[Vector3<f64>],
    start: usize,
    state: &[f64],
    derivative: &mut [f64],
) {
    for (column, torque) in torques.iter().enumerate() {
        let at = start + 3 * column;
        let s = Vector3::new(state[at], state[at + 1], state[at + 2]);
        derivative[at..at + 3].copy_from_slice((by_rate * s + inverse * torque).as_slice());
    }
}

/// Triangular factor of unknowns and errors.
pub struct HardwareInformation {
    factor: DMatrix<f64>,
    pending: Vec<f64>,
}

impl HardwareInformation {
    /// No information yet.
    pub fn new(equations: &HardwareSensitivities<'_>) -> Self {
        let count = equations.unknown() + equations.errors.len();
        Self { factor: DMatrix::zeros(count, count), pending: Vec::new() }
    }

    /// Adds the sample at a time.
    pub fn add(&mut self, equations: &HardwareSensitivities<'_>, time_s: f64, state: &[f64]) {
        let rows = equations.of_reading(time_s, state).transpose();
        self.pending.extend_from_slice(rows.as_slice());
        if self.pending.len() >= BATCH_ROWS * self.factor.ncols() {
            self.fold();
        }
    }

    fn fold(&mut self) {
        let count = self.factor.ncols();
        let rows = DMatrix::from_row_slice(self.pending.len() / count, count, &self.pending);
        self.factor = stack(&self.factor, &rows).qr().r();
        self.pending.clear();
    }

    /// Bound for gyro noise of this sigma per sample and axis, rad/s.
    pub fn bound(
        mut self,
        equations: &HardwareSensitivities<'_>,
        noise_rad_s: f64,
    ) -> HardwareBound {
        self.fold();
        let unit = equations.craft.mean_moment_kg_m2();
        let (known, count) = (equations.unknown(), self.factor.ncols());
        let information = stack(&(self.factor / noise_rad_s), &prior(equations, count)).qr().r();
        let r_xx = information.view((0, 0), (known, known)).into_owned();
        let r_xp = information.view((0, known), (known, count - known)).into_owned();
        let sigmas = DVector::from_iterator(count - known, equations.errors.iter().map(|e| e.1));
        let singular = || DMatrix::repeat(known, known, f64::NAN);
        let inverse = r_xx.try_inverse().unwrap_or_else(singular);
        let random = &inverse * inverse.transpose();
        let effects = -&inverse * r_xp * DMatrix::from_diagonal(&sigmas);
        let considered = random + &effects * effects.transpose();
        let known_errors = DMatrix::from_fn(count - known, count, |row, column| {
            if column == known + row { 1.0 / sigmas[row] } else { 0.0 }
        });
        let solved = stack(&information, &known_errors).qr().r();
        let solved =
            solved.try_inverse().unwrap_or_else(|| DMatrix::repeat(count, count, f64::NAN));
        let solved = &solved * solved.transpose();
        let deviation = |covariance: &DMatrix<f64>, i: usize| {
            let sigma = covariance[(INERTIA + i, INERTIA + i)].sqrt();
            (sigma < UNOBSERVED_SIGMA).then_some(sigma * unit)
        };
        let effect = |(index, (error, sigma)): (usize, &(Error, f64))| Effect {
            name: error.name(),
            unit: error.unit(),
            sigma: *sigma,
            inertia_kg_m2: std::array::from_fn(|i| effects[(INERTIA + i, index)] * unit),
            posterior_over_prior: solved[(known + index, known + index)].sqrt() / sigma,
        };
        HardwareBound {
            considered_kg_m2: std::array::from_fn(|i| deviation(&considered, i)),
            solved_kg_m2: std::array::from_fn(|i| deviation(&solved, i)),
            effects: equations.errors.iter().enumerate().map(effect).collect(),
        }
    }
}

/// Prior of the unknowns: stated torque and bias, modal inertias; almost none of the rest.
fn prior(equations: &HardwareSensitivities<'_>, count: usize) -> DMatrix<f64> {
    let (stated, unknowns) = (&equations.scenario.hardware, &equations.unknowns);
    let mut sigmas = vec![NO_INFORMATION_SIGMA; INERTIA + 6];
    if unknowns.has_torque() {
        let unit = equations.craft.mean_moment_kg_m2();
        sigmas.extend([stated.torque_sigma_n_m.map_or(NO_INFORMATION_SIGMA, |s| s / unit); 3]);
    }
    if unknowns.count() > unknowns.dynamic() {
        sigmas.extend([stated.bias_sigma_rad_s.unwrap_or(NO_INFORMATION_SIGMA); 3]);
    }
    sigmas.resize(equations.unknown(), MODAL_SIGMA);
    let weight = |row: usize, column: usize| if row == column { 1.0 / sigmas[row] } else { 0.0 };
    DMatrix::from_fn(sigmas.len(), count, weight)
}

fn stack(above: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let mut stacked = DMatrix::zeros(above.nrows() + below.nrows(), above.ncols());
    stacked.rows_mut(0, above.nrows()).copy_from(above);
    stacked.rows_mut(above.nrows(), below.nrows()).copy_from(below);
    stacked
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::truth::Flight;
    use crate::truth::integrate::advance;

    /// Bound with the errors solved for, per cent of the mean moment, by an independent program (finite
    /// differences of a batch fit along simulated logs).
    const SOLVED_PERCENT: [(&str, [f64; 6]); 2] = [
        ("cubesat-pyramid-data-sheet", [0.4656, 0.835, 0.9475, 0.2925, 0.3114, 0.4212]),
        ("microsat-slew-data-sheet", [0.6276, 0.9238, 0.7537, 0.2634, 0.307, 0.3131]),
    ];

    #[test]
    fn solved_bound_matches_an_independent_derivation() {
        for (name, expected) in SOLVED_PERCENT {
            let scenario = Scenario::load(name).unwrap();
            let hardware = Flight::simulate(&scenario).unwrap().bound.hardware.unwrap();
            let mean = scenario.spacecraft.inertia_kg_m2[..3].iter().sum::<f64>() / 3.0;
            for i in 0..6 {
                let percent = 100.0 * hardware.solved_kg_m2[i].unwrap() / mean;
                assert!((percent / expected[i] - 1.0).abs() < 0.01, "{name} {i}: {percent} %");
                assert!(hardware.considered_kg_m2[i] >= hardware.solved_kg_m2[i], "{name} {i}");
            }
        }
    }

    #[test]
    fn common_scale_of_the_wheels_is_unobservable_and_scales_the_tensor() {
        let mut scenario = Scenario::load("cubesat-pyramid").unwrap();
        scenario.hardware.common_spin_inertia_sigma = 0.01;
        let flight = Flight::simulate(&scenario).unwrap();
        let effect = &flight.bound.hardware.unwrap().effects[0];
        assert_eq!(effect.name, "common_spin_inertia");
        assert!((effect.posterior_over_prior - 1.0).abs() < 1e-6);
        // The momenta of body and wheels balance: J of the estimate is in proportion to that of the
        // wheels. The least-squares unknown of an estimator too low by one sigma is too low by 1 %.
        for (found, element) in effect.inertia_kg_m2.iter().zip(scenario.spacecraft.inertia_kg_m2) {
            assert!((found.abs() / (0.01 * element.abs()) - 1.0).abs() < 1e-3, "{found}");
            assert!(found * element > 0.0, "{found}");
        }
    }

    #[test]
    fn hardware_without_errors_has_no_bound_of_its_own() {
        let flight = Flight::simulate(&Scenario::load("cubesat-pyramid").unwrap()).unwrap();
        assert_eq!(flight.bound.hardware, None);
        assert_eq!(flight.bound.joint_kg_m2(), [None; 6]);
    }

    /// A body driven about three axes, with a stated mode and torque scale.
    fn driven(extra: &str) -> Scenario {
        let text = format!(
            "name = 'driven'\nduration_s = 10\n[spacecraft]\n\
             inertia_kg_m2 = [3, 4, 5, 0.1, 0.2, -0.1]\nrate_rad_s = [0.02, -0.03, 0.05]\n\
             [gyro]\nrate_hz = 10\nnoise_rad_s = 1e-4\n[[mode]]\nfrequency_hz = 0.4\n\
             damping = 0.05\n[torque]\nkind = 'multisine'\nscale_sigma = 0.05\n\
             amplitude_n_m = [[0.1], [0.2], [0.15]]\nfrequency_hz = [[0.2], [0.3], [0.15]]\n\
             phase_rad = [[0], [1], [2]]\n{extra}\n"
        );
        Scenario::from_toml("s.toml", &text, Path::new("")).unwrap()
    }

    /// Rate at the end of a scenario, rad/s.
    fn end(scenario: &Scenario) -> Vector3<f64> {
        let craft = Spacecraft::new(scenario);
        let state = advance(&craft, 0.0, 10.0, craft.initial_state()).unwrap();
        craft.motion(&state).rate_rad_s
    }

    #[test]
    fn columns_of_mode_and_torque_scale_are_differences_of_true_motions() {
        let (scenario, small) = (driven(""), 1e-6);
        let craft = Spacecraft::new(&scenario);
        let equations = HardwareSensitivities::new(&craft, &scenario).unwrap();
        let state = equations.from_motion(craft.initial_state());
        let state = advance(&equations, 0.0, 10.0, state).unwrap();
        let columns = equations.of_reading(10.0, &state);
        // Rate 3, inertia 6, mode 6, torque scale.
        assert_eq!(columns.ncols(), 16);

        let scaled = driven(&format!("[hardware.torque]\nscale = {small}\n"));
        let difference = (end(&scaled) - end(&scenario)) / small;
        let column = Vector3::from(columns.fixed_view::<3, 1>(0, 15));
        assert!((difference - column).norm() < 1e-5 * column.norm(), "{difference} {column}");

        let axis = Vector3::new(1.0, 2.0, -1.0).normalize();
        let flexible = driven(&format!(
            "[[hardware.mode]]\nfrequency_hz = 0.4\ndamping = 0.05\ninertia_share = {small}\n\
             axis = [1, 2, -1]\n"
        ));
        let difference = (end(&flexible) - end(&scenario)) / small;
        let j = craft.inertia_kg_m2(0.0);
        let modal = axis * axis.transpose() * axis.dot(&(j * axis)) / craft.mean_moment_kg_m2();
        let elements = [modal.m11, modal.m22, modal.m33, modal.m12, modal.m13, modal.m23];
        let column = (0..6)
            .map(|k| Vector3::from(columns.fixed_view::<3, 1>(0, 9 + k)) * elements[k])
            .sum::<Vector3<f64>>();
        assert!((difference - column).norm() < 1e-4 * column.norm(), "{difference} {column}");
    }

    /// A clock's error is one of scale factors, spin inertias and torque, beside the rate at the start.
    #[test]
    fn a_clock_is_a_scale_of_gyro_wheels_and_torque() {
        let text = "name = 'clocked'\nduration_s = 10\n[spacecraft]\n\
             inertia_kg_m2 = [3, 4, 5, 0.1, 0.2, -0.1]\nrate_rad_s = [0.02, -0.03, 0.05]\n\
             [gyro]\nrate_hz = 10\nnoise_rad_s = 1e-4\nscale_sigma = 0.01\nclock_sigma = 0.01\n\
             [wheels]\ncommon_spin_inertia_sigma = 0.01\n\
             [[wheel]]\naxis = [1, 2, 2]\nspin_inertia_kg_m2 = 1e-3\nspeed_rad_s = 100\n\
             torque = { kind = 'multisine', amplitude_n_m = [0.02], frequency_hz = [0.2], phase_rad = [1] }\n\
             [torque]\nkind = 'multisine'\nscale_sigma = 0.05\n\
             amplitude_n_m = [[0.1], [0.2], [0.15]]\nfrequency_hz = [[0.2], [0.3], [0.15]]\n\
             phase_rad = [[0], [1], [2]]\n";
        let scenario = Scenario::from_toml("s.toml", text, Path::new("")).unwrap();
        let craft = Spacecraft::new(&scenario);
        let equations = HardwareSensitivities::new(&craft, &scenario).unwrap();
        let names: Vec<String> = equations.errors.iter().map(|(error, _)| error.name()).collect();
        assert_eq!(names[..3], ["common_spin_inertia", "torque_scale", "clock"]);
        let state = equations.from_motion(craft.initial_state());
        let state = advance(&equations, 0.0, 10.0, state).unwrap();
        let columns = equations.of_reading(10.0, &state);
        let column = |k: usize| Vector3::from(columns.fixed_view::<3, 1>(0, k));
        let start = craft.motion(&craft.initial_state()).rate_rad_s;
        // Rate 3, inertia 6, then the errors.
        let of_scale: Vector3<f64> =
            (0..3).map(|axis| column(12 + axis) - column(axis) * start[axis]).sum();
        let expected = of_scale - column(9) - column(10) * 2.0;
        assert!(
            (column(11) - expected).norm() < 1e-6 * column(11).norm(),
            "{} {expected}",
            column(11)
        );
    }
}
