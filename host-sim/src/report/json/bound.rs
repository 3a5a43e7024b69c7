//! Document of `crlb`: the Cramér-Rao bound of a scenario.

use serde::Serialize;

use super::tensor::percent;

/// Result of `crlb`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrlbReport {
    /// Name of the scenario.
    pub scenario: String,
    /// Names of the unknowns.
    pub unknowns: Vec<String>,
    /// Cramér-Rao bound of each element, one sigma, kg m². Null if the element is unobserved.
    pub bound_kg_m2: [Option<f64>; 6],
    /// Bound in per cent of the true element. Null also if the element is zero.
    pub bound_percent: [Option<f64>; 6],
    /// Observable directions of the six-dimensional space of tensors, 0 to 6.
    pub observed_directions: usize,
    /// First-order error of each element by an unmodelled constant body torque about x, y and z,
    /// kg m² per N m. Null for an unobserved element; null as a whole if the torque is among the
    /// unknowns.
    pub inertia_error_kg_m2_per_n_m: Option<[Option<[f64; 3]>; 6]>,
    /// One sigma with which a constant torque about each axis is observable in the residuals, N m,
    /// with the unknowns adapted to it. Null if the unknowns can imitate the torque.
    pub torque_bound_n_m: [Option<f64>; 3],
    /// Bound with the stated errors of the hardware considered, kg m². Null for an unobserved element;
    /// absent if the hardware is ideal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub considered_kg_m2: Option<[Option<f64>; 6]>,
    /// Bound with these errors among the unknowns, their sigmas as prior, kg m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solved_kg_m2: Option<[Option<f64>; 6]>,
    /// Effect of each error.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectRow>,
}

/// Effect of one error of the hardware.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectRow {
    /// Name, as `gyro_scale_x`.
    pub name: String,
    /// Stated sigma.
    pub sigma: f64,
    /// Unit of the sigma; empty for a share.
    pub unit: String,
    /// Change of each estimated element by an error of one sigma that the estimator does not model,
    /// kg m², in the order of the elements.
    pub inertia_kg_m2: [f64; 6],
    /// Sigma after the data over the stated sigma, if the error is solved for.
    pub posterior_over_prior: f64,
}

impl CrlbReport {
    /// Compares a bound with the truth.
    pub fn new(
        scenario: &str,
        unknowns: Vec<String>,
        truth_kg_m2: [f64; 6],
        bound_kg_m2: [Option<f64>; 6],
        observed_directions: usize,
    ) -> Self {
        Self {
            scenario: scenario.to_owned(),
            unknowns,
            bound_kg_m2,
            bound_percent: std::array::from_fn(|i| percent(bound_kg_m2[i]?, truth_kg_m2[i].abs())),
            observed_directions,
            inertia_error_kg_m2_per_n_m: None,
            torque_bound_n_m: [None; 3],
            considered_kg_m2: None,
            solved_kg_m2: None,
            effects: Vec::new(),
        }
    }

    /// Adds the effect of a constant torque.
    pub fn with_torque(
        self,
        inertia_error_kg_m2_per_n_m: Option<[Option<[f64; 3]>; 6]>,
        torque_bound_n_m: [Option<f64>; 3],
    ) -> Self {
        Self { inertia_error_kg_m2_per_n_m, torque_bound_n_m, ..self }
    }

    /// Adds the bounds with errors of the hardware.
    pub fn with_hardware(
        self,
        considered_kg_m2: [Option<f64>; 6],
        solved_kg_m2: [Option<f64>; 6],
        effects: Vec<EffectRow>,
    ) -> Self {
        let (considered_kg_m2, solved_kg_m2) = (Some(considered_kg_m2), Some(solved_kg_m2));
        Self { considered_kg_m2, solved_kg_m2, effects, ..self }
    }
}
