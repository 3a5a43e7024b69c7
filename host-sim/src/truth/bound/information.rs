//! Fisher information of the sensitivities, and the bound as its inverse.
//!
//! The information is kept as a triangular factor `U`, `UᵀU = Σₖ SₖᵀSₖ`, by QR decomposition, so that
//! a motion with condition number 1e7 keeps its digits. With the singular values `sᵢ` and right
//! singular vectors `vᵢ` of `U`, and gyro noise `σ`, rad/s, the bound is
//! `C = Σᵢ min(σ/sᵢ, σ_max)² vᵢ vᵢᵀ` in the scaled units of [`unknowns`](super::unknowns).

use nalgebra::DMatrix;

use super::hardware::HardwareBound;
use super::torque_effect::TorqueEffect;
use super::unknowns::{INERTIA, NO_INFORMATION_SIGMA, UNOBSERVED_SIGMA, Unknowns};

/// Rows collected before each decomposition: memory against speed.
const BATCH_ROWS: usize = 300;

/// Triangular factor of the information, and rows not yet folded into it.
pub struct Information {
    unknowns: Unknowns,
    mean_moment_kg_m2: f64,
    factor: DMatrix<f64>,
    pending: Vec<f64>,
}

impl Information {
    /// No information yet. `mean_moment_kg_m2` is the unit of inertia and torque.
    pub fn new(unknowns: Unknowns, mean_moment_kg_m2: f64) -> Self {
        let count = unknowns.count();
        Self {
            unknowns,
            mean_moment_kg_m2,
            factor: DMatrix::zeros(count, count),
            pending: Vec::new(),
        }
    }

    /// Adds the sensitivities of one sample, 3 × unknowns.
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

    /// Bound for gyro noise of this variance per sample and axis, rad²/s².
    pub fn bound(mut self, noise_variance_rad2_s2: f64) -> Bound {
        self.fold();
        let sigma = noise_variance_rad2_s2.sqrt();
        let covariance = self.covariance(sigma);
        let inertia = covariance.view((INERTIA, INERTIA), (6, 6)).into_owned();
        let directions = inertia.clone().symmetric_eigenvalues();
        let observed = directions.iter().filter(|v| v.max(0.0).sqrt() < UNOBSERVED_SIGMA).count();
        let mean_moment = self.mean_moment_kg_m2;
        let element = |i: usize| {
            let deviation = inertia[(i, i)].max(0.0).sqrt();
            (deviation < UNOBSERVED_SIGMA).then_some(deviation * mean_moment)
        };
        Bound {
            unknowns: self.unknowns,
            sigma_kg_m2: std::array::from_fn(element),
            observed_directions: observed,
            torque: self
                .unknowns
                .has_torque()
                .then(|| TorqueEffect::new(&self.factor, sigma, mean_moment)),
            hardware: None,
        }
    }

    /// Covariance of the unknowns in scaled units for gyro noise `sigma`, rad/s. Directions without
    /// information have [`NO_INFORMATION_SIGMA`].
    fn covariance(&self, sigma: f64) -> DMatrix<f64> {
        let svd = self.factor.clone().svd(false, true);
        let deviations: Vec<f64> = svd.singular_values.iter().map(|s| sigma / s).collect();
        let v_t = svd.v_t.unwrap_or_else(|| DMatrix::from_element(0, 0, f64::NAN));
        let mut covariance = DMatrix::zeros(self.unknowns.count(), self.unknowns.count());
        for (deviation, direction) in deviations.iter().zip(v_t.row_iter()) {
            let bounded = deviation.min(NO_INFORMATION_SIGMA);
            covariance += direction.transpose() * direction * (bounded * bounded);
        }
        covariance
    }
}

/// Cramér-Rao bound of a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Unknowns that the bound allows for.
    pub unknowns: Unknowns,
    /// One sigma of each element, kg m²; none where the element is unobserved.
    pub sigma_kg_m2: [Option<f64>; 6],
    /// Observed directions in the space of the six elements, 0 to 6.
    pub observed_directions: usize,
    /// Effect of a constant torque, if it is among the unknowns.
    pub torque: Option<TorqueEffect>,
    /// Bound with stated errors of the hardware; none if it is ideal.
    pub hardware: Option<HardwareBound>,
}

impl Bound {
    /// Bound with stated errors of the hardware among the unknowns, kg m²; none where it is unobserved,
    /// or without such errors.
    pub fn joint_kg_m2(&self) -> [Option<f64>; 6] {
        self.hardware.as_ref().map_or([None; 6], |hardware| hardware.solved_kg_m2)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use crate::input::scenario::Scenario;
    use crate::truth::Flight;

    /// Bound of the STSAT-3 spin-up, one sigma in per cent of each element, from an independent
    /// derivation.
    const STSAT_3_PERCENT: [f64; 6] = [0.0194, 0.0144, 0.0157, 1.294, 1.196, 0.142];

    #[test]
    fn bound_of_stsat_3_matches_an_independent_derivation() {
        let scenario = Scenario::load("stsat3-spin-up").unwrap();
        let bound = Flight::simulate(&scenario).unwrap().bound;
        assert_eq!(bound.observed_directions, 6);
        for i in 0..6 {
            let percent =
                100.0 * bound.sigma_kg_m2[i].unwrap() / scenario.spacecraft.inertia_kg_m2[i];
            assert!((percent / STSAT_3_PERCENT[i] - 1.0).abs() < 0.02, "element {i}: {percent} %");
        }
    }

    #[test]
    fn unknown_torque_increases_the_bound_of_the_inertia() {
        let mut scenario = Scenario::load("microsat-slew").unwrap();
        scenario.disturbance_torque_n_m = Vector3::new(1e-5, -1e-5, 0.0);
        let known = Flight::simulate(&scenario).unwrap().bound;
        scenario.solve_for.torque = true;
        let unknown = Flight::simulate(&scenario).unwrap().bound;
        assert_eq!(unknown.unknowns.names().len(), 12);
        for i in 0..6 {
            let ratio = unknown.sigma_kg_m2[i].unwrap() / known.sigma_kg_m2[i].unwrap();
            assert!(ratio > 1.01, "element {i}: {ratio}");
        }
    }

    /// Scenario with torques about three axes during these times, s, and further keys.
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
    fn bound_after_a_sudden_change_equals_that_of_a_flight_starting_there() {
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
    fn slew_about_one_axis_observes_three_directions() {
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
