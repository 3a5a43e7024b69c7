//! `[[thruster]]` of a scenario: a thruster and its pulses.

use flight_input::InputError;
use flight_input::craft::Thruster;
use flight_input::craft::thruster::{MIN_PULSE, TORQUE};
use flight_input::key::{Key, Range, Table};
use flight_input::section::{List, Section};
use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::problem::ScenarioProblem;
use super::profile::intervals_s;

/// Share by which a pulse may be shorter than the shortest: rounding of times.
const ROUNDING: f64 = 1e-6;

const PULSES: Range =
    Range::new("one or more `[on, off]`, each after the previous one", f64::is_finite);
const ON: Key = Key::required(
    "on_s",
    "list of pairs of numbers",
    "s",
    PULSES,
    "Times at which it is switched on and off",
)
.or("never on");

/// The keys of `[[thruster]]` in a scenario.
pub(super) const TABLE: Table = Table {
    header: "[[thruster]]",
    about: "A thruster or a couple of thrusters, on or off: a torque source of `design`. Its torque is part of \
            the commanded external torque: known to the estimator at the samples of the gyro, with the scale \
            error that `torque.scale_sigma` states. Optional.",
    keys: &[TORQUE, MIN_PULSE, ON],
};

/// A thruster and its pulses.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedThruster {
    /// Torque and shortest pulse.
    pub thruster: Thruster,
    /// Times at which it is switched on and off, ascending and disjoint, s.
    pub on_s: Vec<[f64; 2]>,
}

impl SimulatedThruster {
    /// The torque at this time, body axes, N m; at a switch that after it.
    pub fn torque_at_n_m(&self, time_s: f64) -> Vector3<f64> {
        let begun = self.on_s.partition_point(|[on_s, _]| *on_s <= time_s);
        let is_on = self.on_s[..begun].last().is_some_and(|[_, off_s]| time_s < *off_s);
        if is_on { self.thruster.torque_n_m } else { Vector3::zeros() }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThrusterFile {
    torque_n_m: List,
    min_pulse_s: Spanned<f64>,
    on_s: Option<Spanned<Vec<Vec<f64>>>>,
}

impl ThrusterFile {
    pub(super) fn read(&self, section: &Section<'_>) -> Result<SimulatedThruster, InputError> {
        let thruster = Thruster::read(section, &self.torque_n_m, &self.min_pulse_s)?;
        let Some(on_s) = &self.on_s else {
            return Ok(SimulatedThruster { thruster, on_s: Vec::new() });
        };
        let pulses = intervals_s(section, &ON, on_s)?;
        let least_s = thruster.min_pulse_s * (1.0 - ROUNDING);
        if let Some([from_s, to_s]) = pulses.iter().find(|[from_s, to_s]| to_s - from_s < least_s) {
            let problem = ScenarioProblem::ShortPulse {
                key: section.full(&ON),
                from_s: *from_s,
                to_s: *to_s,
                min_pulse_s: thruster.min_pulse_s,
            };
            return Err(section.error(on_s, problem));
        }
        Ok(SimulatedThruster { thruster, on_s: pulses })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::input::Scenario;

    fn read(thruster: &str) -> Result<Scenario, InputError> {
        let text = format!(
            "name = 'test'\nduration_s = 60\nspacecraft = {{ inertia_kg_m2 = [3, 4, 5, 0, 0, 0] }}\n\
             gyro = {{ rate_hz = 10, noise_rad_s = 1e-4 }}\n[[thruster]]\n{thruster}\n"
        );
        Scenario::from_toml("s.toml", &text, Path::new(""))
    }

    #[test]
    fn pulses_are_part_of_the_external_torque() {
        let scenario =
            read("torque_n_m = [0.1, 0, -0.2]\nmin_pulse_s = 0.1\non_s = [[1.05, 1.15], [2, 4]]");
        let torque = scenario.unwrap().torque;
        let x: Vec<f64> = [1.0, 1.1, 1.2, 2.0, 4.0].iter().map(|t| torque.at(*t).x).collect();
        assert_eq!(x, [0.0, 0.1, 0.0, 0.1, 0.0]);
        assert_eq!(torque.breakpoints_s(), [1.05, 1.15, 2.0, 4.0]);
    }

    #[test]
    fn each_bad_key_is_named() {
        for (thruster, expected) in [
            (
                "torque_n_m = [0, 0, 0]\nmin_pulse_s = 0.1",
                "`thruster[1].torque_n_m` is [0, 0, 0]; it must",
            ),
            (
                "torque_n_m = [1, 0, 0]\nmin_pulse_s = 0",
                "`thruster[1].min_pulse_s` is 0; it must be pos",
            ),
            ("torque_n_m = [1, 0, 0]", "missing key `min_pulse_s`; add it"),
            (
                "torque_n_m = [1, 0, 0]\nmin_pulse_s = 0.1\non_s = [[2, 1]]",
                "`thruster[1].on_s` is [[2, 1]]; it must be one or more `[on, off]`",
            ),
            (
                "torque_n_m = [1, 0, 0]\nmin_pulse_s = 0.1\non_s = [[1, 2], [3, 3.05]]",
                "`thruster[1].on_s` has a pulse from 3 to 3.05 s, shorter than `min_pulse_s`, 0.1 s",
            ),
        ] {
            let message = read(thruster).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\n  expected: {expected}");
        }
    }
}
