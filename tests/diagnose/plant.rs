//! Errors that are planted in a log or its craft file.

use anyhow::Result;
use host_sim::input::log::LogRow;
use host_sim::input::scenario::hardware::TrueMode;
use host_sim::input::{Craft, Scenario};
use host_sim::truth::Flight;
use nalgebra::{Matrix3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Constant torque that is planted, over the noise of the momentum `σ J / T`.
const TORQUE_SIGMAS: f64 = 100.0;

/// Change of log and craft by a seed; returns the name that `diagnose` should give.
type Change = Box<dyn Fn(&mut Vec<LogRow>, &mut Craft, u64) -> String + Send + Sync>;

/// Change of the true motion.
type Motion = Box<dyn Fn(&mut Scenario) + Send + Sync>;

/// An error.
pub struct Planted {
    /// Name in the table of the campaign.
    pub name: &'static str,
    /// A mistake of people; an error of the hardware otherwise.
    pub is_mistake: bool,
    motion: Option<Motion>,
    change: Change,
}

impl Planted {
    /// The flight of an error that acts on the motion.
    ///
    /// # Errors
    /// A motion that cannot be integrated.
    pub fn flight(&self, scenario: &Scenario) -> Result<Option<Flight>> {
        let Some(motion) = &self.motion else { return Ok(None) };
        let mut scenario = scenario.clone();
        motion(&mut scenario);
        Ok(Some(Flight::simulate(&scenario)?))
    }

    /// Plants the error; returns its name in a diagnosis.
    pub fn plant(&self, log: &mut Vec<LogRow>, craft: &mut Craft, seed: u64) -> String {
        (self.change)(log, craft, seed)
    }
}

fn error(
    name: &'static str,
    is_mistake: bool,
    change: impl Fn(&mut Vec<LogRow>, &mut Craft, u64) -> String + Send + Sync + 'static,
) -> Planted {
    Planted { name, is_mistake, motion: None, change: Box::new(change) }
}

/// The errors that are possible in a scenario.
pub fn planted(scenario: &Scenario) -> Vec<Planted> {
    let mut all = gyro_mistakes();
    all.extend(time_mistakes());
    let has_wheels = !scenario.wheels.is_empty();
    let has_torque = scenario.torque.at(0.0) != Vector3::zeros();
    if has_wheels {
        all.extend(wheel_mistakes());
        all.extend(wheel_units());
        all.extend(motor_torques());
    }
    if has_torque {
        all.extend(torque_mistakes());
    }
    all.extend(gyro_errors());
    all.push(torque_error());
    all.extend(modes());
    if has_wheels {
        all.extend(wheel_errors());
    }
    if has_wheels && has_torque {
        all.push(error("torque scale", false, |log, _, _| {
            log.iter_mut().for_each(|row| row.torque_n_m *= 1.05);
            "torque scale".to_owned()
        }));
    }
    all
}

/// Columns that hold x, y and z, and their signs: what the log has to be corrected by.
const GYRO_AXES: [(&str, [usize; 3], [f64; 3]); 12] = [
    ("gyro x flipped", [0, 1, 2], [-1.0, 1.0, 1.0]),
    ("gyro y flipped", [0, 1, 2], [1.0, -1.0, 1.0]),
    ("gyro z flipped", [0, 1, 2], [1.0, 1.0, -1.0]),
    ("gyro upside down", [0, 1, 2], [1.0, -1.0, -1.0]),
    ("gyro half a turn about z", [0, 1, 2], [-1.0, -1.0, 1.0]),
    ("gyro all flipped", [0, 1, 2], [-1.0, -1.0, -1.0]),
    ("gyro x and y exchanged", [1, 0, 2], [1.0, 1.0, 1.0]),
    ("gyro y and z exchanged", [0, 2, 1], [1.0, 1.0, 1.0]),
    ("gyro x and z exchanged", [2, 1, 0], [1.0, 1.0, 1.0]),
    ("gyro axes cyclic", [1, 2, 0], [1.0, 1.0, 1.0]),
    ("gyro axes cyclic, backwards", [2, 0, 1], [1.0, 1.0, 1.0]),
    ("gyro quarter of a turn about z", [1, 0, 2], [-1.0, 1.0, 1.0]),
];

fn gyro_mistakes() -> Vec<Planted> {
    let axes = GYRO_AXES.into_iter().map(|(name, order, signs)| {
        let mut correction = Matrix3::zeros();
        for axis in 0..3 {
            correction[(axis, order[axis])] = signs[axis];
        }
        let columns: Vec<String> = (0..3)
            .map(|i| {
                format!("{}{}", if signs[i] < 0.0 { "-" } else { "" }, ["x", "y", "z"][order[i]])
            })
            .collect();
        let kind = match (order == [0, 1, 2], correction.determinant() > 0.0) {
            (true, _) => "flipped",
            (false, true) => "turned",
            (false, false) => "permuted",
        };
        let expected = format!("gyro axes {kind}: x, y, z are columns {}", columns.join(", "));
        error(name, true, move |log, _, _| {
            log.iter_mut().for_each(|row| row.rate_rad_s = correction.transpose() * row.rate_rad_s);
            expected.clone()
        })
    });
    let mut all: Vec<Planted> = axes.collect();
    for (name, unit, factor) in [
        ("gyro in deg/s", "deg/s", 180.0 / std::f64::consts::PI),
        ("gyro in mrad/s", "mrad/s", 1e3),
    ] {
        all.push(error(name, true, move |log, _, _| {
            log.iter_mut().for_each(|row| row.rate_rad_s *= factor);
            format!("gyro in {unit}")
        }));
    }
    for (name, rows) in [("gyro held for 2 rows", 2), ("gyro held for 5 rows", 5)] {
        all.push(error(name, true, move |log, _, _| {
            for row in 0..log.len() {
                log[row].rate_rad_s = log[row - row % rows].rate_rad_s;
            }
            "gyro slower than its log".to_owned()
        }));
    }
    all
}

fn time_mistakes() -> Vec<Planted> {
    let time = |name: &'static str, unit: &'static str, factor: u64| {
        error(name, true, move |log, _, _| {
            log.iter_mut().for_each(|row| row.time_us *= factor);
            format!("time in {unit}")
        })
    };
    vec![time("time in ms", "ms", 1_000), time("time in µs", "µs", 1_000_000)]
}

/// Speeds of each row from `rows` earlier: late wheels.
fn late(log: &mut [LogRow], rows: isize) {
    let speeds: Vec<Vec<f64>> = log.iter().map(|row| row.wheel_speed_rad_s.clone()).collect();
    for (index, row) in log.iter_mut().enumerate() {
        let from = index.saturating_add_signed(-rows).min(speeds.len() - 1);
        row.wheel_speed_rad_s.clone_from(&speeds[from]);
    }
}

fn wheel_mistakes() -> Vec<Planted> {
    let mut all = vec![
        error("sign of one wheel", true, |_, craft, seed| {
            let wheel = seed as usize % craft.wheels.len();
            craft.wheels[wheel].axis *= -1.0;
            format!("sign of wheel {}", wheel + 1)
        }),
        error("sign of all wheels", true, |_, craft, _| {
            craft.wheels.iter_mut().for_each(|wheel| wheel.axis *= -1.0);
            "sign of all wheels".to_owned()
        }),
        error("two wheels exchanged", true, |log, craft, seed| {
            let count = craft.wheels.len();
            let (a, b) = (seed as usize % count, (seed as usize + 1) % count);
            log.iter_mut().for_each(|row| row.wheel_speed_rad_s.swap(a, b));
            let mut order: Vec<usize> = (1..=count).collect();
            order.swap(a, b);
            permuted(&order)
        }),
        error("wheels in reverse order", true, |log, craft, _| {
            log.iter_mut().for_each(|row| row.wheel_speed_rad_s.reverse());
            permuted(&(1..=craft.wheels.len()).rev().collect::<Vec<_>>())
        }),
        error("axis of one wheel", true, |_, craft, seed| {
            let wheel = seed as usize % craft.wheels.len();
            let axis = craft.wheels[wheel].axis;
            let body = axis.iamax();
            craft.wheels[wheel].axis = Vector3::ith((body + 1) % 3, 1.0);
            // A skewed wheel is along no body axis.
            if axis[body].abs() < 0.99 {
                return "wheel axis".to_owned();
            }
            let sign = if axis[body] < 0.0 { "-" } else { "" };
            format!("axis of wheel {}: along {sign}{}", wheel + 1, ["x", "y", "z"][body])
        }),
    ];
    for (name, rows) in [
        ("wheels late by 1 row", 1),
        ("wheels late by 2 rows", 2),
        ("wheels late by 3 rows", 3),
        ("wheels early by 1 row", -1),
        ("wheels early by 2 rows", -2),
        ("wheels early by 3 rows", -3),
    ] {
        all.push(error(name, true, move |log, _, _| {
            late(log, rows);
            name.replacen("wheels", "wheel speeds", 1)
        }));
    }
    for (name, rows) in [
        ("one wheel late by 1 row", 1),
        ("one wheel late by 5 rows", 5),
        ("one wheel early by 2 rows", -2),
    ] {
        all.push(error(name, true, move |log, craft, seed| {
            let wheel = seed as usize % craft.wheels.len();
            let kept: Vec<LogRow> = log.clone();
            late(log, rows);
            for (row, kept) in log.iter_mut().zip(kept) {
                let speed = row.wheel_speed_rad_s[wheel];
                row.wheel_speed_rad_s = kept.wheel_speed_rad_s;
                row.wheel_speed_rad_s[wheel] = speed;
            }
            let (_, by) = name.split_once("wheel ").unwrap_or_default();
            format!("speed of wheel {} {by}", wheel + 1)
        }));
    }
    all.push(error("one wheel in rpm", true, |log, craft, seed| {
        let wheel = seed as usize % craft.wheels.len();
        log.iter_mut().for_each(|row| row.wheel_speed_rad_s[wheel] *= 30.0 / std::f64::consts::PI);
        format!("speed of wheel {} in rpm", wheel + 1)
    }));
    for (name, rows) in [("wheels held for 2 rows", 2), ("wheels held for 5 rows", 5)] {
        all.push(error(name, true, move |log, _, _| {
            for row in 0..log.len() {
                let held = log[row - row % rows].wheel_speed_rad_s.clone();
                log[row].wheel_speed_rad_s = held;
            }
            "wheel speeds held".to_owned()
        }));
    }
    all
}

fn permuted(order: &[usize]) -> String {
    let numbers: Vec<String> = order.iter().map(usize::to_string).collect();
    format!("wheels permuted: [[wheel]] in order has columns {}", numbers.join(", "))
}

fn wheel_units() -> Vec<Planted> {
    use std::f64::consts::PI;
    let speeds = [
        ("wheels in rpm", "rpm", 30.0 / PI),
        ("wheels in rev/s", "rev/s", 0.5 / PI),
        ("wheels in deg/s", "deg/s", 180.0 / PI),
    ];
    let mut all = Vec::new();
    for (name, unit, factor) in speeds {
        all.push(error(name, true, move |log, _, _| {
            let all = log.iter_mut().flat_map(|row| &mut row.wheel_speed_rad_s);
            all.for_each(|speed| *speed *= factor);
            format!("wheel speeds in {unit}")
        }));
    }
    let inertias = [
        ("wheel inertias in g m²", "g m²", 1e3),
        ("wheel inertias in kg cm²", "kg cm²", 1e4),
        ("wheel inertias in g cm²", "g cm²", 1e7),
    ];
    for (name, unit, factor) in inertias {
        all.push(error(name, true, move |_, craft, _| {
            craft.wheels.iter_mut().for_each(|wheel| wheel.spin_inertia_kg_m2 *= factor);
            format!("spin inertia of all wheels in {unit}")
        }));
    }
    for (name, unit, factor) in
        [("one wheel inertia in g m²", "g m²", 1e3), ("one wheel inertia in g cm²", "g cm²", 1e7)]
    {
        all.push(error(name, true, move |_, craft, seed| {
            let wheel = seed as usize % craft.wheels.len();
            craft.wheels[wheel].spin_inertia_kg_m2 *= factor;
            format!("spin inertia of wheel {} in {unit}", wheel + 1)
        }));
    }
    all
}

/// Torque of the motors on the body or on the wheels, in the columns of the external torque.
fn motor_torques() -> Vec<Planted> {
    let motor = |name: &'static str, sign: f64| {
        error(name, true, move |log, craft, _| {
            let momentum = |row: &LogRow| {
                let wheels = craft.wheels.iter().zip(&row.wheel_speed_rad_s);
                wheels
                    .map(|(w, speed)| w.axis * (w.spin_inertia_kg_m2 * speed))
                    .sum::<Vector3<f64>>()
            };
            let momenta: Vec<_> = log.iter().map(momentum).collect();
            for row in 1..log.len() {
                let step_s = (log[row].time_us - log[row - 1].time_us) as f64 * 1e-6;
                log[row].torque_n_m = (momenta[row] - momenta[row - 1]) * (sign / step_s);
            }
            "motor torque given as external torque".to_owned()
        })
    };
    vec![motor("motor torque on the body", -1.0), motor("motor torque on the wheels", 1.0)]
}

fn torque_mistakes() -> Vec<Planted> {
    let mut all = vec![
        error("sign of the torque", true, |log, _, _| {
            log.iter_mut().for_each(|row| row.torque_n_m *= -1.0);
            "sign of the torque".to_owned()
        }),
        error("torque in mN m", true, |log, _, _| {
            log.iter_mut().for_each(|row| row.torque_n_m *= 1e3);
            "torque in mN m".to_owned()
        }),
    ];
    for (axis, name) in
        ["sign of torque x", "sign of torque y", "sign of torque z"].into_iter().enumerate()
    {
        all.push(error(name, true, move |log, _, _| {
            log.iter_mut().for_each(|row| row.torque_n_m[axis] *= -1.0);
            name.to_owned()
        }));
    }
    all
}

/// Numbers of either sign of a size between this and twice this.
fn draw(random: &mut Pcg64, size: f64) -> f64 {
    let value = random.random_range(size..2.0 * size);
    if random.random::<bool>() { value } else { -value }
}

/// Interpolated wheel speeds, `delay_s` later: a gyro that is late by it.
fn delay(log: &mut [LogRow], delay_s: f64) {
    let old = log.to_vec();
    let step_s = (old[1].time_us - old[0].time_us) as f64 * 1e-6;
    for (index, row) in log.iter_mut().enumerate() {
        let place = index as f64 + delay_s / step_s;
        let first = (place.floor() - 1.0).clamp(0.0, old.len() as f64 - 4.0) as usize;
        for (wheel, speed) in row.wheel_speed_rad_s.iter_mut().enumerate() {
            *speed = (first..first + 4)
                .map(|k| {
                    let others = (first..first + 4).filter(|i| *i != k);
                    let weight: f64 =
                        others.map(|i| (place - i as f64) / (k as f64 - i as f64)).product();
                    weight * old[k].wheel_speed_rad_s[wheel]
                })
                .sum();
        }
    }
}

fn gyro_errors() -> Vec<Planted> {
    vec![
        error("gyro scale 0.5 to 1 %", false, |log, _, seed| {
            let mut random = Pcg64::seed_from_u64(seed);
            let scale = Vector3::from_fn(|_, _| 1.0 + draw(&mut random, 0.005));
            log.iter_mut().for_each(|row| row.rate_rad_s.component_mul_assign(&scale));
            "gyro scale factor".to_owned()
        }),
        error("gyro axes 0.5° to 1°", false, |log, _, seed| {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut matrix = Matrix3::identity();
            for (i, k) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
                matrix[(i, k)] = draw(&mut random, 0.5_f64.to_radians());
            }
            log.iter_mut().for_each(|row| row.rate_rad_s = matrix * row.rate_rad_s);
            "gyro axes".to_owned()
        }),
        error("gyro bias 0.5 to 1 mrad/s", false, |log, _, seed| {
            let mut random = Pcg64::seed_from_u64(seed);
            let bias = Vector3::from_fn(|_, _| draw(&mut random, 5e-4));
            log.iter_mut().for_each(|row| row.rate_rad_s += bias);
            "gyro bias".to_owned()
        }),
        error("noise twice as stated", false, |_, craft, _| {
            craft.gyro.noise_rad_s = craft.gyro.noise_rad_s.map(|noise| 0.5 * noise);
            "gyro noise other than stated".to_owned()
        }),
        error("outliers on 1 %", false, |log, _, seed| {
            let mut random = Pcg64::seed_from_u64(seed);
            for _ in 0..log.len().div_ceil(100) {
                let (row, axis) =
                    (random.random_range(8..log.len() - 8), random.random_range(0..3));
                log[row].rate_rad_s[axis] += draw(&mut random, 0.01);
            }
            "outliers".to_owned()
        }),
    ]
}

fn wheel_errors() -> Vec<Planted> {
    vec![
        error("gyro late by 0.2 to 0.4 rows", false, |log, _, seed| {
            let delay_s = draw(&mut Pcg64::seed_from_u64(seed), 0.02);
            delay(log, delay_s);
            "time offset".to_owned()
        }),
        error("wheel inertias 1 to 2 %", false, |_, craft, seed| {
            let mut random = Pcg64::seed_from_u64(seed);
            for wheel in &mut craft.wheels {
                wheel.spin_inertia_kg_m2 *= 1.0 + draw(&mut random, 0.01);
            }
            "wheel spin inertia".to_owned()
        }),
        error("wheel axes 0.5° to 1°", false, |_, craft, seed| {
            let mut random = Pcg64::seed_from_u64(seed);
            for wheel in &mut craft.wheels {
                let tilt = Vector3::from_fn(|_, _| draw(&mut random, 0.5_f64.to_radians()));
                wheel.axis = (wheel.axis + wheel.axis.cross(&tilt)).normalize();
            }
            "wheel axis".to_owned()
        }),
    ]
}

/// An error that acts on the motion.
fn of_motion(
    name: &'static str,
    found: &'static str,
    motion: impl Fn(&mut Scenario) + Send + Sync + 'static,
) -> Planted {
    let change = error(name, false, move |_, _, _| found.to_owned());
    Planted { motion: Some(Box::new(motion)), ..change }
}

/// A torque that is [`TORQUE_SIGMAS`] of the noise of momentum over the flight.
fn torque_error() -> Planted {
    of_motion("constant torque", "constant torque", |scenario| {
        let inertia = &scenario.spacecraft.inertia_kg_m2;
        let size = TORQUE_SIGMAS * scenario.gyro.noise_rad_s / scenario.duration_s;
        scenario.disturbance_torque_n_m = Vector3::new(inertia[0], -inertia[1], inertia[2]) * size;
    })
}

/// Appendages and slosh about a skew axis.
fn modes() -> Vec<Planted> {
    let mode = |name: &'static str, frequency_hz: f64, damping: f64, inertia_share: f64| {
        of_motion(name, "flexible mode or slosh", move |scenario| {
            let axis = Some(Unit::new_normalize(Vector3::new(0.5, 0.8, 0.33)));
            let mode = TrueMode { frequency_hz, damping, inertia_share, axis };
            scenario.true_hardware.modes = vec![mode];
        })
    };
    vec![
        mode("mode at 0.4 Hz, 3 %", 0.4, 0.005, 0.03),
        mode("mode at 1.5 Hz, 5 %", 1.5, 0.01, 0.05),
        mode("slosh at 0.05 Hz, 2 %", 0.05, 0.02, 0.02),
    ]
}
