//! Health over a log: the core's monitor, with an estimate once a second, and the times of its changes.

use fsw_core::Outcome;
use fsw_core::monitor::health::{Driver, Health, HealthMonitor};

use super::adapter::AnyEstimator;

/// Time between two estimates that the monitor takes in, µs: the telemetry period of the flight computer.
const ESTIMATE_US: u64 = 1_000_000;

/// A change of the health.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HealthChange {
    /// Time of the sample, µs.
    pub time_us: u64,
    /// Health from then on.
    pub health: Health,
    /// Evidence of the last change for the worse.
    pub driver: Option<Driver>,
}

/// Health of an estimator over a log.
#[derive(Clone, Debug, Default)]
pub struct HealthHistory {
    monitor: HealthMonitor,
    /// Time of the last estimate, µs.
    estimated_us: Option<u64>,
    changes: Vec<HealthChange>,
}

impl HealthHistory {
    /// Adds a sample at this time with its outcome, after the estimator has stepped.
    pub fn step(&mut self, time_us: u64, outcome: &Outcome, estimator: &dyn AnyEstimator) {
        let before = self.monitor.health();
        self.monitor.step(outcome);
        let health = self.monitor.health();
        if health != before {
            let driver = self.monitor.driver();
            self.changes.push(HealthChange { time_us, health, driver });
        }
        // A clock that was set counts as a second.
        if self.estimated_us.is_none_or(|last_us| time_us.abs_diff(last_us) >= ESTIMATE_US) {
            self.estimated_us = Some(time_us);
            self.monitor.estimate(&estimator.estimate());
        }
    }

    /// Health after the last sample.
    pub fn health(&self) -> Health {
        self.monitor.health()
    }

    /// Evidence of the last change for the worse.
    pub fn driver(&self) -> Option<Driver> {
        self.monitor.driver()
    }

    /// Changes in the order of the samples; nominal before the first.
    pub fn changes(&self) -> &[HealthChange] {
        &self.changes
    }
}
