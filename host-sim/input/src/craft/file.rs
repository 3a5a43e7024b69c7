//! [`Craft`], read from and written to a `CRAFT.toml`.

use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::disturbance::{self, DisturbanceFile, SolveFor};
use super::filter::{self, Filter, FilterFile};
use super::gyro::{self, GyroData, GyroFile};
use super::hardware::{
    self, ModeFile, MountFile, StatedHardware, Statements, TorqueScaleFile, Unstated, WheelsFile,
};
use super::log_format::{self, LogFile, LogFormat};
use super::prior::{self, Prior, PriorFile};
use super::thruster::{self, Thruster, ThrusterFile};
use super::wheel::{self, Wheel, WheelFile, check_count};
use crate::error::InputError;
use crate::key::{ANY, Key, TABLE, TABLES as REPEATED, Table};
use crate::section::Section;
use crate::toml_source::TomlSource;

const ROOT: Table = Table {
    header: "",
    about: "Tables of a craft file.",
    keys: &[
        Key::required("wheel", REPEATED, "", ANY, "Reaction wheels").or("no wheel"),
        Key::required("wheels", TABLE, "", ANY, "Errors of all wheels").or("assumed errors"),
        Key::required("thruster", REPEATED, "", ANY, "Thrusters").or("no thruster"),
        Key::required("gyro", TABLE, "", ANY, "Gyro").or("unknown gyro"),
        Key::required("torque", TABLE, "", ANY, "Error of the torque columns").or("assumed error"),
        Key::required("mount", TABLE, "", ANY, "Turn of all sensors as one").or("none"),
        Key::required("mode", REPEATED, "", ANY, "Flexible modes and slosh").or("rigid body"),
        Key::required("prior", TABLE, "", ANY, "Expected inertia").or("no prior"),
        Key::required("filter", TABLE, "", ANY, "Process noise").or("that of the estimators"),
        Key::required("disturbance", TABLE, "", ANY, "Further unknowns").or("none"),
        Key::required("log", TABLE, "", ANY, "Columns, units and clock of logs")
            .or("SI, as LOG.csv"),
    ],
};

/// The tables of a craft file.
pub const TABLES: [Table; 18] = [
    ROOT,
    wheel::TABLE,
    hardware::TACHOMETER_TABLE,
    hardware::WHEELS_TABLE,
    hardware::TACHOMETERS_TABLE,
    thruster::TABLE,
    gyro::TABLE,
    hardware::TORQUE_TABLE,
    hardware::MOUNT_TABLE,
    hardware::MODE_TABLE,
    prior::TABLE,
    filter::TABLE,
    disturbance::TABLE,
    log_format::TABLES[0],
    log_format::TABLES[1],
    log_format::TABLES[2],
    log_format::TABLES[3],
    log_format::TABLES[4],
];

/// A spacecraft as known to the estimator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Craft {
    /// The reaction wheels, in the order of the log's columns `wheel_1_rad_s`, `wheel_2_rad_s`, …
    pub wheels: Vec<Wheel>,
    /// Thrusters: torque sources of a design. Their torque in a log is that of the torque columns.
    pub thrusters: Vec<Thruster>,
    /// Known properties of the gyro.
    pub gyro: GyroData,
    /// Errors of the hardware: known parts, and one sigma of the rest.
    pub hardware: StatedHardware,
    /// Inertia expected before any measurement, if known.
    pub prior: Option<Prior>,
    /// Process noise of the filters.
    pub filter: Filter,
    /// Unknowns besides the inertia.
    pub solve_for: SolveFor,
    /// Columns, units and clock of its logs.
    pub log: LogFormat,
    /// Initial state of a filter that starts from a guess. Drawn by a campaign; not a key.
    pub initial_estimate: Option<InitialEstimate>,
}

/// Initial state of a filter. Its inertia need not be physical.
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

impl Craft {
    /// The craft in the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, has an unknown key, or a value outside the range of its key.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        Self::from_source(&TomlSource::read(path)?)
    }

    /// The craft in the text of a `CRAFT.toml`; `file` is the name in errors.
    ///
    /// # Errors
    /// As of [`Self::load`].
    pub fn from_toml(file: &str, text: &str) -> Result<Self, InputError> {
        Self::from_source(&TomlSource::new(file, text))
    }

    /// The text of a `CRAFT.toml` that reads back as this craft.
    ///
    /// Debug formatting is used throughout: the shortest decimal that reads back as the same number,
    /// and lists in the syntax of TOML.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for (index, wheel) in self.wheels.iter().enumerate() {
            wheel.write(&mut text, index, &self.hardware);
        }
        self.thrusters.iter().for_each(|thruster| thruster.write(&mut text));
        self.gyro.write(&mut text, &self.hardware);
        self.hardware.write_tables(&mut text);
        if let Some(prior) = &self.prior {
            prior.write(&mut text);
        }
        self.filter.write(&mut text);
        self.solve_for.write(&mut text, &self.hardware);
        self.log.write(&mut text);
        text
    }

    fn from_source(source: &TomlSource) -> Result<Self, InputError> {
        source.check_keys(&TABLES)?;
        source.read_all(|| Self::read(source))
    }

    fn read(source: &TomlSource) -> Result<Self, InputError> {
        let file: CraftFile = source.parse()?;
        let root = Section::root(source);
        check_count(&root, &file.wheel)?;
        let wheels: Vec<Wheel> = (file.wheel.iter().enumerate())
            .map(|(index, wheel)| wheel.get_ref().read(&root.entry("wheel", index)))
            .collect::<Result<_, _>>()?;
        let thrusters = (file.thruster.iter().enumerate())
            .map(|(index, thruster)| thruster.read(&root.entry("thruster", index)))
            .collect::<Result<_, _>>()?;
        let gyro = file.gyro.read(&root.table("gyro"))?;
        let prior = file.prior.map(|prior| prior.read(&root)).transpose()?;
        let filter = file.filter.read(&root)?;
        let DisturbanceFile { torque, gyro_bias, torque_sigma_n_m, varying_torque_sigma_n_m } =
            file.disturbance;
        let spin_inertias: Vec<f64> =
            wheels.iter().map(|wheel: &Wheel| wheel.spin_inertia_kg_m2).collect();
        let log = file.log.map(|log| log.read(&root, &spin_inertias)).transpose()?;
        let hardware = Statements {
            gyro: file.gyro.statements(),
            each_wheel: file.wheel.iter().map(|wheel| wheel.get_ref().statements()).collect(),
            wheels: file.wheels,
            torque_scale_sigma: file.torque.scale_sigma,
            torque_sigma_n_m,
            varying_torque_sigma_n_m,
            mount: file.mount,
            modes: file.mode,
        }
        .read(&root, Unstated::DataSheet)?;
        Ok(Self {
            wheels,
            thrusters,
            gyro,
            prior,
            filter,
            solve_for: SolveFor { torque, gyro_bias }.with_priors(&hardware),
            hardware,
            log: log.unwrap_or_default(),
            initial_estimate: None,
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CraftFile {
    #[serde(default)]
    wheel: Vec<Spanned<WheelFile>>,
    #[serde(default)]
    wheels: WheelsFile,
    #[serde(default)]
    thruster: Vec<ThrusterFile>,
    #[serde(default)]
    gyro: GyroFile,
    #[serde(default)]
    torque: TorqueScaleFile,
    #[serde(default)]
    mount: MountFile,
    #[serde(default)]
    mode: Vec<Spanned<ModeFile>>,
    prior: Option<PriorFile>,
    #[serde(default)]
    filter: FilterFile,
    #[serde(default)]
    disturbance: DisturbanceFile,
    log: Option<LogFile>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::craft::hardware::{Tachometer, TachometerKind};
    use crate::craft::{Mode, WheelLimits};
    use crate::error::Problem;

    fn message(text: &str) -> String {
        Craft::from_toml("craft.toml", text).unwrap_err().to_string()
    }

    /// Hardware with an error in every key.
    fn imperfect_hardware() -> StatedHardware {
        StatedHardware {
            gyro_scale: [0.01, 0.0, -0.02],
            gyro_axes_rad: [0.001, 0.0, 0.0, 0.002, 0.0, 0.0],
            gyro_scale_sigma: 0.003,
            gyro_axes_sigma_rad: 0.1f64.to_radians(),
            gyro_delay_s: 0.02,
            gyro_delay_sigma_s: 0.0,
            gyro_averaged: true,
            gyro_noise_tolerance: 0.2,
            bias_sigma_rad_s: None,
            bias_walk_rad_s_sqrt_s: 1e-6,
            bias_instability_rad_s: 5e-6,
            clock_sigma: 1e-4,
            wheel_spin_inertia_sigma: vec![0.02],
            wheel_axis_sigma_rad: vec![0.3f64.to_radians()],
            tachometers: vec![Tachometer {
                kind: TachometerKind::Period { resolution_s: 5e-7 },
                edges_per_turn: 24.0,
                quantum_rad_s: 0.1,
                hold_s: 1.0,
                latency_s: 0.01,
                noise_rad_s: 0.02,
            }],
            common_spin_inertia_sigma: 0.004,
            torque_scale_sigma: 0.1,
            torque_sigma_n_m: Some(1e-5),
            varying_torque_sigma_n_m: 2e-6,
            mount_sigma_rad: [0.0, 0.0, 2f64.to_radians()],
            modes: vec![Mode {
                frequency_hz: 0.5,
                damping: 0.01,
                frequency_sigma: 0.1,
                damping_sigma: 0.0,
            }],
            assumed: vec!["gyro.axes_sigma_deg", "gyro.noise_tolerance"],
        }
    }

    #[test]
    fn written_craft_reads_back_the_same() {
        let craft = Craft {
            wheels: vec![Wheel {
                name: Some("+x \"fast\"".to_owned()),
                axis: Vector3::new(1.0, 1.0, 1.0).normalize(),
                spin_inertia_kg_m2: 2.1e-5,
                limits: WheelLimits { max_torque_n_m: Some(1e-3), max_speed_rad_s: Some(680.0) },
            }],
            thrusters: vec![Thruster {
                torque_n_m: Vector3::new(0.02, 0.0, -1e-3),
                min_pulse_s: 0.05,
            }],
            gyro: GyroData {
                noise_rad_s: Some(1e-4),
                range_rad_s: None,
                quantum_rad_s: Some(1e-5),
            },
            hardware: imperfect_hardware(),
            prior: Some(Prior {
                inertia_kg_m2: [25.0, 25.0, 25.0, 2.0, 2.0, 2.0],
                sigma_kg_m2: [30.0, 30.0, 30.0, 10.0, 10.0, 10.0],
            }),
            filter: Filter {
                rate_walk_rad_s_sqrt_s: Some(1e-6),
                inertia_walk_kg_m2_sqrt_hour: Some(0.25),
                is_torque_smooth: true,
            },
            solve_for: SolveFor { torque: true, gyro_bias: true },
            log: LogFormat::default(),
            initial_estimate: None,
        };
        let again = Craft::from_toml("craft.toml", &craft.to_toml()).unwrap();
        assert!((again.wheels[0].axis - craft.wheels[0].axis).norm() < 1e-15);
        assert_eq!(again.wheels[0].name, craft.wheels[0].name);
        assert_eq!(again.thrusters, craft.thrusters);
        assert_eq!(
            (again.gyro, again.hardware, again.prior, again.filter, again.solve_for),
            (craft.gyro, craft.hardware, craft.prior, craft.filter, craft.solve_for)
        );
        let bare = Craft::default();
        assert_eq!(Craft::from_toml("craft.toml", &bare.to_toml()).unwrap(), bare);
    }

    #[test]
    fn empty_file_is_a_craft_without_wheels() {
        let craft = Craft::from_toml("craft.toml", "").unwrap();
        assert_eq!(craft, Craft { hardware: craft.hardware.clone(), ..Craft::default() });
    }

    #[test]
    fn absent_errors_are_assumed_and_present_ones_are_not() {
        let wheel = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n";
        let read = |text: &str| Craft::from_toml("craft.toml", text).unwrap().hardware;
        let bare = read(wheel);
        // All but those of a mode, which the craft does not state.
        let rows = hardware::DATA_SHEET.iter().map(|row| row.path);
        let of_a_rigid_body: Vec<_> = rows.filter(|path| !path.starts_with("mode.")).collect();
        assert_eq!(bare.assumed, of_a_rigid_body);
        let mode = read("[[mode]]\nfrequency_hz = 0.5\ndamping = 0.01\n");
        assert_eq!(mode.modes[0].frequency_sigma, 0.05);
        assert!(mode.assumed.contains(&"mode.frequency_sigma"));
        assert_eq!((bare.gyro_scale_sigma, bare.torque_scale_sigma), (0.005, 0.05));
        assert_eq!(bare.wheel_axis_sigma_rad, [0.2f64.to_radians()]);
        assert!(!bare.is_ideal() && read("").wheel_spin_inertia_sigma.is_empty());

        let own = format!("{wheel}spin_inertia_sigma = 0.03\n{wheel}");
        let stated = "[wheels]\nspin_inertia_sigma = 0\n[gyro]\nscale_sigma = 0\n\
                      bias_sigma_rad_s = 0.02\n";
        let stated = Craft::from_toml("craft.toml", &format!("{own}{stated}")).unwrap();
        assert_eq!(stated.hardware.wheel_spin_inertia_sigma, [0.03, 0.0]);
        assert_eq!(stated.hardware.gyro_scale_sigma, 0.0);
        assert_eq!(stated.solve_for, SolveFor { torque: false, gyro_bias: true });
        assert!(!stated.hardware.assumed.contains(&"gyro.scale_sigma"));
        assert!(!stated.hardware.assumed.contains(&"wheel.spin_inertia_sigma"));
    }

    #[test]
    fn each_bad_error_is_reported() {
        for (text, expected) in [
            (
                "[gyro]\nscale_sigma = -1",
                "`gyro.scale_sigma` is -1; it must be zero or positive, at",
            ),
            ("[gyro]\naxes_deg = [1]", "`gyro.axes_deg` has 1 entries, but takes 6"),
            ("[gyro]\nscale = [0, 0, 0.6]", "`gyro.scale` is [0, 0, 0.6]; it must be above -0.5"),
            ("[gyro]\ndelay_sigma_s = nan", "`gyro.delay_sigma_s` is NaN; it must be zero or"),
            ("[wheels]\naxis_sigma_deg = 11", "`wheels.axis_sigma_deg` is 11; it must be zero or"),
            ("[torque]\nscale = 1", "unknown key `scale` (did you mean `scale_sigma`?)"),
            ("[disturbance]\ntorque_sigma_n_m = 0", "`disturbance.torque_sigma_n_m` is 0; it must"),
            ("[[mode]]\ndamping = 0.1", "missing key `frequency_hz`"),
            ("[[mode]]\nfrequency_hz = 1\ndamping = 1", "`mode[1].damping` is 1; it must be zero"),
        ] {
            let message = message(text);
            assert!(message.contains(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn documented_example_is_read() {
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
    fn zero_axis_is_reported_with_key_and_line() {
        let wheel = "[[wheel]]\nspin_inertia_kg_m2 = 1e-3\naxis =";
        assert_eq!(
            message(&format!("{wheel} [1, 0, 0]\n{wheel} [0, 0, 0]\n")),
            "craft.toml:6: `wheel[2].axis` is [0, 0, 0]; it must be finite, with at least \
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
    fn unphysical_prior_is_rejected() {
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
        assert!(message.ends_with("it must be positive and finite"), "{message}");
    }

    #[test]
    fn ninth_wheel_is_rejected_with_the_limit() {
        let text = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n".repeat(9);
        assert_eq!(
            message(&text),
            "craft.toml:25: 9 [[wheel]] tables, but at most 8 are supported; remove some"
        );
    }

    #[test]
    fn all_faults_of_a_file_are_reported_at_once() {
        assert_eq!(
            message("[[wheel]]\naxs = [1, 0, 0]\nspin_inertia_kg_m2 = 1\n[gyros]\n[gyro]\nnoise = 1\n"),
            "craft.toml:2: unknown key `axs` (did you mean `axis`?); known keys here: name, axis, \
             spin_inertia_kg_m2, max_torque_n_m, max_speed_rad_s, spin_inertia_sigma, \
             axis_sigma_deg, tachometer\n\
             error: craft.toml:4: unknown key `gyros` (did you mean `gyro`?); known keys here: wheel, \
             wheels, thruster, gyro, torque, mount, mode, prior, filter, disturbance, log\n\
             error: craft.toml:6: unknown key `noise` (did you mean `noise_rad_s`?); known keys here: "
                .to_owned()
                + &gyro::TABLE.names().join(", ")
        );
        let values = "[[wheel]]\naxis = [0, 0, 0]\nspin_inertia_kg_m2 = -1\n[gyro]\nnoise_rad_s = 0\n\
                      axes_deg = [20, 0]\n[prior]\ninertia_kg_m2 = [1, 1, 3, 0, 0, 0]\n\
                      sigma_kg_m2 = [1, 1, 1, 1, 1, 0]\n";
        let message = message(values);
        let lines: Vec<&str> = message.split("\nerror: ").collect();
        for (index, line) in [2, 3, 5, 6, 6, 8, 9].iter().enumerate() {
            assert!(lines[index].starts_with(&format!("craft.toml:{line}: ")), "{message}");
        }
        assert_eq!(lines.len(), 7, "{message}");
    }

    #[test]
    fn unknown_keys_are_rejected_in_every_table() {
        assert!(message("gyros = 1").contains("did you mean `gyro`?"));
        assert!(message("[gyro]\nnoise = 1").contains("did you mean `noise_rad_s`?"));
        assert!(message("[prior]\ninertia = []").contains("did you mean `inertia_kg_m2`?"));
        assert!(message("[disturbance]\ntorqe = true").contains("did you mean `torque`?"));
        assert!(message("[[wheel]]\naxes = []").contains("did you mean `axis`?"));
    }

    #[test]
    fn every_key_of_the_reader_has_a_row_in_the_reference() {
        for table in TABLES {
            // A table of a wheel follows its wheel.
            let above = if table.header.starts_with("[wheel.") { "[[wheel]]\n" } else { "" };
            let text = format!("{above}{}\nxyzzy = 1", table.header);
            let source = TomlSource::new("craft.toml", &text);
            let problem = source.parse::<CraftFile>().err().unwrap().problem;
            let Problem::UnknownKey { known, .. } = problem else { panic!("{problem}") };
            assert_eq!(known, table.names(), "{}", table.header);
        }
    }
}
