//! `[[wheel]]`: the reaction wheels.

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::hardware::{
    AXIS_SIGMA, SPIN_INERTIA_SIGMA, StatedHardware, TACHOMETER, TachometerFile, WheelStatements,
};
use crate::error::{InputError, Problem};
use crate::key::{ANY, DIRECTION, Key, NUMBER, POSITIVE, TEXT, Table, VECTOR};
use crate::section::{List, Section};

/// Most wheels of a craft: the capacity of the estimators on the host.
pub const MAX_WHEELS: usize = 8;

/// Label of a wheel.
pub const NAME: Key =
    Key::required("name", TEXT, "", ANY, "Label, unused by the estimators").or("none");
/// Spin axis.
pub const AXIS: Key = Key::required(
    "axis",
    VECTOR,
    "",
    DIRECTION,
    "Direction of positive wheel speed, body axes; normalised on load",
);
/// Spin inertia.
pub const SPIN_INERTIA: Key = Key::required(
    "spin_inertia_kg_m2",
    NUMBER,
    "kg m²",
    POSITIVE,
    "Inertia of the rotor about its axis",
);
/// Torque limit of the motor.
pub const MAX_TORQUE: Key = Key::required(
    "max_torque_n_m",
    NUMBER,
    "N m",
    POSITIVE,
    "Largest torque of the motor, either sign: a limit of `design`; `run` notes a torque above it",
)
.or("unlimited");
/// Speed limit.
pub const MAX_SPEED: Key = Key::required(
    "max_speed_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "Largest speed relative to the body, either sign: a limit of `design`; `run` notes a speed above it",
)
.or("unlimited");

/// The keys of `[[wheel]]` in a craft file.
pub const TABLE: Table = Table {
    header: "[[wheel]]",
    about: "A reaction wheel. At most 8, in the order of the log's columns; none is valid.",
    keys: &[
        NAME,
        AXIS,
        SPIN_INERTIA,
        MAX_TORQUE,
        MAX_SPEED,
        SPIN_INERTIA_SIGMA,
        AXIS_SIGMA,
        TACHOMETER,
    ],
};

/// A reaction wheel: balanced, symmetric about its axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheel {
    /// Label, unused by the estimators.
    pub name: Option<String>,
    /// Direction of positive wheel speed, body axes, unit length.
    pub axis: Vector3<f64>,
    /// Inertia about the axis, kg m².
    pub spin_inertia_kg_m2: f64,
    /// Limits of motor and speed.
    pub limits: WheelLimits,
}

/// Limits of a wheel that its data sheet states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelLimits {
    /// Largest torque of the motor, either sign, N m; none if unlimited.
    pub max_torque_n_m: Option<f64>,
    /// Largest speed relative to the body, either sign, rad/s; none if unlimited.
    pub max_speed_rad_s: Option<f64>,
}

/// The limits as written.
#[derive(Clone, Debug, Default)]
pub struct WheelLimitsFile {
    /// `max_torque_n_m`.
    pub max_torque_n_m: Option<Spanned<f64>>,
    /// `max_speed_rad_s`.
    pub max_speed_rad_s: Option<Spanned<f64>>,
}

impl WheelLimitsFile {
    fn read(&self, section: &Section<'_>) -> Result<WheelLimits, InputError> {
        Ok(WheelLimits {
            max_torque_n_m: section.optional_number(&MAX_TORQUE, &self.max_torque_n_m)?,
            max_speed_rad_s: section.optional_number(&MAX_SPEED, &self.max_speed_rad_s)?,
        })
    }
}

impl Wheel {
    /// A wheel from the values of its table.
    ///
    /// # Errors
    /// An axis without direction, or a spin inertia or a limit of zero or less.
    pub fn read(
        section: &Section<'_>,
        name: Option<String>,
        axis: &List,
        spin_inertia: &Spanned<f64>,
        limits: &WheelLimitsFile,
    ) -> Result<Self, InputError> {
        Ok(Self {
            name,
            axis: section.axis(&AXIS, axis)?,
            spin_inertia_kg_m2: section.number(&SPIN_INERTIA, spin_inertia)?,
            limits: limits.read(section)?,
        })
    }

    pub(super) fn write(&self, text: &mut String, index: usize, hardware: &StatedHardware) {
        *text += "[[wheel]]\n";
        if let Some(name) = &self.name {
            *text += &format!("name = {name:?}\n");
        }
        *text += &format!("axis = {:?}\n", self.axis.as_slice());
        *text += &format!("spin_inertia_kg_m2 = {:?}\n", self.spin_inertia_kg_m2);
        let WheelLimits { max_torque_n_m, max_speed_rad_s } = self.limits;
        for (key, limit) in [(MAX_TORQUE, max_torque_n_m), (MAX_SPEED, max_speed_rad_s)] {
            if let Some(limit) = limit {
                *text += &format!("{} = {limit:?}\n", key.name);
            }
        }
        hardware.write_wheel(text, index);
    }
}

/// Limits the number of `[[wheel]]` tables.
///
/// # Errors
/// More than [`MAX_WHEELS`]; the error is at the first surplus table.
pub fn check_count<W>(section: &Section<'_>, wheels: &[Spanned<W>]) -> Result<(), InputError> {
    match wheels.get(MAX_WHEELS) {
        Some(surplus) => {
            let problem = Problem::TooManyWheels { found: wheels.len(), most: MAX_WHEELS };
            Err(section.error(surplus, problem))
        }
        None => Ok(()),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelFile {
    name: Option<String>,
    axis: List,
    spin_inertia_kg_m2: Spanned<f64>,
    max_torque_n_m: Option<Spanned<f64>>,
    max_speed_rad_s: Option<Spanned<f64>>,
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

    pub(super) fn read(&self, section: &Section<'_>) -> Result<Wheel, InputError> {
        let limits = WheelLimitsFile {
            max_torque_n_m: self.max_torque_n_m.clone(),
            max_speed_rad_s: self.max_speed_rad_s.clone(),
        };
        Wheel::read(section, self.name.clone(), &self.axis, &self.spin_inertia_kg_m2, &limits)
    }
}
