//! Report and time history of a processor-in-the-loop flight.

use std::time::Duration;

use fsw_target::link::telemetry::{Received, Telemetry};
use nalgebra::Vector3;

use super::history::HistoryRow;
use super::json::{PilReport, ReplayReport, RunReport, TargetReport};
use crate::estimation::{EstimationResult, Method, any_estimator};
use crate::input::log::LogRow;
use crate::pil::software::{Readings, Software};
use crate::pil::{Mission, PilFlight};

/// Time history of a flight, and the log of its sensors.
#[derive(Debug, Default)]
pub struct PilHistory {
    gyro_noise_rad_s: f64,
    /// State of the estimator after each sample that was stepped.
    pub rows: Vec<HistoryRow>,
    /// Sensor readings of the same samples.
    pub log: Vec<LogRow>,
}

impl PilHistory {
    /// Empty history of a flight with this gyro noise, one sigma, rad/s.
    pub fn new(gyro_noise_rad_s: f64) -> Self {
        Self { gyro_noise_rad_s, ..Self::default() }
    }

    /// Adds a sample from the host's flight computer and its telemetry. A skipped sample has no
    /// outcome in its telemetry and is left out.
    pub fn add(&mut self, software: &Software<'_, '_>, telemetry: &[Received]) {
        let outcome = telemetry.iter().find_map(|received| match received.telemetry {
            Telemetry::Estimate(estimate) => estimate.outcome,
            _ => None,
        });
        let Some(outcome) = outcome else { return };
        let row = log_row(&software.readings(), self.log.len() as u64 + 2);
        let estimator = any_estimator(software.estimator().clone(), Some(self.gyro_noise_rad_s));
        self.rows.push(HistoryRow::new(&row, &outcome, estimator.as_ref()));
        self.log.push(row);
    }
}

/// Sensor readings as a row of a log. The heading is line 1.
fn log_row(readings: &Readings, line: u64) -> LogRow {
    let widen = |vector: &fsw_core::Vec3<f32>| Vector3::from_fn(|i, _| f64::from(vector[i]));
    LogRow {
        line,
        time_us: readings.time_us,
        rate_rad_s: widen(&readings.rate_rad_s),
        wheel_speed_rad_s: readings.wheel_speed_rad_s.map(f64::from).to_vec(),
        torque_n_m: widen(&readings.torque_n_m),
        attitude: None,
    }
}

impl PilReport {
    /// Report of a completed flight; `wall` is the time that it took.
    pub fn new(mission: &Mission<'_>, method: Method, flown: &PilFlight, wall: Duration) -> Self {
        let estimator = any_estimator(flown.estimator.clone(), None);
        let result = EstimationResult {
            counts: flown.outcomes,
            events: flown.events.clone(),
            estimate: estimator.estimate(),
            hardware: estimator.hardware(),
        };
        let mut estimate = ReplayReport::new(method, flown.compared, &result);
        for (reason, count) in
            [("gyro_failed", flown.gyro_failures), ("no_wheel_speed", flown.wheel_failures)]
        {
            if count > 0 {
                estimate.rejected.insert(reason.to_owned(), u64::from(count));
            }
        }
        Self {
            run: RunReport::of_flight(mission.scenario, mission.seed, mission.flight, estimate),
            target: TargetReport {
                identical_samples: flown.compared as u64,
                restarted_at: mission.restart_at,
                stack_high_water_bytes: flown.stack_high_water_bytes,
                wall_s: wall.as_secs_f64(),
            },
        }
    }
}
