//! `faults`: the matrix.

use serde::Serialize;

/// Result of a fault matrix.
#[derive(Clone, Debug, Serialize)]
pub struct FaultsReport {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of the first run.
    pub seed: u64,
    /// Runs of a cell, requested.
    pub runs: u64,
    /// Flights in all.
    pub flights: u64,
    /// Cells that miss a requirement.
    pub missed_cells: u64,
    /// Cells: for each estimator and precision the clean flight, then each fault.
    pub cells: Vec<FaultCell>,
}

/// One estimator with one fault. Times in s.
#[derive(Clone, Debug, Serialize)]
pub struct FaultCell {
    /// Estimator.
    pub estimator: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// Name of the fault; null for the clean flight.
    pub fault: Option<String>,
    /// Completed runs.
    pub runs: u64,
    /// Runs in which the estimator panicked.
    pub panics: u64,
    /// Runs in which it reported a number that is not finite.
    pub not_finite: u64,
    /// Runs with a report that the clean flight of the same seed does not have.
    pub detected: u64,
    /// Median time from the start of the fault to that report.
    pub detection_s: Option<f64>,
    /// Longest of these times.
    pub detection_worst_s: Option<f64>,
    /// Clean flights that report a fault.
    pub false_alarms: u64,
    /// Runs whose health is worse than that of the clean flight; clean flights that are not nominal at some time after
    /// their convergence.
    pub degraded: u64,
    /// Longest time from the start of the fault until then.
    pub degraded_worst_s: Option<f64>,
    /// Runs that end with the health of the clean flight.
    pub nominal: u64,
    /// Longest time from the end of the fault until that health for good, of these runs.
    pub nominal_worst_s: Option<f64>,
    /// Longest total time after the end of the fault with a health that is worse than that of the clean flight.
    pub outage_worst_s: f64,
    /// Runs that end converged.
    pub converged: u64,
    /// Runs whose final estimate is converged, not called non-white, and beyond 5 of its sigmas, where that of the
    /// clean flight is not.
    pub silent_lies: u64,
    /// Runs with such an estimate in flight.
    pub silent_in_flight: u64,
    /// Longest time from the start of the fault to such an estimate in flight.
    pub silent_worst_s: f64,
    /// Runs that end as right as the clean flight.
    pub recovered: u64,
    /// Longest time from the end of the fault until the estimate is as right as the clean one for good.
    pub recovery_worst_s: Option<f64>,
    /// Mean NEES per degree of freedom, of the converged estimates from the start of the fault to a minute after its end.
    pub nees_during: Option<f64>,
    /// Mean NEES per degree of freedom of the final estimates.
    pub nees_after: Option<f64>,
    /// RMS over runs and elements of final error over the bound of the clean flight.
    pub rmse_over_bound: Option<f64>,
    /// The same over that of the clean flights.
    pub rmse_over_clean: Option<f64>,
    /// Requirements that the cell misses.
    pub missed: Vec<String>,
}
