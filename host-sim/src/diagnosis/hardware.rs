//! Errors of the hardware: groups of unknowns that are solved with a wide prior, and their remedies.

use fsw_core::hardware::tilt_directions;

use super::fit::{Fit, Unknowns};
use super::model::Unknown;
use super::record::Record;

/// A group of unknowns of one name.
pub(super) struct Group {
    pub name: &'static str,
    pub unknowns: Vec<Unknown>,
}

/// The groups that are possible with this record and are not among the `base` unknowns.
pub(super) fn groups(record: &Record, base: &Unknowns) -> Vec<Group> {
    let wheels = 0..record.wheels.len();
    let axes = |i: usize| (0..3).filter(move |k| *k != i).map(move |k| Unknown::GyroAxes(i, k));
    let mut all = vec![
        ("gyro scale factor", (0..3).map(Unknown::GyroScale).collect::<Vec<_>>()),
        ("gyro axes", (0..3).flat_map(axes).collect()),
        ("gyro bias", (0..3).map(Unknown::Bias).collect()),
        ("constant torque", (0..3).map(Unknown::Torque).collect()),
        ("wheel spin inertia", wheels.clone().map(Unknown::WheelInertia).collect()),
        (
            "wheel axis",
            wheels.flat_map(|w| (0..2).map(move |tilt| Unknown::WheelAxis(w, tilt))).collect(),
        ),
    ];
    if !record.wheels.is_empty() || record.has_torque() {
        all.push(("time offset", vec![Unknown::Delay]));
    }
    if record.has_torque() {
        all.push(("torque scale", vec![Unknown::TorqueScale]));
    }
    let is_new =
        |unknowns: &[Unknown]| unknowns.first().is_some_and(|first| !base.names.contains(first));
    let groups = all.into_iter().filter(|(_, unknowns)| is_new(unknowns));
    groups.map(|(name, unknowns)| Group { name, unknowns }).collect()
}

/// Values of the unknowns of a group in a fit.
fn values<const N: usize>(fit: &Fit, names: &[Unknown], of: [Unknown; N]) -> [f64; N] {
    of.map(|unknown| names.iter().position(|n| *n == unknown).map_or(0.0, |i| fit.values[i]))
}

/// Lines of the craft file that state what was found.
pub(super) fn remedy(group: &str, fit: &Fit, names: &[Unknown], record: &Record) -> String {
    let of_axes = |unknown: fn(usize) -> Unknown| {
        let values = values(fit, names, [0, 1, 2].map(unknown));
        values.map(|value| format!("{value:.3e}")).join(", ")
    };
    let number = |unknown: Unknown| {
        names
            .iter()
            .position(|n| *n == unknown)
            .map_or((0.0, 0.0), |i| (fit.values[i], fit.sigmas[i]))
    };
    match group {
        "time offset" => {
            let (delay_s, sigma_s) = number(Unknown::Delay);
            format!("[gyro] delay_s = {delay_s:.6}, delay_sigma_s = {sigma_s:.1e}")
        }
        "gyro scale factor" => format!("[gyro] scale = [{}]", of_axes(Unknown::GyroScale)),
        "gyro axes" => {
            let order = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
            let values = values(fit, names, order.map(|(i, k)| Unknown::GyroAxes(i, k)));
            let values = values.map(|value| format!("{:.4}", value.to_degrees())).join(", ");
            format!("[gyro] axes_deg = [{values}]")
        }
        "gyro bias" => "[disturbance] gyro_bias = true".to_owned(),
        "constant torque" => "[disturbance] torque = true".to_owned(),
        "torque scale" => {
            let (scale, _) = number(Unknown::TorqueScale);
            format!("multiply the torque columns by {:.5}", 1.0 + scale)
        }
        "wheel spin inertia" => {
            let inertia = |(w, wheel): (usize, &super::record::Wheel)| {
                let error = number(Unknown::WheelInertia(w)).0;
                format!("{}: {:.5e}", w + 1, wheel.inertia_kg_m2 * (1.0 + error))
            };
            let inertias: Vec<_> = record.wheels.iter().enumerate().map(inertia).collect();
            format!("[[wheel]] spin_inertia_kg_m2 = {}", inertias.join("; "))
        }
        _ => {
            let axis = |(w, wheel): (usize, &super::record::Wheel)| {
                let tilts = tilt_directions(&wheel.axis);
                let tilt = |i: usize| tilts[i] * number(Unknown::WheelAxis(w, i)).0;
                let axis = (wheel.axis + tilt(0) + tilt(1)).normalize();
                format!("{}: [{:.5}, {:.5}, {:.5}]", w + 1, axis.x, axis.y, axis.z)
            };
            let axes: Vec<_> = record.wheels.iter().enumerate().map(axis).collect();
            format!("[[wheel]] axis = {}", axes.join("; "))
        }
    }
}

/// Name of one unknown of a group, to follow the name of the group; empty where there is but one.
pub(super) fn component(unknown: Unknown) -> String {
    let axis = |i: usize| ["x", "y", "z"][i.min(2)];
    match unknown {
        Unknown::GyroScale(i) | Unknown::Bias(i) | Unknown::Torque(i) => axis(i).to_owned(),
        Unknown::GyroAxes(i, k) => format!("{}{}", axis(i), axis(k)),
        Unknown::WheelInertia(w) => format!("wheel {}", w + 1),
        Unknown::WheelAxis(w, tilt) => format!("wheel {}, tilt {}", w + 1, tilt + 1),
        Unknown::Delay | Unknown::TorqueScale => String::new(),
        Unknown::Modal(element) => crate::input::ELEMENT_NAMES[element.min(5)].to_owned(),
    }
}
