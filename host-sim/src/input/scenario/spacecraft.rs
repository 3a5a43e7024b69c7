//! `[spacecraft]`: the true body at the start.

use flight_input::InputError;
use flight_input::key::{ELEMENTS, FINITE, Key, PHYSICAL, Table, VECTOR};
use flight_input::section::{List, Section};
use nalgebra::{UnitQuaternion, Vector3};
use serde::Deserialize;

/// Inertia of the spacecraft.
pub(super) const INERTIA: Key = Key::required(
    "inertia_kg_m2",
    ELEMENTS,
    "kg m²",
    PHYSICAL,
    "`jxx jyy jzz jxy jxz jyz` about the centre of mass, wheels included and locked",
);
const RATE: Key =
    Key::required("rate_rad_s", VECTOR, "rad/s", FINITE, "Initial body rate").or("`[0, 0, 0]`");
const ATTITUDE: Key = Key::required(
    "attitude_deg",
    VECTOR,
    "deg",
    FINITE,
    "Initial roll, pitch and yaw (3-2-1), body to inertial axes",
)
.or("`[0, 0, 0]`");

/// The keys of `[spacecraft]`.
pub(super) const TABLE: Table = Table {
    header: "[spacecraft]",
    about: "The true body at the start.",
    keys: &[INERTIA, RATE, ATTITUDE],
};

/// The true body.
#[derive(Clone, Debug, PartialEq)]
pub struct Spacecraft {
    /// `jxx jyy jzz jxy jxz jyz` about the centre of mass, wheels included and locked, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Initial rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Initial attitude: the rotation from body axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpacecraftFile {
    pub inertia_kg_m2: List,
    rate_rad_s: Option<List>,
    attitude_deg: Option<List>,
}

impl SpacecraftFile {
    pub(super) fn read(&self, section: &Section<'_>) -> Result<Spacecraft, InputError> {
        Ok(Spacecraft {
            attitude: attitude(section, &ATTITUDE, &self.attitude_deg)?,
            inertia_kg_m2: section.inertia(&INERTIA, &self.inertia_kg_m2)?,
            rate_rad_s: section.vector_or_zero(&RATE, &self.rate_rad_s)?,
        })
    }
}

/// Roll, pitch and yaw in degrees as the rotation from body axes to inertial axes: yaw about z, then
/// pitch about the new y, then roll about the new x (3-2-1).
pub(super) fn attitude(
    section: &Section<'_>,
    key: &Key,
    angles_deg: &Option<List>,
) -> Result<UnitQuaternion<f64>, InputError> {
    let Some(angles_deg) = angles_deg else { return Ok(UnitQuaternion::identity()) };
    let [roll, pitch, yaw] = section.list::<3>(key, angles_deg)?.map(f64::to_radians);
    Ok(UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}
