//! Log of a simulated flight: sensor readings at each true state.

use nalgebra::{UnitQuaternion, Vector3};

use crate::fault::inject;
use crate::input::log::LogRow;
use crate::input::scenario::Scenario;
use crate::sensor::clock::Clock;
use crate::sensor::gyro::Gyro;
use crate::sensor::rate_filter::RateFilter;
use crate::sensor::tachometer::{Angles, Tachometers};
use crate::truth::{Flight, Instant, Trajectory};

/// Log of a flight with the gyro noise of this seed, in the form that `replay` reads, after the faults of
/// its samples. The scenario is that of the seed. Commanded torque and attitude are without error.
pub fn log_of(scenario: &Scenario, flight: &Flight, seed: u64) -> Vec<LogRow> {
    let rows = sensors(scenario, flight, seed);
    if scenario.faults.is_empty() {
        return rows;
    }
    let samples = inject(rows, &scenario.faults, scenario.gyro.noise_rad_s, seed);
    samples.into_iter().map(|sample| sample.row).collect()
}

/// The same before the faults.
pub fn sensors(scenario: &Scenario, flight: &Flight, seed: u64) -> Vec<LogRow> {
    let hardware = &scenario.true_hardware;
    let period_s = 1.0 / scenario.gyro.rate_hz;
    let mut gyro = Gyro::with_errors(&scenario.gyro, &hardware.gyro, seed);
    let mut tachometers = Tachometers::new(scenario.tachometers().collect(), period_s, seed);
    let mut clock = Clock::new(hardware.clock, period_s, seed);
    let observed = flight.trajectory.as_ref().map(|along| Observed::new(scenario, along));
    let row = |(instant, line): (&Instant, u64)| {
        let true_s = clock.true_time_s(instant.time_us);
        let rate_rad_s = observed.as_ref().map(|observed| observed.rate_rad_s(true_s));
        let along = observed.as_ref().map(|observed| (&observed.angles, true_s));
        LogRow {
            line,
            time_us: instant.time_us,
            rate_rad_s: gyro.read(instant.time_us, &rate_rad_s.unwrap_or(instant.rate_rad_s)),
            wheel_speed_rad_s: tachometers.read(&instant.wheel_speed_rad_s, along),
            torque_n_m: observed
                .as_ref()
                .map_or(instant.torque_n_m, |_| scenario.torque.at(true_s)),
            attitude: Some(inertial_to_body(&instant.attitude)),
        }
    };
    flight.instants.iter().zip(2..).map(row).collect()
}

/// Motion as the sensors observe it, at any true time.
pub struct Observed<'a> {
    filter: RateFilter<'a>,
    angles: Angles<'a>,
    delay_s: f64,
    /// Duration of the mean; none for the instantaneous rate.
    mean_s: Option<f64>,
}

impl<'a> Observed<'a> {
    /// Motion of this scenario along its trajectory.
    pub fn new(scenario: &Scenario, trajectory: &'a Trajectory) -> Self {
        Self::with_lag(scenario, trajectory, scenario.true_hardware.gyro.lag_s)
    }

    /// The same with this time constant of the gyro's low-pass filter, s.
    pub fn with_lag(scenario: &Scenario, trajectory: &'a Trajectory, lag_s: f64) -> Self {
        let gyro = &scenario.true_hardware.gyro;
        Self {
            filter: RateFilter::new(trajectory, lag_s),
            angles: Angles::new(trajectory),
            delay_s: gyro.delay_s,
            mean_s: gyro.averaged.then_some(1.0 / scenario.gyro.rate_hz),
        }
    }

    /// Rate that a reading at this time shows, without axes, bias and noise, rad/s.
    pub fn rate_rad_s(&self, true_s: f64) -> Vector3<f64> {
        let shown_s = true_s - self.delay_s;
        match self.mean_s {
            Some(mean_s) => self.filter.mean(shown_s - mean_s, shown_s),
            None => self.filter.at(shown_s),
        }
    }
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
    use super::*;
    use fsw_core::Quaternion;

    #[test]
    fn attitude_of_the_log_transforms_inertial_into_body_components() {
        let attitude = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.8);
        let to_body = Quaternion::new(inertial_to_body(&attitude)).to_body().unwrap();
        let inertial = Vector3::new(0.2, -1.0, 0.7);
        assert!((to_body * inertial - attitude.inverse() * inertial).norm() < 1e-15);
    }
}
