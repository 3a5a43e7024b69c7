//! `[random_spacecraft]`: a scenario with another spacecraft for each seed.
//!
//! ```toml
//! name = "random-spacecraft"
//! [random_spacecraft]                # least and most of each
//! mass_kg = [1.33, 500.0]
//! rate_hz = [4.0, 1000.0]            # of the gyro
//! samples = [500, 5000]              # of the record
//! body_rate_rad_s = [0.01, 1.0]
//! noise_over_rate = [1e-4, 1e-1]     # one sigma of a gyro sample over the body rate
//! [disturbance]                      # optional, as in other scenarios
//! torque = false
//! [wheels]                           # optional, as all keys of errors
//! spin_inertia_sigma = 0.01
//! ```
//!
//! The file has no other tables: their values are drawn by `random_draw`.

use flight_input::InputError;
use flight_input::craft::StatedHardware;
use flight_input::key::{Key, Range, Table};
use flight_input::section::{List, Section};
use serde::Deserialize;

use super::hardware::TrueHardware;
use super::limits::{MAX_RATE_HZ, MAX_SAMPLES};

/// Type of a range of values.
const PAIR: &str = "2 numbers";

const ASCENDING: Range = Range::new("two positive numbers, the second no smaller", |x| x > 0.0);
const RATES: Range =
    Range::new("two positive numbers, the second no smaller, at most 100 kHz", |rate| {
        rate > 0.0 && rate <= MAX_RATE_HZ
    });
const SAMPLE_COUNTS: Range =
    Range::new("two positive numbers, the second no smaller, at most 1e7", |samples| {
        samples > 0.0 && samples <= MAX_SAMPLES
    });

const MASS: Key = Key::required("mass_kg", PAIR, "kg", ASCENDING, "Mass of the spacecraft");
const RATE: Key = Key::required("rate_hz", PAIR, "Hz", RATES, "Gyro samples per second");
const SAMPLES: Key =
    Key::required("samples", PAIR, "", SAMPLE_COUNTS, "Samples of the record, rounded");
const BODY_RATE: Key = Key::required(
    "body_rate_rad_s",
    PAIR,
    "rad/s",
    ASCENDING,
    "Typical body rate, limited to 0.03 rad per sample",
);
const NOISE: Key = Key::required(
    "noise_over_rate",
    PAIR,
    "",
    ASCENDING,
    "Gyro noise of one sample over the body rate",
);

/// The keys of `[random_spacecraft]`.
pub(super) const TABLE: Table = Table {
    header: "[random_spacecraft]",
    about: "Another spacecraft for each seed, in place of all tables but those of \
            errors: `[gyro]`, `[wheels]`, `[torque]`, `[disturbance]`, `[[mode]]`, `[hardware]`. Each key \
            gives the least and the most of a log-uniform distribution.",
    keys: &[MASS, RATE, SAMPLES, BODY_RATE, NOISE],
};

/// Ranges of log-uniform distributions, least and most.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomSpacecraft {
    /// Mass of the spacecraft, kg.
    pub mass_kg: [f64; 2],
    /// Gyro samples per second, Hz.
    pub rate_hz: [f64; 2],
    /// Samples of the record.
    pub samples: [f64; 2],
    /// Typical body rate, rad/s.
    pub body_rate_rad_s: [f64; 2],
    /// Gyro noise of one sample over the body rate.
    pub noise_over_rate: [f64; 2],
    /// Stated errors, with those of as many wheels as a spacecraft may have.
    pub hardware: StatedHardware,
    /// Fixed true errors.
    pub true_hardware: TrueHardware,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RandomSpacecraftFile {
    mass_kg: List,
    rate_hz: List,
    samples: List,
    body_rate_rad_s: List,
    noise_over_rate: List,
}

impl RandomSpacecraftFile {
    pub(super) fn read(&self, section: &Section<'_>) -> Result<RandomSpacecraft, InputError> {
        let range = |key: &Key, value: &List| {
            let range = section.list::<2>(key, value)?;
            if range[0] <= range[1] && range[1].is_finite() {
                return Ok(range);
            }
            Err(section.list_out_of_range(key, value))
        };
        Ok(RandomSpacecraft {
            mass_kg: range(&MASS, &self.mass_kg)?,
            rate_hz: range(&RATE, &self.rate_hz)?,
            samples: range(&SAMPLES, &self.samples)?,
            body_rate_rad_s: range(&BODY_RATE, &self.body_rate_rad_s)?,
            noise_over_rate: range(&NOISE, &self.noise_over_rate)?,
            hardware: StatedHardware::default(),
            true_hardware: TrueHardware::default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use flight_input::InputError;
    use fsw_core::Inertia;

    use crate::input::Scenario;
    use crate::input::scenario::ExternalTorque;

    const GOOD: &str = r#"name = "test"
[random_spacecraft]
mass_kg = [1, 500]
rate_hz = [4, 1000]
samples = [500, 5000]
body_rate_rad_s = [0.01, 1]
noise_over_rate = [1e-4, 1e-1]
"#;

    fn parse(text: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", text, Path::new(""))
    }

    #[test]
    fn each_seed_draws_another_spacecraft_within_the_ranges() {
        let scenario = parse(GOOD).unwrap();
        let mut wheels = [0; 5];
        for seed in 0..300 {
            let drawn = scenario.of_seed(seed);
            assert_eq!(drawn, scenario.of_seed(seed));
            assert_ne!(drawn.spacecraft, scenario.of_seed(seed + 1).spacecraft);
            assert_eq!(drawn.name, format!("test-{seed}"));
            assert!(Inertia::new(drawn.spacecraft.inertia_kg_m2).check().is_ok());
            let rate_hz = drawn.gyro.rate_hz;
            assert!((4.0..1000.0).contains(&rate_hz));
            assert!((499.9..5000.1).contains(&(drawn.duration_s * rate_hz)));
            assert!((1e-6..0.1).contains(&drawn.gyro.noise_rad_s));
            wheels[drawn.wheels.len()] += 1;
            assert_eq!(drawn.wheels.is_empty(), drawn.torque != ExternalTorque::ZERO);
        }
        // One third each: 100, standard deviation 8.
        assert!([0, 3, 4].iter().all(|count| (60..140).contains(&wheels[*count])), "{wheels:?}");
    }

    #[test]
    fn range_of_equal_ends_is_a_fixed_value() {
        let one = parse(&GOOD.replace("[4, 1000]", "[10, 10]")).unwrap();
        assert!((0..20).all(|seed| (one.of_seed(seed).gyro.rate_hz - 10.0).abs() < 1e-12));
    }

    #[test]
    fn unknowns_of_the_estimator_apply_to_every_seed() {
        let asked = parse(&format!("{GOOD}[disturbance]\ntorque = true\n")).unwrap();
        assert!(asked.solve_for.torque && asked.of_seed(5).solve_for.torque);
    }

    #[test]
    fn each_bad_value_is_reported() {
        let at = "s.toml:3: `random_spacecraft.mass_kg`";
        for (good, bad, expected) in [
            ("[1, 500]", "[1]", format!("{at} has 1 entries, but takes 2")),
            ("[1, 500]", "[0, 500]", format!("{at} is [0, 500]; it must be two positive numbers")),
            ("[1, 500]", "[500, 1]", format!("{at} is [500, 1]; it must be two positive numbers")),
            ("mass_kg", "mass", "s.toml:3: unknown key `mass` (did you mean `mass_kg`?)".into()),
            ("1000]", "1e6]", "s.toml:4: `random_spacecraft.rate_hz` is [4, 1e6]; it".into()),
            ("5000]", "1e9]", "s.toml:5: `random_spacecraft.samples` is [500, 1e9]".into()),
            ("samples = [500, 5000]\n", "", "s.toml:2: missing key `samples`".into()),
            ("name = \"test\"", "duration_s = 5", "s.toml:1: unknown key `duration_s`".into()),
        ] {
            let message = parse(&GOOD.replacen(good, bad, 1)).unwrap_err().to_string();
            assert!(message.starts_with(&expected), "{message}\n  expected: {expected}");
        }
    }
}
