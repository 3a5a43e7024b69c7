//! How the true inertia changes in flight: what happens at once, and what goes on slowly.
//!
//! ```toml
//! [[change]]                                   # deployment, docking, a lost mass; in order of time
//! time_s = 300.0
//! inertia_factor = [1.05, 1, 1, 1, 1, 1]       # each element times this; or instead
//! inertia_kg_m2 = [14.9, 17.3, 20.3, 0, 0, 0]  # the tensor from then on, wheels included and locked
//! [drift]                                      # fuel
//! inertia_rate_per_hour = [-0.01, -0.01, -0.01, 0, 0, 0]
//! ```
//!
//! The drift is a straight line in time, each element by this share of what it was at the start, or
//! just after the last change. Elements are about the centre of mass of the moment, in axes fixed to
//! the body.
//!
//! What is assumed of the momentum: a change takes no angular momentum along and brings none, nor
//! does what drifts. So the total is conserved in inertial space but for the external torque, and each
//! wheel keeps its own axial momentum, since a bearing passes no torque about its axis: the rate and
//! the wheels' speeds relative to the body jump, unless all is at rest. Parts that move within the
//! craft do this exactly. A mass that leaves a turning body, and the jet of a thruster, take momentum
//! along; that would be a torque, which isn't modelled.
//!
//! The estimator is told nothing of all this.

use serde::Deserialize;
use toml::Spanned;

use super::super::check::{Check, is_physical, principal_moments, tensor};
use super::super::error::{InputError, Problem};
use super::{Scenario, SimulatedWheel};

const SECONDS_PER_HOUR: f64 = 3600.0;

/// How the true inertia departs from what it is at the start. Not at all by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// What happens at once, in order of time.
    pub sudden: Vec<SuddenChange>,
    /// What goes on slowly: share of each element per hour, of what it was at the start or just after
    /// the last sudden change.
    pub drift_per_hour: [f64; 6],
}

/// A new tensor from one moment on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuddenChange {
    /// When, s since the start. A sample at this very time already sees what follows.
    pub time_s: f64,
    /// `jxx jyy jzz jxy jxz jyz` just after it, kg m².
    pub inertia_kg_m2: [f64; 6],
}

/// A part of a flight over which each element of the inertia is a straight line in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Its start, s since the start of the flight.
    pub from_s: f64,
    /// Its end; none where it is the flight's.
    pub to_s: Option<f64>,
    /// `jxx jyy jzz jxy jxz jyz` at its start, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Slope of each, kg m²/s.
    pub slope_kg_m2_s: [f64; 6],
}

impl Changes {
    /// Whether the inertia goes on changing slowly.
    pub fn drifts(&self) -> bool {
        self.drift_per_hour.iter().any(|share| *share != 0.0)
    }

    fn stretch(&self, from_s: f64, to_s: Option<f64>, inertia_kg_m2: [f64; 6]) -> Stretch {
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

impl Scenario {
    /// The flight from one sudden change to the next; a single stretch if there is none.
    pub fn stretches(&self) -> impl Iterator<Item = Stretch> {
        (0..=self.changes.sudden.len()).map(|index| self.stretch(index))
    }

    /// The stretch after so many sudden changes.
    pub fn stretch(&self, after: usize) -> Stretch {
        let sudden = &self.changes.sudden;
        let start = SuddenChange { time_s: 0.0, inertia_kg_m2: self.spacecraft.inertia_kg_m2 };
        let begin = after.checked_sub(1).and_then(|index| sudden.get(index)).unwrap_or(&start);
        let to_s = sudden.get(after).map(|next| next.time_s);
        self.changes.stretch(begin.time_s, to_s, begin.inertia_kg_m2)
    }

    /// The true elements at a time of the flight, kg m².
    pub fn inertia_at_kg_m2(&self, time_s: f64) -> [f64; 6] {
        let begun = self.changes.sudden.partition_point(|change| change.time_s <= time_s);
        self.stretch(begun).inertia_at_kg_m2(time_s)
    }

    /// The true elements at the end of the flight, kg m²: what its last estimate is measured with.
    pub fn final_inertia_kg_m2(&self) -> [f64; 6] {
        self.inertia_at_kg_m2(self.duration_s)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangeFile {
    time_s: Spanned<f64>,
    inertia_factor: Option<Spanned<Vec<f64>>>,
    inertia_kg_m2: Option<Spanned<Vec<f64>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DriftFile {
    inertia_rate_per_hour: Spanned<Vec<f64>>,
}

/// Checks the tables `[[change]]` and `[drift]` of a body that starts with these elements and carries
/// these wheels.
pub(super) fn changes(
    check: &Check<'_>,
    sudden: &[Spanned<ChangeFile>],
    drift: Option<&DriftFile>,
    (inertia_kg_m2, wheels): (&[f64; 6], &[SimulatedWheel]),
    duration_s: f64,
) -> Result<Changes, InputError> {
    let drift_key = "drift.inertia_rate_per_hour";
    let drift = drift.map(|file| &file.inertia_rate_per_hour);
    let mut changes = Changes::default();
    if let Some(shares) = drift {
        changes.drift_per_hour = check.list(drift_key, shares)?;
    }
    let body = |key: &str, value: &Spanned<Vec<f64>>, time_s: f64, elements: &[f64; 6]| {
        let principal_moments_kg_m2 = principal_moments(&tensor(elements));
        let rest = super::file::without_wheels(elements, wheels);
        if is_physical(&principal_moments_kg_m2) && rest[0] > 0.0 {
            return Ok(());
        }
        let key = key.to_owned();
        Err(check.error(value, Problem::ChangesToNoBody { key, time_s, principal_moments_kg_m2 }))
    };
    // Between two tensors that a body can have, all on the straight line are.
    let end_of = |stretch: &Stretch, to_s: f64| {
        let end = stretch.inertia_at_kg_m2(to_s);
        drift.map_or(Ok(()), |shares| body(drift_key, shares, to_s, &end)).map(|()| end)
    };

    let mut stretch = changes.stretch(0.0, None, *inertia_kg_m2);
    for (index, spanned) in sudden.iter().enumerate() {
        let (file, key) = (spanned.get_ref(), format!("change[{}]", index + 1));
        let time_s = check.number(
            &format!("{key}.time_s"),
            &file.time_s,
            "after the start and the change before, and before the end of the flight",
            |time_s| stretch.from_s < time_s && time_s < duration_s,
        )?;
        let before = end_of(&stretch, time_s)?;
        let (name, list, elements) = match (&file.inertia_factor, &file.inertia_kg_m2) {
            (Some(factor), None) => {
                let name = format!("{key}.inertia_factor");
                let factors: [f64; 6] = check.list(&name, factor)?;
                (name, factor, std::array::from_fn(|i| before[i] * factors[i]))
            }
            (None, Some(elements)) => {
                let name = format!("{key}.inertia_kg_m2");
                let list = check.list(&name, elements)?;
                (name, elements, list)
            }
            _ => {
                let keys = &["inertia_factor", "inertia_kg_m2"];
                return Err(check.error(spanned, Problem::NotOneOf { key, keys }));
            }
        };
        body(&name, list, time_s, &elements)?;
        changes.sudden.push(SuddenChange { time_s, inertia_kg_m2: elements });
        stretch = changes.stretch(time_s, None, elements);
    }
    end_of(&stretch, duration_s)?;
    Ok(changes)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

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
    fn nothing_changes_unless_it_is_said() {
        let scenario = parse("").unwrap();
        assert_eq!(scenario.changes, Changes::default());
        assert_eq!(scenario.stretches().count(), 1);
        assert_eq!(scenario.final_inertia_kg_m2(), scenario.spacecraft.inertia_kg_m2);
    }

    #[test]
    fn a_change_is_of_what_was_before_and_the_drift_goes_on_from_there() {
        let scenario = parse(&format!("{FACTOR}{TENSOR}{DRIFT}")).unwrap();
        near(scenario.inertia_at_kg_m2(1800.0), [2.85, 4.0, 5.05, 0.1, 0.0, 0.0]);
        near(scenario.inertia_at_kg_m2(3600.0), [2.7, 4.2, 5.1, 0.2, 0.0, 0.0]);
        near(scenario.inertia_at_kg_m2(4500.0), [2.6325, 4.2, 5.1255, 0.2, 0.0, 0.0]);
        near(scenario.final_inertia_kg_m2(), [5.7, 7.0, 8.08, 0.0, 0.0, 0.0]);
        let ends: Vec<_> = scenario.stretches().map(|s| (s.from_s, s.to_s)).collect();
        assert_eq!(ends, [(0.0, Some(3600.0)), (3600.0, Some(5400.0)), (5400.0, None)]);
    }

    #[test]
    fn every_tensor_is_scaled_with_the_dispersed_truth() {
        let dispersion = "[dispersion]\ninertia_factor = [1.0, 2.0]\n";
        let scenario = parse(&format!("{FACTOR}{dispersion}")).unwrap();
        near(scenario.of_truth(1).final_inertia_kg_m2(), [6.0, 8.4, 10.0, 0.4, 0.0, 0.0]);
        // A wheel of 1 kg m² about z, in a body that is to have 0.9.
        let change = TENSOR.replace("6, 7, 8, 0", "3, 3, 3, 0");
        let message = parse(&format!("{change}{}", dispersion.replace("2.0", "0.3")));
        let message = message.unwrap_err().to_string();
        assert!(message.starts_with("s.toml:15: `dispersion.inertia_factor`"), "{message}");
    }

    #[test]
    fn each_bad_value_is_named() {
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
                "s.toml:13: `change[1].inertia_factor` makes principal moments of [2.994, 5, 10.01] \
                 kg m² by t = 3600 s, which no body that carries these wheels has",
            ),
            (
                FACTOR,
                "inertia_factor = [1, 1.05, 1, 2, 1, 1]\n",
                "",
                "s.toml:11: `change[1]` takes one of inertia_factor, inertia_kg_m2; give just one",
            ),
            (
                FACTOR,
                "1, 1]",
                "1, 1]\ninertia_kg_m2 = [6, 7, 8, 0, 0, 0]",
                "s.toml:11: `change[1]` takes one of inertia_factor, inertia_kg_m2; give just one",
            ),
            // A body that is no more than its wheel about z.
            (TENSOR, "6, 7, 8", "1, 1, 1", "s.toml:13: `change[1].inertia_kg_m2` makes principal"),
            (DRIFT, "-0.1", "nan", "s.toml:12: `drift.inertia_rate_per_hour` is [NaN, 0, 0.02, 0,"),
            (DRIFT, "-0.1, 0,", "-0.1,", "s.toml:12: `drift.inertia_rate_per_hour` has 5 entries"),
            (
                DRIFT,
                "-0.1",
                "-0.5",
                "s.toml:12: `drift.inertia_rate_per_hour` makes principal moments of [-0.002498, \
                 4.002, 5.2] kg m² by t = 7200 s",
            ),
            (DRIFT, "inertia_", "moment_", "s.toml:12: unknown key `moment_rate_per_hour`"),
        ] {
            let message = parse(&extra.replacen(good, bad, 1)).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
        let message = parse(&format!("{TENSOR}{FACTOR}")).unwrap_err().to_string();
        assert!(message.starts_with("s.toml:15: `change[2].time_s` is 3600; it must"), "{message}");
    }
}
