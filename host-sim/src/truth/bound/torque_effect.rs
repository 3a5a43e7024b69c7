//! Effect of a constant body torque on a fit that does not model it, and its detectability.
//!
//! A constant torque `τ`, N m, changes the rates by `S_τ τ` to first order. A least-squares fit of the
//! other unknowns with sensitivities `S` absorbs the part within the span of `S` as an error of the
//! unknowns, and leaves the rest in the residuals:
//!
//! ```text
//! B = (Sᵀ S)⁻¹ Sᵀ S_τ      error of the unknowns per torque
//! (S_τ − S B) τ            residual
//! ```
//!
//! A torque along a commanded torque of constant direction is absorbed completely: it is
//! indistinguishable from another inertia.

use nalgebra::{DMatrix, DVector};

use super::unknowns::{INERTIA, NO_INFORMATION_SIGMA, TORQUE, UNOBSERVED_SIGMA};

/// Residual, as a share of the torque's effect on the rates, below which it is rounding error: the
/// sensitivities are integrated to about twelve digits.
const MIN_RESIDUAL_SHARE: f64 = 1e-8;

/// Effect of a constant torque about each body axis.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueEffect {
    /// Error of each element per unmodelled torque about x, y and z, kg m² per N m, to first order;
    /// none where the element is unobserved.
    pub inertia_error_kg_m2_per_n_m: [Option<[f64; 3]>; 6],
    /// Bound of a torque about each axis, one sigma, N m, with no torque about the other axes; none
    /// where the other unknowns absorb it.
    pub alone_n_m: [Option<f64>; 3],
    /// Bound of a torque about each axis, one sigma, N m, with unknown torques about the other axes.
    pub together_n_m: [Option<f64>; 3],
}

impl TorqueEffect {
    /// Effect from the triangular factor of the sensitivities to all unknowns, the torque included.
    /// Inertia and torque are scaled by `mean_moment_kg_m2`; `sigma_rad_s` is the gyro noise.
    pub(super) fn new(factor: &DMatrix<f64>, sigma_rad_s: f64, mean_moment_kg_m2: f64) -> Self {
        let others = factor.clone().remove_columns(TORQUE, 3);
        let fit = Fit::new(&others, sigma_rad_s);
        let torque = |axis: usize| factor.column(TORQUE + axis).into_owned();
        let absorbed: [DVector<f64>; 3] = std::array::from_fn(|axis| fit.solve(&torque(axis)));
        // Both are scaled by the mean moment, which cancels in the error per torque.
        let of_element = |i: usize| std::array::from_fn(|axis| absorbed[axis][INERTIA + i]);
        let sigma_n_m = |residual: Option<f64>| {
            residual.map(|residual| sigma_rad_s * mean_moment_kg_m2 / residual)
        };
        Self {
            inertia_error_kg_m2_per_n_m: std::array::from_fn(|i| {
                (fit.sigma[INERTIA + i] < UNOBSERVED_SIGMA).then(|| of_element(i))
            }),
            alone_n_m: std::array::from_fn(|axis| sigma_n_m(fit.residual(&torque(axis)))),
            together_n_m: std::array::from_fn(|axis| {
                let others = factor.clone().remove_column(TORQUE + axis);
                sigma_n_m(Fit::new(&others, sigma_rad_s).residual(&torque(axis)))
            }),
        }
    }
}

/// Least-squares fit with its unobserved directions held at zero.
struct Fit {
    /// Orthonormal basis of the rate changes that the unknowns can produce.
    basis: DMatrix<f64>,
    /// Map from coordinates in the basis to the unknowns.
    to_unknowns: DMatrix<f64>,
    /// One sigma of each unknown.
    sigma: DVector<f64>,
}

impl Fit {
    fn new(sensitivities: &DMatrix<f64>, sigma_rad_s: f64) -> Self {
        let svd = sensitivities.clone().svd(true, true);
        let empty = || DMatrix::from_element(0, 0, f64::NAN);
        let (u, v_t) = (svd.u.unwrap_or_else(empty), svd.v_t.unwrap_or_else(empty));
        let singular = &svd.singular_values;
        let observed: Vec<usize> =
            (0..singular.len()).filter(|i| sigma_rad_s / singular[*i] < UNOBSERVED_SIGMA).collect();
        let mut to_unknowns = v_t.select_rows(&observed).transpose();
        for (mut column, i) in to_unknowns.column_iter_mut().zip(&observed) {
            column /= singular[*i];
        }
        let mut variance = DVector::zeros(sensitivities.ncols());
        for (direction, size) in v_t.row_iter().zip(singular.iter()) {
            let deviation = (sigma_rad_s / size).min(NO_INFORMATION_SIGMA);
            variance += direction.map(|x| (x * deviation).powi(2)).transpose();
        }
        Self { basis: u.select_columns(&observed), to_unknowns, sigma: variance.map(f64::sqrt) }
    }

    /// Unknowns that fit these changes of the rates best.
    fn solve(&self, change: &DVector<f64>) -> DVector<f64> {
        &self.to_unknowns * self.basis.tr_mul(change)
    }

    /// Norm of the residual of these changes; none if it is rounding error.
    fn residual(&self, change: &DVector<f64>) -> Option<f64> {
        let residual = (change - &self.basis * self.basis.tr_mul(change)).norm();
        (residual > MIN_RESIDUAL_SHARE * change.norm()).then_some(residual)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::input::Scenario;
    use crate::truth::Flight;

    /// One minute under torques about three axes, at a low sample rate for a quick fit.
    const SHAKEN: &str = r#"name = "shaken"
duration_s = 60.0
[spacecraft]
inertia_kg_m2 = [3, 4, 5, 0.1, -0.2, 0.15]
rate_rad_s = [0.02, -0.01, 0.015]
[torque]
kind = "multisine"
amplitude_n_m = [[0.02], [0.03], [0.02]]
frequency_hz = [[0.03], [0.05], [0.07]]
phase_rad = [[0], [1], [2]]
[gyro]
rate_hz = 2.0
noise_rad_s = 1e-4
"#;

    fn scenario(text: &str) -> Scenario {
        Scenario::from_toml("s.toml", text, Path::new("")).unwrap()
    }

    fn effect(scenario: &Scenario) -> TorqueEffect {
        let mut asked = scenario.clone();
        asked.solve_for.torque = true;
        Flight::simulate(&asked).unwrap().bound.torque.unwrap()
    }

    /// Rates of a flight as one vector.
    fn rates(scenario: &Scenario) -> DVector<f64> {
        let flight = Flight::simulate(scenario).unwrap();
        let all =
            flight.instants.iter().flat_map(|i| i.rate_rad_s.iter().copied().collect::<Vec<_>>());
        DVector::from_iterator(3 * flight.instants.len(), all)
    }

    /// Least-squares fit of initial rate and elements to these rates, without a disturbance, by
    /// Gauss-Newton with finite differences; and the norm of the residual.
    fn fit(start: &Scenario, measured: &DVector<f64>) -> (Scenario, f64) {
        const STEP: f64 = 1e-4;
        let moved = |from: &Scenario, by: &DVector<f64>| {
            let mut scenario = from.clone();
            scenario.spacecraft.rate_rad_s += Vector3::new(by[0], by[1], by[2]);
            for i in 0..6 {
                scenario.spacecraft.inertia_kg_m2[i] += by[3 + i];
            }
            scenario
        };
        let mut found = start.clone();
        for _ in 0..3 {
            let slope = |i: usize| {
                let step = |size: f64| {
                    rates(&moved(
                        &found,
                        &DVector::from_fn(9, |k, _| if k == i { size } else { 0.0 }),
                    ))
                };
                (step(STEP) - step(-STEP)) / (2.0 * STEP)
            };
            let jacobian = DMatrix::from_columns(&(0..9).map(slope).collect::<Vec<_>>());
            let residual = measured - rates(&found);
            found = moved(&found, &jacobian.svd(true, true).solve(&residual, 0.0).unwrap());
        }
        let left = (measured - rates(&found)).norm();
        (found, left)
    }

    #[test]
    fn effect_matches_error_and_residual_of_a_fit() {
        let truth = scenario(SHAKEN);
        let effect = effect(&truth);
        for axis in 0..3 {
            let torque_n_m = 1e-6;
            let mut disturbed = truth.clone();
            disturbed.disturbance_torque_n_m[axis] = torque_n_m;
            let (found, left) = fit(&truth, &rates(&disturbed));
            for i in 0..6 {
                let error = found.spacecraft.inertia_kg_m2[i] - truth.spacecraft.inertia_kg_m2[i];
                let row = effect.inertia_error_kg_m2_per_n_m[i].unwrap();
                let largest = row.iter().fold(0.0f64, |most, x| most.max(x.abs()));
                // Second order in the torque, which is 1e-4 of the commanded one.
                let tolerance = 1e-3 * largest;
                assert!((error / torque_n_m - row[axis]).abs() < tolerance, "{i} {axis}: {error}");
            }
            let sigmas = left / truth.gyro.noise_rad_s;
            let expected = torque_n_m / effect.alone_n_m[axis].unwrap();
            assert!((sigmas / expected - 1.0).abs() < 1e-3, "{axis}: {sigmas}, {expected}");
            assert!(effect.together_n_m[axis].unwrap() > effect.alone_n_m[axis].unwrap());
        }
    }

    /// From rest under a constant torque `u`, a disturbance `ε u` has the effect of an inertia smaller
    /// by the share ε.
    #[test]
    fn torque_along_the_commanded_one_is_absorbed_by_the_inertia() {
        let mut spin_up = Scenario::load("stsat3-spin-up").unwrap();
        spin_up.duration_s = 200.0;
        let effect = effect(&spin_up);
        let commanded_n_m = [1e-3, 1e-3, -2e-3];
        let inertia = spin_up.spacecraft.inertia_kg_m2;
        for i in 0..6 {
            let row = effect.inertia_error_kg_m2_per_n_m[i].unwrap();
            let error: f64 = row.iter().zip(commanded_n_m).map(|(b, u)| b * u).sum();
            assert!((error + inertia[i]).abs() < 1e-4 * inertia[0], "{i}: {error}");
        }
        assert_eq!(effect.together_n_m, [None; 3]);
        assert!(effect.alone_n_m.iter().all(Option::is_some));
    }

    #[test]
    fn unobserved_element_has_no_error() {
        let mut slew = Scenario::load("kim-2010-slew").unwrap();
        slew.duration_s = 60.0;
        assert!(effect(&slew).inertia_error_kg_m2_per_n_m.contains(&None));
    }
}
