//! `[[wheel]]` of a scenario: a reaction wheel, its initial speed and its motor.

use flight_input::InputError;
use flight_input::craft::Wheel;
use flight_input::craft::hardware::{
    AXIS_SIGMA, SPIN_INERTIA_SIGMA, TACHOMETER, TachometerFile, WheelStatements,
};
use flight_input::craft::wheel::{
    AXIS, MAX_SPEED, MAX_TORQUE, NAME, SPIN_INERTIA, WheelLimitsFile,
};
use flight_input::inertia::{principal_moments, tensor};
use flight_input::key::{ANY, FINITE, Key, NUMBER, TABLE as A_TABLE, Table};
use flight_input::section::{List, Section};
use serde::Deserialize;
use toml::Spanned;

use super::profile::{Surroundings, TorqueProfile, WheelProfileFile, wheel_profile};

const SPEED: Key =
    Key::required("speed_rad_s", NUMBER, "rad/s", FINITE, "Initial speed relative to the body")
        .or("0");
const TORQUE: Key = Key::required(
    "torque",
    A_TABLE,
    "",
    ANY,
    "Torque of the motor on the wheel about its axis: see `[wheel.torque]`",
)
.or("no torque");

/// The keys of `[[wheel]]` in a scenario.
pub(super) const TABLE: Table = Table {
    header: "[[wheel]]",
    about: "A reaction wheel. At most 8; none is valid.",
    keys: &[
        NAME,
        AXIS,
        SPIN_INERTIA,
        MAX_TORQUE,
        MAX_SPEED,
        SPEED,
        TORQUE,
        SPIN_INERTIA_SIGMA,
        AXIS_SIGMA,
        TACHOMETER,
    ],
};

/// A wheel, its initial speed and its motor.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedWheel {
    /// Axis and spin inertia, both known to the estimator.
    pub wheel: Wheel,
    /// Initial speed relative to the body, rad/s.
    pub speed_rad_s: f64,
    /// Torque of the motor on the wheel about its axis, N m; the opposite acts on the body. The
    /// torque of a controller is added.
    pub torque: TorqueProfile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelFile {
    name: Option<String>,
    axis: List,
    spin_inertia_kg_m2: Spanned<f64>,
    max_torque_n_m: Option<Spanned<f64>>,
    max_speed_rad_s: Option<Spanned<f64>>,
    speed_rad_s: Option<Spanned<f64>>,
    torque: Option<WheelProfileFile>,
    spin_inertia_sigma: Option<Spanned<f64>>,
    axis_sigma_deg: Option<Spanned<f64>>,
    tachometer: Option<TachometerFile>,
}

impl WheelFile {
    /// The statements on errors.
    pub(super) fn statements(&self) -> WheelStatements {
        WheelStatements {
            spin_inertia_sigma: self.spin_inertia_sigma.clone(),
            axis_sigma_deg: self.axis_sigma_deg.clone(),
            tachometer: self.tachometer.clone(),
        }
    }

    pub(super) fn read(
        &self,
        section: &Section<'_>,
        surroundings: Surroundings<'_>,
    ) -> Result<SimulatedWheel, InputError> {
        let limits = WheelLimitsFile {
            max_torque_n_m: self.max_torque_n_m.clone(),
            max_speed_rad_s: self.max_speed_rad_s.clone(),
        };
        let (name, spin_inertia) = (self.name.clone(), &self.spin_inertia_kg_m2);
        let wheel = Wheel::read(section, name, &self.axis, spin_inertia, &limits)?;
        let speed_rad_s = section.optional_number(&SPEED, &self.speed_rad_s)?.unwrap_or(0.0);
        let torque = match &self.torque {
            Some(profile) => wheel_profile(&section.table(TORQUE.name), profile, surroundings)?,
            None => TorqueProfile::ZERO,
        };
        Ok(SimulatedWheel { wheel, speed_rad_s, torque })
    }
}

/// Principal moments of `J − Σ Iₛ a aᵀ`, ascending, kg m².
///
/// The motors turn against this tensor; the equation of motion has a solution only if it is positive
/// definite.
pub(super) fn moments_without_wheels(
    inertia_kg_m2: &[f64; 6],
    wheels: &[SimulatedWheel],
) -> [f64; 3] {
    let mut rest = tensor(inertia_kg_m2);
    for SimulatedWheel { wheel, .. } in wheels {
        rest -= wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2;
    }
    principal_moments(&rest)
}
