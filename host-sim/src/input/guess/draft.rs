//! Text of a drafted craft file.

use std::fmt::Write as _;

use flight_input::csv_source::CsvSource;
use flight_input::units::TimeUnit;
use flight_input::words::short;

use super::clock::{self, FoundClock};
use super::name::Name;
use super::sensors::{self, Found};
use super::{numbers, usual_size};

/// Largest ordinary rate, rad/s: 2,000 deg/s. Above, the unit is deg/s.
const MAX_RATE_RAD_S: f64 = 35.0;
/// Largest speed of a wheel in rad/s: 9,500 rpm. Above, the unit is rpm.
const MAX_WHEEL_RAD_S: f64 = 1_000.0;
/// Column of the comments.
const COMMENT: usize = 38;

const HEAD: &str = "\
# A craft, drafted from the log LOG.
# The lines of [log] are what its header and its numbers suggest: confirm each. `CONFIRM` marks what
# rests on a guess, `FILL IN` what no log shows. All keys: host-sim/docs/keys.md
";
const WHEEL_HEAD: &str = "
# The wheels, in the order of the columns above.
";
const TAIL: &str = "
[gyro]                                # errors left out have data-sheet values, printed as assumed
# noise_rad_s = 1e-4                  # one sigma of a sample; measured from the log if left out
# range_rad_s = 4.36                  # full scale

# [prior]                             # expected inertia, wheels included, if known: jxx jyy jzz jxy jxz jyz
# inertia_kg_m2 = [0.06, 0.10, 0.12, 0, 0, 0]
# sigma_kg_m2 = [0.03, 0.03, 0.03, 0.01, 0.01, 0.01]

# [disturbance]                       # further unknowns
# torque = true
# gyro_bias = true
";

/// The craft file for logs like `source`; `file` is the log's name.
///
/// # Errors
/// A sentence on the sensor that is not found: time or gyro.
pub fn draft(file: &str, source: &CsvSource) -> Result<String, NothingFound> {
    let units = source.units();
    let name =
        |(index, full): (usize, &String)| Name::of(full, units.get(index).map(String::as_str));
    let names: Vec<Name> = source.columns().iter().enumerate().map(name).collect();
    let channels = channels(source);
    let missing = |sensor| NothingFound {
        sensor,
        columns: source.columns().to_vec(),
        channels: channels.clone(),
    };
    let clock = clock::find(source, &names).ok_or_else(|| missing("time"))?;
    let gyro = sensors::gyro(&names).ok_or_else(|| missing("a gyro about x, y and z"))?;
    let wheels = sensors::wheels(&names);

    let mut text = HEAD.replace("LOG", file);
    write_clock(&mut text, &clock);
    write_rates(&mut text, "gyro", source, &gyro, MAX_RATE_RAD_S, "deg/s");
    if let Some(wheels) = &wheels {
        write_rates(&mut text, "wheels", source, wheels, MAX_WHEEL_RAD_S, "rpm");
    }
    if let Some(torque) = sensors::torque(&names) {
        write_torque(&mut text, &torque);
    }
    if let Some(wheels) = &wheels {
        text += WHEEL_HEAD;
        wheels.columns.iter().for_each(|wheel| write_wheel(&mut text, wheel));
    }
    Ok(text + TAIL)
}

/// A log in which a sensor is not found.
#[derive(Debug, thiserror::Error)]
#[error(
    "no columns of {sensor} are recognised by their names; {}; the columns are: {}",
    match channels {
        Some(name) => {
            format!("`{name}` names a channel in each row: export a column for each channel, and a row for each sample")
        }
        None => "write [log] by hand (host-sim/docs/logs.md)".to_owned(),
    },
    columns.join(", ")
)]
pub struct NothingFound {
    sensor: &'static str,
    columns: Vec<String>,
    /// Column with the names of channels.
    channels: Option<String>,
}

/// Column whose cells name the channels of a table with one value in each row: few texts, each of them often.
fn channels(source: &CsvSource) -> Option<String> {
    let of = |name: &String| {
        let column = source.column(name, |_| true).ok()?;
        let cells = source.rows().iter().map(|row| source.text(row, &column));
        let texts: Vec<&str> = cells.filter(|cell| cell.parse::<f64>().is_err()).collect();
        let distinct = texts.iter().collect::<std::collections::BTreeSet<_>>().len();
        let is_each = texts.len() == source.rows().len();
        (is_each && (3..=texts.len() / 3).contains(&distinct)).then(|| name.clone())
    };
    source.columns().iter().find_map(of)
}

/// A line with a comment.
fn line(text: &mut String, line: &str, comment: &str) {
    let gap = if comment.is_empty() { "" } else { "# " };
    let space = if line.len() < COMMENT { "" } else { " " };
    let _ = writeln!(text, "{}", format!("{line:COMMENT$}{space}{gap}{comment}").trim_end());
}

fn write_clock(text: &mut String, clock: &FoundClock) {
    let FoundClock { columns, units, form, reason, step_s } = clock;
    *text += "\n[log]\n";
    let step = step_s.map_or(String::new(), |s| format!("; rows typically every {} s", short(s)));
    let unit: Vec<&str> = units.iter().map(|unit| unit.key()).collect();
    match (columns.as_slice(), unit.as_slice()) {
        ([column], [unit]) => {
            line(text, &format!("time = {}", toml(column)), "");
            let zone = if units == &[TimeUnit::Date] { ", UTC without an offset" } else { "" };
            let comment = format!("{reason}{zone}{step}");
            line(text, &format!("time_unit = {unit:?}"), &comment);
        }
        _ => {
            line(text, &format!("time = {}", list(columns)), "the sum of both");
            line(text, &format!("time_unit = {unit:?}"), &format!("{reason}{step}"));
        }
    }
    if let Some((form, reason)) = form {
        line(text, &format!("time_format = {}", toml(form)), reason);
    }
}

fn write_rates(
    text: &mut String,
    table: &str,
    source: &CsvSource,
    found: &Found<'_>,
    largest_si: f64,
    other: &str,
) {
    let _ = writeln!(text, "\n[log.{table}]");
    write_columns(text, found);
    let values: Vec<Vec<f64>> =
        found.columns.iter().map(|name| numbers(source, &name.full)).collect();
    let is_counts = table == "gyro" && are_counts(&values);
    let size = values.into_iter().map(usual_size).fold(0.0, f64::max);
    let first = found.columns[0];
    let known = first.rate_unit().or_else(|| first.momentum_unit());
    let by_size = if size > largest_si { other } else { "rad/s" };
    let up_to = format!("values up to {}", short(size));
    let (unit, reason) = match (known, &first.unknown_unit) {
        (Some(unit), _) => (unit.name, "as in the header".to_owned()),
        (None, Some(stated)) => {
            (by_size, format!("CONFIRM: the header states {stated}, which is not known; {up_to}"))
        }
        (None, None) => (by_size, format!("CONFIRM: not in the header; {up_to}")),
    };
    if known.is_none() && is_counts {
        line(text, "unit = \"deg/s\"", "CONFIRM: unit of the scale below");
        line(text, "scale = 0", &format!("FILL IN: {up_to} are counts; deg/s a count"));
    } else {
        line(text, &format!("unit = {unit:?}"), &reason);
        let ones = vec!["1"; found.columns.len()].join(", ");
        line(
            text,
            &format!("# scale = [{ones}]"),
            "units per count; negative: the other direction",
        );
    }
    if table == "wheels" {
        line(text, "# file = \"*_wheels.csv\"", "if they are in a file of their own");
    }
}

/// True for integers of more than one digit: readings in counts.
fn are_counts(values: &[Vec<f64>]) -> bool {
    let mut all = values.iter().flatten().peekable();
    all.peek().is_some()
        && all.all(|value| value.fract() == 0.0)
        && values.iter().flatten().any(|value| value.abs() >= 10.0)
}

fn write_torque(text: &mut String, found: &Found<'_>) {
    *text += "\n[log.torque]                          # CONFIRM: external torque, not that of the wheels\n";
    write_columns(text, found);
    let unit = found.columns[0].unit.as_deref();
    let unit = unit.and_then(|unit| flight_input::units::find(unit, &flight_input::units::TORQUES));
    match unit {
        Some(unit) => line(text, &format!("unit = {:?}", unit.name), "as in the header"),
        None => line(text, "unit = \"N m\"", "CONFIRM: not in the header"),
    }
}

fn write_columns(text: &mut String, found: &Found<'_>) {
    let columns: Vec<String> = found.columns.iter().map(|name| name.full.clone()).collect();
    let doubt = found.doubt.map_or(String::new(), |doubt| format!("CONFIRM: {doubt}"));
    line(text, &format!("columns = {}", list(&columns)), &doubt);
    if !found.others.is_empty() {
        let _ = writeln!(text, "# also possible: {} …", found.others.join(" …, "));
    }
}

fn write_wheel(text: &mut String, wheel: &Name) {
    let _ = writeln!(text, "[[wheel]]");
    line(text, &format!("name = {}", toml(&wheel.full)), "");
    let axis = match wheel.index.as_deref() {
        Some("x") => "axis = [1, 0, 0]",
        Some("y") => "axis = [0, 1, 0]",
        Some("z") => "axis = [0, 0, 1]",
        _ => "axis = [0, 0, 0]",
    };
    let word = if axis.contains('1') { "CONFIRM" } else { "FILL IN" };
    line(text, axis, &format!("{word}: direction of positive speed, body axes"));
    line(text, "spin_inertia_kg_m2 = 0", "FILL IN: from the data sheet");
}

/// A text in the syntax of TOML.
fn toml(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// A list of texts in the syntax of TOML.
fn list(texts: &[String]) -> String {
    format!("[{}]", texts.iter().map(|text| toml(text)).collect::<Vec<_>>().join(", "))
}
