//! Results on the hardware: names of its parameters, and the kind of error that dominates.

use fsw_core::hardware::{Finding, Parameter};

/// Names of the body axes.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Names of the elements of a tensor.
const ELEMENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];

/// Name of a parameter, as `wheel 2 spin inertia`; wheels count from 1, as the columns of a log.
pub fn name(parameter: Parameter) -> String {
    let kind = parameter.kind();
    let axis = |i: u8| AXES.get(usize::from(i)).copied().unwrap_or("?");
    match parameter {
        Parameter::GyroScale(i)
        | Parameter::Mount(i)
        | Parameter::GyroBias(i)
        | Parameter::DisturbanceTorque(i) => format!("{kind} {}", axis(i)),
        Parameter::GyroAxes(of, about) => format!("{kind} {}{}", axis(of), axis(about)),
        Parameter::WheelInertia(i) => format!("{kind} {}", i + 1),
        Parameter::WheelAxis(i, tilt) => format!("{kind} {}, tilt {}", i + 1, tilt + 1),
        Parameter::ModalInertia(mode, element) => {
            let element = ELEMENTS.get(usize::from(element)).copied().unwrap_or("?");
            format!("{kind} {} {element}", mode + 1)
        }
        Parameter::ModeFrequency(mode) | Parameter::ModeDamping(mode) => {
            format!("{kind} {}", mode + 1)
        }
        Parameter::Delay | Parameter::TorqueScale | Parameter::CommonWheelInertia => {
            kind.to_owned()
        }
    }
}

/// Key of a craft file that states one sigma of the parameter; see
/// [`DATA_SHEET`](crate::input::craft::hardware::DATA_SHEET).
pub fn key(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::GyroScale(_) => "gyro.scale_sigma",
        Parameter::GyroAxes(..) => "gyro.axes_sigma_deg",
        Parameter::WheelInertia(_) => "wheel.spin_inertia_sigma",
        Parameter::WheelAxis(..) => "wheel.axis_sigma_deg",
        Parameter::Delay => "gyro.delay_sigma_s",
        Parameter::TorqueScale => "torque.scale_sigma",
        Parameter::CommonWheelInertia => "wheels.common_spin_inertia_sigma",
        Parameter::Mount(_) => "mount.sigma_deg",
        Parameter::GyroBias(_) => "gyro.bias_sigma_rad_s",
        Parameter::DisturbanceTorque(_) => "disturbance.torque_sigma_n_m",
        Parameter::ModalInertia(..) => "mode",
        Parameter::ModeFrequency(_) => "mode.frequency_sigma",
        Parameter::ModeDamping(_) => "mode.damping_sigma",
    }
}

/// Kind of the parameter whose remaining error shifts the tensor most, by the Frobenius norm of the shift; none
/// without a finite shift.
pub fn largest_systematic(findings: &[Finding<f64>]) -> Option<&'static str> {
    let shifts = findings.iter().map(|finding| (finding, squared_norm(&finding.effect_kg_m2)));
    let finite = shifts.filter(|(_, squares)| squares.is_finite() && *squares > 0.0);
    finite.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(finding, _)| finding.parameter.kind())
}

/// The kind of parameter of this name, as [`Parameter::kind`] gives it; none for another name.
pub fn kind_named(name: &str) -> Option<&'static str> {
    const ONE_OF_EACH: [Parameter; 13] = [
        Parameter::GyroScale(0),
        Parameter::GyroAxes(0, 0),
        Parameter::WheelInertia(0),
        Parameter::WheelAxis(0, 0),
        Parameter::Delay,
        Parameter::TorqueScale,
        Parameter::CommonWheelInertia,
        Parameter::Mount(0),
        Parameter::GyroBias(0),
        Parameter::DisturbanceTorque(0),
        Parameter::ModalInertia(0, 0),
        Parameter::ModeFrequency(0),
        Parameter::ModeDamping(0),
    ];
    ONE_OF_EACH.map(Parameter::kind).into_iter().find(|kind| *kind == name)
}

/// Square of the Frobenius norm of a tensor of these elements: a product stands in it twice.
pub fn squared_norm(elements: &[f64; 6]) -> f64 {
    let [xx, yy, zz, xy, xz, yz] = elements.map(|x| x * x);
    xx + yy + zz + 2.0 * (xy + xz + yz)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(parameter: Parameter, effect_kg_m2: [f64; 6]) -> Finding<f64> {
        Finding { parameter, value: 0.0, sigma: 0.01, stated: 0.01, effect_kg_m2 }
    }

    #[test]
    fn largest_effect_counts_products_twice() {
        let findings = [
            finding(Parameter::GyroScale(0), [1.2, 0.0, 0.0, 0.0, 0.0, 0.0]),
            finding(Parameter::WheelAxis(1, 0), [0.0, 0.0, 0.0, -1.0, 0.0, 0.0]),
            finding(Parameter::Delay, [f64::NAN; 6]),
        ];
        assert_eq!(largest_systematic(&findings), Some("wheel axis"));
        assert_eq!(largest_systematic(&findings[2..]), None);
    }

    #[test]
    fn names_have_axes_and_wheels() {
        assert_eq!(name(Parameter::GyroAxes(0, 2)), "gyro axes xz");
        assert_eq!(name(Parameter::WheelAxis(1, 0)), "wheel axis 2, tilt 1");
        assert_eq!(name(Parameter::Delay), "time offset");
    }
}
