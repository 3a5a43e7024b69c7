//! Columns of a log: their names, and their places in a file.

use super::time_columns::TimeColumns;
use crate::craft::{LogFormat, MAX_WHEELS, SensorFormat};
use crate::csv_problem::CsvProblem;
use crate::csv_source::{Column, CsvRow, CsvSource};
use crate::error::InputError;
use crate::key::{FINITE, Key, NUMBER, Range};
use crate::nearest::{likeness, nearest};
use crate::units::{self, RATES, TORQUES, Unit};

pub(super) const TIME: &str = "t_s";
pub(super) const GYRO: [&str; 3] = ["gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"];
pub(super) const TORQUE: [&str; 3] = ["torque_x_n_m", "torque_y_n_m", "torque_z_n_m"];
pub(super) const ATTITUDE: [&str; 4] = ["attitude_q1", "attitude_q2", "attitude_q3", "attitude_q4"];

const INCREASING: Range = Range::new("increasing, within ±10²⁰", f64::is_finite);
const ZERO_WITH_ALL: &str = "all three absent: 0";
const NONE_WITH_ALL: &str = "all four absent: no attitude";

/// The columns, one row each; `N` in a name counts the wheels from 1.
pub const COLUMNS: [Key; 12] = [
    column(
        TIME,
        "s",
        INCREASING,
        "Time of the sample, from any origin, resolved to 1 µs; times since 1970 also in ms, µs or ns, and dates as \
         ISO 8601",
    ),
    column(GYRO[0], "rad/s", FINITE, "Body rate about x"),
    column(GYRO[1], "rad/s", FINITE, "Body rate about y"),
    column(GYRO[2], "rad/s", FINITE, "Body rate about z"),
    column("wheel_N_rad_s", "rad/s", FINITE, "Speed of wheel N relative to the body"),
    column(TORQUE[0], "N m", FINITE, "External torque about x").or(ZERO_WITH_ALL),
    column(TORQUE[1], "N m", FINITE, "External torque about y").or(ZERO_WITH_ALL),
    column(TORQUE[2], "N m", FINITE, "External torque about z").or(ZERO_WITH_ALL),
    column(
        ATTITUDE[0],
        "",
        FINITE,
        "Attitude quaternion, inertial to body axes: x of the vector part",
    )
    .or(NONE_WITH_ALL),
    column(ATTITUDE[1], "", FINITE, "y of its vector part").or(NONE_WITH_ALL),
    column(ATTITUDE[2], "", FINITE, "z of its vector part").or(NONE_WITH_ALL),
    column(ATTITUDE[3], "", FINITE, "Its scalar part").or(NONE_WITH_ALL),
];

const fn column(
    name: &'static str,
    unit: &'static str,
    range: Range,
    meaning: &'static str,
) -> Key {
    Key::required(name, NUMBER, unit, range, meaning)
}

/// The column of the speed of a wheel, counted from 1.
pub(super) fn wheel(number: usize) -> String {
    format!("wheel_{number}_rad_s")
}

/// Columns of one kind of sensor.
#[derive(Debug)]
pub(super) struct Sensor {
    columns: Vec<Column>,
    /// SI value of one count of each.
    factors: Vec<f64>,
}

impl Sensor {
    /// The values of a row in SI units.
    ///
    /// # Errors
    /// The first fault of a cell.
    pub(super) fn values(&self, source: &CsvSource, row: &CsvRow) -> Result<Vec<f64>, CsvProblem> {
        let columns = self.columns.iter().zip(&self.factors);
        columns.map(|(column, factor)| Ok(source.finite_number(row, column)? * factor)).collect()
    }

    /// True for a row without a value, as in a table of several sensors: every cell is empty or NaN.
    pub(super) fn is_absent(&self, source: &CsvSource, row: &CsvRow) -> bool {
        let is_empty = |column: &Column| {
            let text = source.text(row, column);
            text.is_empty() || text.eq_ignore_ascii_case("nan")
        };
        !self.columns.is_empty() && self.columns.iter().all(is_empty)
    }
}

/// The place of each quantity in the table of the gyro. A sensor with a table of its own has none.
pub(super) struct Columns {
    pub time: TimeColumns,
    pub gyro: Sensor,
    pub wheels: Option<Sensor>,
    pub torque: Option<Sensor>,
    pub attitude: Option<Sensor>,
    pub notes: Vec<String>,
}

impl Columns {
    /// The columns of the log of a craft with `wheel_count` wheels.
    pub(super) fn find(
        source: &CsvSource,
        format: &LogFormat,
        wheel_count: usize,
    ) -> Result<Self, InputError> {
        let mapped = [&format.gyro, &format.wheels, &format.torque, &format.attitude];
        let names = mapped.iter().flat_map(|sensor| sensor.iter()).flat_map(|s| &s.columns);
        let names: Vec<&str> = names.chain(&format.time.columns).map(String::as_str).collect();
        let is_known = |name: &str| is_known(name) || names.contains(&name);
        let time = TimeColumns::find(source, &format.time, is_known)?;
        let stated = |sensor: &Option<SensorFormat>| {
            let here = sensor.as_ref().filter(|sensor| sensor.file.is_none());
            here.map(|sensor| Sensor::find(source, sensor, is_known)).transpose()
        };
        let standard = |names: &[&str]| all(source, names, is_known).map(Sensor::si);
        let gyro = match stated(&format.gyro)? {
            Some(gyro) => gyro,
            None => standard(&GYRO)?,
        };
        let wheels = match &format.wheels {
            Some(_) => stated(&format.wheels)?,
            None => Some(Sensor::si(wheel_columns(source, wheel_count, is_known)?)),
        };
        let of = |sensor: &Option<SensorFormat>, names: &[&str]| match sensor {
            Some(_) => stated(sensor),
            None if has_any(source, names) => standard(names).map(Some),
            None => Ok(None),
        };
        let (torque, attitude) = (of(&format.torque, &TORQUE)?, of(&format.attitude, &ATTITUDE)?);
        let is_mapped = mapped.iter().any(|sensor| sensor.is_some());
        let mut notes = if is_mapped { Vec::new() } else { notes_on_ignored(source, is_known) };
        let with_units: [(_, _, &[Unit]); 3] = [
            ("gyro", &format.gyro, &RATES),
            ("wheels", &format.wheels, &RATES),
            ("torque", &format.torque, &TORQUES),
        ];
        for (table, sensor, units) in with_units {
            notes.extend(sensor.iter().filter_map(|sensor| note_on_unit(table, sensor, units)));
        }
        Ok(Self { time, gyro, wheels, torque, attitude, notes })
    }
}

impl Sensor {
    /// The columns of `format` in a table.
    pub(super) fn find(
        source: &CsvSource,
        format: &SensorFormat,
        is_known: impl Fn(&str) -> bool + Copy,
    ) -> Result<Self, InputError> {
        let columns = all(source, &format.columns, is_known)?;
        Ok(Self { columns, factors: format.factors.clone() })
    }

    fn si(columns: Vec<Column>) -> Self {
        Self { factors: vec![1.0; columns.len()], columns }
    }
}

/// The columns of the wheels by their standard names: one for each wheel.
fn wheel_columns(
    source: &CsvSource,
    wheel_count: usize,
    is_known: impl Fn(&str) -> bool + Copy,
) -> Result<Vec<Column>, InputError> {
    let found = source.columns().iter().filter(|name| is_wheel(name)).count();
    if found != wheel_count {
        let problem = CsvProblem::WheelColumns { log: found, craft: wheel_count };
        return Err(source.header_error(problem));
    }
    let names: Vec<String> = (1..=wheel_count).map(wheel).collect();
    all(source, &names, is_known)
}

/// True for the name of a log column.
fn is_known(name: &str) -> bool {
    name == TIME
        || GYRO.contains(&name)
        || TORQUE.contains(&name)
        || ATTITUDE.contains(&name)
        || is_wheel(name)
}

/// True for `wheel_N_rad_s` with any number N.
fn is_wheel(name: &str) -> bool {
    name.strip_prefix("wheel_")
        .and_then(|rest| rest.strip_suffix("_rad_s"))
        .is_some_and(|number| number.parse::<u32>().is_ok())
}

fn all<S: AsRef<str>>(
    source: &CsvSource,
    names: &[S],
    is_known: impl Fn(&str) -> bool + Copy,
) -> Result<Vec<Column>, InputError> {
    names.iter().map(|name| source.column(name.as_ref(), is_known)).collect()
}

/// One column of a group requires the others: a torque without one of its axes is a mistake.
fn has_any(source: &CsvSource, names: &[&str]) -> bool {
    names.iter().any(|name| source.columns().iter().any(|column| column == name))
}

/// Note on the first column whose name ends with another unit than the one stated. Without external torque and net
/// momentum, `J ω` is minus the momentum of the wheels: no residual shows a wrong unit of gyro or wheels.
fn note_on_unit(table: &str, sensor: &SensorFormat, units: &[Unit]) -> Option<String> {
    let columns = sensor.columns.iter().zip(&sensor.factors);
    let mut contradictions = columns.filter_map(|(name, factor)| {
        let unit = units::in_name(name, units)?;
        let is_same = (factor.abs() / unit.factor - 1.0).abs() < SAME_UNIT;
        (!is_same).then(|| {
            format!(
                "a count of column `{name}` is read as {factor:.6} {}, and its name says {}; \
                 state unit = \"{}\" in [log.{table}] if the name is right",
                units[0].name, unit.name, unit.name
            )
        })
    });
    contradictions.next()
}

/// Share by which the factor of a column may differ from its unit: rounded digits of a person.
const SAME_UNIT: f64 = 1e-3;

fn notes_on_ignored(source: &CsvSource, is_known: impl Fn(&str) -> bool) -> Vec<String> {
    /// Least likeness of a suggestion: a foreign quantity, as a temperature, gets none.
    const NEARLY: f64 = 0.9;
    /// Most columns with a note of their own.
    const LISTED: usize = 4;
    let wheels = (1..=MAX_WHEELS).map(wheel);
    let fixed = [TIME].into_iter().chain(GYRO).chain(TORQUE).chain(ATTITUDE).map(str::to_owned);
    let known: Vec<String> = fixed.chain(wheels).collect();
    let note = |column: &&String| match nearest(column, &known) {
        _ if column.is_empty() => "a column without a name is ignored".to_owned(),
        Some(name) if likeness(column, name) > NEARLY => {
            format!("column `{column}` is ignored (did you mean `{name}`?)")
        }
        _ => format!("column `{column}` is ignored"),
    };
    let ignored: Vec<&String> = source.columns().iter().filter(|name| !is_known(name)).collect();
    let mut notes: Vec<String> = ignored.iter().take(LISTED).map(note).collect();
    if ignored.len() > LISTED {
        notes.push(format!("{} further columns are ignored", ignored.len() - LISTED));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_the_reference_are_the_known_columns() {
        assert!(COLUMNS.iter().all(|column| is_known(&column.name.replace('N', "1"))));
        assert_eq!(COLUMNS.len(), 1 + GYRO.len() + 1 + TORQUE.len() + ATTITUDE.len());
    }

    #[test]
    fn column_whose_name_contradicts_its_unit_is_noted() {
        let note = |name: &str, factor: f64, units: &[Unit]| {
            let sensor = SensorFormat {
                columns: vec![name.to_owned()],
                factors: vec![factor],
                file: None,
                time: None,
            };
            note_on_unit("gyro", &sensor, units)
        };
        assert_eq!(
            note("wx_dps", 1.0, &RATES).unwrap(),
            "a count of column `wx_dps` is read as 1.000000 rad/s, and its name says deg/s; state \
             unit = \"deg/s\" in [log.gyro] if the name is right"
        );
        assert!(note("rw1_rpm", 1.0, &RATES).unwrap().contains("rpm"));
        assert!(note("tx_mNm", 1.0, &TORQUES).unwrap().contains("mN m"));
        // The unit stated, mounted the other way round, rounded, and names without a unit.
        for (name, factor) in [
            ("wx_dps", std::f64::consts::PI / 180.0),
            ("wx_dps", -0.017453),
            ("rate_x_rad_s", 1.0),
            ("wx", 0.00106),
        ] {
            assert_eq!(note(name, factor, &RATES), None, "{name}");
        }
    }
}
