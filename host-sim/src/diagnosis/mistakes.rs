//! Mistakes of people: each a change of log or craft file that undoes it.

use nalgebra::{Matrix3, Vector3};

use super::record::{MARGIN, Record, median};

/// Share of rows without a new wheel speed above which the speeds are held.
const HELD_SHARE: f64 = 0.3;
/// Largest shift of wheel columns, rows: within the margin of a fit.
const LARGEST_SHIFT: isize = MARGIN as isize - 1;
/// Cosine between torque columns and motor torque above which one is taken for the other.
const SAME_TORQUE: f64 = 0.7;

/// Plausible intervals between rows, s: gyros of 2 kHz to house-keeping once a minute.
const INTERVAL_S: std::ops::RangeInclusive<f64> = 5e-4..=60.0;

/// A mistake.
pub(super) struct Mistake {
    pub name: String,
    /// Correction of craft file or log.
    pub remedy: String,
    /// Number of flips and exchanges that it consists of.
    pub steps: usize,
    change: Change,
}

/// Change of log or craft that undoes a mistake.
enum Change {
    /// Rates times a matrix; the noise times the factor.
    Gyro(Matrix3<f64>, f64),
    Time(f64),
    /// Momentum of one wheel, or of all, times a factor.
    Wheel(Option<usize>, f64),
    /// Wheel i has the speeds of this column.
    Columns(Vec<usize>),
    Axis(usize, Vector3<f64>),
    /// Torque about one axis, or all, times a factor.
    Torque(Option<usize>, f64),
    /// Speeds of one wheel, or of all, of this many rows later.
    Shift(Option<usize>, isize),
    /// Wheel speeds at their changes alone, linear between.
    Interpolate,
    /// Readings at their changes alone.
    FreshReadings,
}

impl Mistake {
    /// The record without the mistake.
    pub(super) fn undone(&self, record: &Record) -> Record {
        let mut record = record.clone();
        self.change.apply(&mut record);
        record
    }

    /// Columns that the mistake shifts: shifts of the same columns are neighbours. None for another mistake.
    pub(super) fn shifted(&self) -> Option<Option<usize>> {
        match self.change {
            Change::Shift(one, _) => Some(one),
            _ => None,
        }
    }

    /// Factor by which readings in the right unit are smaller than those of the log; one unless their unit is wrong.
    pub(super) fn gyro_factor(&self) -> f64 {
        match self.change {
            Change::Gyro(_, factor) => factor,
            _ => 1.0,
        }
    }
}

impl Change {
    fn apply(&self, record: &mut Record) {
        match self {
            Self::Gyro(matrix, factor) => {
                record.rate_rad_s.iter_mut().for_each(|rate| *rate = matrix * *rate);
                record.noise_rad_s *= factor;
            }
            Self::Time(factor) => record.time_s.iter_mut().for_each(|time| *time *= factor),
            Self::Wheel(one, factor) => {
                for (index, wheel) in record.wheels.iter_mut().enumerate() {
                    if one.is_none_or(|one| one == index) {
                        wheel.inertia_kg_m2 *= factor;
                    }
                }
            }
            Self::Columns(columns) => {
                let speeds = columns.iter().map(|column| record.wheel_rad_s[*column].clone());
                record.wheel_rad_s = speeds.collect();
            }
            Self::Axis(wheel, axis) => record.wheels[*wheel].axis = *axis,
            Self::Torque(axis, factor) => {
                for torque in &mut record.torque_n_m {
                    for i in (0..3).filter(|i| axis.is_none_or(|axis| axis == *i)) {
                        torque[i] *= factor;
                    }
                }
            }
            Self::Shift(one, rows) => {
                for (index, speeds) in record.wheel_rad_s.iter_mut().enumerate() {
                    if one.is_none_or(|one| one == index) {
                        shift(speeds, *rows);
                    }
                }
            }
            Self::Interpolate => interpolate(record),
            Self::FreshReadings => *record = record.without_repeated(),
        }
    }
}

/// Each value from `rows` later; the ends repeat.
fn shift(values: &mut [f64], rows: isize) {
    let old = values.to_vec();
    for (row, value) in values.iter_mut().enumerate() {
        *value = old[row.saturating_add_signed(rows).min(old.len() - 1)];
    }
}

/// Rows at which a wheel has a new speed.
fn changes(speeds: &[f64]) -> Vec<usize> {
    let is_new = |row: &usize| *row == 0 || speeds[*row] != speeds[*row - 1];
    (0..speeds.len()).filter(is_new).collect()
}

fn interpolate(record: &mut Record) {
    for speeds in &mut record.wheel_rad_s {
        for pair in changes(speeds).windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let span_s = record.time_s[to] - record.time_s[from];
            for row in from + 1..to {
                let share = (record.time_s[row] - record.time_s[from]) / span_s;
                speeds[row] = speeds[from] + (speeds[to] - speeds[from]) * share;
            }
        }
    }
}

/// All mistakes that are possible with this record.
pub(super) fn all(record: &Record) -> Vec<Mistake> {
    let mut all = gyro();
    all.extend(time(record));
    all.extend(readings(record));
    if !record.wheels.is_empty() {
        all.extend(wheel_signs(record.wheels.len()));
        all.extend(wheel_columns(record.wheels.len()));
        all.extend(wheel_axes(record));
        all.extend(wheel_units(record.wheels.len()));
        all.extend(shifts(record.wheels.len()));
    }
    if record.has_torque() {
        all.extend(torque(record));
    }
    all
}

fn mistake(name: impl Into<String>, remedy: impl Into<String>, change: Change) -> Mistake {
    let steps = match &change {
        Change::Gyro(matrix, _) => steps_of_axes(matrix),
        Change::Columns(order) => exchanges(order),
        _ => 1,
    };
    Mistake { name: name.into(), remedy: remedy.into(), steps, change }
}

/// Flips and exchanges of a signed permutation of axes.
fn steps_of_axes(matrix: &Matrix3<f64>) -> usize {
    let order: Vec<usize> = (0..3).map(|i| matrix.row(i).transpose().iamax()).collect();
    let flips = matrix.iter().filter(|entry| **entry < 0.0).count();
    (flips + exchanges(&order)).max(1)
}

/// Exchanges that make up a permutation: its length less the number of its cycles.
fn exchanges(order: &[usize]) -> usize {
    let mut is_seen = vec![false; order.len()];
    let mut cycles = 0;
    for start in 0..order.len() {
        let mut place = start;
        while !std::mem::replace(&mut is_seen[place], true) {
            place = order[place];
            cycles += usize::from(place == start);
        }
    }
    order.len() - cycles
}

/// The 47 other assignments of gyro axes, and its units.
fn gyro() -> Vec<Mistake> {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut all = Vec::new();
    for order in ORDERS {
        for signs in 0..8 {
            let is_negative = |axis: usize| signs >> axis & 1 == 1;
            if order == [0, 1, 2] && signs == 0 {
                continue;
            }
            let mut matrix = Matrix3::zeros();
            let mut names = Vec::new();
            for axis in 0..3 {
                matrix[(axis, order[axis])] = if is_negative(axis) { -1.0 } else { 1.0 };
                let sign = if is_negative(axis) { "-" } else { "" };
                names.push(format!("{sign}{}", ["x", "y", "z"][order[axis]]));
            }
            let kind = match (order == [0, 1, 2], matrix.determinant() > 0.0) {
                (true, _) => "gyro axes flipped",
                (false, true) => "gyro axes turned",
                (false, false) => "gyro axes permuted",
            };
            let names = names.join(", ");
            all.push(mistake(
                format!("{kind}: x, y, z are columns {names}"),
                format!("use columns {names} as gyro_x, gyro_y, gyro_z"),
                Change::Gyro(matrix, 1.0),
            ));
        }
    }
    let degree = std::f64::consts::PI / 180.0;
    let scaled = |factor: f64| Change::Gyro(Matrix3::identity() * factor, factor);
    all.push(mistake("gyro in deg/s", "multiply gyro columns by 0.0174533", scaled(degree)));
    all.push(mistake("gyro in mrad/s", "multiply gyro columns by 0.001", scaled(1e-3)));
    all
}

/// Units of time that leave a plausible interval between rows.
fn time(record: &Record) -> Vec<Mistake> {
    let steps = record.time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let interval_s = median(steps.collect());
    let time = |unit: &str, factor: f64| {
        let (name, remedy) = (format!("time in {unit}"), format!("multiply t_s by {factor:e}"));
        mistake(name, remedy, Change::Time(factor))
    };
    let units = [("ms", 1e-3), ("µs", 1e-6), ("minutes", 60.0)];
    let plausible =
        units.into_iter().filter(|(_, factor)| INTERVAL_S.contains(&(interval_s * factor)));
    plausible.map(|(unit, factor)| time(unit, factor)).collect()
}

/// Repeated readings and speeds.
fn readings(record: &Record) -> Vec<Mistake> {
    let rates = &record.rate_rad_s;
    let repeated = rates.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let is_held = |count: usize| count as f64 > HELD_SHARE * record.len() as f64;
    let mut all = Vec::new();
    if is_held(repeated) {
        let remedy = "keep the first row of each reading and remove the others";
        all.push(mistake("gyro slower than its log", remedy, Change::FreshReadings));
    }
    // A wheel that stands has one speed.
    let held = record.wheel_rad_s.iter().map(|speeds| changes(speeds).len()).filter(|n| *n > 1);
    if held.clone().any(|changes| is_held(record.len() - changes)) {
        let remedy =
            "keep the rows at which a wheel speed changes, or interpolate the speeds between";
        all.push(mistake("wheel speeds held", remedy, Change::Interpolate));
    }
    all
}

fn wheel_signs(wheels: usize) -> Vec<Mistake> {
    let one = |wheel: usize| {
        let number = wheel + 1;
        let remedy = format!("negate axis of [[wheel]] {number}");
        mistake(format!("sign of wheel {number}"), remedy, Change::Wheel(Some(wheel), -1.0))
    };
    let mut all: Vec<_> = (0..wheels).map(one).collect();
    if wheels > 1 {
        let remedy = "negate axis of every [[wheel]]";
        all.push(mistake("sign of all wheels", remedy, Change::Wheel(None, -1.0)));
    }
    all
}

/// Assignments of columns to wheels: all of up to four wheels, exchanges of two for more.
fn wheel_columns(wheels: usize) -> Vec<Mistake> {
    const EACH: usize = 4;
    let identity: Vec<usize> = (0..wheels).collect();
    let mut orders = Vec::new();
    if wheels <= EACH {
        permutations(&mut identity.clone(), 0, &mut orders);
        orders.retain(|order| *order != identity);
    } else {
        for a in 0..wheels {
            for b in a + 1..wheels {
                let mut order = identity.clone();
                order.swap(a, b);
                orders.push(order);
            }
        }
    }
    let name = |order: Vec<usize>| {
        let numbers: Vec<_> = order.iter().map(|column| (column + 1).to_string()).collect();
        let numbers = numbers.join(", ");
        mistake(
            format!("wheels permuted: [[wheel]] in order has columns {numbers}"),
            format!("give [[wheel]] in the order of the columns: column numbers now {numbers}"),
            Change::Columns(order),
        )
    };
    orders.into_iter().map(name).collect()
}

fn permutations(order: &mut Vec<usize>, from: usize, all: &mut Vec<Vec<usize>>) {
    if from == order.len() {
        all.push(order.clone());
    }
    for other in from..order.len() {
        order.swap(from, other);
        permutations(order, from + 1, all);
        order.swap(from, other);
    }
}

/// A wheel along another body axis than stated.
fn wheel_axes(record: &Record) -> Vec<Mistake> {
    const SAME: f64 = 0.99;
    let mut all = Vec::new();
    for (index, wheel) in record.wheels.iter().enumerate() {
        for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
            for (axis, sign) in [(axis, ""), (-axis, "-")] {
                // Its own sign is another mistake.
                if wheel.axis.dot(&axis).abs() < SAME {
                    let axis_of: [f64; 3] = axis.into();
                    all.push(mistake(
                        format!("axis of wheel {}: along {sign}{name}", index + 1),
                        format!("[[wheel]] {}: axis = {axis_of:?}", index + 1),
                        Change::Axis(index, axis),
                    ));
                }
            }
        }
    }
    all
}

fn wheel_units(wheels: usize) -> Vec<Mistake> {
    use std::f64::consts::PI;
    let mut all = Vec::new();
    for (unit, factor) in [("rpm", PI / 30.0), ("rev/s", 2.0 * PI), ("deg/s", PI / 180.0)] {
        let remedy = format!("multiply wheel columns by {factor:.6}");
        all.push(mistake(format!("wheel speeds in {unit}"), remedy, Change::Wheel(None, factor)));
        for wheel in (0..wheels).filter(|_| wheels > 1) {
            let number = wheel + 1;
            let remedy = format!("multiply the column of wheel {number} by {factor:.6}");
            let name = format!("speed of wheel {number} in {unit}");
            all.push(mistake(name, remedy, Change::Wheel(Some(wheel), factor)));
        }
    }
    for (unit, factor) in [("g m²", 1e-3), ("kg cm²", 1e-4), ("kg mm²", 1e-6), ("g cm²", 1e-7)]
    {
        let remedy = |of: &str| format!("multiply spin_inertia_kg_m2 of {of} by {factor:e}");
        all.push(mistake(
            format!("spin inertia of all wheels in {unit}"),
            remedy("every [[wheel]]"),
            Change::Wheel(None, factor),
        ));
        for wheel in 0..wheels {
            all.push(mistake(
                format!("spin inertia of wheel {} in {unit}", wheel + 1),
                remedy(&format!("[[wheel]] {}", wheel + 1)),
                Change::Wheel(Some(wheel), factor),
            ));
        }
    }
    all
}

/// Columns of all wheels, and of each, that are late or early.
fn shifts(wheels: usize) -> Vec<Mistake> {
    let shift = |one: Option<usize>, rows: isize| {
        let (word, to) = if rows > 0 { ("late", "up") } else { ("early", "down") };
        let count = rows.unsigned_abs();
        let plural = if count == 1 { "row" } else { "rows" };
        let (of, columns) = match one {
            Some(wheel) => {
                (format!("speed of wheel {}", wheel + 1), format!("column of wheel {}", wheel + 1))
            }
            None => ("wheel speeds".to_owned(), "wheel columns".to_owned()),
        };
        mistake(
            format!("{of} {word} by {count} {plural}"),
            format!("move the {columns} {to} by {count} {plural}"),
            Change::Shift(one, rows),
        )
    };
    let each = (0..wheels).map(Some).filter(|_| wheels > 1);
    let rows = || (-LARGEST_SHIFT..=LARGEST_SHIFT).filter(|rows| *rows != 0);
    std::iter::once(None).chain(each).flat_map(|one| rows().map(move |n| shift(one, n))).collect()
}

fn torque(record: &Record) -> Vec<Mistake> {
    let sign = |axis: usize| {
        let name = ["x", "y", "z"][axis];
        mistake(
            format!("sign of torque {name}"),
            format!("negate torque_{name}_n_m"),
            Change::Torque(Some(axis), -1.0),
        )
    };
    let mut all: Vec<_> = (0..3).map(sign).collect();
    all.push(mistake(
        "sign of the torque",
        "negate the torque columns",
        Change::Torque(None, -1.0),
    ));
    let remedy = "multiply the torque columns by 0.001";
    all.push(mistake("torque in mN m", remedy, Change::Torque(None, 1e-3)));
    if is_motor_torque(record) {
        let remedy = "remove the torque columns: wheel speeds contain the motor torque";
        all.push(mistake(
            "motor torque given as external torque",
            remedy,
            Change::Torque(None, 0.0),
        ));
    }
    all
}

/// The torque columns follow the momentum exchanged with the wheels, over steps of several rows.
fn is_motor_torque(record: &Record) -> bool {
    const STEP: usize = 4;
    let rows: Vec<usize> = (0..record.len()).step_by(STEP).collect();
    let (mut product, mut torques, mut exchanges) = (0.0, 0.0, 0.0);
    for pair in rows.windows(2) {
        let mut exchanged = Vector3::zeros();
        for (wheel, speeds) in record.wheels.iter().zip(&record.wheel_rad_s) {
            exchanged += wheel.axis * (wheel.inertia_kg_m2 * (speeds[pair[1]] - speeds[pair[0]]));
        }
        let impulse = (pair[0]..pair[1])
            .map(|row| record.torque_n_m[row] * (record.time_s[row + 1] - record.time_s[row]))
            .sum::<Vector3<f64>>();
        product += impulse.dot(&exchanged);
        torques += impulse.norm_squared();
        exchanges += exchanged.norm_squared();
    }
    product.abs() > SAME_TORQUE * (torques * exchanges).sqrt() && exchanges > 0.0
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::input::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    fn record(name: &str) -> Record {
        let scenario = Scenario::load(name).unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        Record::new(&scenario.craft(), &log_of(&scenario, &flight, 1))
    }

    #[test]
    fn names_are_unique_and_axes_are_all_signed_permutations() {
        let all = all(&record("cubesat-pyramid"));
        let names: HashSet<&str> = all.iter().map(|mistake| mistake.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        let axes = names.iter().filter(|name| name.starts_with("gyro axes")).count();
        let wheels = names.iter().filter(|name| name.starts_with("wheels permuted")).count();
        assert_eq!((axes, wheels), (47, 23));
    }

    #[test]
    fn causes_need_their_columns() {
        let spin_up = all(&record("stsat3-spin-up"));
        let has = |name: &str| spin_up.iter().any(|mistake| mistake.name == name);
        assert!(has("sign of the torque") && !has("sign of wheel 1"));
        assert!(!has("motor torque given as external torque") && !has("gyro slower than its log"));
        // Rows at 10 Hz are not 10 kHz.
        assert!(!has("time in ms"));
    }

    #[test]
    fn steps_count_flips_and_exchanges() {
        assert_eq!(exchanges(&[0, 1, 2, 3]), 0);
        assert_eq!(exchanges(&[3, 2, 1, 0]), 2);
        assert_eq!(exchanges(&[1, 2, 0]), 2);
        let flipped = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0));
        assert_eq!(steps_of_axes(&flipped), 2);
    }

    #[test]
    fn held_speeds_are_interpolated() {
        let mut record = record("cubesat-pyramid");
        let linear = |row: usize| 3.0 * row as f64;
        for speeds in &mut record.wheel_rad_s {
            let rows = speeds.iter_mut().enumerate();
            rows.for_each(|(row, speed)| *speed = linear(row - row % 4));
        }
        interpolate(&mut record);
        for row in 0..=600 {
            assert!((record.wheel_rad_s[1][row] - linear(row)).abs() < 1e-9, "{row}");
        }
    }

    #[test]
    fn shifts_move_speeds_and_repeat_the_ends() {
        let mut values = [1.0, 2.0, 3.0, 4.0];
        shift(&mut values, 1);
        assert_eq!(values, [2.0, 3.0, 4.0, 4.0]);
        shift(&mut values, -2);
        assert_eq!(values, [2.0, 2.0, 2.0, 3.0]);
    }
}
