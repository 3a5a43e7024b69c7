//! `[disturbance]`: unknowns besides the inertia, in craft files and scenarios.

use serde::Deserialize;

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
    keys: &[TORQUE, GYRO_BIAS],
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
    pub(super) fn write(&self, text: &mut String) {
        if *self != Self::default() {
            let Self { torque, gyro_bias } = self;
            *text += &format!("[disturbance]\ntorque = {torque}\ngyro_bias = {gyro_bias}\n");
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
}
