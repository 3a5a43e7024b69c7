//! Columns of a log: their names, and their places in a file.

use crate::csv_problem::CsvProblem;
use crate::csv_source::{Column, CsvSource};
use crate::error::InputError;
use crate::key::{FINITE, Key, NUMBER, Range};
use crate::nearest::{likeness, nearest};

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
        "Time of the sample, from any origin, resolved to 1 µs; times since 1970 also in ms, µs or ns",
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

/// The place of each quantity in a file.
pub(super) struct Columns {
    pub time: Column,
    pub gyro: Vec<Column>,
    pub wheels: Vec<Column>,
    pub torque: Option<Vec<Column>>,
    pub attitude: Option<Vec<Column>>,
    pub notes: Vec<String>,
}

impl Columns {
    /// The columns of the log of a craft with `wheel_count` wheels.
    pub(super) fn find(source: &CsvSource, wheel_count: usize) -> Result<Self, InputError> {
        let time = source.column(TIME, is_known)?;
        let gyro = all(source, &GYRO)?;

        let wheel_columns = source.columns().iter().filter(|name| is_wheel(name)).count();
        if wheel_columns != wheel_count {
            let problem = CsvProblem::WheelColumns { log: wheel_columns, craft: wheel_count };
            return Err(source.header_error(problem));
        }
        let wheel_names: Vec<String> = (1..=wheel_count).map(wheel).collect();
        let wheels = all(source, &wheel_names)?;

        let torque = all_or_none(source, &TORQUE)?;
        let attitude = all_or_none(source, &ATTITUDE)?;

        let mut known = vec![TIME.to_owned()];
        known.extend(GYRO.iter().chain(&TORQUE).chain(&ATTITUDE).map(|name| (*name).to_owned()));
        known.extend(wheel_names);
        let notes = notes_on_ignored(source.columns(), &known);
        Ok(Self { time, gyro, wheels, torque, attitude, notes })
    }
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

fn all<S: AsRef<str>>(source: &CsvSource, names: &[S]) -> Result<Vec<Column>, InputError> {
    names.iter().map(|name| source.column(name.as_ref(), is_known)).collect()
}

/// One column of a group requires the others: a torque without one of its axes is a mistake.
fn all_or_none(source: &CsvSource, names: &[&str]) -> Result<Option<Vec<Column>>, InputError> {
    let is_there = |name: &&str| source.columns().iter().any(|column| column == name);
    if names.iter().any(is_there) { all(source, names).map(Some) } else { Ok(None) }
}

fn notes_on_ignored(columns: &[String], known: &[String]) -> Vec<String> {
    // Least likeness of a suggestion: a foreign quantity, as a temperature, gets none.
    const NEARLY: f64 = 0.9;
    columns
        .iter()
        .filter(|column| !known.contains(column))
        .map(|column| match nearest(column, known) {
            _ if column.is_empty() => "a column without a name is ignored".to_owned(),
            Some(name) if likeness(column, name) > NEARLY => {
                format!("column `{column}` is ignored (did you mean `{name}`?)")
            }
            _ => format!("column `{column}` is ignored"),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_the_reference_are_the_known_columns() {
        assert!(COLUMNS.iter().all(|column| is_known(&column.name.replace('N', "1"))));
        assert_eq!(COLUMNS.len(), 1 + GYRO.len() + 1 + TORQUE.len() + ATTITUDE.len());
    }
}
