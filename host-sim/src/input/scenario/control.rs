//! A closed-loop slew: the attitude controller of a scenario, and how its file writes it.
//!
//! ```toml
//! [control]                            # optional; three wheels or more
//! target_attitude_deg = [0, 0, 0]      # roll, pitch, yaw; left out: zero
//! natural_frequency_rad_s = 0.043      # gains 2 ω² J and 2 ζ ω J, with the true J; or instead
//! damping_ratio = 0.707
//! attitude_gain_n_m = [1, 1, 1]        # gains about x, y, z
//! rate_gain_n_m_s = [20, 20, 20]
//! ```
//!
//! With gains proportional to `J`, no external torque and total momentum zero, a slew from rest
//! stays about one fixed axis, whatever the angles, and shows no more than `J` along it: three
//! of six directions. Wheels that spin, or gains that aren't proportional to `J`, show more.

use nalgebra::{Matrix3, Matrix3xX, UnitQuaternion, Vector3};
use serde::Deserialize;
use toml::Spanned;

use super::super::check::{Check, tensor};
use super::super::error::{InputError, Problem};
use super::SimulatedWheel;

/// Least singular value of the unit axes side by side, at which they still span three dimensions.
/// Below, some torque on the body would take a thousand times as much of the motors.
const LEAST_SPAN: f64 = 1e-3;

/// Proportional-derivative control of the attitude by the wheels, \[Kim2010\] Eq. (17):
/// `u = −K_P q_e − K_D ω`.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Where to: the rotation that takes body axes to inertial axes. The target is at rest.
    pub target: UnitQuaternion<f64>,
    /// `K_P`, on the vector part of the error quaternion, N m.
    pub attitude_gain_n_m: Matrix3<f64>,
    /// `K_D`, on the body rate, N m s.
    pub rate_gain_n_m_s: Matrix3<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlFile {
    target_attitude_deg: Option<Spanned<Vec<f64>>>,
    natural_frequency_rad_s: Option<Spanned<f64>>,
    damping_ratio: Option<Spanned<f64>>,
    attitude_gain_n_m: Option<Spanned<Vec<f64>>>,
    rate_gain_n_m_s: Option<Spanned<Vec<f64>>>,
}

/// Checks the table `[control]` of a spacecraft with these elements and wheels.
pub(super) fn control(
    check: &Check<'_>,
    spanned: &Spanned<ControlFile>,
    inertia_kg_m2: &[f64; 6],
    wheels: &[SimulatedWheel],
) -> Result<Control, InputError> {
    let file = spanned.get_ref();
    let axes: Vec<Vector3<f64>> = wheels.iter().map(|motor| motor.wheel.axis).collect();
    if !spans(&axes) {
        return Err(check.error(spanned, Problem::WheelsDoNotSpan { found: axes.len() }));
    }
    let has_frequency = file.natural_frequency_rad_s.is_some() || file.damping_ratio.is_some();
    let has_gains = file.attitude_gain_n_m.is_some() || file.rate_gain_n_m_s.is_some();
    let (attitude_gain_n_m, rate_gain_n_m_s) = match (has_frequency, has_gains) {
        (true, true) => return Err(check.error(spanned, Problem::TwoKindsOfGains)),
        (_, false) => file.proportional_gains(check, spanned, inertia_kg_m2)?,
        (false, true) => file.axis_gains(check, spanned)?,
    };
    let target = match &file.target_attitude_deg {
        Some(angles) => attitude(check, "control.target_attitude_deg", angles)?,
        None => UnitQuaternion::identity(),
    };
    Ok(Control { target, attitude_gain_n_m, rate_gain_n_m_s })
}

impl ControlFile {
    /// `2 ω² J` and `2 ζ ω J`, \[Kim2010\] Table 1.
    fn proportional_gains(
        &self,
        check: &Check<'_>,
        table: &Spanned<Self>,
        inertia_kg_m2: &[f64; 6],
    ) -> Result<(Matrix3<f64>, Matrix3<f64>), InputError> {
        let number = |key: &str, value: &Option<Spanned<f64>>| match value {
            Some(value) => check.positive(key, value),
            None => Err(check.error(table, Problem::MissingKey { key: key.to_owned() })),
        };
        let omega = number("control.natural_frequency_rad_s", &self.natural_frequency_rad_s)?;
        let zeta = number("control.damping_ratio", &self.damping_ratio)?;
        let inertia = tensor(inertia_kg_m2);
        Ok((inertia * (2.0 * omega * omega), inertia * (2.0 * zeta * omega)))
    }

    fn axis_gains(
        &self,
        check: &Check<'_>,
        table: &Spanned<Self>,
    ) -> Result<(Matrix3<f64>, Matrix3<f64>), InputError> {
        let gain = |key: &str, value: &Option<Spanned<Vec<f64>>>| {
            let Some(value) = value else {
                return Err(check.error(table, Problem::MissingKey { key: key.to_owned() }));
            };
            let gains = check.vector(key, value)?;
            if gains.iter().all(|gain| *gain > 0.0) {
                return Ok(Matrix3::from_diagonal(&gains));
            }
            Err(check.bad_list(key, value, "three positive gains"))
        };
        Ok((
            gain("control.attitude_gain_n_m", &self.attitude_gain_n_m)?,
            gain("control.rate_gain_n_m_s", &self.rate_gain_n_m_s)?,
        ))
    }
}

fn spans(axes: &[Vector3<f64>]) -> bool {
    axes.len() >= 3 && Matrix3xX::from_columns(axes).singular_values().min() >= LEAST_SPAN
}

/// Roll, pitch and yaw in degrees, as the rotation that takes body axes to inertial axes: the body
/// is turned by yaw about z, then by pitch about its new y, then by roll about its new x (3-2-1).
pub(super) fn attitude(
    check: &Check<'_>,
    key: &str,
    angles_deg: &Spanned<Vec<f64>>,
) -> Result<UnitQuaternion<f64>, InputError> {
    let [roll, pitch, yaw] = check.list::<3>(key, angles_deg)?.map(f64::to_radians);
    Ok(UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Scenario;
    use super::*;

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
    fn gains_are_proportional_to_the_inertia_or_as_told() {
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
    fn yaw_turns_the_bodys_x_axis_to_inertial_y() {
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
    fn each_bad_value_is_named() {
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
                "s.toml:15: `control.attitude_gain_n_m` is [1, -1, 1]; it must be three positive",
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
