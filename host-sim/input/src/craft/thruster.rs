//! `[[thruster]]`: thrusters, as sources of a known external torque.

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use crate::error::InputError;
use crate::key::{DIRECTION, Key, NUMBER, POSITIVE, Table, VECTOR};
use crate::section::{List, Section};

/// Torque while the thruster is on.
pub const TORQUE: Key = Key::required(
    "torque_n_m",
    VECTOR,
    "N m",
    DIRECTION,
    "Torque on the body while on: lever from the centre of mass × force",
);
/// Shortest pulse.
pub const MIN_PULSE: Key = Key::required(
    "min_pulse_s",
    NUMBER,
    "s",
    POSITIVE,
    "Shortest pulse; `design` commands multiples of it, rounded up to samples of the gyro",
);

/// The keys of `[[thruster]]` in a craft file.
pub const TABLE: Table = Table {
    header: "[[thruster]]",
    about: "A thruster or a couple of thrusters, on or off: a torque source of `design`. The scale error \
            common to all is `torque.scale_sigma`. Optional.",
    keys: &[TORQUE, MIN_PULSE],
};

/// A thruster: a constant torque, on or off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thruster {
    /// Torque on the body while on, N m.
    pub torque_n_m: Vector3<f64>,
    /// Shortest pulse, s.
    pub min_pulse_s: f64,
}

impl Thruster {
    /// A thruster from the values of its table.
    ///
    /// # Errors
    /// A torque that is zero or not finite, or a shortest pulse that is not positive.
    pub fn read(
        section: &Section<'_>,
        torque: &List,
        min_pulse: &Spanned<f64>,
    ) -> Result<Self, InputError> {
        let torque_n_m = section.vector(&TORQUE, torque)?;
        if torque_n_m == Vector3::zeros() {
            return Err(section.list_out_of_range(&TORQUE, torque));
        }
        Ok(Self { torque_n_m, min_pulse_s: section.number(&MIN_PULSE, min_pulse)? })
    }

    pub(super) fn write(&self, text: &mut String) {
        *text += "[[thruster]]\n";
        *text += &format!("{} = {:?}\n", TORQUE.name, self.torque_n_m.as_slice());
        *text += &format!("{} = {:?}\n", MIN_PULSE.name, self.min_pulse_s);
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThrusterFile {
    torque_n_m: List,
    min_pulse_s: Spanned<f64>,
}

impl ThrusterFile {
    pub(super) fn read(&self, section: &Section<'_>) -> Result<Thruster, InputError> {
        Thruster::read(section, &self.torque_n_m, &self.min_pulse_s)
    }
}
