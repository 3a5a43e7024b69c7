//! What differs from run to run of a campaign, besides the gyro's noise.
//!
//! ```toml
//! [dispersion]                                 # optional, as each of its keys
//! inertia_factor = [0.9, 0.8, 0.7, 0.6, 0.5]   # the true tensor times these, in turn; after a change too
//! [dispersion.initial_estimate]                # where a filter starts: uniform within ± of these
//! rate_rad_s = 1.0e-3
//! moments_kg_m2 = 30.0
//! products_kg_m2 = 2.0
//! rate_sigma_rad_s = 1.0e-3                    # what it is told that this is worth, one sigma
//! sigma_kg_m2 = [20, 20, 20, 1.2, 1.2, 1.2]
//! ```
//!
//! All follows from a run's seed alone, so that `run --seed` flies it again.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Deserialize;
use toml::Spanned;

use super::super::check::Check;
use super::super::craft::InitialEstimate;
use super::super::error::InputError;
use super::{RandomSpacecraft, Scenario};

/// The gyro's noise has the same seed and is far shorter than this.
const BEYOND_THE_GYRO: u128 = 1 << 64;

/// What differs from run to run. Nothing by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dispersion {
    /// Factors of the true inertia: a run takes number `seed mod length`. Empty: all fly the
    /// scenario's own.
    pub inertia_factors: Vec<f64>,
    /// Where the estimator starts.
    pub initial_estimate: Option<InitialSpread>,
    /// What the whole spacecraft is drawn from, if each run has its own. All else that the scenario
    /// says of it is then that of seed 0.
    pub spacecraft: Option<RandomSpacecraft>,
}

/// Half-widths of uniform distributions about zero, and the sigmas that go with them.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialSpread {
    /// Of each axis of the rate, rad/s.
    pub rate_rad_s: f64,
    /// Of each moment, kg m².
    pub moments_kg_m2: f64,
    /// Of each product, kg m².
    pub products_kg_m2: f64,
    /// One sigma of the rate that the estimator is told, rad/s.
    pub rate_sigma_rad_s: f64,
    /// One sigma of each element that the estimator is told, kg m².
    pub sigma_kg_m2: [f64; 6],
}

impl Dispersion {
    /// How many different truths there are.
    pub fn truths(&self) -> usize {
        self.inertia_factors.len().max(1)
    }

    /// Which of them the run of this seed flies.
    pub fn truth_of(&self, seed: u64) -> usize {
        (seed % self.truths() as u64) as usize
    }
}

impl InitialSpread {
    fn draw(&self, seed: u64) -> InitialEstimate {
        let mut random = Pcg64::seed_from_u64(seed);
        random.advance(BEYOND_THE_GYRO);
        let mut within = |half_width: f64| half_width * (2.0 * random.random::<f64>() - 1.0);
        let rate_rad_s = std::array::from_fn(|_| within(self.rate_rad_s));
        let inertia_kg_m2 = std::array::from_fn(|i| {
            within(if i < 3 { self.moments_kg_m2 } else { self.products_kg_m2 })
        });
        InitialEstimate {
            rate_rad_s: rate_rad_s.into(),
            rate_sigma_rad_s: self.rate_sigma_rad_s,
            inertia_kg_m2,
            sigma_kg_m2: self.sigma_kg_m2,
        }
    }
}

impl Scenario {
    /// The scenario with truth number `index` of its [`Dispersion`].
    pub fn of_truth(&self, index: usize) -> Self {
        let mut scenario = self.clone();
        if let Some(factor) = self.dispersion.inertia_factors.get(index) {
            let scale = |elements: &mut [f64; 6]| *elements = elements.map(|j| j * factor);
            scale(&mut scenario.spacecraft.inertia_kg_m2);
            scenario.changes.sudden.iter_mut().for_each(|change| scale(&mut change.inertia_kg_m2));
        }
        scenario
    }

    /// The scenario as the run of this seed flies it.
    pub fn of_seed(&self, seed: u64) -> Self {
        if let Some(random) = &self.dispersion.spacecraft {
            return Self {
                solve_for: self.solve_for,
                disturbance_torque_n_m: self.disturbance_torque_n_m,
                ..random.draw(&self.name, seed)
            };
        }
        let mut scenario = self.of_truth(self.dispersion.truth_of(seed));
        let spread = &self.dispersion.initial_estimate;
        scenario.initial_estimate = spread.as_ref().map(|spread| spread.draw(seed));
        scenario
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DispersionFile {
    inertia_factor: Option<Spanned<Vec<f64>>>,
    initial_estimate: Option<InitialSpreadFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InitialSpreadFile {
    rate_rad_s: Spanned<f64>,
    moments_kg_m2: Spanned<f64>,
    products_kg_m2: Spanned<f64>,
    rate_sigma_rad_s: Spanned<f64>,
    sigma_kg_m2: Spanned<Vec<f64>>,
}

impl DispersionFile {
    /// `fits` says whether a body of the scenario's inertia times a factor can carry its wheels.
    pub(super) fn check(
        &self,
        check: &Check<'_>,
        fits: impl Fn(f64) -> bool,
    ) -> Result<Dispersion, InputError> {
        let inertia_factors = match &self.inertia_factor {
            None => Vec::new(),
            Some(factors) => {
                let list = factors.get_ref();
                let is_good = |factor: &f64| factor.is_finite() && *factor > 0.0 && fits(*factor);
                if list.is_empty() || !list.iter().all(is_good) {
                    let required = "one or more positive factors, each leaving the body heavier than its wheels";
                    return Err(check.bad_list("dispersion.inertia_factor", factors, required));
                }
                list.clone()
            }
        };
        let initial_estimate =
            self.initial_estimate.as_ref().map(|spread| spread.check(check)).transpose()?;
        Ok(Dispersion { inertia_factors, initial_estimate, spacecraft: None })
    }
}

impl InitialSpreadFile {
    fn check(&self, check: &Check<'_>) -> Result<InitialSpread, InputError> {
        let key = |name: &str| format!("dispersion.initial_estimate.{name}");
        Ok(InitialSpread {
            rate_rad_s: check.not_negative(&key("rate_rad_s"), &self.rate_rad_s)?,
            moments_kg_m2: check.not_negative(&key("moments_kg_m2"), &self.moments_kg_m2)?,
            products_kg_m2: check.not_negative(&key("products_kg_m2"), &self.products_kg_m2)?,
            rate_sigma_rad_s: check.positive(&key("rate_sigma_rad_s"), &self.rate_sigma_rad_s)?,
            sigma_kg_m2: check.sigmas(&key("sigma_kg_m2"), &self.sigma_kg_m2)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

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
    fn each_bad_value_is_named() {
        for (good, bad, expected) in [
            ("[0.9, 0.5]", "[]", "s.toml:12: `dispersion.inertia_factor` is []; it must be one or"),
            (
                "0.9",
                "-0.9",
                "s.toml:12: `dispersion.inertia_factor` is [-0.9, 0.5]; it must be one",
            ),
            // Half the body of 5 kg m² about z, and a wheel of 3.
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
    fn a_run_follows_from_its_seed() {
        let scenario = parse(GOOD).unwrap();
        assert_eq!(scenario.of_seed(7), scenario.of_seed(7));
        assert_ne!(scenario.of_seed(7).initial_estimate, scenario.of_seed(9).initial_estimate);
        let jzz = |seed| scenario.of_seed(seed).spacecraft.inertia_kg_m2[2];
        assert_eq!([jzz(0), jzz(1), jzz(2)], [4.5, 2.5, 4.5]);
    }

    #[test]
    fn starts_fill_their_range_evenly() {
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
    fn a_start_that_no_body_has_is_no_prior() {
        let scenario = parse(GOOD).unwrap();
        let physical = (0..200).filter(|seed| {
            let craft = scenario.of_seed(*seed).craft();
            let start = craft.initial_estimate.unwrap();
            craft.prior.is_some_and(|prior| prior.inertia_kg_m2 == start.inertia_kg_m2)
        });
        // An eighth has three positive moments, and half of these obey the triangle inequality.
        assert!((2..40).contains(&physical.count()));
    }
}
