//! The spacecraft of a design: a scenario or a craft file; and the scenario that flies the result.

use std::path::Path;

use flight_input::InputError;
use toml::{Table as Toml, Value};

use super::command::Table;
use super::problem::DesignError;
use crate::input::{Craft, Scenario};

/// A file that cannot be the subject of a design.
#[derive(Debug, thiserror::Error)]
pub enum SubjectError {
    /// The file is rejected.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The craft lacks what a design needs.
    #[error("{file}: {error}")]
    Design {
        /// The file.
        file: String,
        /// The fault.
        error: DesignError,
    },
}

/// Spacecraft in a scenario or craft file, or in a built-in scenario. A craft file is a file without
/// `[spacecraft]` and `[random_spacecraft]`; its gyro is read at `rate_hz`.
///
/// # Errors
/// A rejected file, or a craft without prior or gyro noise.
pub fn subject(name_or_path: &str, rate_hz: f64) -> Result<Scenario, SubjectError> {
    let path = Path::new(name_or_path);
    let is_craft = path.is_file()
        && std::fs::read_to_string(path)
            .ok()
            .and_then(|text| text.parse::<Toml>().ok())
            .is_some_and(|table| {
                !table.contains_key("spacecraft") && !table.contains_key("random_spacecraft")
            });
    if !is_craft {
        return Ok(Scenario::load(name_or_path)?);
    }
    let fault = |error| SubjectError::Design { file: name_or_path.to_owned(), error };
    let craft = Craft::load(path)?;
    let prior = craft.prior.as_ref().ok_or_else(|| fault(DesignError::NoPrior))?;
    if craft.gyro.noise_rad_s.is_none() {
        return Err(fault(DesignError::NoNoise));
    }
    let name = path.file_stem().map_or("craft".to_owned(), |stem| stem.to_string_lossy().into());
    let text = scenario_text(&craft, &name, 1.0, &prior.inertia_kg_m2, rate_hz);
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(Scenario::from_toml(name_or_path, &text.to_string(), folder)?)
}

/// Files of a scenario that flies a table: name and text of each, the scenario first. It has the spacecraft, wheels,
/// thrusters, gyro, stated errors, prior and disturbance of `scenario`.
pub fn flown(scenario: &Scenario, table: &Table) -> Vec<(String, String)> {
    let rows = table.torque_n_m.len();
    let duration_s = rows.saturating_sub(1) as f64 * table.step_s;
    let name = format!("{}-design", scenario.name);
    let inertia = &scenario.spacecraft.inertia_kg_m2;
    let craft = scenario.craft();
    let mut text = scenario_text(&craft, &name, duration_s, inertia, scenario.gyro.rate_hz);
    let (roll, pitch, yaw) = scenario.spacecraft.attitude.euler_angles();
    let angles = [roll, pitch, yaw].map(|angle| Value::from(angle.to_degrees()));
    edit(&mut text, "spacecraft", |table| {
        table.insert("attitude_deg".into(), angles.to_vec().into());
    });
    let disturbance = scenario.disturbance_torque_n_m.map(Value::from);
    let disturbance: Vec<Value> = disturbance.iter().cloned().collect();
    edit(&mut text, "disturbance", |table| {
        table.insert("torque_n_m".into(), disturbance.into());
    });
    let mut files = Vec::new();
    if let Some(Value::Array(wheels)) = text.get_mut("wheel") {
        for (index, wheel) in wheels.iter_mut().enumerate() {
            let csv = format!("torque-{}.csv", index + 1);
            let Value::Table(wheel) = wheel else { continue };
            let torque: Toml =
                [("kind".to_owned(), "table".into()), ("csv".to_owned(), csv.as_str().into())]
                    .into_iter()
                    .collect();
            wheel.insert("torque".into(), torque.into());
            wheel.insert("speed_rad_s".into(), scenario.wheels[index].speed_rad_s.into());
            let line = |(row, torques): (usize, &Vec<f64>)| {
                format!("{:?},{:?}\n", stamp_s(row, table.step_s), torques[index])
            };
            let lines: String = table.torque_n_m.iter().enumerate().map(line).collect();
            files.push((csv, format!("t_s,x\n{lines}")));
        }
    }
    if let Some(Value::Array(thrusters)) = text.get_mut("thruster") {
        for (thruster, on_s) in thrusters.iter_mut().zip(table.thruster_pulses_s(scenario)) {
            let pulse = |[on_s, off_s]: &[f64; 2]| Value::from(vec![*on_s, *off_s]);
            let Value::Table(thruster) = thruster else { continue };
            if !on_s.is_empty() {
                thruster.insert("on_s".into(), on_s.iter().map(pulse).collect::<Vec<_>>().into());
            }
        }
    }
    files.insert(0, ("scenario.toml".to_owned(), text.to_string()));
    files
}

/// Time of a row, rounded to the resolution of a time stamp, 1 µs.
pub(crate) fn stamp_s(row: usize, step_s: f64) -> f64 {
    (row as f64 * step_s * 1e6).round() / 1e6
}

/// A scenario of a craft at rest with this inertia. Assumed errors of the hardware are stated: in a scenario an absent
/// key is ideal. Keys that a scenario does not have are left out: known errors of the gyro, the mount, the filters.
fn scenario_text(
    craft: &Craft,
    name: &str,
    duration_s: f64,
    inertia_kg_m2: &[f64; 6],
    rate_hz: f64,
) -> Toml {
    let mut stated = craft.clone();
    stated.hardware.assumed.clear();
    // The text of a craft that was read is valid.
    let mut text: Toml = stated.to_toml().parse().unwrap_or_default();
    for key in ["torque", "mount", "filter", "log"] {
        text.remove(key);
    }
    let scale_sigma = craft.hardware.torque_scale_sigma;
    if !craft.thrusters.is_empty() && scale_sigma > 0.0 {
        edit(&mut text, "torque", |torque| {
            torque.insert("kind".into(), "constant".into());
            torque.insert("value_n_m".into(), vec![0.0; 3].into());
            torque.insert("scale_sigma".into(), scale_sigma.into());
        });
    }
    edit(&mut text, "gyro", |gyro| {
        for key in ["scale", "axes_deg"] {
            gyro.remove(key);
        }
        gyro.insert("rate_hz".into(), rate_hz.into());
    });
    text.insert("name".into(), name.into());
    text.insert("duration_s".into(), duration_s.into());
    let inertia: Vec<Value> = inertia_kg_m2.iter().map(|j| Value::from(*j)).collect();
    edit(&mut text, "spacecraft", |table| {
        table.insert("inertia_kg_m2".into(), inertia.into());
    });
    text
}

/// Changes the table of this name, empty at first.
fn edit(text: &mut Toml, name: &str, change: impl FnOnce(&mut Toml)) {
    let mut table = match text.remove(name) {
        Some(Value::Table(table)) => table,
        _ => Toml::new(),
    };
    change(&mut table);
    text.insert(name.to_owned(), table.into());
}
