//! A simulated log: what the sensors recorded of a flight.

use crate::input::log::LogRow;
use crate::input::scenario::Scenario;
use crate::sensor::gyro::Gyro;
use crate::truth::Flight;

/// The log of a flight with the gyro noise of this seed, as `replay` would read it.
pub fn log_of(scenario: &Scenario, flight: &Flight, seed: u64) -> Vec<LogRow> {
    let mut gyro = Gyro::new(&scenario.gyro, seed);
    flight
        .instants
        .iter()
        .zip(2..)
        .map(|(instant, line)| LogRow {
            line,
            time_us: instant.time_us,
            rate_rad_s: gyro.read(instant.time_us, &instant.rate_rad_s),
            wheel_speed_rad_s: instant.wheel_speed_rad_s.clone(),
            torque_n_m: instant.torque_n_m,
        })
        .collect()
}
