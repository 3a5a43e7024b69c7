//! Documents of one estimate: `replay`, and `run` with the truth beside it.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::Matrix3;
use serde::Serialize;

use super::explanation::ExplanationReport;
use super::hardware::HardwareResult;
use super::tensor::{elements, percent};
use crate::campaign::Reference;
use crate::estimation::squared_norm;

/// Result of `replay`: the estimate from a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Name of the estimator, as `joint-ekf`.
    pub estimator: String,
    /// Precision of the flight core: `f32` or `f64`.
    pub precision: String,
    /// Samples in the log.
    pub samples: u64,
    /// Samples used in the estimate.
    pub accepted: u64,
    /// Rejected samples by reason. A reason that did not occur may be absent.
    pub rejected: BTreeMap<String, u64>,
    /// Status of the estimate.
    pub status: Status,
    /// Inertia tensor about the centre of mass, body axes, wheels locked and included, kg m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// One sigma of each element, kg m²: root sum of squares of the random and the systematic one.
    pub sigma_kg_m2: [f64; 6],
    /// One sigma of each element by the noise alone, kg m².
    pub sigma_random_kg_m2: [f64; 6],
    /// One sigma of each element by the stated and assumed errors of the hardware, kg m². Zero for ideal
    /// hardware, and from an estimator that does not consider them; a note says so.
    pub sigma_systematic_kg_m2: [f64; 6],
    /// Kind of hardware error with the largest effect on the tensor. Null without any.
    pub largest_systematic: Option<String>,
    /// Results on each parameter of the hardware among the unknowns.
    pub hardware: Vec<HardwareResult>,
    /// Covariance of the elements, kg² m⁴: noise and hardware.
    pub covariance_kg2_m4: [[f64; 6]; 6],
    /// Observed directions of the six-dimensional space of tensors, 0 to 6.
    pub observed_directions: usize,
    /// Observability of each element.
    pub element_observed: [bool; 6],
    /// Observability of the scale of the tensor. False if only its ratios are observed.
    pub scale_observed: bool,
    /// Tensor divided by its trace.
    pub inertia_over_trace: [[f64; 3]; 3],
    /// One sigma of each element of the tensor divided by its trace.
    pub inertia_over_trace_sigma: [f64; 6],
    /// True for the tensor of a rigid body.
    pub physical: bool,
    /// Constant disturbance torque, body axes, N m. Null unless requested.
    pub disturbance_torque_n_m: Option<[f64; 3]>,
    /// Gyro bias, body axes, rad/s. Null unless requested.
    pub gyro_bias_rad_s: Option<[f64; 3]>,
    /// RMS over samples and axes of measured minus estimated rate, rad/s.
    pub residual_rms_rad_s: f64,
    /// Result of the test of the residuals for white noise. Null if not tested.
    pub residuals_white: Option<bool>,
    /// True if the tensor was projected on the nearest physical one.
    pub projected: bool,
    /// Times of restarts of the whole state, s: it was not finite, or too many spikes came in a row.
    /// Times of events are since the first sample, as `t_s` of `history.csv`; each is that of the step
    /// that reported the event.
    pub restarts: Vec<f64>,
    /// Times of the first samples after gaps that are too long for a prediction, s.
    pub gaps: Vec<f64>,
    /// Times at which a fault or a change in mid-motion put the earlier estimate in doubt, s.
    pub interruptions: Vec<f64>,
    /// Times at which the earlier estimate was discarded because new data contradicted it, s. A
    /// series of spikes that ends in a restart is a restart and a change.
    pub changes: Vec<f64>,
    /// Samples rejected because they were too far from the prediction.
    pub spikes: Spikes,
    /// Health after the last sample: `nominal`, `degraded` or `lost`.
    pub health: String,
    /// Evidence of its last change for the worse. Null before the first.
    pub health_driver: Option<String>,
    /// Changes of the health; nominal before the first.
    pub health_changes: Vec<HealthChange>,
    /// Causes that explain the residuals, best first, where `replay` finds them not white or the status is
    /// `diverged`: see `diagnose`.
    pub explanations: Vec<ExplanationReport>,
    /// Rows of the log that were not used as samples, by reason: see `replay`.
    pub skipped_rows: BTreeMap<String, u64>,
    /// Notes on the input and the set-up, one sentence each, as on stderr.
    pub notes: Vec<String>,
}

/// A change of the health.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HealthChange {
    /// Time since the first sample, s.
    pub t_s: f64,
    /// Health from then on.
    pub health: String,
    /// Evidence of the last change for the worse.
    pub driver: Option<String>,
}

/// Number of spikes, and the times of the first ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Spikes {
    /// Number of spikes.
    pub count: u64,
    /// Times of the first [`Spikes::LISTED`], s.
    pub first_s: Vec<f64>,
}

impl Spikes {
    /// Largest number of times.
    pub const LISTED: usize = 10;
}

/// Status of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// All directions are observed and the model explains the data.
    Converged,
    /// Some directions are unobserved.
    Partial,
    /// No direction is observed.
    Unobservable,
    /// The model does not explain the data.
    Diverged,
}

/// Result of `run`: the estimate from a simulated flight, beside the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of the gyro noise.
    pub seed: u64,
    /// Result of `replay` for the flight's log.
    #[serde(flatten)]
    pub estimate: ReplayReport,
    /// True elements at the end of the flight, kg m².
    pub truth_kg_m2: [f64; 6],
    /// Estimated minus true, per cent of the true element. Null if the element is zero.
    pub error_percent: [Option<f64>; 6],
    /// Estimated minus true over the reported sigma. Null without a sigma.
    pub error_over_sigma: [Option<f64>; 6],
    /// Cramér-Rao bound of each element, one sigma, kg m². Null if the element is unobserved.
    pub bound_kg_m2: [Option<f64>; 6],
    /// Bound with the stated errors of the hardware among the unknowns, one sigma, kg m². Null for ideal hardware.
    pub joint_bound_kg_m2: [Option<f64>; 6],
}

impl ReplayReport {
    /// Elements of the tensor, kg m².
    pub fn elements_kg_m2(&self) -> [f64; 6] {
        elements(&self.inertia_kg_m2)
    }

    /// Principal moments, ascending, kg m².
    pub fn principal_moments_kg_m2(&self) -> [f64; 3] {
        let tensor = Matrix3::from(self.inertia_kg_m2);
        let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        moments
    }

    /// The residuals differ from the noise: they are not white, or the status is `diverged`.
    pub fn is_unexplained(&self) -> bool {
        self.status == Status::Diverged || self.residuals_white == Some(false)
    }

    /// The systematic sigma of all elements exceeds the random one.
    pub fn is_limited_by_hardware(&self) -> bool {
        squared_norm(&self.sigma_systematic_kg_m2) > squared_norm(&self.sigma_random_kg_m2)
    }

    /// Number of rejected samples.
    pub fn rejected_total(&self) -> u64 {
        self.rejected.values().sum()
    }
}

impl RunReport {
    /// Compares an estimate with truth and bounds.
    pub fn new(scenario: &str, seed: u64, estimate: ReplayReport, reference: &Reference) -> Self {
        let Reference { truth_kg_m2, bound_kg_m2, joint_bound_kg_m2 } = *reference;
        let found = estimate.elements_kg_m2();
        let error_percent =
            std::array::from_fn(|i| percent(found[i] - truth_kg_m2[i], truth_kg_m2[i]));
        let error_over_sigma = std::array::from_fn(|i| {
            let ratio = (found[i] - truth_kg_m2[i]) / estimate.sigma_kg_m2[i];
            ratio.is_finite().then_some(ratio)
        });
        Self {
            scenario: scenario.to_owned(),
            seed,
            estimate,
            truth_kg_m2,
            error_percent,
            error_over_sigma,
            bound_kg_m2,
            joint_bound_kg_m2,
        }
    }

    /// Name and values of the bound that the errors are measured by: the joint bound where errors of the hardware are
    /// stated, since no estimator reaches that of the noise alone.
    pub fn measure(&self) -> (&'static str, [Option<f64>; 6]) {
        match self.joint_bound_kg_m2.iter().any(Option::is_some) {
            true => ("joint bound", self.joint_bound_kg_m2),
            false => ("bound", self.bound_kg_m2),
        }
    }
}

impl Status {
    /// The status of this name, as [`fmt::Display`] writes it.
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Converged, Self::Partial, Self::Unobservable, Self::Diverged];
        all.into_iter().find(|status| status.to_string() == name)
    }
}

impl fmt::Display for Status {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Converged => "converged",
            Self::Partial => "partial",
            Self::Unobservable => "unobservable",
            Self::Diverged => "diverged",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::super::tensor::matrix;

    #[test]
    fn principal_moments_are_the_eigenvalues_in_ascending_order() {
        /// Rounding of eigenvalues of magnitude 3, kg m².
        const TOLERANCE_KG_M2: f64 = 1e-12;
        let mut report = examples::replay();
        report.inertia_kg_m2 = matrix(&[3.0, 2.0, 2.0, 0.0, 0.0, 1.0]);
        let moments = report.principal_moments_kg_m2();
        for (moment, expected) in moments.iter().zip([1.0, 3.0, 3.0]) {
            assert!((moment - expected).abs() < TOLERANCE_KG_M2, "{moments:?}");
        }
    }
}
