//! The tables of a `SCENARIO.toml` as they are written, and their checks.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;

use super::super::check::{Check, principal_moments, tensor};
use super::super::craft::{FilterFile, PriorFile, SolveFor, Wheel, check_wheel_count, wheel_key};
use super::super::error::{InputError, Problem};
use super::super::toml_source::TomlSource;
use super::change::{ChangeFile, DriftFile, changes};
use super::control::{ControlFile, attitude, control};
use super::dispersion::DispersionFile;
use super::profile_file::{
    ExternalProfileFile, Surroundings, WheelProfileFile, external_profile, wheel_profile,
};
use super::random_spacecraft::RandomSpacecraftFile;
use super::{
    Dispersion, ExternalTorque, MAX_RATE_HZ, MAX_SAMPLES, Scenario, SimulatedGyro, SimulatedWheel,
    Spacecraft, TorqueProfile,
};

/// Reads and checks a scenario; `folder` is where the tables it names are.
pub(super) fn read(source: &TomlSource, folder: &Path) -> Result<Scenario, InputError> {
    match source.parse()? {
        Kind { random_spacecraft: Some(_) } => read_random(source),
        Kind { random_spacecraft: None } => read_one(source, folder),
    }
}

/// A scenario in which each seed has a spacecraft of its own.
fn read_random(source: &TomlSource) -> Result<Scenario, InputError> {
    let file: RandomFile = source.parse()?;
    let check = &Check::new(source);
    let random = file.random_spacecraft.check(check)?;
    let Disturbance { torque_n_m, solve_for } = file.disturbance.check(check)?;
    let dispersion = Dispersion { spacecraft: Some(random.clone()), ..Dispersion::default() };
    Ok(Scenario {
        name: file.name.clone(),
        disturbance_torque_n_m: torque_n_m,
        solve_for,
        dispersion,
        ..random.draw(&file.name, 0)
    })
}

/// A scenario of one spacecraft.
fn read_one(source: &TomlSource, folder: &Path) -> Result<Scenario, InputError> {
    let file: ScenarioFile = source.parse()?;
    let check = &Check::new(source);

    let duration_s = check.positive("duration_s", &file.duration_s)?;
    let gyro = file.gyro.check(check)?;
    check_sample_count(check, &file.duration_s, duration_s * gyro.rate_hz)?;
    let spacecraft = file.spacecraft.check(check)?;
    let surroundings = Surroundings { folder, duration_s };
    check_wheel_count(check, &file.wheel)?;
    let wheels = (file.wheel.iter().enumerate())
        .map(|(index, wheel)| wheel.get_ref().check(check, &wheel_key(index), surroundings))
        .collect::<Result<Vec<_>, _>>()?;
    check_wheels_fit(check, &file.spacecraft.inertia_kg_m2, &spacecraft, &wheels)?;
    let body = (&spacecraft.inertia_kg_m2, wheels.as_slice());
    let changes = changes(check, &file.change, file.drift.as_ref(), body, duration_s)?;
    let later = changes.sudden.iter().map(|change| change.inertia_kg_m2);
    let tensors: Vec<[f64; 6]> = later.chain([spacecraft.inertia_kg_m2]).collect();
    let carries_wheels = |factor: f64| {
        let rest = |tensor: &[f64; 6]| without_wheels(&tensor.map(|j| j * factor), &wheels)[0];
        tensors.iter().all(|tensor| rest(tensor) > 0.0)
    };
    let dispersion = file.dispersion.check(check, carries_wheels)?;
    let torque = match &file.torque {
        Some(profile) => external_profile(check, profile, surroundings)?,
        None => ExternalTorque::ZERO,
    };

    let control = (file.control.as_ref())
        .map(|table| control(check, table, &spacecraft.inertia_kg_m2, &wheels))
        .transpose()?;
    let disturbance = file.disturbance.check(check)?;

    Ok(Scenario {
        name: file.name,
        duration_s,
        spacecraft,
        changes,
        wheels,
        torque,
        control,
        gyro,
        disturbance_torque_n_m: disturbance.torque_n_m,
        solve_for: disturbance.solve_for,
        prior: file.prior.map(|prior| prior.check(check)).transpose()?,
        rate_walk_rad_s_sqrt_s: file.filter.rate_walk(check)?,
        inertia_walk_kg_m2_sqrt_hour: file.filter.inertia_walk(check)?,
        dispersion,
        initial_estimate: None,
    })
}

fn check_sample_count(
    check: &Check<'_>,
    duration_s: &Spanned<f64>,
    samples: f64,
) -> Result<(), InputError> {
    if samples <= MAX_SAMPLES {
        return Ok(());
    }
    Err(check.error(duration_s, Problem::TooManySamples { samples, limit: MAX_SAMPLES }))
}

/// The body without the wheels' spin inertia, `J − Σ Iₛ a aᵀ`, is what the motors turn against; the
/// equation of motion has no solution unless it is positive definite.
fn check_wheels_fit(
    check: &Check<'_>,
    inertia: &Spanned<Vec<f64>>,
    spacecraft: &Spacecraft,
    wheels: &[SimulatedWheel],
) -> Result<(), InputError> {
    let principal_moments_kg_m2 = without_wheels(&spacecraft.inertia_kg_m2, wheels);
    if principal_moments_kg_m2[0] > 0.0 {
        return Ok(());
    }
    let key = "spacecraft.inertia_kg_m2".to_owned();
    Err(check.error(inertia, Problem::WheelsOutweighBody { key, principal_moments_kg_m2 }))
}

/// Principal moments of `J − Σ Iₛ a aᵀ`, ascending, kg m².
pub(super) fn without_wheels(inertia_kg_m2: &[f64; 6], wheels: &[SimulatedWheel]) -> [f64; 3] {
    let mut rest = tensor(inertia_kg_m2);
    for SimulatedWheel { wheel, .. } in wheels {
        rest -= wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2;
    }
    principal_moments(&rest)
}

fn optional_vector(
    check: &Check<'_>,
    key: &str,
    value: &Option<Spanned<Vec<f64>>>,
) -> Result<Vector3<f64>, InputError> {
    value.as_ref().map_or(Ok(Vector3::zeros()), |value| check.vector(key, value))
}

/// Tells a scenario of random spacecraft from one of a single one.
#[derive(Deserialize)]
struct Kind {
    random_spacecraft: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RandomFile {
    name: String,
    random_spacecraft: RandomSpacecraftFile,
    #[serde(default)]
    disturbance: DisturbanceFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScenarioFile {
    name: String,
    duration_s: Spanned<f64>,
    spacecraft: SpacecraftFile,
    #[serde(default)]
    change: Vec<Spanned<ChangeFile>>,
    drift: Option<DriftFile>,
    #[serde(default)]
    wheel: Vec<Spanned<WheelFile>>,
    torque: Option<ExternalProfileFile>,
    control: Option<Spanned<ControlFile>>,
    gyro: GyroFile,
    #[serde(default)]
    disturbance: DisturbanceFile,
    prior: Option<PriorFile>,
    #[serde(default)]
    filter: FilterFile,
    #[serde(default)]
    dispersion: DispersionFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpacecraftFile {
    inertia_kg_m2: Spanned<Vec<f64>>,
    rate_rad_s: Option<Spanned<Vec<f64>>>,
    attitude_deg: Option<Spanned<Vec<f64>>>,
}

impl SpacecraftFile {
    fn check(&self, check: &Check<'_>) -> Result<Spacecraft, InputError> {
        let attitude = match &self.attitude_deg {
            Some(angles) => attitude(check, "spacecraft.attitude_deg", angles)?,
            None => UnitQuaternion::identity(),
        };
        Ok(Spacecraft {
            attitude,
            inertia_kg_m2: check.inertia("spacecraft.inertia_kg_m2", &self.inertia_kg_m2)?,
            rate_rad_s: optional_vector(check, "spacecraft.rate_rad_s", &self.rate_rad_s)?,
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelFile {
    name: Option<String>,
    axis: Spanned<Vec<f64>>,
    spin_inertia_kg_m2: Spanned<f64>,
    speed_rad_s: Option<Spanned<f64>>,
    torque: Option<WheelProfileFile>,
}

impl WheelFile {
    fn check(
        &self,
        check: &Check<'_>,
        key: &str,
        surroundings: Surroundings<'_>,
    ) -> Result<SimulatedWheel, InputError> {
        let inertia_key = format!("{key}.spin_inertia_kg_m2");
        let wheel = Wheel {
            name: self.name.clone(),
            axis: check.axis(&format!("{key}.axis"), &self.axis)?,
            spin_inertia_kg_m2: check.positive(&inertia_key, &self.spin_inertia_kg_m2)?,
        };
        let speed_rad_s = match &self.speed_rad_s {
            Some(speed) => check.finite(&format!("{key}.speed_rad_s"), speed)?,
            None => 0.0,
        };
        let torque = match &self.torque {
            Some(profile) => wheel_profile(check, &format!("{key}.torque"), profile, surroundings)?,
            None => TorqueProfile::ZERO,
        };
        Ok(SimulatedWheel { wheel, speed_rad_s, torque })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GyroFile {
    rate_hz: Spanned<f64>,
    noise_rad_s: Spanned<f64>,
    bias_rad_s: Option<Spanned<Vec<f64>>>,
    bias_walk_rad_s_sqrt_s: Option<Spanned<f64>>,
    quantum_rad_s: Option<Spanned<f64>>,
    range_rad_s: Option<Spanned<f64>>,
}

impl GyroFile {
    fn check(&self, check: &Check<'_>) -> Result<SimulatedGyro, InputError> {
        let not_negative = |key: &str, value: &Option<Spanned<f64>>| {
            value.as_ref().map_or(Ok(0.0), |value| check.not_negative(key, value))
        };
        let walk = &self.bias_walk_rad_s_sqrt_s;
        let quantum_rad_s = not_negative("gyro.quantum_rad_s", &self.quantum_rad_s)?;
        let range_rad_s = (self.range_rad_s.as_ref())
            .map(|range| check.positive("gyro.range_rad_s", range))
            .transpose()?;
        Ok(SimulatedGyro {
            rate_hz: check.number(
                "gyro.rate_hz",
                &self.rate_hz,
                "positive, and at most 100 kHz",
                |rate| rate > 0.0 && rate <= MAX_RATE_HZ,
            )?,
            noise_rad_s: check.positive("gyro.noise_rad_s", &self.noise_rad_s)?,
            bias_rad_s: optional_vector(check, "gyro.bias_rad_s", &self.bias_rad_s)?,
            bias_walk_rad_s_sqrt_s: not_negative("gyro.bias_walk_rad_s_sqrt_s", walk)?,
            quantum_rad_s: (quantum_rad_s > 0.0).then_some(quantum_rad_s),
            range_rad_s,
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
    torque_n_m: Option<Spanned<Vec<f64>>>,
}

/// What disturbs the motion, and what the estimator is asked for.
struct Disturbance {
    torque_n_m: Vector3<f64>,
    solve_for: SolveFor,
}

impl DisturbanceFile {
    fn check(&self, check: &Check<'_>) -> Result<Disturbance, InputError> {
        Ok(Disturbance {
            torque_n_m: optional_vector(check, "disturbance.torque_n_m", &self.torque_n_m)?,
            solve_for: SolveFor { torque: self.torque, gyro_bias: self.gyro_bias },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scenario that is right: each test makes one thing wrong in it.
    const GOOD: &str = r#"name = "test"
duration_s = 60.0
[spacecraft]
inertia_kg_m2 = [3, 4, 5, 0, 0, 0]
[gyro]
rate_hz = 10.0
noise_rad_s = 1e-4
"#;
    const WHEEL: &str = "[[wheel]]\naxis = [0, 0, 2]\nspin_inertia_kg_m2 = 1e-3\n";

    fn parse(text: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", text, Path::new(""))
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn what_is_left_out_is_zero_or_none() {
        let scenario = parse(GOOD).unwrap();
        assert_eq!(scenario.spacecraft.rate_rad_s, Vector3::zeros());
        assert_eq!(scenario.spacecraft.attitude, UnitQuaternion::identity());
        assert_eq!(scenario.control, None);
        assert_eq!(scenario.torque, ExternalTorque::ZERO);
        assert!(scenario.wheels.is_empty() && scenario.prior.is_none());
        assert_eq!(scenario.solve_for, SolveFor::default());
        assert_eq!(scenario.disturbance_torque_n_m, Vector3::zeros());
        assert_eq!(scenario.gyro.quantum_rad_s, None);

        let wheel = &parse(&format!("{GOOD}{WHEEL}")).unwrap().wheels[0];
        assert_eq!(wheel.wheel.axis, Vector3::z());
        assert_eq!((wheel.speed_rad_s, &wheel.torque), (0.0, &TorqueProfile::ZERO));
    }

    #[test]
    fn estimator_is_told_all_but_the_truth() {
        let extra = "bias_rad_s = [1, 2, 3]\nquantum_rad_s = 1e-5\nrange_rad_s = 4\n\
                     [disturbance]\ntorque = true\ntorque_n_m = [1e-6, 0, 0]\n";
        let scenario = parse(&format!("{GOOD}{extra}{WHEEL}")).unwrap();
        assert_eq!(scenario.disturbance_torque_n_m.x, 1e-6);
        let craft = scenario.craft();
        assert_eq!(craft.wheels.len(), 1);
        assert_eq!(craft.gyro.noise_rad_s, Some(1e-4));
        assert_eq!(craft.gyro.range_rad_s, Some(4.0));
        assert!(craft.solve_for.torque && craft.prior.is_none());
    }

    #[test]
    fn each_bad_value_is_named() {
        for (good, bad, expected) in [
            ("60.0", "0", "s.toml:2: `duration_s` is 0; it must be positive"),
            ("60.0", "inf", "s.toml:2: `duration_s` is inf; it must be positive and finite"),
            ("60.0", "1e8", "s.toml:2: `duration_s` times `gyro.rate_hz` gives 1.000e9 samples"),
            ("rate_hz = 10.0", "rate_hz = 0", "s.toml:6: `gyro.rate_hz` is 0; it must be positive"),
            ("rate_hz = 10.0", "rate_hz = 2e5", "s.toml:6: `gyro.rate_hz` is 200000; it must be"),
            ("rate_hz = 10.0", "rate_hz = nan", "s.toml:6: `gyro.rate_hz` is NaN; it must be"),
            ("1e-4", "-1e-4", "s.toml:7: `gyro.noise_rad_s` is -0.0001; it must be positive"),
            ("1e-4", "0", "s.toml:7: `gyro.noise_rad_s` is 0; it must be positive"),
            ("5, 0", "9, 0", "s.toml:4: `spacecraft.inertia_kg_m2` (jxx jyy jzz jxy jxz jyz) is"),
            ("[3, 4,", "[-3, 4,", "s.toml:4: `spacecraft.inertia_kg_m2` (jxx jyy"),
            ("[3, 4,", "[3,", "s.toml:4: `spacecraft.inertia_kg_m2` has 5 entries, but takes 6"),
            ("\"test\"", "3", "s.toml:1: wrong type of value: integer `3`, expected a string"),
            ("[gyro]", "[gyros]", "s.toml:5: unknown key `gyros` (did you mean `gyro`?)"),
            ("rate_hz", "rate", "s.toml:6: unknown key `rate` (did you mean `rate_hz`?)"),
            ("duration_s = 60.0", "", "s.toml: missing key `duration_s`"),
            ("rate_hz = 10.0", "", "s.toml:5: missing key `rate_hz`"),
        ] {
            let message = message(&GOOD.replacen(good, bad, 1));
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn each_bad_optional_value_is_named() {
        for (extra, expected) in [
            ("bias_rad_s = [0, 0]", "`gyro.bias_rad_s` has 2 entries, but takes 3"),
            ("bias_rad_s = [0, 0, nan]", "`gyro.bias_rad_s` is [0, 0, NaN]; it must be finite"),
            ("quantum_rad_s = -1", "`gyro.quantum_rad_s` is -1; it must be zero or positive"),
            ("bias_walk_rad_s_sqrt_s = -1", "`gyro.bias_walk_rad_s_sqrt_s` is -1; it must be"),
            ("range_rad_s = 0", "`gyro.range_rad_s` is 0; it must be positive"),
            ("[disturbance]\ntorque_n_m = [1]", "`disturbance.torque_n_m` has 1 entries"),
            ("[filter]\nrate_walk_rad_s_sqrt_s = -1", "`filter.rate_walk_rad_s_sqrt_s` is -1; it"),
            (
                "[filter]\ninertia_walk_kg_m2_sqrt_hour = nan",
                "`filter.inertia_walk_kg_m2_sqrt_hour` is NaN; it must be zero or positive",
            ),
            ("[disturbance]\nbias = true", "unknown key `bias` (did you mean `gyro_bias`?)"),
        ] {
            let message = message(&format!("{GOOD}{extra}\n"));
            assert!(message.contains(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn each_bad_value_of_a_wheel_is_named() {
        for (good, bad, expected) in [
            ("[0, 0, 2]", "[0, 0, 0]", "s.toml:12: `wheel[2].axis` is [0, 0, 0]; it must be a dir"),
            ("1e-3", "0", "s.toml:13: `wheel[2].spin_inertia_kg_m2` is 0; it must be positive"),
            ("axis", "axes", "s.toml:12: unknown key `axes` (did you mean `axis`?)"),
            (
                "1e-3",
                "1e-3\nspeed_rad_s = inf",
                "s.toml:14: `wheel[2].speed_rad_s` is inf; it must",
            ),
        ] {
            let message = message(&format!("{GOOD}{WHEEL}{}", WHEEL.replacen(good, bad, 1)));
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
        let nine = message(&format!("{GOOD}{}", WHEEL.repeat(9)));
        assert!(nine.contains("9 [[wheel]] tables, but at most 8"), "{nine}");
    }

    #[test]
    fn wheels_heavier_than_the_body_are_refused() {
        let message = message(&format!("{GOOD}{}", WHEEL.replace("1e-3", "3.0").repeat(2)));
        assert!(
            message.starts_with(
                "s.toml:4: `spacecraft.inertia_kg_m2` includes the wheels (locked), but leaves \
                 principal moments [-1, 3, 4]"
            ),
            "{message}"
        );
    }

    #[test]
    fn unphysical_prior_is_refused() {
        let prior = "[prior]\ninertia_kg_m2 = [1,1,3,0,0,0]\nsigma_kg_m2 = [1,1,1,1,1,1]\n";
        let message = message(&format!("{GOOD}{prior}"));
        assert!(message.starts_with("s.toml:9: `prior.inertia_kg_m2`"), "{message}");
    }

    #[test]
    fn unknown_name_lists_the_built_in_scenarios() {
        let message = Scenario::load("stsat").unwrap_err().to_string();
        assert!(message.starts_with("stsat: neither a file nor a built-in scenario"), "{message}");
        assert!(message.contains("stsat3-spin-up, stsat3-spin-up-wrong-prior"), "{message}");
        let message = Scenario::load("gone.toml").unwrap_err().to_string();
        assert!(message.starts_with("gone.toml: cannot be read: "), "{message}");
    }
}
