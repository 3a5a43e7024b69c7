//! `[[change]]` and `[drift]`: changes of the true inertia in flight, unknown to the estimator.
//!
//! ```toml
//! [[change]]                                   # deployment, docking, loss of a mass; ascending time
//! time_s = 300.0
//! inertia_factor = [1.05, 1, 1, 1, 1, 1]       # each element times this; or instead
//! inertia_kg_m2 = [14.9, 17.3, 20.3, 0, 0, 0]  # the new tensor, wheels included and locked
//! [drift]                                      # fuel consumption
//! inertia_rate_per_hour = [-0.01, -0.01, -0.01, 0, 0, 0]
//! ```
//!
//! The drift is linear in time: each element changes by a constant share per hour of its value at the
//! start or just after the last change. Elements are about the instantaneous centre of mass, in axes
//! fixed to the body.
//!
//! Assumption: neither a change nor the drift transports angular momentum. The total is conserved in
//! inertial space except for the external torque. Each wheel keeps its axial momentum, as a bearing
//! transmits no torque about its axis. Rate and relative wheel speeds therefore jump unless all is at
//! rest. This is exact for parts that move within the craft. A mass that leaves a rotating body, and
//! the jet of a thruster, carry momentum away; the equivalent torque is not modelled.

use flight_input::InputError;
use flight_input::inertia::{is_physical, principal_moments, tensor};
use flight_input::key::{ELEMENTS, FINITE, Key, NUMBER, PHYSICAL, Range, Table};
use flight_input::section::{List, Section};
use serde::Deserialize;
use toml::Spanned;

use super::problem::ScenarioProblem;
use super::wheel::{SimulatedWheel, moments_without_wheels};

const SECONDS_PER_HOUR: f64 = 3600.0;

const IN_FLIGHT: Range =
    Range::new("after the start and the previous change, before the end of the flight", |_| true);

const TIME: Key = Key::required("time_s", NUMBER, "s", IN_FLIGHT, "Time since the start");
const FACTOR: Key =
    Key::required("inertia_factor", ELEMENTS, "", FINITE, "Factor of each inertia element")
        .or("required without `inertia_kg_m2`");
const INERTIA: Key = Key::required(
    "inertia_kg_m2",
    ELEMENTS,
    "kg m²",
    PHYSICAL,
    "New `jxx jyy jzz jxy jxz jyz`, wheels included and locked",
)
.or("required without `inertia_factor`");
const RATE: Key = Key::required(
    "inertia_rate_per_hour",
    ELEMENTS,
    "1/h",
    FINITE,
    "Change of each element per hour, as a share of it at the start or after the last change",
);

/// The keys of `[[change]]`.
pub(super) const CHANGE_TABLE: Table = Table {
    header: "[[change]]",
    about: "A sudden change of the true inertia, in ascending time. The new tensor must be that of \
            a rigid body that carries the wheels. Optional.",
    keys: &[TIME, FACTOR, INERTIA],
};
/// The keys of `[drift]`.
pub(super) const DRIFT_TABLE: Table = Table {
    header: "[drift]",
    about: "A linear drift of the true inertia. Optional.",
    keys: &[RATE],
};

/// Departures of the true inertia from its initial value. None by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Sudden changes, in ascending time.
    pub sudden: Vec<SuddenChange>,
    /// Linear drift: share of each element per hour, of its value at the start or just after the last
    /// sudden change.
    pub drift_per_hour: [f64; 6],
}

/// A new tensor from one instant on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuddenChange {
    /// Time since the start, s. A sample at this instant observes the new tensor.
    pub time_s: f64,
    /// `jxx jyy jzz jxy jxz jyz` just after it, kg m².
    pub inertia_kg_m2: [f64; 6],
}

/// Part of a flight over which each inertia element is linear in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Start, s since the start of the flight.
    pub from_s: f64,
    /// End, s since the start of the flight; none for the end of the flight.
    pub to_s: Option<f64>,
    /// `jxx jyy jzz jxy jxz jyz` at its start, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Slope of each, kg m²/s.
    pub slope_kg_m2_s: [f64; 6],
}

impl Changes {
    /// True if the inertia drifts.
    pub fn drifts(&self) -> bool {
        self.drift_per_hour.iter().any(|share| *share != 0.0)
    }

    /// The stretch after `after` sudden changes of a body with these elements at the start.
    pub(super) fn stretch(&self, after: usize, initial_kg_m2: [f64; 6]) -> Stretch {
        let start = SuddenChange { time_s: 0.0, inertia_kg_m2: initial_kg_m2 };
        let begin = after.checked_sub(1).and_then(|index| self.sudden.get(index)).unwrap_or(&start);
        let to_s = self.sudden.get(after).map(|next| next.time_s);
        self.stretch_between(begin.time_s, to_s, begin.inertia_kg_m2)
    }

    fn stretch_between(&self, from_s: f64, to_s: Option<f64>, inertia_kg_m2: [f64; 6]) -> Stretch {
        let slope = |i: usize| inertia_kg_m2[i] * self.drift_per_hour[i] / SECONDS_PER_HOUR;
        Stretch { from_s, to_s, inertia_kg_m2, slope_kg_m2_s: std::array::from_fn(slope) }
    }
}

impl Stretch {
    /// The elements at a time within it, kg m².
    pub fn inertia_at_kg_m2(&self, time_s: f64) -> [f64; 6] {
        let elapsed_s = time_s - self.from_s;
        std::array::from_fn(|i| self.inertia_kg_m2[i] + self.slope_kg_m2_s[i] * elapsed_s)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangeFile {
    time_s: Spanned<f64>,
    inertia_factor: Option<List>,
    inertia_kg_m2: Option<List>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DriftFile {
    inertia_rate_per_hour: List,
}

/// `[[change]]` and `[drift]` as written, and the body that they change.
pub(super) struct ChangesFile<'a> {
    pub sudden: &'a [Spanned<ChangeFile>],
    pub drift: Option<&'a DriftFile>,
    pub initial_kg_m2: [f64; 6],
    pub wheels: &'a [SimulatedWheel],
}

impl ChangesFile<'_> {
    /// The checked changes of a flight of this duration.
    ///
    /// The tensor is checked at both ends of each stretch. Physical tensors form a convex set, so the
    /// linear drift between them is physical too.
    pub(super) fn read(&self, root: &Section<'_>, duration_s: f64) -> Result<Changes, InputError> {
        let mut changes = Changes::default();
        if let Some(drift) = self.drift {
            let section = root.table("drift");
            changes.drift_per_hour = section.list(&RATE, &drift.inertia_rate_per_hour)?;
        }
        let mut stretch = changes.stretch_between(0.0, None, self.initial_kg_m2);
        for (index, spanned) in self.sudden.iter().enumerate() {
            let (file, section) = (spanned.get_ref(), root.entry("change", index));
            let time_s = section.number_if(&TIME, &file.time_s, |time_s| {
                stretch.from_s < time_s && time_s < duration_s
            })?;
            let before_kg_m2 = self.end_of(root, &stretch, time_s)?;
            let (key, list, inertia_kg_m2) = file.elements(&section, spanned, &before_kg_m2)?;
            self.check_body(&section, key, list, time_s, &inertia_kg_m2)?;
            changes.sudden.push(SuddenChange { time_s, inertia_kg_m2 });
            stretch = changes.stretch_between(time_s, None, inertia_kg_m2);
        }
        self.end_of(root, &stretch, duration_s)?;
        Ok(changes)
    }

    /// The elements at the end of a stretch, kg m².
    fn end_of(
        &self,
        root: &Section<'_>,
        stretch: &Stretch,
        to_s: f64,
    ) -> Result<[f64; 6], InputError> {
        let end_kg_m2 = stretch.inertia_at_kg_m2(to_s);
        if let Some(drift) = self.drift {
            let (section, shares) = (root.table("drift"), &drift.inertia_rate_per_hour);
            self.check_body(&section, &RATE, shares, to_s, &end_kg_m2)?;
        }
        Ok(end_kg_m2)
    }

    /// Requires a rigid body that carries the wheels.
    fn check_body(
        &self,
        section: &Section<'_>,
        key: &Key,
        value: &List,
        time_s: f64,
        elements_kg_m2: &[f64; 6],
    ) -> Result<(), InputError> {
        let principal_moments_kg_m2 = principal_moments(&tensor(elements_kg_m2));
        let rest = moments_without_wheels(elements_kg_m2, self.wheels);
        if is_physical(&principal_moments_kg_m2) && rest[0] > 0.0 {
            return Ok(());
        }
        let key = section.full(key);
        let problem = ScenarioProblem::UnphysicalChange { key, time_s, principal_moments_kg_m2 };
        Err(section.error(value, problem))
    }
}

impl ChangeFile {
    /// The new elements, with the key and the list that give them.
    fn elements(
        &self,
        section: &Section<'_>,
        table: &Spanned<Self>,
        before_kg_m2: &[f64; 6],
    ) -> Result<(&'static Key, &List, [f64; 6]), InputError> {
        match (&self.inertia_factor, &self.inertia_kg_m2) {
            (Some(factors), None) => {
                let list: [f64; 6] = section.list(&FACTOR, factors)?;
                Ok((&FACTOR, factors, std::array::from_fn(|i| before_kg_m2[i] * list[i])))
            }
            (None, Some(elements)) => Ok((&INERTIA, elements, section.list(&INERTIA, elements)?)),
            _ => {
                let key = section.path().to_owned();
                let keys = [FACTOR.name, INERTIA.name];
                Err(section.error(table, ScenarioProblem::NotOneOf { key, keys }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::input::Scenario;

    const BODY: &str = r#"name = "test"
duration_s = 7200.0
[spacecraft]
inertia_kg_m2 = [3, 4, 5, 0.1, 0, 0]
[gyro]
rate_hz = 1.0
noise_rad_s = 1e-4
[[wheel]]
axis = [0, 0, 1]
spin_inertia_kg_m2 = 1.0
"#;
    const FACTOR: &str = "[[change]]\ntime_s = 3600\ninertia_factor = [1, 1.05, 1, 2, 1, 1]\n";
    const TENSOR: &str = "[[change]]\ntime_s = 5400\ninertia_kg_m2 = [6, 7, 8, 0, 0, 0]\n";
    const DRIFT: &str = "[drift]\ninertia_rate_per_hour = [-0.1, 0, 0.02, 0, 0, 0]\n";

    fn parse(extra: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", &format!("{BODY}{extra}"), Path::new(""))
    }

    fn near(found: [f64; 6], expected: [f64; 6]) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn inertia_is_constant_by_default() {
        let scenario = parse("").unwrap();
        assert_eq!(scenario.changes, Changes::default());
        assert_eq!(scenario.stretches().count(), 1);
        assert_eq!(scenario.final_inertia_kg_m2(), scenario.spacecraft.inertia_kg_m2);
    }

    #[test]
    fn change_acts_on_the_drifted_tensor_and_the_drift_continues() {
        let scenario = parse(&format!("{FACTOR}{TENSOR}{DRIFT}")).unwrap();
        near(scenario.inertia_at_kg_m2(1800.0), [2.85, 4.0, 5.05, 0.1, 0.0, 0.0]);
        near(scenario.inertia_at_kg_m2(3600.0), [2.7, 4.2, 5.1, 0.2, 0.0, 0.0]);
        near(scenario.inertia_at_kg_m2(4500.0), [2.6325, 4.2, 5.1255, 0.2, 0.0, 0.0]);
        near(scenario.final_inertia_kg_m2(), [5.7, 7.0, 8.08, 0.0, 0.0, 0.0]);
        let ends: Vec<_> = scenario.stretches().map(|s| (s.from_s, s.to_s)).collect();
        assert_eq!(ends, [(0.0, Some(3600.0)), (3600.0, Some(5400.0)), (5400.0, None)]);
    }

    #[test]
    fn dispersion_scales_every_tensor() {
        let dispersion = "[dispersion]\ninertia_factor = [1.0, 2.0]\n";
        let scenario = parse(&format!("{FACTOR}{dispersion}")).unwrap();
        near(scenario.of_truth(1).final_inertia_kg_m2(), [6.0, 8.4, 10.0, 0.4, 0.0, 0.0]);
        // A wheel of 1 kg m² about z in a body of 0.9 kg m².
        let change = TENSOR.replace("6, 7, 8, 0", "3, 3, 3, 0");
        let message = parse(&format!("{change}{}", dispersion.replace("2.0", "0.3")));
        let message = message.unwrap_err().to_string();
        assert!(message.starts_with("s.toml:15: `dispersion.inertia_factor`"), "{message}");
    }

    #[test]
    fn each_bad_value_is_reported() {
        for (extra, good, bad, expected) in [
            (FACTOR, "3600", "0", "s.toml:12: `change[1].time_s` is 0; it must be after the start"),
            (FACTOR, "3600", "7200", "s.toml:12: `change[1].time_s` is 7200; it must be after"),
            (FACTOR, "3600", "nan", "s.toml:12: `change[1].time_s` is NaN; it must be after"),
            (FACTOR, "time_s", "at_s", "s.toml:12: unknown key `at_s` (did you mean `time_s`?)"),
            (FACTOR, "1.05, 1,", "", "s.toml:13: `change[1].inertia_factor` has 4 entries, but"),
            (FACTOR, "1.05", "inf", "s.toml:13: `change[1].inertia_factor` is [1, inf, 1, 2, 1,"),
            (
                FACTOR,
                "1.05",
                "2.5",
                "s.toml:13: `change[1].inertia_factor` leads to principal moments [2.994, 5, 10.01] \
                 kg m² at t = 3600 s, which no body that carries these wheels has",
            ),
            (
                FACTOR,
                "inertia_factor = [1, 1.05, 1, 2, 1, 1]\n",
                "",
                "s.toml:11: `change[1]` takes exactly one of inertia_factor, inertia_kg_m2; keep",
            ),
            (
                FACTOR,
                "1, 1]",
                "1, 1]\ninertia_kg_m2 = [6, 7, 8, 0, 0, 0]",
                "s.toml:11: `change[1]` takes exactly one of inertia_factor, inertia_kg_m2; keep",
            ),
            // About z the body has no more than its wheel.
            (TENSOR, "6, 7, 8", "1, 1, 1", "s.toml:13: `change[1].inertia_kg_m2` leads to princ"),
            (DRIFT, "-0.1", "nan", "s.toml:12: `drift.inertia_rate_per_hour` is [NaN, 0, 0.02, 0,"),
            (DRIFT, "-0.1, 0,", "-0.1,", "s.toml:12: `drift.inertia_rate_per_hour` has 5 entries"),
            (
                DRIFT,
                "-0.1",
                "-0.5",
                "s.toml:12: `drift.inertia_rate_per_hour` leads to principal moments [-0.002498, \
                 4.002, 5.2] kg m² at t = 7200 s",
            ),
            (DRIFT, "inertia_", "moment_", "s.toml:11: missing key `inertia_rate_per_hour`"),
        ] {
            let message = parse(&extra.replacen(good, bad, 1)).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
        let message = parse(&format!("{TENSOR}{FACTOR}")).unwrap_err().to_string();
        assert!(message.starts_with("s.toml:15: `change[2].time_s` is 3600; it must"), "{message}");
    }
}
