//! The tables of a `SCENARIO.toml`, combined into a [`Scenario`].

use std::path::Path;

use flight_input::InputError;
use flight_input::craft::MAX_WHEELS;
use flight_input::craft::filter::{self, Filter, FilterFile};
use flight_input::craft::hardware::{
    self, ModeFile, Statements, TorqueScaleFile, Unstated, WheelStatements, WheelsFile,
};
use flight_input::craft::prior::{self, PriorFile};
use flight_input::craft::wheel::check_count;
use flight_input::inertia::{principal_moments, tensor};
use flight_input::key::{ANY, Key, NUMBER, POSITIVE, TABLE, TABLES as REPEATED, TEXT, Table};
use flight_input::section::Section;
use flight_input::toml_source::TomlSource;
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;

use super::change::{self, ChangeFile, ChangesFile, DriftFile};
use super::control::{self, ControlFile, control};
use super::definition::Scenario;
use super::dispersion::{self, Dispersion, DispersionFile};
use super::disturbance::{self, Disturbance, DisturbanceFile};
use super::fault::{self, FaultFile};
use super::gyro::{self, GyroErrorsFile, GyroFile};
use super::hardware::{self as true_hardware, Carrier, HardwareFile};
use super::limits::MAX_SAMPLES;
use super::problem::ScenarioProblem;
use super::profile::{self, ExternalProfileFile, ExternalTorque, Surroundings, external_profile};
use super::random_draw;
use super::random_spacecraft::{self, RandomSpacecraftFile};
use super::spacecraft::{self, SpacecraftFile};
use super::thruster::{self, ThrusterFile};
use super::wheel::{self, SimulatedWheel, WheelFile, moments_without_wheels};

const NAME: Key = Key::required("name", TEXT, "", ANY, "Name in reports");
const DURATION: Key = Key::required(
    "duration_s",
    NUMBER,
    "s",
    POSITIVE,
    "Duration of the flight, at most 1e7 samples",
);

const ROOT: Table = Table {
    header: "",
    about: "Keys above the first table, and the tables. A scenario of random spacecraft has only \
            `name`, `[random_spacecraft]` and tables of errors.",
    keys: &[
        NAME,
        DURATION,
        Key::required("spacecraft", TABLE, "", ANY, "True body"),
        Key::required("change", REPEATED, "", ANY, "Sudden changes of the inertia").or("no change"),
        Key::required("drift", TABLE, "", ANY, "Drift of the inertia").or("no drift"),
        Key::required("wheel", REPEATED, "", ANY, "Reaction wheels").or("no wheel"),
        Key::required("wheels", TABLE, "", ANY, "Errors of all wheels").or("ideal wheels"),
        Key::required("torque", TABLE, "", ANY, "Commanded external torque").or("no torque"),
        Key::required("thruster", REPEATED, "", ANY, "Thrusters").or("no thruster"),
        Key::required("control", TABLE, "", ANY, "Attitude controller").or("no controller"),
        Key::required("gyro", TABLE, "", ANY, "Simulated gyro"),
        Key::required("mode", REPEATED, "", ANY, "Modes known to the estimator").or("rigid body"),
        Key::required("hardware", TABLE, "", ANY, "True errors of the hardware").or("ideal"),
        Key::required("fault", REPEATED, "", ANY, "Faults before the estimator").or("no fault"),
        Key::required("disturbance", TABLE, "", ANY, "Unknown torque, further unknowns").or("none"),
        Key::required("prior", TABLE, "", ANY, "Expected inertia").or("no prior"),
        Key::required("filter", TABLE, "", ANY, "Process noise").or("that of the estimators"),
        Key::required("dispersion", TABLE, "", ANY, "Differences between runs").or("none"),
    ],
};
const FILTER_TABLE: Table =
    Table { keys: &[filter::RATE_WALK, filter::INERTIA_WALK], ..filter::TABLE };

const WHEELS_TABLE: Table = Table {
    keys: &[
        hardware::EACH_SPIN_INERTIA_SIGMA.or("0"),
        hardware::EACH_AXIS_SIGMA.or("0"),
        hardware::COMMON_SPIN_INERTIA_SIGMA,
        hardware::EACH_TACHOMETER,
    ],
    ..hardware::WHEELS_TABLE
};

const OWN_TABLES: [Table; 21] = [
    ROOT,
    spacecraft::TABLE,
    wheel::TABLE,
    profile::WHEEL_TABLE,
    hardware::TACHOMETER_TABLE,
    WHEELS_TABLE,
    hardware::TACHOMETERS_TABLE,
    profile::EXTERNAL_TABLE,
    thruster::TABLE,
    control::TABLE,
    gyro::TABLE,
    hardware::MODE_TABLE,
    disturbance::TABLE,
    prior::TABLE,
    FILTER_TABLE,
    change::CHANGE_TABLE,
    change::DRIFT_TABLE,
    dispersion::TABLE,
    dispersion::INITIAL_TABLE,
    random_spacecraft::TABLE,
    fault::TABLE,
];

const TABLE_COUNT: usize = OWN_TABLES.len() + true_hardware::TABLES.len();

/// The tables of a scenario file.
pub const TABLES: [Table; TABLE_COUNT] = {
    let mut tables = [ROOT; TABLE_COUNT];
    let mut index = 0;
    while index < TABLE_COUNT {
        tables[index] = if index < OWN_TABLES.len() {
            OWN_TABLES[index]
        } else {
            true_hardware::TABLES[index - OWN_TABLES.len()]
        };
        index += 1;
    }
    tables
};

/// Discriminator: a scenario of random spacecraft, or of a single one.
#[derive(Deserialize)]
struct Kind {
    random_spacecraft: Option<IgnoredAny>,
}

/// Keys that a craft file lacks, and tables that it has.
#[derive(Deserialize)]
struct KeysOfCraft {
    duration_s: Option<IgnoredAny>,
    spacecraft: Option<IgnoredAny>,
    wheel: Option<IgnoredAny>,
    gyro: Option<IgnoredAny>,
    log: Option<IgnoredAny>,
}

impl KeysOfCraft {
    fn are_alone(&self) -> bool {
        let describes_flight = self.duration_s.is_some() || self.spacecraft.is_some();
        let tables = [&self.wheel, &self.gyro, &self.log];
        !describes_flight && tables.iter().any(|table| table.is_some())
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RandomFile {
    name: String,
    random_spacecraft: RandomSpacecraftFile,
    #[serde(default)]
    disturbance: DisturbanceFile,
    #[serde(default)]
    gyro: GyroErrorsFile,
    #[serde(default)]
    wheels: WheelsFile,
    #[serde(default)]
    torque: TorqueScaleFile,
    #[serde(default)]
    mode: Vec<Spanned<ModeFile>>,
    #[serde(default)]
    hardware: HardwareFile,
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
    #[serde(default)]
    wheels: WheelsFile,
    torque: Option<ExternalProfileFile>,
    #[serde(default)]
    thruster: Vec<ThrusterFile>,
    control: Option<Spanned<ControlFile>>,
    gyro: GyroFile,
    #[serde(default)]
    mode: Vec<Spanned<ModeFile>>,
    #[serde(default)]
    hardware: HardwareFile,
    #[serde(default)]
    fault: Vec<Spanned<FaultFile>>,
    #[serde(default)]
    disturbance: DisturbanceFile,
    prior: Option<PriorFile>,
    #[serde(default)]
    filter: FilterFile,
    #[serde(default)]
    dispersion: DispersionFile,
}

/// The checked scenario; `folder` is that of the CSV tables it names.
pub(super) fn read(source: &TomlSource, folder: &Path) -> Result<Scenario, InputError> {
    let Kind { random_spacecraft } = source.parse()?;
    if random_spacecraft.is_none() {
        if source.parse::<KeysOfCraft>()?.are_alone() {
            return Err(source.error(0..0, ScenarioProblem::CraftFile.into()));
        }
        // With the keys of a craft file that have an error of their own here.
        let table = |table: Table| if table.header == "[filter]" { filter::TABLE } else { table };
        source.check_keys(&TABLES.map(table))?;
    }
    source.read_all(|| read_values(source, folder))
}

fn read_values(source: &TomlSource, folder: &Path) -> Result<Scenario, InputError> {
    let root = Section::root(source);
    match source.parse()? {
        Kind { random_spacecraft: Some(_) } => source.parse::<RandomFile>()?.read(&root),
        Kind { random_spacecraft: None } => source.parse::<ScenarioFile>()?.read(&root, folder),
    }
}

/// A random spacecraft, for the check of modal inertias: least over largest moment of eight masses in a
/// cube is above 0.1.
const RANDOM_CARRIER: Carrier =
    Carrier { wheels: MAX_WHEELS, largest_moment_kg_m2: 1.0, smallest_moment_kg_m2: 0.1 };

impl RandomFile {
    fn statements(&self) -> Statements {
        Statements {
            gyro: self.gyro.statements(),
            each_wheel: vec![WheelStatements::default(); MAX_WHEELS],
            wheels: self.wheels.clone(),
            torque_scale_sigma: self.torque.scale_sigma.clone(),
            torque_sigma_n_m: self.disturbance.torque_sigma_n_m.clone(),
            varying_torque_sigma_n_m: self.disturbance.varying_torque_sigma_n_m.clone(),
            modes: self.mode.clone(),
            ..Statements::default()
        }
    }

    fn read(&self, root: &Section<'_>) -> Result<Scenario, InputError> {
        let mut random = self.random_spacecraft.read(&root.table("random_spacecraft"))?;
        random.hardware = self.statements().read(root, Unstated::Ideal)?;
        random.true_hardware = self.hardware.read(root, &RANDOM_CARRIER)?;
        let Disturbance { torque_n_m, solve_for } = self.disturbance.read(root)?;
        root.checked()?;
        let dispersion = Dispersion { spacecraft: Some(random.clone()), ..Dispersion::default() };
        Ok(Scenario {
            name: self.name.clone(),
            disturbance_torque_n_m: torque_n_m,
            solve_for: solve_for.with_priors(&random.hardware),
            dispersion,
            ..random_draw::scenario(&random, &self.name, 0)
        })
    }
}

/// Each of the tensors times a factor leaves a positive definite body without its wheels.
fn carries_wheels(tensors: &[[f64; 6]], factor: f64, wheels: &[SimulatedWheel]) -> bool {
    let rest = |j: &[f64; 6]| moments_without_wheels(&j.map(|j| j * factor), wheels)[0];
    tensors.iter().all(|tensor| rest(tensor) > 0.0)
}

/// The body that carries the hardware of a scenario.
fn carrier(inertia_kg_m2: &[f64; 6], wheels: &[SimulatedWheel]) -> Carrier {
    Carrier {
        wheels: wheels.len(),
        largest_moment_kg_m2: principal_moments(&tensor(inertia_kg_m2))[2],
        smallest_moment_kg_m2: moments_without_wheels(inertia_kg_m2, wheels)[0],
    }
}

impl ScenarioFile {
    fn read(self, root: &Section<'_>, folder: &Path) -> Result<Scenario, InputError> {
        let duration_s = root.number(&DURATION, &self.duration_s)?;
        let gyro = self.gyro.read(&root.table("gyro"))?;
        self.check_sample_count(root, duration_s * gyro.rate_hz)?;
        let spacecraft = self.spacecraft.read(&root.table("spacecraft"))?;
        let inertia_kg_m2 = &spacecraft.inertia_kg_m2;
        let surroundings = Surroundings { folder, duration_s };
        let wheels = self.simulated_wheels(root, inertia_kg_m2, surroundings)?;
        let changes = ChangesFile {
            sudden: &self.change,
            drift: self.drift.as_ref(),
            initial_kg_m2: *inertia_kg_m2,
            wheels: &wheels,
        }
        .read(root, duration_s)?;
        let later = changes.sudden.iter().map(|change| change.inertia_kg_m2);
        let tensors: Vec<[f64; 6]> = later.chain([*inertia_kg_m2]).collect();
        let carries = |factor: f64| carries_wheels(&tensors, factor, &wheels);
        let dispersion = self.dispersion.read(&root.table("dispersion"), carries)?;
        let torque = (self.torque.as_ref())
            .map(|profile| external_profile(&root.table("torque"), profile, surroundings))
            .transpose()?;
        let thrusters = (self.thruster.iter().enumerate())
            .map(|(index, thruster)| thruster.read(&root.entry("thruster", index)))
            .collect::<Result<_, _>>()?;
        let torque = ExternalTorque { thrusters, ..torque.unwrap_or(ExternalTorque::ZERO) };
        let control = (self.control.as_ref())
            .map(|table| control(&root.table("control"), table, inertia_kg_m2, &wheels))
            .transpose()?;
        let disturbance = self.disturbance.read(root)?;
        let hardware = self.statements().read(root, Unstated::Ideal)?;
        let true_hardware = self.hardware.read(root, &carrier(inertia_kg_m2, &wheels))?;
        let filter = self.filter(root)?;
        let faults = (self.fault.iter().enumerate())
            .map(|(index, file)| fault::read(&root.entry("fault", index), file, wheels.len()))
            .collect::<Result<Vec<_>, _>>()?;
        let prior = self.prior.map(|prior| prior.read(root)).transpose()?;
        Ok(Scenario {
            faults,
            changes,
            wheels,
            torque,
            control,
            disturbance_torque_n_m: disturbance.torque_n_m,
            solve_for: disturbance.solve_for.with_priors(&hardware),
            hardware,
            true_hardware,
            prior,
            filter,
            dispersion,
            ..Scenario::free(self.name, duration_s, spacecraft, gyro)
        })
    }

    /// The statements of all tables on the hardware.
    fn statements(&self) -> Statements {
        let torque = self.torque.as_ref();
        Statements {
            gyro: self.gyro.statements(),
            each_wheel: self.wheel.iter().map(|wheel| wheel.get_ref().statements()).collect(),
            wheels: self.wheels.clone(),
            torque_scale_sigma: torque.and_then(|profile| profile.get_ref().scale_sigma.clone()),
            torque_sigma_n_m: self.disturbance.torque_sigma_n_m.clone(),
            varying_torque_sigma_n_m: self.disturbance.varying_torque_sigma_n_m.clone(),
            modes: self.mode.clone(),
            ..Statements::default()
        }
    }

    fn check_sample_count(&self, root: &Section<'_>, samples: f64) -> Result<(), InputError> {
        if samples <= MAX_SAMPLES {
            return Ok(());
        }
        let problem = ScenarioProblem::TooManySamples { samples, limit: MAX_SAMPLES };
        Err(root.error(&self.duration_s, problem))
    }

    /// The wheels, which must leave the body a positive definite inertia.
    fn simulated_wheels(
        &self,
        root: &Section<'_>,
        inertia_kg_m2: &[f64; 6],
        surroundings: Surroundings<'_>,
    ) -> Result<Vec<SimulatedWheel>, InputError> {
        check_count(root, &self.wheel)?;
        let wheels = (self.wheel.iter().enumerate())
            .map(|(index, wheel)| wheel.get_ref().read(&root.entry("wheel", index), surroundings))
            .collect::<Result<Vec<_>, _>>()?;
        let principal_moments_kg_m2 = moments_without_wheels(inertia_kg_m2, &wheels);
        if principal_moments_kg_m2[0] > 0.0 {
            return Ok(wheels);
        }
        let section = root.table("spacecraft");
        let key = section.full(&spacecraft::INERTIA);
        let problem = ScenarioProblem::WheelsOutweighBody { key, principal_moments_kg_m2 };
        Err(section.error(&self.spacecraft.inertia_kg_m2, problem))
    }

    /// Process noise. The smoothness of the torque follows from its profile.
    fn filter(&self, root: &Section<'_>) -> Result<Filter, InputError> {
        if let Some(span) = self.filter.torque_is_smooth_at() {
            let key = root.table("filter").full(&filter::TORQUE_IS_SMOOTH);
            return Err(root.error_at(span, ScenarioProblem::KeyOfCraftFile { key }));
        }
        self.filter.read(root)
    }
}

#[cfg(test)]
mod tests {
    use flight_input::error::Problem;
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::input::craft::SolveFor;
    use crate::input::scenario::TorqueProfile;

    /// A valid scenario; each test changes one part of it.
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
    fn absent_keys_have_their_defaults() {
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
    fn craft_of_a_scenario_excludes_the_truth() {
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
    fn each_bad_value_is_reported() {
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
            (
                "duration_s = 60.0\n[spacecraft]\ninertia_kg_m2 = [3, 4, 5, 0, 0, 0]",
                "",
                "s.toml: a craft file, not a scenario: a scenario also has `duration_s`, [spacecraft] and",
            ),
            ("rate_hz = 10.0", "", "s.toml:5: missing key `rate_hz`"),
        ] {
            let message = message(&GOOD.replacen(good, bad, 1));
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn a_craft_file_is_named_whatever_its_tables() {
        for tables in [WHEEL, "[gyro]\nnoise_rad_s = 1e-4\n", "[log]\n"] {
            let message = message(tables);
            assert!(message.starts_with("s.toml: a craft file, not a scenario"), "{message}");
        }
    }

    #[test]
    fn each_bad_optional_value_is_reported() {
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
    fn each_bad_value_of_a_wheel_is_reported() {
        for (good, bad, expected) in [
            (
                "[0, 0, 2]",
                "[0, 0, 0]",
                "s.toml:12: `wheel[2].axis` is [0, 0, 0]; it must be finite",
            ),
            ("1e-3", "0", "s.toml:13: `wheel[2].spin_inertia_kg_m2` is 0; it must be positive"),
            (
                "1e-3",
                "1e-3\nmax_torque_n_m = 0",
                "s.toml:14: `wheel[2].max_torque_n_m` is 0; it must be positive",
            ),
            (
                "1e-3",
                "1e-3\nmax_speed_rad_s = -1",
                "s.toml:14: `wheel[2].max_speed_rad_s` is -1; it must be positive",
            ),
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
    fn wheels_heavier_than_the_body_are_rejected() {
        let message = message(&format!("{GOOD}{}", WHEEL.replace("1e-3", "3.0").repeat(2)));
        assert!(
            message.starts_with(
                "s.toml:4: `spacecraft.inertia_kg_m2` includes the wheels (locked), but without \
                 their spin inertia its principal moments are [-1, 3, 4]"
            ),
            "{message}"
        );
    }

    #[test]
    fn unphysical_prior_is_rejected() {
        let prior = "[prior]\ninertia_kg_m2 = [1,1,3,0,0,0]\nsigma_kg_m2 = [1,1,1,1,1,1]\n";
        let message = message(&format!("{GOOD}{prior}"));
        assert!(message.starts_with("s.toml:9: `prior.inertia_kg_m2`"), "{message}");
    }

    #[test]
    fn torque_is_smooth_is_rejected_with_the_reason() {
        let message = message(&format!("{GOOD}[filter]\ntorque_is_smooth = true\n"));
        assert!(message.starts_with("s.toml:9: `filter.torque_is_smooth` is a key of craft files"));
    }

    #[test]
    fn every_key_of_the_reader_has_a_row_in_the_reference() {
        for table in TABLES {
            let above = if table.header.starts_with("[wheel.") { "[[wheel]]\n" } else { "" };
            let text = format!("{above}{}\nxyzzy = 1\n", table.header);
            let source = TomlSource::new("s.toml", &text);
            let problem = read_values(&source, Path::new("")).unwrap_err().problem;
            let Problem::UnknownKey { known, .. } = problem else { panic!("{problem}") };
            let known: Vec<_> = known.iter().filter(|key| *key != "torque_is_smooth").collect();
            assert_eq!(known, table.names().iter().collect::<Vec<_>>(), "{}", table.header);
        }
        let random = parse("aaa = 1\n[random_spacecraft]\n").unwrap_err().to_string();
        assert!(random.contains("known keys here: name, random_spacecraft, disturbance"));
    }
}
