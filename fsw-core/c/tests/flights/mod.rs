//! Recorded flights of the examples, as rows.
#![allow(dead_code, reason = "each test uses a part")]

use fsw_core_c::fsw_sample;
pub use fsw_core_c::fsw_wheels;

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub time_us: u64,
    pub rate_rad_s: [f32; 3],
    pub wheel_speed_rad_s: [f32; 4],
    pub torque_n_m: [f32; 3],
}

pub type Rows = [Row];

/// Spin-up of STSAT-3 by thrusters.
pub fn spin_up() -> Vec<Row> {
    rows(include_str!("../../examples/flights/spin_up.inc"))
}

/// Slew of a cubesat by four wheels.
pub fn wheel_slew() -> Vec<Row> {
    rows(include_str!("../../examples/flights/wheel_slew.inc"))
}

/// The rows `ROW(time, rates, wheel speeds, torques)` of an include file.
fn rows(text: &str) -> Vec<Row> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("ROW(")?.strip_suffix(')'));
    lines
        .map(|line| {
            let (time, numbers) = line.split_once(',').unwrap();
            let numbers: Vec<f32> = numbers
                .split(',')
                .map(|number| number.trim().trim_end_matches('f').parse().unwrap())
                .collect();
            Row {
                time_us: time.parse().unwrap(),
                rate_rad_s: numbers[..3].try_into().unwrap(),
                wheel_speed_rad_s: numbers[3..7].try_into().unwrap(),
                torque_n_m: numbers[7..].try_into().unwrap(),
            }
        })
        .collect()
}

/// Sample of C.
pub fn sample(row: &Row) -> fsw_sample {
    fsw_sample {
        struct_size: size_of::<fsw_sample>() as u32,
        reserved: 0,
        time_us: row.time_us,
        rate_rad_s: row.rate_rad_s,
        wheel_speed_rad_s: row.wheel_speed_rad_s,
        torque_n_m: row.torque_n_m,
    }
}

/// Wheels of both flights.
pub fn pyramid() -> fsw_wheels {
    fsw_wheels {
        axis: [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0]],
        spin_inertia_kg_m2: [2.1e-5; 4],
    }
}
