//! `[[wheel]]`: the reaction wheels.

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::hardware::{AXIS_SIGMA, SPIN_INERTIA_SIGMA, StatedHardware, WheelStatements};
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

/// The keys of `[[wheel]]` in a craft file.
pub const TABLE: Table = Table {
    header: "[[wheel]]",
    about: "A reaction wheel. At most 8, in the order of the log's columns; none is valid.",
    keys: &[NAME, AXIS, SPIN_INERTIA, SPIN_INERTIA_SIGMA, AXIS_SIGMA],
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
}

impl Wheel {
    /// A wheel from the values of its table.
    ///
    /// # Errors
    /// An axis without direction, or a spin inertia of zero or less.
    pub fn read(
        section: &Section<'_>,
        name: Option<String>,
        axis: &List,
        spin_inertia: &Spanned<f64>,
    ) -> Result<Self, InputError> {
        Ok(Self {
            name,
            axis: section.axis(&AXIS, axis)?,
            spin_inertia_kg_m2: section.number(&SPIN_INERTIA, spin_inertia)?,
        })
    }

    pub(super) fn write(&self, text: &mut String, index: usize, hardware: &StatedHardware) {
        *text += "[[wheel]]\n";
        if let Some(name) = &self.name {
            *text += &format!("name = {name:?}\n");
        }
        *text += &format!("axis = {:?}\n", self.axis.as_slice());
        *text += &format!("spin_inertia_kg_m2 = {:?}\n", self.spin_inertia_kg_m2);
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
    spin_inertia_sigma: Option<Spanned<f64>>,
    axis_sigma_deg: Option<Spanned<f64>>,
}

impl WheelFile {
    /// The statements on errors.
    pub(super) fn statements(&self) -> WheelStatements {
        WheelStatements {
            spin_inertia_sigma: self.spin_inertia_sigma.clone(),
            axis_sigma_deg: self.axis_sigma_deg.clone(),
        }
    }

    pub(super) fn read(&self, section: &Section<'_>) -> Result<Wheel, InputError> {
        Wheel::read(section, self.name.clone(), &self.axis, &self.spin_inertia_kg_m2)
    }
}
