//! Torque profiles as a scenario file writes them, and their checks.
//!
//! | `kind` | keys of a wheel's profile | keys of the external torque's profile |
//! |---|---|---|
//! | `"constant"` | `value_n_m` = number | `value_n_m` = list of 3 |
//! | `"multisine"` | `amplitude_n_m`, `frequency_hz`, `phase_rad` = lists of one length | lists of 3 such lists |
//! | and if wanted | `sweep_hz_s` = list of that length (chirps) | list of 3 such lists |
//! | | `points_hz` = number: commanded so often, straight lines in between | the same |
//! | `"table"` | `csv` = file with columns `t_s`, `x` | `csv` = file with columns `t_s`, `x`, `y`, `z` |
//! | `"points"` | `time_s`, `point_n_m` = lists of one length | `point_n_m` = list of 3 such lists |
//!
//! Between the rows of a table, and between points, torque runs in straight lines.
//!
//! Any of them may have `during_s` = list of `[start, end]`: it then acts only during these, its own
//! time counted from each start, and is zero in between.
//!
//! The keys of all kinds are fields of one struct, rather than variants of an enum tagged by
//! `kind`: serde forgets the line numbers inside such an enum.

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::super::check::Check;
use super::super::csv_source::CsvSource;
use super::super::error::{CsvProblem, InputError, Problem, numbers};
use super::{ExternalTorque, MAX_SAMPLES, Sine, TorqueProfile};

/// A list of numbers that knows where it stands.
type List = Spanned<Vec<f64>>;
/// A wheel's profile.
pub(super) type WheelProfileFile = Spanned<ProfileFile<f64, Vec<f64>>>;
/// The external torque's profile.
pub(super) type ExternalProfileFile = Spanned<ProfileFile<Vec<f64>, Vec<List>>>;

/// A profile whose constant is a `Value`, and whose amplitudes, frequencies and phases are `Lists`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProfileFile<Value, Lists> {
    kind: Kind,
    value_n_m: Option<Spanned<Value>>,
    amplitude_n_m: Option<Spanned<Lists>>,
    frequency_hz: Option<Spanned<Lists>>,
    phase_rad: Option<Spanned<Lists>>,
    sweep_hz_s: Option<Spanned<Lists>>,
    points_hz: Option<Spanned<f64>>,
    csv: Option<Spanned<String>>,
    time_s: Option<List>,
    point_n_m: Option<Spanned<Lists>>,
    during_s: Option<Spanned<Vec<Vec<f64>>>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Constant,
    Multisine,
    Table,
    Points,
}

/// A profile with the keys that its kind takes, and no others.
enum Parts<'a, Value, Lists> {
    Constant(&'a Spanned<Value>),
    Multisine {
        amplitude: &'a Spanned<Lists>,
        frequency: &'a Spanned<Lists>,
        phase: &'a Spanned<Lists>,
        sweep: Option<&'a Spanned<Lists>>,
    },
    Table(&'a Spanned<String>),
    Points {
        time: &'a List,
        value: &'a Spanned<Lists>,
    },
}

/// Where profiles are read: beside which tables, and how long the scenario lasts.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub folder: &'a Path,
    pub duration_s: f64,
}

/// The lists of one sum of sines.
struct SineLists<'a> {
    amplitude: &'a List,
    frequency: &'a List,
    phase: &'a List,
    sweep: Option<&'a List>,
}

/// Reads and checks the profile of a wheel's motor; `key` is the profile's.
pub(super) fn wheel_profile(
    check: &Check<'_>,
    key: &str,
    file: &WheelProfileFile,
    surroundings: Surroundings<'_>,
) -> Result<TorqueProfile, InputError> {
    let profile = match parts(check, key, file)? {
        Parts::Constant(value) => {
            let value_n_m = check.finite(&format!("{key}.value_n_m"), value)?;
            TorqueProfile::Constant { value_n_m }
        }
        Parts::Multisine { amplitude, frequency, phase, sweep } => {
            multisine(check, key, "", SineLists { amplitude, frequency, phase, sweep })?
        }
        Parts::Table(csv) => {
            let [profile] = table(surroundings.folder, csv, ["x"])?;
            profile
        }
        Parts::Points { time, value } => points(check, key, "", time, value)?,
    };
    let profile = in_points(check, key, file.get_ref(), surroundings, profile)?;
    Ok(match intervals_s(check, key, file)? {
        Some(intervals_s) => during(intervals_s, profile),
        None => profile,
    })
}

/// Reads and checks the profile of the external torque.
pub(super) fn external_profile(
    check: &Check<'_>,
    file: &ExternalProfileFile,
    surroundings: Surroundings<'_>,
) -> Result<ExternalTorque, InputError> {
    const KEY: &str = "torque";
    const AXES: [&str; 3] = ["[1]", "[2]", "[3]"];
    let three = |key: &str, lists| check.length::<List, 3>(&format!("{KEY}.{key}"), lists);
    let axes = match parts(check, KEY, file)? {
        Parts::Constant(value) => check
            .list::<3>("torque.value_n_m", value)?
            .map(|value_n_m| TorqueProfile::Constant { value_n_m }),
        Parts::Multisine { amplitude, frequency, phase, sweep } => {
            let amplitude = three("amplitude_n_m", amplitude)?;
            let frequency = three("frequency_hz", frequency)?;
            let phase = three("phase_rad", phase)?;
            let sweep = sweep.map(|sweep| three("sweep_hz_s", sweep)).transpose()?;
            let axis = |i: usize| {
                let lists = SineLists {
                    amplitude: &amplitude[i],
                    frequency: &frequency[i],
                    phase: &phase[i],
                    sweep: sweep.as_ref().map(|sweep| &sweep[i]),
                };
                multisine(check, KEY, AXES[i], lists)
            };
            [axis(0)?, axis(1)?, axis(2)?]
        }
        Parts::Table(csv) => table(surroundings.folder, csv, ["x", "y", "z"])?,
        Parts::Points { time, value } => {
            let value = three("point_n_m", value)?;
            let axis = |i: usize| points(check, KEY, AXES[i], time, &value[i]);
            [axis(0)?, axis(1)?, axis(2)?]
        }
    };
    let [x, y, z] = axes.map(|axis| in_points(check, KEY, file.get_ref(), surroundings, axis));
    let axes = [x?, y?, z?];
    Ok(match intervals_s(check, KEY, file)? {
        Some(intervals_s) => {
            ExternalTorque { axes: axes.map(|profile| during(intervals_s.clone(), profile)) }
        }
        None => ExternalTorque { axes },
    })
}

fn during(intervals_s: Vec<[f64; 2]>, profile: TorqueProfile) -> TorqueProfile {
    TorqueProfile::During { intervals_s, profile: Box::new(profile) }
}

/// When a profile acts, if not always.
fn intervals_s<Value, Lists>(
    check: &Check<'_>,
    key: &str,
    file: &Spanned<ProfileFile<Value, Lists>>,
) -> Result<Option<Vec<[f64; 2]>>, InputError> {
    let Some(during_s) = &file.get_ref().during_s else { return Ok(None) };
    let lists = during_s.get_ref();
    let pairs: Option<Vec<[f64; 2]>> =
        lists.iter().map(|list| <[f64; 2]>::try_from(list.as_slice()).ok()).collect();
    let times: Vec<f64> = lists.concat();
    let are_in_order = times.iter().all(|time_s| time_s.is_finite())
        && lists.iter().all(|list| list.is_sorted_by(|a, b| a < b))
        && times.is_sorted();
    match pairs {
        Some(pairs) if are_in_order && !pairs.is_empty() => Ok(Some(pairs)),
        _ => {
            let found: Vec<String> = lists.iter().map(|list| numbers(list)).collect();
            let problem = Problem::BadValue {
                key: format!("{key}.during_s"),
                found: format!("[{}]", found.join(", ")),
                required: "one or more [start, end], each after the one before",
            };
            Err(check.error(during_s, problem))
        }
    }
}

/// Sees that the keys of the profile's kind are there, and only those.
fn parts<'a, Value, Lists>(
    check: &Check<'_>,
    key: &str,
    spanned: &'a Spanned<ProfileFile<Value, Lists>>,
) -> Result<Parts<'a, Value, Lists>, InputError> {
    let file = spanned.get_ref();
    let (kind, takes): (_, &'static [&'static str]) = match file.kind {
        Kind::Constant => ("constant", &["value_n_m"]),
        Kind::Multisine => (
            "multisine",
            &["amplitude_n_m", "frequency_hz", "phase_rad", "sweep_hz_s", "points_hz"],
        ),
        Kind::Table => ("table", &["csv"]),
        Kind::Points => ("points", &["time_s", "point_n_m"]),
    };
    let present = [
        ("value_n_m", file.value_n_m.as_ref().map(Spanned::span)),
        ("amplitude_n_m", file.amplitude_n_m.as_ref().map(Spanned::span)),
        ("frequency_hz", file.frequency_hz.as_ref().map(Spanned::span)),
        ("phase_rad", file.phase_rad.as_ref().map(Spanned::span)),
        ("sweep_hz_s", file.sweep_hz_s.as_ref().map(Spanned::span)),
        ("points_hz", file.points_hz.as_ref().map(Spanned::span)),
        ("csv", file.csv.as_ref().map(Spanned::span)),
        ("time_s", file.time_s.as_ref().map(Spanned::span)),
        ("point_n_m", file.point_n_m.as_ref().map(Spanned::span)),
    ];
    for (name, span) in present {
        if let Some(span) = span
            && !takes.contains(&name)
        {
            let key = format!("{key}.{name}");
            return Err(check.error_at(span, Problem::KeyOfOtherKind { key, kind, takes }));
        }
    }
    let missing =
        |name: &str| check.error(spanned, Problem::MissingKey { key: format!("{key}.{name}") });
    Ok(match file.kind {
        Kind::Constant => {
            Parts::Constant(file.value_n_m.as_ref().ok_or_else(|| missing("value_n_m"))?)
        }
        Kind::Multisine => Parts::Multisine {
            amplitude: file.amplitude_n_m.as_ref().ok_or_else(|| missing("amplitude_n_m"))?,
            frequency: file.frequency_hz.as_ref().ok_or_else(|| missing("frequency_hz"))?,
            phase: file.phase_rad.as_ref().ok_or_else(|| missing("phase_rad"))?,
            sweep: file.sweep_hz_s.as_ref(),
        },
        Kind::Table => Parts::Table(file.csv.as_ref().ok_or_else(|| missing("csv"))?),
        Kind::Points => Parts::Points {
            time: file.time_s.as_ref().ok_or_else(|| missing("time_s"))?,
            value: file.point_n_m.as_ref().ok_or_else(|| missing("point_n_m"))?,
        },
    })
}

/// The sum of sines of the profile `key`; `axis` is empty or, as `[1]`, says which of three lists.
fn multisine(
    check: &Check<'_>,
    key: &str,
    axis: &str,
    lists: SineLists<'_>,
) -> Result<TorqueProfile, InputError> {
    let SineLists { amplitude, frequency, phase, sweep } = lists;
    let amplitude_key = format!("{key}.amplitude_n_m{axis}");
    let count = amplitude.get_ref().len();
    finite(check, &amplitude_key, amplitude)?;
    for (name, list) in
        [("frequency_hz", Some(frequency)), ("phase_rad", Some(phase)), ("sweep_hz_s", sweep)]
    {
        if let Some(list) = list {
            let key = format!("{key}.{name}{axis}");
            finite(check, &key, list)?;
            equally_long(check, key, list, &amplitude_key, count)?;
        }
    }
    let term = |i: usize| Sine {
        amplitude_n_m: amplitude.get_ref()[i],
        frequency_hz: frequency.get_ref()[i],
        sweep_hz_s: sweep.map_or(0.0, |sweep| sweep.get_ref()[i]),
        phase_rad: phase.get_ref()[i],
    };
    Ok(TorqueProfile::Multisine { terms: (0..count).map(term).collect() })
}

/// Straight lines between the points of the profile `key`.
fn points(
    check: &Check<'_>,
    key: &str,
    axis: &str,
    time: &List,
    value: &List,
) -> Result<TorqueProfile, InputError> {
    let (time_key, value_key) = (format!("{key}.time_s"), format!("{key}.point_n_m{axis}"));
    let time_s = time.get_ref();
    let ascends = time_s.windows(2).all(|pair| pair[0] < pair[1]);
    if time_s.is_empty() || !ascends || time_s.iter().any(|t| !t.is_finite()) {
        return Err(check.bad_list(
            &time_key,
            time,
            "finite times, each later than the one before",
        ));
    }
    finite(check, &value_key, value)?;
    equally_long(check, value_key, value, &time_key, time_s.len())?;
    Ok(TorqueProfile::Table { time_s: time_s.clone(), value_n_m: value.get_ref().clone() })
}

fn finite(check: &Check<'_>, key: &str, list: &List) -> Result<(), InputError> {
    match list.get_ref().iter().all(|number| number.is_finite()) {
        true => Ok(()),
        false => Err(check.bad_list(key, list, "finite numbers")),
    }
}

fn equally_long(
    check: &Check<'_>,
    key: String,
    list: &List,
    other: &str,
    required: usize,
) -> Result<(), InputError> {
    let found = list.get_ref().len();
    if found == required {
        return Ok(());
    }
    let other = other.to_owned();
    Err(check.error(list, Problem::UnequalLengths { key, found, other, required }))
}

/// The profile as it is commanded at the points that the file asks for, if it does.
fn in_points<Value, Lists>(
    check: &Check<'_>,
    key: &str,
    file: &ProfileFile<Value, Lists>,
    surroundings: Surroundings<'_>,
    profile: TorqueProfile,
) -> Result<TorqueProfile, InputError> {
    let Some(rate_hz) = &file.points_hz else { return Ok(profile) };
    let duration_s = surroundings.duration_s;
    let required = "positive, and give at most 1e7 points over `duration_s`";
    let rate_hz = check.number(&format!("{key}.points_hz"), rate_hz, required, |rate| {
        rate > 0.0 && rate * duration_s <= MAX_SAMPLES
    })?;
    Ok(profile.in_points(rate_hz, duration_s))
}

/// Reads one profile per column of the CSV file that `csv` names, all over column `t_s`.
fn table<const N: usize>(
    folder: &Path,
    csv: &Spanned<String>,
    columns: [&str; N],
) -> Result<[TorqueProfile; N], InputError> {
    let source = CsvSource::read(&folder.join(csv.get_ref()))?;
    let time_s = strictly_increasing_times(&source)?;
    let mut profiles = [TorqueProfile::ZERO; N];
    for (profile, name) in profiles.iter_mut().zip(columns) {
        let column = source.column(name, |other| other == "t_s" || columns.contains(&other))?;
        let value_n_m = (source.rows().iter())
            .map(|row| source.number(row, &column))
            .collect::<Result<_, _>>()?;
        *profile = TorqueProfile::Table { time_s: time_s.clone(), value_n_m };
    }
    Ok(profiles)
}

fn strictly_increasing_times(source: &CsvSource) -> Result<Vec<f64>, InputError> {
    let column = source.column("t_s", |other| ["x", "y", "z"].contains(&other))?;
    let mut times: Vec<f64> = Vec::with_capacity(source.rows().len());
    for row in source.rows() {
        let time = source.number(row, &column)?;
        if let Some(&previous) = times.last()
            && time <= previous
        {
            let problem = if time < previous {
                CsvProblem::TimeBackwards { time: time.to_string(), previous: previous.to_string() }
            } else {
                CsvProblem::DuplicateTime { time: time.to_string() }
            };
            return Err(source.error(Some(row.line), problem));
        }
        times.push(time);
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::Scenario;
    use super::*;

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

    /// The scenario with an external torque from a table of this text, in a file `torque.csv`.
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
    fn any_kind_may_act_now_and_then() {
        let wheel = "{ kind = 'constant', value_n_m = 1, during_s = [[1, 2], [2, 4], [7, 9]] }";
        let torque = &parse(&with_wheel(wheel)).unwrap().wheels[0].torque;
        assert_eq!([0.5, 1.0, 3.0, 4.0, 8.0].map(|t| torque.at(t)), [0.0, 1.0, 1.0, 0.0, 1.0]);
        let external = "kind = 'constant'\nvalue_n_m = [1, 2, 3]\nduring_s = [[1, 2]]";
        let torque = parse(&with_torque(external)).unwrap().torque;
        assert_eq!((torque.at(0.5).norm(), torque.at(1.5).as_slice()), (0.0, &[1.0, 2.0, 3.0][..]));
        assert_eq!(torque.breakpoints_s(), [1.0, 2.0]);
    }

    #[test]
    fn times_that_are_not_in_order_are_refused() {
        for during in ["[]", "[[1]]", "[[1, 2, 3]]", "[[2, 1]]", "[[1, 1]]", "[[1, 3], [2, 4]]"] {
            let wheel = format!("{{ kind = 'constant', value_n_m = 1, during_s = {during} }}");
            let message = message(&with_wheel(&wheel));
            let expected = format!("s.toml:8: `wheel[1].torque.during_s` is {during}; it must be");
            assert!(message.starts_with(&expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn table_is_read_from_beside_the_scenario() {
        let scenario = with_table("t_s,x,y,z\n0,0,1,2\n10,10,1,2\n").unwrap();
        assert_eq!(scenario.torque.at(5.0).as_slice(), [5.0, 1.0, 2.0]);
        assert_eq!(scenario.torque.breakpoints_s(), [0.0, 10.0]);
    }

    #[test]
    fn bad_table_is_named_with_its_line() {
        for (csv, expected) in [
            ("t_s,x,y\n0,0,0\n", "torque.csv:1: no column `z`"),
            ("t_s,x,y,z\n0,0,0,0\n0,0,0,0\n", "torque.csv:3: column `t_s`: 0 is there twice"),
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
    fn bad_profile_of_a_wheel_is_named() {
        for (torque, expected) in [
            ("{ value_n_m = 1 }", "s.toml:8: missing key `kind`"),
            ("{ kind = 'constant' }", "s.toml:8: missing key `wheel[1].torque.value_n_m`"),
            ("{ kind = 'sine' }", "s.toml:8: unknown word \"sine\" (did you mean `multisine`?)"),
            ("{ kind = 'constant', value = 1 }", "s.toml:8: unknown key `value` (did you mean `v"),
            (
                "{ kind = 'constant', value_n_m = inf }",
                "s.toml:8: `wheel[1].torque.value_n_m` is inf; it must be a finite number",
            ),
            (
                "{ kind = 'constant', value_n_m = 1, csv = 'x' }",
                "s.toml:8: `wheel[1].torque.csv` has no meaning for kind = \"constant\", which \
                 takes: value_n_m; remove it",
            ),
            (
                "{ kind = 'multisine', amplitude_n_m = [1], frequency_hz = [1, 2], phase_rad = [0] }",
                "s.toml:8: `wheel[1].torque.frequency_hz` has 2 entries, but \
                 `wheel[1].torque.amplitude_n_m` has 1",
            ),
            (
                "{ kind = 'multisine', amplitude_n_m = [1], frequency_hz = [nan], phase_rad = [0] }",
                "s.toml:8: `wheel[1].torque.frequency_hz` is [NaN]; it must be finite numbers",
            ),
        ] {
            let message = message(&with_wheel(torque));
            assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
        }
    }

    #[test]
    fn bad_profile_of_the_external_torque_is_named() {
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
                "s.toml:8: `torque.points_hz` has no meaning for kind = \"constant\"",
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
