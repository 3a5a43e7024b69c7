//! `CRAFT.toml`: what is known of a spacecraft before its log is looked at.
//!
//! ```toml
//! [[wheel]]                          # one per reaction wheel, in the order of the log's columns
//! name = "x"                         # optional, for people
//! axis = [1.0, 0.0, 0.0]             # normalised on load
//! spin_inertia_kg_m2 = 1.691e-6
//! [gyro]                             # optional, as is each of its keys
//! noise_rad_s = 1.0e-4               # one sigma, white, per sample
//! range_rad_s = 4.36                 # full scale
//! quantum_rad_s = 1.0e-5             # least significant bit
//! [prior]                            # optional
//! inertia_kg_m2 = [25, 25, 25, 2, 2, 2]
//! sigma_kg_m2 = [30, 30, 30, 10, 10, 10]
//! [filter]                           # optional
//! rate_walk_rad_s_sqrt_s = 1.0e-6    # process noise of the rate, where an estimator has one
//! inertia_walk_kg_m2_sqrt_hour = 0.02 # and of each element of the inertia (fuel): one sigma after an hour
//! torque_is_smooth = true            # the log's torque swings between its samples; else straight lines
//! [disturbance]                      # optional: what else to estimate
//! torque = true
//! gyro_bias = false
//! ```

use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::check::Check;
use super::error::{InputError, Problem};
use super::toml_source::TomlSource;

/// Most wheels a craft may have; the flight core has a fixed size.
pub const MAX_WHEELS: usize = 8;

/// What the estimator is told about a spacecraft.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Craft {
    /// The reaction wheels, in the order of the log's columns `wheel_1_rad_s`, `wheel_2_rad_s`, …
    pub wheels: Vec<Wheel>,
    /// The gyro, as far as it is known.
    pub gyro: GyroData,
    /// Inertia expected before any measurement, if anything is known.
    pub prior: Option<Prior>,
    /// Process noise of the rate that filters are told, (rad/s)/√s; each has its own if none.
    pub rate_walk_rad_s_sqrt_s: Option<f64>,
    /// Random walk of each element of the inertia that filters are told, kg m²/√h; none if none.
    pub inertia_walk_kg_m2_sqrt_hour: Option<f64>,
    /// Whether the external torque swings between its samples, like a sine, rather than going straight
    /// from one to the next.
    pub is_torque_smooth: bool,
    /// What is to be estimated besides the inertia.
    pub solve_for: SolveFor,
    /// Where a filter that starts from a guess, whatever it be, starts: drawn by a campaign, never in
    /// a file.
    pub initial_estimate: Option<InitialEstimate>,
}

/// A reaction wheel: balanced, symmetric about its axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheel {
    /// A name for people; no meaning here.
    pub name: Option<String>,
    /// Direction of positive wheel speed, body axes, unit length.
    pub axis: Vector3<f64>,
    /// Inertia about the axis, kg m².
    pub spin_inertia_kg_m2: f64,
}

/// What is known of the gyro.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GyroData {
    /// White noise of one sample, one sigma per axis, rad/s; unknown if none.
    pub noise_rad_s: Option<f64>,
    /// Largest rate the gyro shows, rad/s; unknown or unlimited if none.
    pub range_rad_s: Option<f64>,
    /// Least significant bit, rad/s; unknown or negligible if none.
    pub quantum_rad_s: Option<f64>,
}

/// The inertia expected before any measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// `jxx jyy jzz jxy jxz jyz`, wheels included and locked, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Standard deviation of each, in the same order, kg m².
    pub sigma_kg_m2: [f64; 6],
}

/// An initial state of a filter, which may be no body's.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialEstimate {
    /// Body rate, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// One sigma of each axis, rad/s.
    pub rate_sigma_rad_s: f64,
    /// `jxx jyy jzz jxy jxz jyz`, kg m²: any finite numbers.
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each, kg m².
    pub sigma_kg_m2: [f64; 6],
}

/// What the estimator is asked for besides the inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolveFor {
    /// A constant or slowly varying torque in body axes.
    pub torque: bool,
    /// A constant gyro bias.
    pub gyro_bias: bool,
}

impl Craft {
    /// Reads and checks a `CRAFT.toml`.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        Self::from_source(&TomlSource::read(path)?)
    }

    /// Reads and checks the text of a `CRAFT.toml`; `file` is what errors call it.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, InputError> {
        Self::from_source(&TomlSource::new(file, text))
    }

    /// The text of a `CRAFT.toml` that reads back as this craft.
    pub fn to_toml(&self) -> String {
        // `{:?}` prints the shortest decimal that reads back as the same number, and lists as
        // TOML writes them.
        let mut text = String::new();
        for wheel in &self.wheels {
            text += "[[wheel]]\n";
            if let Some(name) = &wheel.name {
                text += &format!("name = {name:?}\n");
            }
            text += &format!("axis = {:?}\n", wheel.axis.as_slice());
            text += &format!("spin_inertia_kg_m2 = {:?}\n", wheel.spin_inertia_kg_m2);
        }
        text += "[gyro]\n";
        let GyroData { noise_rad_s, range_rad_s, quantum_rad_s } = self.gyro;
        for (key, value) in [
            ("noise_rad_s", noise_rad_s),
            ("range_rad_s", range_rad_s),
            ("quantum_rad_s", quantum_rad_s),
        ] {
            if let Some(value) = value {
                text += &format!("{key} = {value:?}\n");
            }
        }
        if let Some(Prior { inertia_kg_m2, sigma_kg_m2 }) = &self.prior {
            text += &format!("[prior]\ninertia_kg_m2 = {inertia_kg_m2:?}\n");
            text += &format!("sigma_kg_m2 = {sigma_kg_m2:?}\n");
        }
        let walks = [
            ("rate_walk_rad_s_sqrt_s", self.rate_walk_rad_s_sqrt_s),
            ("inertia_walk_kg_m2_sqrt_hour", self.inertia_walk_kg_m2_sqrt_hour),
        ];
        text += "[filter]\n";
        for (key, walk) in walks {
            if let Some(walk) = walk {
                text += &format!("{key} = {walk:?}\n");
            }
        }
        if self.is_torque_smooth {
            text += "torque_is_smooth = true\n";
        }
        if self.solve_for != SolveFor::default() {
            let SolveFor { torque, gyro_bias } = self.solve_for;
            text += &format!("[disturbance]\ntorque = {torque}\ngyro_bias = {gyro_bias}\n");
        }
        text
    }

    fn from_source(source: &TomlSource) -> Result<Self, InputError> {
        let file: CraftFile = source.parse()?;
        let check = Check::new(source);

        check_wheel_count(&check, &file.wheel)?;
        let mut wheels = Vec::new();
        for (index, wheel) in file.wheel.iter().enumerate() {
            let wheel = wheel.get_ref();
            let key = wheel_key(index);
            wheels.push(Wheel {
                name: wheel.name.clone(),
                axis: check.axis(&format!("{key}.axis"), &wheel.axis)?,
                spin_inertia_kg_m2: check
                    .positive(&format!("{key}.spin_inertia_kg_m2"), &wheel.spin_inertia_kg_m2)?,
            });
        }
        let positive = |key: &str, value: &Option<Spanned<f64>>| {
            value.as_ref().map(|value| check.positive(key, value)).transpose()
        };
        Ok(Self {
            wheels,
            gyro: GyroData {
                noise_rad_s: positive("gyro.noise_rad_s", &file.gyro.noise_rad_s)?,
                range_rad_s: positive("gyro.range_rad_s", &file.gyro.range_rad_s)?,
                quantum_rad_s: positive("gyro.quantum_rad_s", &file.gyro.quantum_rad_s)?,
            },
            prior: file.prior.map(|prior| prior.check(&check)).transpose()?,
            rate_walk_rad_s_sqrt_s: file.filter.rate_walk(&check)?,
            inertia_walk_kg_m2_sqrt_hour: file.filter.inertia_walk(&check)?,
            is_torque_smooth: file.filter.torque_is_smooth.unwrap_or(false),
            solve_for: SolveFor {
                torque: file.disturbance.torque,
                gyro_bias: file.disturbance.gyro_bias,
            },
            initial_estimate: None,
        })
    }
}

/// How errors name a wheel: counted from 1, as in the log's columns.
pub(super) fn wheel_key(index: usize) -> String {
    format!("wheel[{}]", index + 1)
}

/// Refuses the first wheel that is one too many.
pub(super) fn check_wheel_count<W>(
    check: &Check<'_>,
    wheels: &[Spanned<W>],
) -> Result<(), InputError> {
    match wheels.get(MAX_WHEELS) {
        Some(surplus) => {
            let problem = Problem::TooManyWheels { found: wheels.len(), most: MAX_WHEELS };
            Err(check.error(surplus, problem))
        }
        None => Ok(()),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CraftFile {
    #[serde(default)]
    wheel: Vec<Spanned<WheelFile>>,
    #[serde(default)]
    gyro: GyroFile,
    prior: Option<PriorFile>,
    #[serde(default)]
    filter: FilterFile,
    #[serde(default)]
    disturbance: DisturbanceFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelFile {
    name: Option<String>,
    axis: Spanned<Vec<f64>>,
    spin_inertia_kg_m2: Spanned<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct GyroFile {
    noise_rad_s: Option<Spanned<f64>>,
    range_rad_s: Option<Spanned<f64>>,
    quantum_rad_s: Option<Spanned<f64>>,
}

/// `[prior]`, which scenarios have too.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PriorFile {
    inertia_kg_m2: Spanned<Vec<f64>>,
    sigma_kg_m2: Spanned<Vec<f64>>,
}

impl PriorFile {
    pub(super) fn check(&self, check: &Check<'_>) -> Result<Prior, InputError> {
        Ok(Prior {
            inertia_kg_m2: check.inertia("prior.inertia_kg_m2", &self.inertia_kg_m2)?,
            sigma_kg_m2: check.sigmas("prior.sigma_kg_m2", &self.sigma_kg_m2)?,
        })
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct DisturbanceFile {
    #[serde(default)]
    torque: bool,
    #[serde(default)]
    gyro_bias: bool,
}

/// What filters are told of how their states may wander, as a file has it.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FilterFile {
    rate_walk_rad_s_sqrt_s: Option<Spanned<f64>>,
    inertia_walk_kg_m2_sqrt_hour: Option<Spanned<f64>>,
    pub(super) torque_is_smooth: Option<bool>,
}

impl FilterFile {
    pub(super) fn rate_walk(&self, check: &Check<'_>) -> Result<Option<f64>, InputError> {
        let walk = self.rate_walk_rad_s_sqrt_s.as_ref();
        walk.map(|walk| check.not_negative("filter.rate_walk_rad_s_sqrt_s", walk)).transpose()
    }

    pub(super) fn inertia_walk(&self, check: &Check<'_>) -> Result<Option<f64>, InputError> {
        let walk = self.inertia_walk_kg_m2_sqrt_hour.as_ref();
        walk.map(|walk| check.not_negative("filter.inertia_walk_kg_m2_sqrt_hour", walk)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Craft::from_toml("craft.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let craft = Craft {
            wheels: vec![Wheel {
                name: Some("+x \"fast\"".to_owned()),
                axis: Vector3::new(1.0, 1.0, 1.0).normalize(),
                spin_inertia_kg_m2: 2.1e-5,
            }],
            gyro: GyroData {
                noise_rad_s: Some(1e-4),
                range_rad_s: None,
                quantum_rad_s: Some(1e-5),
            },
            prior: Some(Prior {
                inertia_kg_m2: [25.0, 25.0, 25.0, 2.0, 2.0, 2.0],
                sigma_kg_m2: [30.0, 30.0, 30.0, 10.0, 10.0, 10.0],
            }),
            rate_walk_rad_s_sqrt_s: Some(1e-6),
            inertia_walk_kg_m2_sqrt_hour: Some(0.25),
            is_torque_smooth: true,
            solve_for: SolveFor { torque: true, gyro_bias: false },
            initial_estimate: None,
        };
        let again = Craft::from_toml("craft.toml", &craft.to_toml()).unwrap();
        assert!((again.wheels[0].axis - craft.wheels[0].axis).norm() < 1e-15);
        assert_eq!(again.wheels[0].name, craft.wheels[0].name);
        assert_eq!(
            (again.gyro, again.prior, again.rate_walk_rad_s_sqrt_s, again.solve_for),
            (craft.gyro, craft.prior, craft.rate_walk_rad_s_sqrt_s, craft.solve_for)
        );
        assert_eq!(again.inertia_walk_kg_m2_sqrt_hour, Some(0.25));
        assert!(again.is_torque_smooth);
        let bare = Craft::default();
        assert_eq!(Craft::from_toml("craft.toml", &bare.to_toml()).unwrap(), bare);
    }

    #[test]
    fn empty_file_is_a_craft_without_wheels() {
        assert_eq!(Craft::from_toml("craft.toml", "").unwrap(), Craft::default());
    }

    #[test]
    fn example_of_the_contract_is_read() {
        let craft = Craft::from_toml(
            "craft.toml",
            "[[wheel]]\naxis = [0.0, 0.0, 2.0]\nspin_inertia_kg_m2 = 1.691e-6\n\
             [gyro]\nnoise_rad_s = 1.0e-4\n\
             [prior]\ninertia_kg_m2 = [25, 25, 25, 2, 2, 2]\n\
             sigma_kg_m2 = [30, 30, 30, 10, 10, 10]\n\
             [disturbance]\ntorque = true\ngyro_bias = false\n",
        )
        .unwrap();
        assert_eq!(craft.wheels[0].axis, Vector3::z());
        assert_eq!(craft.wheels[0].spin_inertia_kg_m2, 1.691e-6);
        assert_eq!(craft.gyro.noise_rad_s, Some(1e-4));
        assert_eq!(craft.prior.unwrap().sigma_kg_m2[5], 10.0);
        assert_eq!(craft.solve_for, SolveFor { torque: true, gyro_bias: false });
    }

    #[test]
    fn zero_axis_is_refused_by_name_and_line() {
        let wheel = "[[wheel]]\nspin_inertia_kg_m2 = 1e-3\naxis =";
        assert_eq!(
            message(&format!("{wheel} [1, 0, 0]\n{wheel} [0, 0, 0]\n")),
            "craft.toml:6: `wheel[2].axis` is [0, 0, 0]; it must be a direction, with at least \
             one entry other than zero"
        );
    }

    #[test]
    fn axis_must_be_three_finite_numbers() {
        let wheel = "[[wheel]]\nspin_inertia_kg_m2 = 1e-3\naxis =";
        let nan = message(&format!("{wheel} [nan, 0, 1]"));
        assert!(nan.contains("`wheel[1].axis` is [NaN, 0, 1]; it must be finite"), "{nan}");
        let long = message(&format!("{wheel} [0, 0, 1, 0]"));
        assert!(long.contains("`wheel[1].axis` has 4 entries, but takes 3"), "{long}");
        let short = message(&format!("{wheel} [0, 1]"));
        assert!(short.contains("`wheel[1].axis` has 2 entries, but takes 3"), "{short}");
    }

    #[test]
    fn spin_inertia_must_be_positive_and_finite() {
        for bad in ["0", "-1e-3", "nan", "inf"] {
            let text = format!("[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = {bad}");
            let message = message(&text);
            assert!(message.starts_with("craft.toml:3: `wheel[1].spin_inertia_kg_m2` is"), "{bad}");
        }
    }

    #[test]
    fn gyro_values_must_be_positive_and_finite() {
        for key in ["noise_rad_s", "range_rad_s", "quantum_rad_s"] {
            for bad in ["0", "-1e-4", "nan", "inf"] {
                let message = message(&format!("[gyro]\n{key} = {bad}"));
                assert!(message.starts_with(&format!("craft.toml:2: `gyro.{key}` is")), "{bad}");
                assert!(message.ends_with("it must be positive and finite"), "{message}");
            }
        }
    }

    #[test]
    fn prior_that_no_body_has_is_refused() {
        let prior = |inertia: &str| {
            message(&format!("[prior]\ninertia_kg_m2 = {inertia}\nsigma_kg_m2 = [1,1,1,1,1,1]"))
        };
        let triangle = prior("[1, 1, 3, 0, 0, 0]");
        assert!(triangle.starts_with("craft.toml:2: `prior.inertia_kg_m2`"), "{triangle}");
        assert!(triangle.contains("principal moments are [1, 1, 3]"), "{triangle}");
        let indefinite = prior("[1, 1, 1, 2, 0, 0]");
        assert!(indefinite.contains("principal moments are [-1, 1, 3]"), "{indefinite}");
        let short = prior("[1, 1, 1]");
        assert!(short.contains("`prior.inertia_kg_m2` has 3 entries, but takes 6"), "{short}");
    }

    #[test]
    fn prior_sigma_must_be_positive() {
        let text = "[prior]\ninertia_kg_m2 = [1,1,1,0,0,0]\nsigma_kg_m2 = [1,1,1,0,1,1]";
        let message = message(text);
        assert!(message.starts_with("craft.toml:3: `prior.sigma_kg_m2` is"), "{message}");
        assert!(message.ends_with("it must be six positive standard deviations"), "{message}");
    }

    #[test]
    fn ninth_wheel_is_refused_and_the_limit_told() {
        let text = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n".repeat(9);
        assert_eq!(
            message(&text),
            "craft.toml:25: 9 [[wheel]] tables, but at most 8 are supported; remove some"
        );
    }

    #[test]
    fn unknown_keys_are_refused_at_every_level() {
        assert!(message("gyros = 1").contains("did you mean `gyro`?"));
        assert!(message("[gyro]\nnoise = 1").contains("did you mean `noise_rad_s`?"));
        assert!(message("[prior]\ninertia = []").contains("did you mean `inertia_kg_m2`?"));
        assert!(message("[disturbance]\ntorqe = true").contains("did you mean `torque`?"));
        assert!(message("[[wheel]]\naxes = []").contains("did you mean `axis`?"));
    }
}
