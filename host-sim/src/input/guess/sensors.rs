//! Columns of gyro, wheels and torque among the columns of a log.

use flight_input::craft::MAX_WHEELS;

use super::name::Name;

/// Words of a gyro, the better ones first.
const GYRO: [&str; 18] = [
    "gyro",
    "gyr",
    "giro",
    "angular",
    "angvel",
    "ang",
    "omega",
    "rate",
    "rates",
    "drehrate",
    "winkelgeschwindigkeit",
    "pqr",
    "w",
    "om",
    "rot",
    "imu",
    "g",
    "spin",
];
/// Words of other quantities with three axes.
const NOT_GYRO: [&str; 28] = [
    "acc",
    "accel",
    "mag",
    "setpoint",
    "target",
    "reference",
    "ref",
    "cmd",
    "command",
    "desired",
    "integral",
    "bias",
    "offset",
    "unfilt",
    "raw",
    "error",
    "torque",
    "wheel",
    "rw",
    "position",
    "pos",
    "orientation",
    "linear",
    "quaternion",
    "covariance",
    "temperature",
    "sun",
    "variance",
];
/// Words of a reaction wheel.
const WHEEL: [&str; 8] = ["wheel", "rw", "rwa", "rws", "reaction", "flywheel", "mw", "tacho"];
/// Words of other quantities of a wheel.
const NOT_SPEED: [&str; 18] = [
    "current",
    "temp",
    "temperature",
    "torque",
    "trq",
    "cmd",
    "command",
    "setpoint",
    "target",
    "desired",
    "voltage",
    "status",
    "power",
    "momentum",
    "state",
    "duty",
    "count",
    "accel",
];
/// Words of speeds that are those of wheels where others are those of the gyro.
const NUMBERED: [&str; 4] = ["omega", "om", "speed", "spd"];
/// Words of an external torque.
const TORQUE: [&str; 3] = ["torque", "trq", "tau"];
const EXTERNAL: [&str; 6] = ["ext", "external", "thruster", "mtq", "magnetorquer", "rcs"];

/// Columns of a kind of sensor, in the order of the craft file.
#[derive(Debug)]
pub(super) struct Found<'a> {
    /// The columns.
    pub columns: Vec<&'a Name>,
    /// First columns of other groups that are possible.
    pub others: Vec<&'a str>,
    /// Why the columns are to be confirmed, if their names do not suffice.
    pub doubt: Option<&'static str>,
}

/// Columns with one name but for the index.
struct Group<'a> {
    columns: Vec<&'a Name>,
}

fn groups(names: &[Name]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for name in names.iter().filter(|name| !name.full.is_empty()) {
        let same = groups.iter_mut().find(|group| {
            let first = group.columns[0];
            first.words == name.words
                && first.unit == name.unit
                && first.index.is_some()
                && name.index.is_some()
                && group.columns.iter().all(|column| column.index != name.index)
        });
        match same {
            Some(group) => group.columns.push(name),
            None => groups.push(Group { columns: vec![name] }),
        }
    }
    for group in &mut groups {
        group.columns.sort_by_key(|column| order(column.index.as_deref()));
    }
    groups
}

/// Place of an index among its group.
fn order(index: Option<&str>) -> u32 {
    match index {
        Some("x") => 0,
        Some("y") => 1,
        Some("z") => 2,
        Some("w") => 3,
        Some(number) => number.parse().unwrap_or(u32::MAX),
        None => 0,
    }
}

/// The three axes of a gyro.
pub(super) fn gyro(names: &[Name]) -> Option<Found<'_>> {
    let score = |group: &Group<'_>| {
        let first = group.columns[0];
        let rank = GYRO.iter().position(|word| first.has(&[word]));
        let by_word = rank.map_or(0, |rank| 20 - rank as i32);
        let by_unit = match (&first.unit, first.rate_unit()) {
            (_, Some(_)) => 10,
            (Some(_), None) => -30,
            (None, None) => 0,
        };
        let penalty = if first.has(&NOT_GYRO) { -15 } else { 0 };
        by_word + by_unit + penalty
    };
    best(three_axes(names), score).or_else(|| only(three_axes(names)))
}

/// The only three axes of a log.
fn only(groups: Vec<Group<'_>>) -> Option<Found<'_>> {
    let is_possible = |group: &Group<'_>| {
        let first = group.columns[0];
        first.unit.is_none() && !first.has(&NOT_GYRO) && !first.has(&["rpy"])
    };
    let mut possible = groups.into_iter().filter(is_possible);
    let found = possible.next().filter(|_| possible.next().is_none())?;
    let doubt = Some("the only columns x, y, z");
    Some(Found { columns: found.columns, others: Vec::new(), doubt })
}

/// The speeds of wheels.
pub(super) fn wheels(names: &[Name]) -> Option<Found<'_>> {
    let is_speed = |group: &&Group<'_>| {
        let first = group.columns[0];
        first.has(&WHEEL) && !first.has(&NOT_SPEED) && group.columns.len() <= MAX_WHEELS
    };
    let score = |group: &Group<'_>| {
        let first = group.columns[0];
        let by_unit = if first.rate_unit().is_some() { 10 } else { 0 };
        let by_word = if first.has(&["speed", "omega", "tacho", "meas", "rate"]) { 5 } else { 0 };
        let is_fit = first.unit.is_none() || first.rate_unit().is_some();
        if is_fit { 1 + by_unit + by_word } else { 0 }
    };
    let is_momentum = |group: &Group<'_>| {
        group.columns[0].momentum_unit().is_some() && group.columns.len() <= MAX_WHEELS
    };
    let named = groups(names).into_iter().filter(|group| is_speed(&group)).collect();
    let momenta = || best(groups(names).into_iter().filter(is_momentum).collect(), |_| 1);
    best(named, score).or_else(momenta).or_else(|| {
        let gyro = gyro(names)?;
        let is_numbered = |group: &Group<'_>| {
            let first = group.columns[0];
            let is_count = group.columns.iter().all(|column| {
                column.index.as_deref().is_some_and(|index| index.parse::<u32>().is_ok())
            });
            let is_speed = first.has(&NUMBERED) && !first.has(&NOT_SPEED);
            let is_other = !gyro.columns.iter().any(|column| column.full == first.full);
            is_count && is_speed && is_other && (2..=MAX_WHEELS).contains(&group.columns.len())
        };
        let numbered = groups(names).into_iter().filter(is_numbered).collect();
        best(numbered, |_| 1).map(|found| Found { doubt: Some("numbered speeds"), ..found })
    })
}

/// The three axes of an external torque.
pub(super) fn torque(names: &[Name]) -> Option<Found<'_>> {
    let score = |group: &Group<'_>| {
        let first = group.columns[0];
        let is_torque = first.has(&TORQUE) && !first.has(&WHEEL) && !first.has(&["cmd", "motor"]);
        i32::from(is_torque) * (1 + i32::from(first.has(&EXTERNAL)))
    };
    best(three_axes(names), score)
}

/// Groups of three columns x y z, 0 1 2 or 1 2 3.
fn three_axes(names: &[Name]) -> Vec<Group<'_>> {
    let is_three = |group: &Group<'_>| {
        let indices: Vec<&str> = group.columns.iter().filter_map(|c| c.index.as_deref()).collect();
        [["x", "y", "z"], ["0", "1", "2"], ["1", "2", "3"]].iter().any(|axes| indices == *axes)
    };
    groups(names).into_iter().filter(is_three).collect()
}

/// The group with the highest score above zero, the first of equals.
fn best<'a>(groups: Vec<Group<'a>>, score: impl Fn(&Group<'a>) -> i32) -> Option<Found<'a>> {
    let mut scored: Vec<(i32, Group<'a>)> =
        groups.into_iter().map(|group| (score(&group), group)).filter(|(s, _)| *s > 0).collect();
    scored.sort_by_key(|(score, _)| -score);
    let mut scored = scored.into_iter().map(|(_, group)| group.columns);
    let columns = scored.next()?;
    let others = scored.map(|columns| columns[0].full.as_str()).collect();
    Some(Found { columns, others, doubt: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<Name> {
        list.iter().map(|full| Name::of(full, None)).collect()
    }

    fn full(found: Option<Found<'_>>) -> Vec<String> {
        found.map_or(Vec::new(), |found| found.columns.iter().map(|c| c.full.clone()).collect())
    }

    #[test]
    fn gyro_is_found_beside_other_vectors() {
        let header = names(&[
            "accSmooth[0]",
            "accSmooth[1]",
            "accSmooth[2]",
            "gyroUnfilt[0] (deg/s)",
            "gyroUnfilt[1] (deg/s)",
            "gyroUnfilt[2] (deg/s)",
            "gyroADC[0] (deg/s)",
            "gyroADC[1] (deg/s)",
            "gyroADC[2] (deg/s)",
            "magADC[0]",
            "magADC[1]",
            "magADC[2]",
        ]);
        assert_eq!(full(gyro(&header))[0], "gyroADC[0] (deg/s)");
        let header = names(&[
            "/imu/linear_acceleration/x",
            "/imu/linear_acceleration/y",
            "/imu/linear_acceleration/z",
            "/imu/angular_velocity/z",
            "/imu/angular_velocity/y",
            "/imu/angular_velocity/x",
        ]);
        assert_eq!(
            full(gyro(&header)),
            ["/imu/angular_velocity/x", "/imu/angular_velocity/y", "/imu/angular_velocity/z"]
        );
        assert!(gyro(&names(&["a", "b", "c", "acc_x", "acc_y", "acc_z"])).is_none());
        assert!(gyro(&names(&["roll", "pitch", "yaw"])).is_none());
    }

    #[test]
    fn gyro_is_found_by_unit_convention_or_alone() {
        for header in [
            ["ax", "ay", "az", "gx", "gy", "gz"],
            ["roll_deg", "pitch_deg", "yaw_deg", "p", "q", "r"],
            ["pos_x", "pos_y", "pos_z", "Prędkość X [°/s]", "Prędkość Y [°/s]", "Prędkość Z [°/s]"],
            ["mag_x", "mag_y", "mag_z", "value_x", "value_y", "value_z"],
        ] {
            assert_eq!(full(gyro(&names(&header))), header[3..], "{header:?}");
        }
        let doubt = |header: &[&str]| gyro(&names(header)).and_then(|found| found.doubt);
        assert!(doubt(&["x", "y", "z"]).is_some() && doubt(&["wx", "wy", "wz"]).is_none());
    }

    #[test]
    fn wheels_are_counted_and_other_quantities_of_them_are_not() {
        let header = names(&[
            "rw1_current",
            "rw2_current",
            "rw1_speed_rpm",
            "rw2_speed_rpm",
            "rw3_speed_rpm",
            "wx",
        ]);
        assert_eq!(full(wheels(&header)), ["rw1_speed_rpm", "rw2_speed_rpm", "rw3_speed_rpm"]);
        assert_eq!(full(wheels(&names(&["wheel speed [rpm]"]))), ["wheel speed [rpm]"]);
        assert!(wheels(&names(&["gyro_x", "rw_temp"])).is_none());
        let header = names(&["w_x", "w_y", "w_z", "om1", "om2", "om3"]);
        assert_eq!(full(wheels(&header)), ["om1", "om2", "om3"]);
    }

    #[test]
    fn external_torque_is_not_that_of_a_wheel() {
        let header = names(&["rw_torque_x", "rw_torque_y", "rw_torque_z"]);
        assert!(torque(&header).is_none());
        let header = names(&["torque_x_n_m", "torque_y_n_m", "torque_z_n_m"]);
        assert_eq!(full(torque(&header)).len(), 3);
    }
}
