//! Report of a fault matrix, assembled from its cells.

use super::json::{FaultCell, FaultsReport};
use crate::fault::{Cell, Matrix};

impl FaultsReport {
    /// Report of the completed runs of a matrix.
    pub fn new(matrix: &Matrix<'_>, cells: &[Cell]) -> Self {
        let cells: Vec<FaultCell> = cells.iter().map(FaultCell::from).collect();
        Self {
            scenario: matrix.scenario.name.clone(),
            seed: matrix.first_seed,
            runs: matrix.runs,
            flights: cells.iter().map(|cell| cell.runs).sum(),
            missed_cells: cells.iter().filter(|cell| !cell.missed.is_empty()).count() as u64,
            cells,
        }
    }
}

impl From<&Cell> for FaultCell {
    fn from(cell: &Cell) -> Self {
        let row = &cell.row;
        Self {
            estimator: cell.method.estimator.to_string(),
            precision: cell.method.precision.to_string(),
            fault: cell.fault.clone(),
            runs: row.runs as u64,
            panics: row.panics as u64,
            not_finite: row.not_finite as u64,
            detected: row.detected as u64,
            detection_s: row.detection_s,
            detection_worst_s: row.detection_worst_s,
            false_alarms: row.false_alarms as u64,
            degraded: row.degraded as u64,
            degraded_worst_s: row.degraded_s,
            nominal: row.nominal as u64,
            nominal_worst_s: row.nominal_s,
            outage_worst_s: row.outage_s,
            converged: row.converged as u64,
            silent_lies: row.silent as u64,
            silent_in_flight: row.silent_in_flight as u64,
            silent_worst_s: row.wrong_s,
            recovered: row.recovered as u64,
            recovery_worst_s: row.recovery_s,
            nees_during: row.nees_during,
            nees_after: row.nees_after,
            rmse_over_bound: row.over_bound,
            rmse_over_clean: row.over_clean,
            missed: row.missed.clone(),
        }
    }
}
