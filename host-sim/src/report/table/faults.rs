//! Table of `faults`: a part for each estimator, a row for each fault.

use super::cells::{EMPTY, heading, or};
use crate::report::columns::Columns;
use crate::report::json::{FaultCell, FaultsReport};
use crate::report::number::significant;

/// Table of a fault matrix.
pub fn faults(report: &FaultsReport) -> String {
    let last_seed = report.seed.wrapping_add(report.runs.saturating_sub(1));
    let mut text = [
        heading("scenario", &format!("{}, seeds {} to {last_seed}", report.scenario, report.seed)),
        heading("flights", &report.flights.to_string()),
        heading("missed", &format!("{} of {} cells", report.missed_cells, report.cells.len())),
    ]
    .concat();
    let same =
        |a: &FaultCell, b: &FaultCell| a.estimator == b.estimator && a.precision == b.precision;
    for cells in report.cells.chunk_by(same) {
        text += &part(cells);
    }
    text
}

/// The cells of one estimator.
fn part(cells: &[FaultCell]) -> String {
    let Some(clean) = cells.first() else { return String::new() };
    let mut table = Columns::new(&[
        ("fault", ""),
        ("survived", ""),
        ("detected", ""),
        ("after", "s"),
        ("degraded", ""),
        ("within", "s"),
        ("nominal", ""),
        ("within", "s"),
        ("outage", "s"),
        ("converged", ""),
        ("silent", ""),
        ("in flight", "s"),
        ("recovered", ""),
        ("after", "s"),
        ("NEES", "during"),
        ("NEES", "end"),
        ("RMS", "/bound"),
        ("RMS", "/clean"),
        ("missed", ""),
    ]);
    cells.iter().for_each(|cell| table.row(fault_row(cell)));
    let name = format!("{}, {}", clean.estimator, clean.precision);
    let alarms = format!("{} of {} clean flights", clean.false_alarms, clean.runs);
    ["\n", &heading("estimator", &name), &heading("false alarms", &alarms), "\n", &table.finish()]
        .concat()
}

/// Cells of a row.
pub(in crate::report) fn fault_row(cell: &FaultCell) -> Vec<String> {
    let number = |value: Option<f64>| or(value.map(|value| significant(value, 3)), EMPTY);
    let name = cell.fault.clone();
    let is_fault = name.is_some();
    let of_fault = |text: String| if is_fault { text } else { EMPTY.to_owned() };
    let lost = cell.panics + cell.not_finite;
    let missed = if cell.missed.is_empty() { EMPTY.into() } else { cell.missed.join(", ") };
    vec![
        name.unwrap_or_else(|| "none".to_owned()),
        (cell.runs - lost.min(cell.runs)).to_string(),
        of_fault(cell.detected.to_string()),
        of_fault(number(cell.detection_s)),
        cell.degraded.to_string(),
        of_fault(number(cell.degraded_worst_s)),
        of_fault(cell.nominal.to_string()),
        of_fault(number(cell.nominal_worst_s)),
        of_fault(significant(cell.outage_worst_s, 3)),
        cell.converged.to_string(),
        cell.silent_lies.to_string(),
        of_fault(significant(cell.silent_worst_s, 3)),
        of_fault(cell.recovered.to_string()),
        of_fault(number(cell.recovery_worst_s)),
        of_fault(number(cell.nees_during)),
        number(cell.nees_after),
        number(cell.rmse_over_bound),
        of_fault(number(cell.rmse_over_clean)),
        missed,
    ]
}
