//! `[control]`: the attitude controller of a closed-loop slew.
//!
//! ```toml
//! [control]                            # optional; three or more wheels
//! target_attitude_deg = [0, 0, 0]      # roll, pitch, yaw
//! natural_frequency_rad_s = 0.043      # gains 2 ω² J and 2 ζ ω J, with the true J; or instead
//! damping_ratio = 0.707
//! attitude_gain_n_m = [1, 1, 1]        # gains about x, y, z
//! rate_gain_n_m_s = [20, 20, 20]
//! ```
//!
//! Observability: with gains proportional to `J`, no external torque and zero total momentum, a slew
//! from rest is about one fixed axis for any angles. Only `J` along that axis is observable: three of
//! six directions. Spinning wheels, or gains not proportional to `J`, make more observable.

use flight_input::InputError;
use flight_input::inertia::tensor;
use flight_input::key::{FINITE, Key, NUMBER, POSITIVE, Table, VECTOR};
use flight_input::section::{List, Section};
use nalgebra::{Matrix3, Matrix3xX, UnitQuaternion, Vector3};
use serde::Deserialize;
use toml::Spanned;

use super::problem::ScenarioProblem;
use super::spacecraft::attitude;
use super::wheel::SimulatedWheel;

/// Least singular value of the matrix of unit wheel axes: below it the axes do not span three
/// dimensions, as some torque on the body takes 1,000 times as much motor torque.
const LEAST_SPAN: f64 = 1e-3;

const TARGET: Key = Key::required(
    "target_attitude_deg",
    VECTOR,
    "deg",
    FINITE,
    "Target roll, pitch and yaw (3-2-1), at rest",
)
.or("`[0, 0, 0]`");
const FREQUENCY: Key = Key::required(
    "natural_frequency_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "ω of the gains 2 ω² J and 2 ζ ω J, with the true J",
)
.or("gains per axis");
const DAMPING: Key =
    Key::required("damping_ratio", NUMBER, "", POSITIVE, "ζ of these gains").or("gains per axis");
const ATTITUDE_GAIN: Key = Key::required(
    "attitude_gain_n_m",
    VECTOR,
    "N m",
    POSITIVE,
    "Gains on the vector part of the error quaternion, per axis",
)
.or("gains from ω and ζ");
const RATE_GAIN: Key =
    Key::required("rate_gain_n_m_s", VECTOR, "N m s", POSITIVE, "Gains on the body rate, per axis")
        .or("gains from ω and ζ");

/// The keys of `[control]`.
pub(super) const TABLE: Table = Table {
    header: "[control]",
    about: "Attitude control by three or more wheels whose axes span three dimensions. Gains are \
            given either by `natural_frequency_rad_s` and `damping_ratio`, or by \
            `attitude_gain_n_m` and `rate_gain_n_m_s`. Optional.",
    keys: &[TARGET, FREQUENCY, DAMPING, ATTITUDE_GAIN, RATE_GAIN],
};

/// Proportional-derivative attitude control by the wheels, \[Kim2010\] Eq. (17):
/// `u = −K_P q_e − K_D ω`.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Target attitude, at rest: the rotation from body axes to inertial axes.
    pub target: UnitQuaternion<f64>,
    /// `K_P`, on the vector part of the error quaternion, N m.
    pub attitude_gain_n_m: Matrix3<f64>,
    /// `K_D`, on the body rate, N m s.
    pub rate_gain_n_m_s: Matrix3<f64>,
}

/// `K_P` and `K_D`.
type Gains = (Matrix3<f64>, Matrix3<f64>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlFile {
    target_attitude_deg: Option<List>,
    natural_frequency_rad_s: Option<Spanned<f64>>,
    damping_ratio: Option<Spanned<f64>>,
    attitude_gain_n_m: Option<List>,
    rate_gain_n_m_s: Option<List>,
}

/// The checked `[control]` of a spacecraft with these elements and wheels.
pub(super) fn control(
    section: &Section<'_>,
    spanned: &Spanned<ControlFile>,
    inertia_kg_m2: &[f64; 6],
    wheels: &[SimulatedWheel],
) -> Result<Control, InputError> {
    let file = spanned.get_ref();
    let axes: Vec<Vector3<f64>> = wheels.iter().map(|motor| motor.wheel.axis).collect();
    if !spans(&axes) {
        let problem = ScenarioProblem::WheelsDoNotSpan { found: axes.len() };
        return Err(section.error(spanned, problem));
    }
    let has_frequency = file.natural_frequency_rad_s.is_some() || file.damping_ratio.is_some();
    let has_gains = file.attitude_gain_n_m.is_some() || file.rate_gain_n_m_s.is_some();
    let (attitude_gain_n_m, rate_gain_n_m_s) = match (has_frequency, has_gains) {
        (true, true) => return Err(section.error(spanned, ScenarioProblem::TwoKindsOfGains)),
        (_, false) => file.proportional_gains(section, spanned, inertia_kg_m2)?,
        (false, true) => file.axis_gains(section, spanned)?,
    };
    let target = attitude(section, &TARGET, &file.target_attitude_deg)?;
    Ok(Control { target, attitude_gain_n_m, rate_gain_n_m_s })
}

impl ControlFile {
    /// `2 ω² J` and `2 ζ ω J`, \[Kim2010\] Table 1.
    fn proportional_gains(
        &self,
        section: &Section<'_>,
        table: &Spanned<Self>,
        inertia_kg_m2: &[f64; 6],
    ) -> Result<Gains, InputError> {
        let number = |key: &Key, value: &Option<Spanned<f64>>| {
            section.optional_number(key, value)?.ok_or_else(|| section.missing(key, table))
        };
        let omega = number(&FREQUENCY, &self.natural_frequency_rad_s)?;
        let zeta = number(&DAMPING, &self.damping_ratio)?;
        let inertia = tensor(inertia_kg_m2);
        Ok((inertia * (2.0 * omega * omega), inertia * (2.0 * zeta * omega)))
    }

    fn axis_gains(
        &self,
        section: &Section<'_>,
        table: &Spanned<Self>,
    ) -> Result<Gains, InputError> {
        let gain = |key: &Key, value: &Option<List>| {
            let value = value.as_ref().ok_or_else(|| section.missing(key, table))?;
            section.vector(key, value).map(|gains| Matrix3::from_diagonal(&gains))
        };
        Ok((
            gain(&ATTITUDE_GAIN, &self.attitude_gain_n_m)?,
            gain(&RATE_GAIN, &self.rate_gain_n_m_s)?,
        ))
    }
}

fn spans(axes: &[Vector3<f64>]) -> bool {
    axes.len() >= 3 && Matrix3xX::from_columns(axes).singular_values().min() >= LEAST_SPAN
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::input::Scenario;

    const BODY: &str = "name = 'test'
duration_s = 60
spacecraft = { inertia_kg_m2 = [3, 4, 5, 0.1, 0, 0], attitude_deg = [0, 0, 90] }
gyro = { rate_hz = 10, noise_rad_s = 1e-4 }
";
    const X: &str = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n";
    const Y: &str = "[[wheel]]\naxis = [0, 1, 0]\nspin_inertia_kg_m2 = 1e-3\n";
    const Z: &str = "[[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1e-3\n";
    const FREQUENCY: &str = "natural_frequency_rad_s = 0.5\ndamping_ratio = 0.7\n";

    fn parse(text: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", text, Path::new(""))
    }

    fn with(control: &str) -> Result<Scenario, InputError> {
        parse(&format!("{BODY}{X}{Y}{Z}[control]\n{control}"))
    }

    #[test]
    fn gains_are_proportional_to_the_inertia_or_per_axis() {
        let control = with(FREQUENCY).unwrap().control.unwrap();
        let inertia = Matrix3::new(3.0, 0.1, 0.0, 0.1, 4.0, 0.0, 0.0, 0.0, 5.0);
        assert!((control.attitude_gain_n_m - inertia * 0.5).norm() < 1e-15);
        assert!((control.rate_gain_n_m_s - inertia * 0.7).norm() < 1e-15);
        assert_eq!(control.target, UnitQuaternion::identity());

        let gains = "attitude_gain_n_m = [1, 2, 3]\nrate_gain_n_m_s = [4, 5, 6]\n";
        let control = with(gains).unwrap().control.unwrap();
        assert_eq!(control.attitude_gain_n_m.diagonal(), Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(control.rate_gain_n_m_s.diagonal(), Vector3::new(4.0, 5.0, 6.0));
    }

    #[test]
    fn yaw_of_90_deg_turns_body_x_to_inertial_y() {
        let attitude = parse(BODY).unwrap().spacecraft.attitude;
        assert!((attitude * Vector3::x() - Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn wheels_must_span_three_dimensions() {
        for wheels in ["", X, &[X, Y].concat(), &[X, Y, X].concat()] {
            let error = parse(&format!("{BODY}{wheels}[control]\n{FREQUENCY}")).unwrap_err();
            assert!(error.to_string().contains("turns the body with its wheels, but"), "{error}");
        }
        let slanted = X.replace("[1, 0, 0]", "[1, 1, 1]");
        assert!(parse(&format!("{BODY}{X}{Y}{slanted}{X}[control]\n{FREQUENCY}")).is_ok());
    }

    #[test]
    fn each_bad_value_is_reported() {
        for (control, expected) in [
            ("natural_frequency_rad_s = 0.5", "s.toml:14: missing key `control.damping_ratio`"),
            ("", "s.toml:14: missing key `control.natural_frequency_rad_s`"),
            (
                "natural_frequency_rad_s = 0\ndamping_ratio = 1",
                "s.toml:15: `control.natural_frequency_rad_s` is 0; it must be positive",
            ),
            ("attitude_gain_n_m = [1, 1, 1]", "s.toml:14: missing key `control.rate_gain_n_m_s`"),
            (
                "attitude_gain_n_m = [1, -1, 1]\nrate_gain_n_m_s = [1, 1, 1]",
                "s.toml:15: `control.attitude_gain_n_m` is [1, -1, 1]; it must be positive and",
            ),
            (
                "damping_ratio = 1\nrate_gain_n_m_s = [1, 1, 1]",
                "s.toml:14: `control` has gains of both kinds",
            ),
            ("damping = 1", "s.toml:15: unknown key `damping` (did you mean `damping_ratio`?)"),
            (
                "target_attitude_deg = [1]\nnatural_frequency_rad_s = 1\ndamping_ratio = 1",
                "s.toml:15: `control.target_attitude_deg` has 1 entries, but takes 3",
            ),
        ] {
            let message = with(control).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }
}
