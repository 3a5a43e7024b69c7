//! `[disturbance]`: unknowns besides the inertia, in craft files and scenarios.

use serde::Deserialize;
use toml::Spanned;

use super::hardware::{StatedHardware, TORQUE_SIGMA, VARYING_TORQUE_SIGMA};
use crate::key::{ANY, FLAG, Key, Table};

/// Torque among the unknowns.
pub const TORQUE: Key =
    Key::required("torque", FLAG, "", ANY, "Estimate a constant or slowly varying external torque")
        .or("false");
/// Gyro bias among the unknowns.
pub const GYRO_BIAS: Key =
    Key::required("gyro_bias", FLAG, "", ANY, "Estimate a constant gyro bias").or("false");

/// The keys of `[disturbance]` in a craft file.
pub const TABLE: Table = Table {
    header: "[disturbance]",
    about: "Unknowns estimated besides the inertia. Optional.",
    keys: &[TORQUE, GYRO_BIAS, TORQUE_SIGMA, VARYING_TORQUE_SIGMA],
};

/// Unknowns besides the inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolveFor {
    /// A constant or slowly varying torque in body axes.
    pub torque: bool,
    /// A constant gyro bias.
    pub gyro_bias: bool,
}

impl SolveFor {
    /// The unknowns that are asked for by a flag, by the sigma of their prior, or by their drift.
    pub fn with_priors(self, hardware: &StatedHardware) -> Self {
        Self {
            torque: self.torque
                || hardware.torque_sigma_n_m.is_some()
                || hardware.varying_torque_sigma_n_m > 0.0,
            gyro_bias: self.gyro_bias
                || hardware.bias_sigma_rad_s.is_some()
                || hardware.bias_walk_rad_s_sqrt_s > 0.0
                || hardware.bias_instability_rad_s > 0.0,
        }
    }

    pub(super) fn write(&self, text: &mut String, hardware: &StatedHardware) {
        if *self != Self::default() {
            let Self { torque, gyro_bias } = self;
            *text += &format!("[disturbance]\ntorque = {torque}\ngyro_bias = {gyro_bias}\n");
            hardware.write_disturbance(text);
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DisturbanceFile {
    #[serde(default)]
    pub torque: bool,
    #[serde(default)]
    pub gyro_bias: bool,
    pub torque_sigma_n_m: Option<Spanned<f64>>,
    pub varying_torque_sigma_n_m: Option<Spanned<f64>>,
}
