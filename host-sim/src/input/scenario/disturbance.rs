//! `[disturbance]` of a scenario: a torque unknown to the estimator, and its further unknowns.

use flight_input::InputError;
use flight_input::craft::SolveFor;
use flight_input::craft::disturbance::{GYRO_BIAS, TORQUE};
use flight_input::craft::hardware::{TORQUE_SIGMA, VARYING_TORQUE_SIGMA};
use flight_input::key::{FINITE, Key, Table, VECTOR};
use flight_input::section::{List, Section};
use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

const TORQUE_N_M: Key = Key::required(
    "torque_n_m",
    VECTOR,
    "N m",
    FINITE,
    "True constant external torque, unknown to the estimator",
)
.or("`[0, 0, 0]`");

/// The keys of `[disturbance]` in a scenario.
pub(super) const TABLE: Table = Table {
    header: "[disturbance]",
    about: "A torque unknown to the estimator, and the unknowns besides the inertia. Optional.",
    keys: &[TORQUE, GYRO_BIAS, TORQUE_N_M, TORQUE_SIGMA, VARYING_TORQUE_SIGMA],
};

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DisturbanceFile {
    #[serde(default)]
    torque: bool,
    #[serde(default)]
    gyro_bias: bool,
    torque_n_m: Option<List>,
    pub(super) torque_sigma_n_m: Option<Spanned<f64>>,
    pub(super) varying_torque_sigma_n_m: Option<Spanned<f64>>,
}

/// The disturbance torque, and the unknowns besides the inertia.
pub(super) struct Disturbance {
    pub torque_n_m: Vector3<f64>,
    pub solve_for: SolveFor,
}

impl DisturbanceFile {
    pub(super) fn read(&self, root: &Section<'_>) -> Result<Disturbance, InputError> {
        let section = root.table("disturbance");
        Ok(Disturbance {
            torque_n_m: section.vector_or_zero(&TORQUE_N_M, &self.torque_n_m)?,
            solve_for: SolveFor { torque: self.torque, gyro_bias: self.gyro_bias },
        })
    }
}
