//! `[dispersion]`: differences between the runs of a campaign besides gyro noise.
//!
//! ```toml
//! [dispersion]                                 # optional, as is each of its keys
//! inertia_factor = [0.9, 0.8, 0.7, 0.6, 0.5] # factors of the true tensor, before and after
//! changes; run i uses entry i modulo the length [dispersion.initial_estimate] # uniform within ±
//! of these rate_rad_s = 1.0e-3 moments_kg_m2 = 30.0 products_kg_m2 = 2.0 rate_sigma_rad_s = 1.0e-3
//! # initial sigmas of the filter sigma_kg_m2 = [20, 20, 20, 1.2, 1.2, 1.2]
//! ```

use flight_input::InputError;
use flight_input::key::{
    ANY, ELEMENTS, Key, NOT_NEGATIVE, NUMBER, POSITIVE, Range, TABLE as A_TABLE, Table,
};
use flight_input::section::{List, Section};
use serde::Deserialize;
use toml::Spanned;

use super::random_spacecraft::RandomSpacecraft;

const FACTORS: Range = Range::new(
    "one or more positive factors, each leaving the body heavier than its wheels",
    |factor| factor.is_finite() && factor > 0.0,
);

const INERTIA_FACTOR: Key = Key::required(
    "inertia_factor",
    "list of numbers",
    "",
    FACTORS,
    "Factors of the true inertia; a run takes number seed mod length",
)
.or("1");
const INITIAL_ESTIMATE: Key = Key::required(
    "initial_estimate",
    A_TABLE,
    "",
    ANY,
    "Distribution of the filter's initial state: see `[dispersion.initial_estimate]`",
)
.or("that of the estimator");
const RATE: Key = Key::required(
    "rate_rad_s",
    NUMBER,
    "rad/s",
    NOT_NEGATIVE,
    "Half-width of each axis of the initial rate",
);
const MOMENTS: Key = Key::required(
    "moments_kg_m2",
    NUMBER,
    "kg m²",
    NOT_NEGATIVE,
    "Half-width of each initial moment",
);
const PRODUCTS: Key = Key::required(
    "products_kg_m2",
    NUMBER,
    "kg m²",
    NOT_NEGATIVE,
    "Half-width of each initial product",
);
const RATE_SIGMA: Key = Key::required(
    "rate_sigma_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "Initial sigma of the rate in the filter",
);
const SIGMA: Key = Key::required(
    "sigma_kg_m2",
    ELEMENTS,
    "kg m²",
    POSITIVE,
    "Initial sigma of each inertia element in the filter",
);

/// The keys of `[dispersion]`.
pub(super) const TABLE: Table = Table {
    header: "[dispersion]",
    about: "Differences between the runs of a campaign besides gyro noise. Optional.",
    keys: &[INERTIA_FACTOR, INITIAL_ESTIMATE],
};
/// The keys of `[dispersion.initial_estimate]`.
pub(super) const INITIAL_TABLE: Table = Table {
    header: "[dispersion.initial_estimate]",
    about: "The filter's initial state, uniform about zero. Optional.",
    keys: &[RATE, MOMENTS, PRODUCTS, RATE_SIGMA, SIGMA],
};

/// Differences between runs. None by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dispersion {
    /// Factors of the true inertia: a run takes number `seed mod length`. Empty for factor 1.
    pub inertia_factors: Vec<f64>,
    /// Distribution of the filter's initial state.
    pub initial_estimate: Option<InitialSpread>,
    /// Distribution of the spacecraft, if each run has its own. The scenario then holds the spacecraft
    /// of seed 0.
    pub spacecraft: Option<RandomSpacecraft>,
}

/// Half-widths of uniform distributions about zero, and the initial sigmas of the filter.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialSpread {
    /// Half-width of each axis of the rate, rad/s.
    pub rate_rad_s: f64,
    /// Half-width of each moment, kg m².
    pub moments_kg_m2: f64,
    /// Half-width of each product, kg m².
    pub products_kg_m2: f64,
    /// Initial sigma of the rate, rad/s.
    pub rate_sigma_rad_s: f64,
    /// Initial sigma of each inertia element, kg m².
    pub sigma_kg_m2: [f64; 6],
}

impl Dispersion {
    /// Number of different true spacecraft.
    pub fn truths(&self) -> usize {
        self.inertia_factors.len().max(1)
    }

    /// Index of the true spacecraft of this seed.
    pub fn truth_of(&self, seed: u64) -> usize {
        (seed % self.truths() as u64) as usize
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DispersionFile {
    inertia_factor: Option<List>,
    initial_estimate: Option<InitialSpreadFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InitialSpreadFile {
    rate_rad_s: Spanned<f64>,
    moments_kg_m2: Spanned<f64>,
    products_kg_m2: Spanned<f64>,
    rate_sigma_rad_s: Spanned<f64>,
    sigma_kg_m2: List,
}

impl DispersionFile {
    /// `carries_wheels`: whether a body of the scenario's inertia times a factor can carry the wheels.
    pub(super) fn read(
        &self,
        section: &Section<'_>,
        carries_wheels: impl Fn(f64) -> bool,
    ) -> Result<Dispersion, InputError> {
        let mut inertia_factors = Vec::new();
        if let Some(factors) = &self.inertia_factor {
            let list = factors.get_ref();
            section.all_in(&section.full(&INERTIA_FACTOR), &FACTORS, factors)?;
            if list.is_empty() || !list.iter().all(|factor| carries_wheels(*factor)) {
                return Err(section.list_out_of_range(&INERTIA_FACTOR, factors));
            }
            inertia_factors = list.clone();
        }
        let initial = section.table(INITIAL_ESTIMATE.name);
        let initial_estimate =
            self.initial_estimate.as_ref().map(|spread| spread.read(&initial)).transpose()?;
        Ok(Dispersion { inertia_factors, initial_estimate, spacecraft: None })
    }
}

impl InitialSpreadFile {
    fn read(&self, section: &Section<'_>) -> Result<InitialSpread, InputError> {
        Ok(InitialSpread {
            rate_rad_s: section.number(&RATE, &self.rate_rad_s)?,
            moments_kg_m2: section.number(&MOMENTS, &self.moments_kg_m2)?,
            products_kg_m2: section.number(&PRODUCTS, &self.products_kg_m2)?,
            rate_sigma_rad_s: section.number(&RATE_SIGMA, &self.rate_sigma_rad_s)?,
            sigma_kg_m2: section.list(&SIGMA, &self.sigma_kg_m2)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use flight_input::InputError;

    use crate::input::Scenario;

    const GOOD: &str = r#"name = "test"
duration_s = 60.0
[spacecraft]
inertia_kg_m2 = [3, 4, 5, 0, 0, 0]
[gyro]
rate_hz = 10.0
noise_rad_s = 1e-4
[[wheel]]
axis = [0, 0, 1]
spin_inertia_kg_m2 = 1.0
[dispersion]
inertia_factor = [0.9, 0.5]
[dispersion.initial_estimate]
rate_rad_s = 0.1
moments_kg_m2 = 3
products_kg_m2 = 0.5
rate_sigma_rad_s = 0.2
sigma_kg_m2 = [1, 1, 1, 2, 2, 2]
"#;

    fn parse(text: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", text, Path::new(""))
    }

    #[test]
    fn each_bad_value_is_reported() {
        for (good, bad, expected) in [
            ("[0.9, 0.5]", "[]", "s.toml:12: `dispersion.inertia_factor` is []; it must be one or"),
            (
                "0.9",
                "-0.9",
                "s.toml:12: `dispersion.inertia_factor` is [-0.9, 0.5]; it must be one",
            ),
            // Half of 5 kg m² about z, with a wheel of 3 kg m².
            ("1.0", "3.0", "s.toml:12: `dispersion.inertia_factor` is [0.9, 0.5]; it must be one"),
            ("factor", "factors", "s.toml:12: unknown key `inertia_factors` (did you mean"),
            ("= 0.1", "= -1", "s.toml:14: `dispersion.initial_estimate.rate_rad_s` is -1; it must"),
            ("= 0.2", "= 0", "s.toml:17: `dispersion.initial_estimate.rate_sigma_rad_s` is 0; it"),
            ("2]\n", "0]\n", "s.toml:18: `dispersion.initial_estimate.sigma_kg_m2` is"),
            ("products_kg_m2 = 0.5\n", "", "s.toml:13: missing key `products_kg_m2`"),
        ] {
            let at = GOOD.find("[dispersion]").unwrap();
            let (head, tail) = GOOD.split_at(if good == "1.0" { 0 } else { at });
            let message =
                parse(&format!("{head}{}", tail.replacen(good, bad, 1))).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn run_is_determined_by_its_seed() {
        let scenario = parse(GOOD).unwrap();
        assert_eq!(scenario.of_seed(7), scenario.of_seed(7));
        assert_ne!(scenario.of_seed(7).initial_estimate, scenario.of_seed(9).initial_estimate);
        let jzz = |seed| scenario.of_seed(seed).spacecraft.inertia_kg_m2[2];
        assert_eq!([jzz(0), jzz(1), jzz(2)], [4.5, 2.5, 4.5]);
    }

    #[test]
    fn initial_estimates_are_uniform() {
        let scenario = parse(GOOD).unwrap();
        let half_width = [3.0, 3.0, 3.0, 0.5, 0.5, 0.5];
        let (mut sum, mut square, count) = ([0.0; 6], [0.0; 6], 4000);
        for seed in 0..count {
            let start = scenario.of_seed(seed).initial_estimate.unwrap();
            assert!(start.rate_rad_s.amax() <= 0.1);
            for i in 0..6 {
                let x = start.inertia_kg_m2[i] / half_width[i];
                assert!(x.abs() <= 1.0);
                sum[i] += x / count as f64;
                square[i] += x * x / count as f64;
            }
        }
        for i in 0..6 {
            // Mean 0 and mean square 1/3, within five sigma of 4,000 draws.
            assert!(sum[i].abs() < 5.0 * (1.0 / 3.0 / 4000.0f64).sqrt(), "{sum:?}");
            assert!((square[i] - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / 4000.0f64).sqrt());
        }
    }

    #[test]
    fn unphysical_initial_estimate_is_not_a_prior() {
        let scenario = parse(GOOD).unwrap();
        let physical = (0..200).filter(|seed| {
            let craft = scenario.of_seed(*seed).craft();
            let start = craft.initial_estimate.unwrap();
            craft.prior.is_some_and(|prior| prior.inertia_kg_m2 == start.inertia_kg_m2)
        });
        // One in eight has three positive moments; half of these satisfy the triangle inequality.
        assert!((2..40).contains(&physical.count()));
    }
}
