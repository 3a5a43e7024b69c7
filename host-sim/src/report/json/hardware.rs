//! Result on one parameter of the hardware.

use fsw_core::hardware::Finding;
use serde::Serialize;

use crate::estimation::{key, parameter_name};
use crate::input::craft::hardware::DATA_SHEET;

/// A parameter of the hardware among the unknowns: its prior and what the data made of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HardwareResult {
    /// Name, as `wheel spin inertia 2`.
    pub name: String,
    /// Kind of the parameter, as in `largest_systematic`.
    pub kind: String,
    /// Estimate, in `unit`.
    pub value: f64,
    /// One sigma after the data.
    pub sigma: f64,
    /// One sigma before the data, as stated or assumed.
    pub stated: f64,
    /// Key of the craft file that states it.
    pub key: String,
    /// True if the craft file leaves the key out: `stated` is then that of the data sheet.
    pub assumed: bool,
    /// `rad`, `s`, or empty for a share.
    pub unit: String,
    /// Shift of the six elements by one sigma of what the data leave of the parameter, kg m².
    pub effect_kg_m2: [f64; 6],
}

/// Stated sigmas beyond which an estimate contradicts what was stated.
const CONTRADICTED: f64 = 5.0;

impl HardwareResult {
    /// True for an estimate beyond five of its stated sigmas: the hardware is not as stated, or log and craft file have a
    /// mistake that looks like this parameter.
    pub fn is_contradicted(&self) -> bool {
        self.value.abs() > CONTRADICTED * self.stated
    }
}

impl From<&Finding<f64>> for HardwareResult {
    fn from(finding: &Finding<f64>) -> Self {
        Self {
            name: parameter_name(finding.parameter),
            kind: finding.parameter.kind().to_owned(),
            value: finding.value,
            sigma: finding.sigma,
            stated: finding.stated,
            key: key(finding.parameter).to_owned(),
            assumed: false,
            unit: finding.parameter.unit().to_owned(),
            effect_kg_m2: finding.effect_kg_m2,
        }
    }
}

impl HardwareResult {
    /// Marks the value as assumed if its key is among those that the craft file leaves out. A wheel with a
    /// statement of its own differs from the data sheet.
    pub fn mark_assumed(&mut self, assumed: &[&str]) {
        let in_unit = |value: f64| if self.unit == "rad" { value.to_radians() } else { value };
        let row = DATA_SHEET.iter().find(|row| row.path == self.key);
        /// Rounding of the value in the estimator's precision, share.
        const ROUNDING: f64 = 1e-6;
        let is_of_data_sheet = row.is_some_and(|row| {
            let value = in_unit(row.value);
            (self.stated - value).abs() <= ROUNDING * value
        });
        self.assumed = is_of_data_sheet && assumed.contains(&self.key.as_str());
    }

    /// Share of the prior's sigma that is left.
    pub fn left(&self) -> f64 {
        self.sigma / self.stated
    }
}
