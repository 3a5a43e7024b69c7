//! Table of several logs: one row for each result.

use super::cells::{DIGITS, EMPTY};
use crate::input::ELEMENT_NAMES;
use crate::report::columns::Columns;
use crate::report::json::{LogReport, ReplayReport, Status};
use crate::report::number::significant;

/// Rows of the results, and the number of each status.
pub fn logs(reports: &[LogReport]) -> String {
    let mut columns = vec![
        ("log", ""),
        ("estimator", ""),
        ("samples", ""),
        ("skipped", ""),
        ("status", ""),
        ("observed", "of 6"),
        ("white", ""),
    ];
    columns.extend(ELEMENT_NAMES.map(|name| (name, "kg m²")));
    columns.push(("largest sigma", "%"));
    let mut table = Columns::new(&columns);
    for report in reports {
        let mut cells = vec![report.log.clone()];
        match &report.result {
            Some(result) => cells.extend(result_cells(result)),
            None => cells.extend(failed_cells(report)),
        }
        table.row(cells);
    }
    format!("{}\n{}\n", table.finish(), totals(reports))
}

fn result_cells(result: &ReplayReport) -> Vec<String> {
    let skipped: u64 = result.skipped_rows.values().sum();
    let white = match result.residuals_white {
        Some(true) => "yes",
        Some(false) => "no",
        None => EMPTY,
    };
    let mut cells = vec![
        result.estimator.clone(),
        result.samples.to_string(),
        skipped.to_string(),
        result.status.to_string(),
        result.observed_directions.to_string(),
        white.to_owned(),
    ];
    let is_known = result.observed_directions > 0;
    let elements = result.elements_kg_m2();
    cells.extend(
        elements
            .map(|element| if is_known { significant(element, DIGITS) } else { EMPTY.to_owned() }),
    );
    // Of the mean moment: a product may be zero.
    let mean = (elements[0] + elements[1] + elements[2]) / 3.0;
    let largest = result.sigma_kg_m2.iter().copied().fold(0.0, f64::max);
    let percent = 100.0 * largest / mean;
    let is_meaningful = is_known && percent.is_finite();
    cells.push(if is_meaningful { significant(percent, DIGITS) } else { EMPTY.to_owned() });
    cells
}

fn failed_cells(report: &LogReport) -> Vec<String> {
    let estimator = report.estimator.clone().unwrap_or_else(|| EMPTY.to_owned());
    let mut cells = vec![estimator, EMPTY.to_owned(), EMPTY.to_owned(), "failed".to_owned()];
    cells.resize(6 + ELEMENT_NAMES.len() + 1, EMPTY.to_owned());
    cells
}

/// Number of results by status.
fn totals(reports: &[LogReport]) -> String {
    let all = [Status::Converged, Status::Partial, Status::Unobservable, Status::Diverged];
    let results = || reports.iter().filter_map(|report| report.result.as_ref());
    let count = |status: Status| results().filter(|result| result.status == status).count();
    let counted = all.iter().map(|status| (count(*status), status.to_string()));
    let failed = (reports.len() - results().count(), "failed".to_owned());
    let listed: Vec<String> = counted
        .chain([failed])
        .filter(|(count, _)| *count > 0)
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    format!("{} results: {}", reports.len(), listed.join(", "))
}
