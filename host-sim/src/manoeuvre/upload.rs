//! Table of the flight computer of a design.

use fsw_core::manoeuvre::{Limits, MOST_REPEATS, TableError};
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::manoeuvre::{FlightTable, SPLINES};
use thiserror::Error;

use super::design::Design;
use super::problem::Request;
use crate::input::Scenario;

/// Share by which the limits of excursion and rate on board exceed those of the design: noise of the gyro, in the angle
/// its integral, and torques outside the model.
const RESERVE: f64 = 0.25;
/// Noise of the gyro, in sigmas of a reading, that the rate limit leaves room for: exceeded on an axis once in 10⁹ readings.
const RATE_SIGMAS: f64 = 6.0;
/// Largest limits of a table.
const MOST_EXCURSION_RAD: f64 = 1.57;
const MOST_RATE_RAD_S: f64 = 10.0;

/// Reason for which the flight computer cannot fly a design.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum NotFlown {
    /// Thrusters.
    #[error("the design has pulses of thrusters, and the flight computer commands wheels alone")]
    Thrusters,
    /// More wheels than places.
    #[error("the design has {0} wheels, the flight computer {WHEELS}")]
    Wheels(usize),
    /// More coefficients than places.
    #[error(
        "the design has {0} coefficients, the flight computer {SPLINES}; repeat a shorter pattern"
    )]
    Splines(usize),
    /// Value that the flight computer rejects.
    #[error("the flight computer rejects the table: {0}")]
    Table(TableError),
}

/// The table that the flight computer plays.
///
/// Torque and speed limits are those of the wheels. The excursion limit is that of the request and a quarter. The rate
/// limit is the largest rate of the design within two sigma of the prior and a quarter, and six sigma of the gyro.
///
/// # Errors
/// See [`NotFlown`].
pub fn flight_table(
    scenario: &Scenario,
    request: &Request,
    design: &Design,
) -> Result<FlightTable, NotFlown> {
    let wheels = scenario.wheels.len();
    let splines = design.coefficients_n_m.first().map_or(0, Vec::len);
    if !scenario.torque.thrusters.is_empty() {
        return Err(NotFlown::Thrusters);
    }
    if wheels > WHEELS {
        return Err(NotFlown::Wheels(wheels));
    }
    if splines > SPLINES {
        return Err(NotFlown::Splines(splines));
    }
    let of = |value: &dyn Fn(usize) -> Option<f64>| -> [f32; WHEELS] {
        std::array::from_fn(|i| value(i).unwrap_or(0.0) as f32)
    };
    let noise_rad_s = RATE_SIGMAS * scenario.gyro.reading_variance_rad2_s2().sqrt();
    let limits = |i: usize| scenario.wheels.get(i).map(|wheel| wheel.wheel.limits);
    let mut table = FlightTable {
        knot_us: (design.knot_s * 1e6).round() as u32,
        repeats: u32::try_from(design.repeats).unwrap_or(MOST_REPEATS + 1),
        splines: splines as u32,
        limits: Limits {
            torque_n_m: of(&|i| limits(i)?.max_torque_n_m),
            speed_rad_s: of(&|i| limits(i)?.max_speed_rad_s),
            rate_rad_s: (design.best.peak_rate_rad_s * (1.0 + RESERVE) + noise_rad_s)
                .min(MOST_RATE_RAD_S) as f32,
            excursion_rad: (request.limits.excursion_rad * (1.0 + RESERVE)).min(MOST_EXCURSION_RAD)
                as f32,
        },
        ..FlightTable::EMPTY
    };
    for (places, coefficients) in table.coefficients_n_m.iter_mut().zip(&design.coefficients_n_m) {
        places.iter_mut().zip(coefficients).for_each(|(place, c)| *place = *c as f32);
    }
    let spin = of(&|i| Some(scenario.wheels.get(i)?.wheel.spin_inertia_kg_m2));
    table.validate(&spin).map_err(NotFlown::Table)?;
    Ok(table)
}
