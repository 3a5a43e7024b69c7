//! Log of a simulated flight: sensor readings at each true state.

use nalgebra::UnitQuaternion;

use crate::input::log::LogRow;
use crate::input::scenario::Scenario;
use crate::sensor::gyro::Gyro;
use crate::truth::Flight;

/// Log of a flight with the gyro noise of this seed, in the form that `replay` reads. Wheel speeds,
/// commanded torque and attitude are without error.
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
            attitude: Some(inertial_to_body(&instant.attitude)),
        })
        .collect()
}

/// Attitude as columns of a log: quaternion from inertial to body axes, scalar last.
///
/// The quaternion that rotates a vector from body to inertial axes (`v′ = q v q*`) has the same four
/// components as the one that transforms components from inertial to body axes by \[Kim2010\]
/// Eq. (6).
fn inertial_to_body(body_to_inertial: &UnitQuaternion<f64>) -> [f64; 4] {
    let q = body_to_inertial;
    [q.i, q.j, q.k, q.w]
}

#[cfg(test)]
mod tests {
    use fsw_core::Quaternion;
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn attitude_of_the_log_transforms_inertial_into_body_components() {
        let attitude = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.8);
        let to_body = Quaternion::new(inertial_to_body(&attitude)).to_body().unwrap();
        let inertial = Vector3::new(0.2, -1.0, 0.7);
        assert!((to_body * inertial - attitude.inverse() * inertial).norm() < 1e-15);
    }
}
