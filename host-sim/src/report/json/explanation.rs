//! Document of `diagnose`.

use serde::Serialize;

use crate::diagnosis::{Diagnosis, Explanation};

/// Result of `diagnose`: explanations of the residuals, best first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiagnosisReport {
    /// Chi-square of the log as it is, with the stated noise. Null if no model follows the motion.
    pub chi_square: Option<f64>,
    /// Number of scalar readings: chi-square of residuals that are noise.
    pub readings: f64,
    /// Gyro noise by differences of the readings, one sigma, rad/s.
    pub measured_noise_rad_s: f64,
    /// Explanations. Empty where the residuals agree with the noise, or no single cause explains them.
    pub explanations: Vec<ExplanationReport>,
}

/// One explanation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExplanationReport {
    /// Name.
    pub name: String,
    /// Component of `value`, as `x` or `wheel 2`. Empty for the only one.
    pub component: String,
    /// Value of the component with the largest value over sigma. Null for a mistake without a number.
    pub value: Option<f64>,
    /// One sigma of it.
    pub sigma: Option<f64>,
    /// Unit of value and sigma; empty for a share or a count.
    pub unit: String,
    /// Decrease of chi-square with this explanation.
    pub chi_square: f64,
    /// Share of the excess of chi-square over the number of readings.
    pub share_explained: f64,
    /// Line for the craft file, or correction of the log.
    pub remedy: String,
    /// Names of explanations that the log does not distinguish from this one.
    pub indistinguishable_from: Vec<String>,
}

impl From<&Diagnosis> for DiagnosisReport {
    fn from(diagnosis: &Diagnosis) -> Self {
        Self {
            chi_square: Some(diagnosis.chi_square).filter(|x| x.is_finite()),
            readings: diagnosis.readings,
            measured_noise_rad_s: diagnosis.noise_rad_s,
            explanations: diagnosis.explanations.iter().map(ExplanationReport::from).collect(),
        }
    }
}

impl From<&Explanation> for ExplanationReport {
    fn from(explanation: &Explanation) -> Self {
        Self {
            name: explanation.name.clone(),
            component: explanation.component.clone(),
            value: explanation.value.map(|(value, _)| value),
            sigma: explanation.value.map(|(_, sigma)| sigma),
            unit: explanation.unit.to_owned(),
            chi_square: explanation.chi_square,
            share_explained: explanation.share,
            remedy: explanation.remedy.clone(),
            indistinguishable_from: explanation.same_as.clone(),
        }
    }
}
