//! From a profile as written to a [`TorqueProfile`] or an [`ExternalTorque`].

use std::path::Path;

use flight_input::InputError;
use flight_input::craft::hardware::TORQUE_SCALE_SIGMA;
use flight_input::key::Key;
use flight_input::section::{List, Section};
use toml::Spanned;

use super::super::limits::MAX_SAMPLES;
use super::super::problem::ScenarioProblem;
use super::csv_table::table;
use super::keys::{
    AMPLITUDE, DURING, ExternalProfileFile, FREQUENCY, PHASE, POINT, POINTS, Parts, ProfileFile,
    SWEEP, VALUE, WheelProfileFile,
};
use super::lists::{Axis, SineLists, intervals_s};
use super::torque::{ExternalTorque, TorqueProfile};

/// Number of external axes.
const AXES: usize = 3;
/// An external axis in errors.
const SUFFIXES: [&str; AXES] = ["[1]", "[2]", "[3]"];

/// The folder of the CSV tables, and the duration of the flight, s.
#[derive(Clone, Copy)]
pub(in super::super) struct Surroundings<'a> {
    pub folder: &'a Path,
    pub duration_s: f64,
}

/// The checked profile of a wheel's motor.
pub(in super::super) fn wheel_profile(
    section: &Section<'_>,
    file: &WheelProfileFile,
    surroundings: Surroundings<'_>,
) -> Result<TorqueProfile, InputError> {
    if let Some(sigma) = &file.get_ref().scale_sigma {
        let key = section.full(&TORQUE_SCALE_SIGMA);
        return Err(section.error(sigma, ScenarioProblem::KeyOfExternalTorque { key }));
    }
    let axis = Axis { section, suffix: "" };
    let profile = match Parts::of(section, file)? {
        Parts::Constant(value) => {
            TorqueProfile::Constant { value_n_m: section.number(&VALUE, value)? }
        }
        Parts::Multisine { amplitude, frequency, phase, sweep } => {
            axis.multisine(&SineLists { amplitude, frequency, phase, sweep })?
        }
        Parts::Table(csv) => {
            let [profile] = table(&surroundings.folder.join(csv.get_ref()), ["x"])?;
            profile
        }
        Parts::Points { time, value } => axis.points(time, value)?,
    };
    let [profile] = when(section, file.get_ref(), surroundings, [profile])?;
    Ok(profile)
}

/// The checked profile of the external torque.
pub(in super::super) fn external_profile(
    section: &Section<'_>,
    file: &ExternalProfileFile,
    surroundings: Surroundings<'_>,
) -> Result<ExternalTorque, InputError> {
    let axes = match Parts::of(section, file)? {
        Parts::Constant(value) => section
            .list::<AXES>(&VALUE, value)?
            .map(|value_n_m| TorqueProfile::Constant { value_n_m }),
        Parts::Multisine { amplitude, frequency, phase, sweep } => {
            multisines(section, amplitude, frequency, phase, sweep)?
        }
        Parts::Table(csv) => table(&surroundings.folder.join(csv.get_ref()), ["x", "y", "z"])?,
        Parts::Points { time, value } => {
            let value = three(section, &POINT, value)?;
            each_axis(section, |axis, i| axis.points(time, &value[i]))?
        }
    };
    Ok(ExternalTorque {
        axes: when(section, file.get_ref(), surroundings, axes)?,
        thrusters: Vec::new(),
    })
}

fn multisines(
    section: &Section<'_>,
    amplitude: &Spanned<Vec<List>>,
    frequency: &Spanned<Vec<List>>,
    phase: &Spanned<Vec<List>>,
    sweep: Option<&Spanned<Vec<List>>>,
) -> Result<[TorqueProfile; AXES], InputError> {
    let amplitude = three(section, &AMPLITUDE, amplitude)?;
    let frequency = three(section, &FREQUENCY, frequency)?;
    let phase = three(section, &PHASE, phase)?;
    let sweep = sweep.map(|sweep| three(section, &SWEEP, sweep)).transpose()?;
    each_axis(section, |axis, i| {
        axis.multisine(&SineLists {
            amplitude: &amplitude[i],
            frequency: &frequency[i],
            phase: &phase[i],
            sweep: sweep.as_ref().map(|sweep| &sweep[i]),
        })
    })
}

fn three(
    section: &Section<'_>,
    key: &Key,
    lists: &Spanned<Vec<List>>,
) -> Result<[List; AXES], InputError> {
    section.length(key, lists)
}

fn each_axis(
    section: &Section<'_>,
    profile: impl Fn(&Axis<'_>, usize) -> Result<TorqueProfile, InputError>,
) -> Result<[TorqueProfile; AXES], InputError> {
    let axis = |i: usize| profile(&Axis { section, suffix: SUFFIXES[i] }, i);
    Ok([axis(0)?, axis(1)?, axis(2)?])
}

/// The profiles at the points of `points_hz` and in the intervals of `during_s`, where present.
fn when<Value, Lists, const N: usize>(
    section: &Section<'_>,
    file: &ProfileFile<Value, Lists>,
    surroundings: Surroundings<'_>,
    mut profiles: [TorqueProfile; N],
) -> Result<[TorqueProfile; N], InputError> {
    if let Some(points_hz) = &file.points_hz {
        let duration_s = surroundings.duration_s;
        let rate_hz =
            section.number_if(&POINTS, points_hz, |rate_hz| rate_hz * duration_s <= MAX_SAMPLES)?;
        profiles = profiles.map(|profile| profile.in_points(rate_hz, duration_s));
    }
    if let Some(during_s) = &file.during_s {
        let intervals_s = intervals_s(section, &DURING, during_s)?;
        profiles = profiles.map(|profile| TorqueProfile::During {
            intervals_s: intervals_s.clone(),
            profile: Box::new(profile),
        });
    }
    Ok(profiles)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::input::Scenario;

    const BODY: &str = "name = 'test'
duration_s = 60
                        spacecraft = { inertia_kg_m2 = [3, 4, 5, 0, 0, 0] }
                        gyro = { rate_hz = 10, noise_rad_s = 1e-4 }
";

    fn with_wheel(torque: &str) -> String {
        format!("{BODY}[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\ntorque = {torque}\n")
    }

    fn with_torque(torque: &str) -> String {
        format!("{BODY}[torque]\n{torque}\n")
    }

    fn parse(text: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", text, Path::new(""))
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    /// A scenario with an external torque from a file `torque.csv` of this text.
    fn with_table(csv: &str) -> Result<Scenario, InputError> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("torque.csv"), csv).unwrap();
        let path = folder.path().join("scenario.toml");
        fs::write(&path, with_torque("kind = 'table'\ncsv = 'torque.csv'")).unwrap();
        Scenario::load(&path.display().to_string())
    }

    #[test]
    fn constant_is_read() {
        let wheel = parse(&with_wheel("{ kind = 'constant', value_n_m = 1e-3 }")).unwrap();
        assert_eq!(wheel.wheels[0].torque.at(7.0), 1e-3);
        let external = parse(&with_torque("kind = 'constant'\nvalue_n_m = [1, 2, 3]")).unwrap();
        assert_eq!(external.torque.at(7.0).as_slice(), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn multisine_is_read() {
        let lists = "{ kind = 'multisine', amplitude_n_m = [1, 2], frequency_hz = [0.25, 5], \
                     phase_rad = [0, 0] }";
        let wheel = parse(&with_wheel(lists)).unwrap();
        assert!((wheel.wheels[0].torque.at(1.0) - 1.0).abs() < 1e-12);

        let lists = "kind = 'multisine'\namplitude_n_m = [[1], [], [2, 3]]\n\
                     frequency_hz = [[0.25], [], [0.25, 1]]\nphase_rad = [[0], [], [0, 0]]";
        let torque = parse(&with_torque(lists)).unwrap().torque;
        assert!((torque.at(1.0) - nalgebra::Vector3::new(1.0, 0.0, 2.0)).norm() < 1e-12);
    }

    #[test]
    fn chirps_are_read_and_commanded_in_points() {
        let lists = "kind = 'multisine'\npoints_hz = 10\namplitude_n_m = [[2], [], []]\n\
                     frequency_hz = [[0.25], [], []]\nsweep_hz_s = [[0.5], [], []]\n\
                     phase_rad = [[0], [], []]";
        let torque = parse(&with_torque(lists)).unwrap().torque;
        assert!((torque.at(1.0) - nalgebra::Vector3::new(-2.0, 0.0, 0.0)).norm() < 1e-12);
        assert_eq!(torque.breakpoints_s().len(), 601);
        let middle = (torque.at(1.0) + torque.at(1.1)) / 2.0;
        assert!((torque.at(1.05) - middle).norm() < 1e-12);
    }

    #[test]
    fn points_are_read() {
        let points = "{ kind = 'points', time_s = [0, 10], point_n_m = [0, 10] }";
        assert_eq!(parse(&with_wheel(points)).unwrap().wheels[0].torque.at(5.0), 5.0);
        let points = "kind = 'points'\ntime_s = [0, 10]\npoint_n_m = [[0, 10], [1, 1], [2, 2]]";
        let torque = parse(&with_torque(points)).unwrap().torque;
        assert_eq!(torque.at(5.0).as_slice(), [5.0, 1.0, 2.0]);
    }

    #[test]
    fn any_kind_may_act_in_intervals() {
        let wheel = "{ kind = 'constant', value_n_m = 1, during_s = [[1, 2], [2, 4], [7, 9]] }";
        let torque = &parse(&with_wheel(wheel)).unwrap().wheels[0].torque;
        assert_eq!([0.5, 1.0, 3.0, 4.0, 8.0].map(|t| torque.at(t)), [0.0, 1.0, 1.0, 0.0, 1.0]);
        let external = "kind = 'constant'\nvalue_n_m = [1, 2, 3]\nduring_s = [[1, 2]]";
        let torque = parse(&with_torque(external)).unwrap().torque;
        assert_eq!((torque.at(0.5).norm(), torque.at(1.5).as_slice()), (0.0, &[1.0, 2.0, 3.0][..]));
        assert_eq!(torque.breakpoints_s(), [1.0, 2.0]);
    }

    #[test]
    fn intervals_out_of_order_are_rejected() {
        for during in ["[]", "[[1]]", "[[1, 2, 3]]", "[[2, 1]]", "[[1, 1]]", "[[1, 3], [2, 4]]"] {
            let wheel = format!("{{ kind = 'constant', value_n_m = 1, during_s = {during} }}");
            let message = message(&with_wheel(&wheel));
            let expected = format!("s.toml:8: `wheel[1].torque.during_s` is {during}; it must be");
            assert!(message.starts_with(&expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn table_is_read_from_the_folder_of_the_scenario() {
        let scenario = with_table("t_s,x,y,z\n0,0,1,2\n10,10,1,2\n").unwrap();
        assert_eq!(scenario.torque.at(5.0).as_slice(), [5.0, 1.0, 2.0]);
        assert_eq!(scenario.torque.breakpoints_s(), [0.0, 10.0]);
    }

    #[test]
    fn bad_table_is_reported_with_its_line() {
        for (csv, expected) in [
            ("t_s,x,y\n0,0,0\n", "torque.csv:1: no column `z`"),
            ("t_s,x,y,z\n0,0,0,0\n0,0,0,0\n", "torque.csv:3: column `t_s`: 0 appears twice"),
            ("t_s,x,y,z\n1,0,0,0\n0,0,0,0\n", "torque.csv:3: column `t_s`: time runs backwards"),
            ("t_s,x,y,z\n1,0,a,0\n", "torque.csv:2: column `y`: \"a\" is not a number"),
            ("t_s,x,y,z\n", "torque.csv: no row follows the header"),
        ] {
            let message = with_table(csv).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\n  expected: {expected}");
        }
        let message = message(&with_torque("kind = 'table'\ncsv = 'no/such.csv'"));
        assert!(message.starts_with("no/such.csv: cannot be read: "), "{message}");
    }

    #[test]
    fn bad_profile_of_a_wheel_is_reported() {
        for (torque, expected) in [
            ("{ value_n_m = 1 }", "s.toml:8: missing key `kind`"),
            ("{ kind = 'constant' }", "s.toml:8: missing key `wheel[1].torque.value_n_m`"),
            ("{ kind = 'sine' }", "s.toml:8: unknown word \"sine\" (did you mean `multisine`?)"),
            ("{ kind = 'constant', value = 1 }", "s.toml:8: unknown key `value` (did you mean `v"),
            (
                "{ kind = 'constant', value_n_m = inf }",
                "s.toml:8: `wheel[1].torque.value_n_m` is inf; it must be finite",
            ),
            (
                "{ kind = 'constant', value_n_m = 1, csv = 'x' }",
                "s.toml:8: `wheel[1].torque.csv` does not belong to kind = \"constant\", which \
                 takes: value_n_m; remove it",
            ),
            (
                "{ kind = 'multisine', amplitude_n_m = [1], frequency_hz = [1, 2], phase_rad = [0] }",
                "s.toml:8: `wheel[1].torque.frequency_hz` has 2 entries, but \
                 `wheel[1].torque.amplitude_n_m` has 1",
            ),
            (
                "{ kind = 'multisine', amplitude_n_m = [1], frequency_hz = [nan], phase_rad = [0] }",
                "s.toml:8: `wheel[1].torque.frequency_hz` is [NaN]; it must be finite",
            ),
        ] {
            let message = message(&with_wheel(torque));
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn bad_profile_of_the_external_torque_is_reported() {
        for (torque, expected) in [
            ("kind = 'constant'\nvalue_n_m = [1, 2]", "s.toml:7: `torque.value_n_m` has 2 entries"),
            ("kind = 'constant'", "s.toml:5: missing key `torque.value_n_m`"),
            (
                "kind = 'points'\ntime_s = [0, 0]\npoint_n_m = [[1, 1], [1, 1], [1, 1]]",
                "s.toml:7: `torque.time_s` is [0, 0]; it must be finite times, each later",
            ),
            (
                "kind = 'points'\ntime_s = [0, 1]\npoint_n_m = [[1, 1], [1], [1, 1]]",
                "s.toml:8: `torque.point_n_m[2]` has 1 entries, but `torque.time_s` has 2",
            ),
            (
                "kind = 'constant'\nvalue_n_m = [1, 1, 1]\npoints_hz = 10",
                "s.toml:8: `torque.points_hz` does not belong to kind = \"constant\"",
            ),
            (
                "kind = 'multisine'\npoints_hz = 1e9\namplitude_n_m = [[], [], []]\n\
                 frequency_hz = [[], [], []]\nphase_rad = [[], [], []]",
                "s.toml:7: `torque.points_hz` is 1000000000; it must be positive, and give at most",
            ),
            (
                "kind = 'multisine'\namplitude_n_m = [[1], [1]]\nfrequency_hz = []\nphase_rad = []",
                "s.toml:7: `torque.amplitude_n_m` has 2 entries, but takes 3",
            ),
            (
                "kind = 'multisine'\namplitude_n_m = [[1], [1], [1]]\n\
                 frequency_hz = [[1], [1], [1]]\nphase_rad = [[0], [], [0]]",
                "s.toml:9: `torque.phase_rad[2]` has 0 entries, but `torque.amplitude_n_m[2]` has 1",
            ),
        ] {
            let message = message(&with_torque(torque));
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }
}
