//! Page of a fault matrix: a table for each estimator, and its cells that miss a requirement.

use maud::{Markup, html};

use super::{Kind, Page, facts, files, places, section, table};
use crate::report::json::{FaultCell, FaultsReport};
use crate::report::plots::{Colour, Dot, Figure, Panel, Series};
use crate::report::table::fault_row;

/// The page, and its figures.
pub(in crate::report) fn faults(
    report: &FaultsReport,
    command: &str,
    all_files: &[(&str, &str)],
) -> (String, Vec<Figure>) {
    let figures: Vec<Figure> = [outcomes(report), errors(report)]
        .into_iter()
        .filter(|figure| !figure.is_empty())
        .collect();
    let title = format!("Fault matrix, {}, {} runs a cell", report.scenario, report.runs);
    let cells = report.cells.len();
    let lost: u64 = report.cells.iter().map(|cell| cell.panics + cell.not_finite).sum();
    let silent: u64 = report.cells.iter().map(|cell| cell.silent_lies).sum();
    let (kind, verdict) = match report.missed_cells {
        0 => (Kind::Good, format!("All {cells} cells meet their requirements")),
        missed => (Kind::Partial, format!("{missed} of {cells} cells miss a requirement")),
    };
    let verdict =
        format!("{verdict}. {lost} runs panicked or were not finite, {silent} end silently wrong.");
    let body = html! {
        (section("Over all estimators", places(&figures)))
        @for part in report.cells.chunk_by(|a, b| a.estimator == b.estimator && a.precision == b.precision) {
            (estimator(part))
        }
        (files(all_files))
    };
    let page = Page { title: &title, verdict: &verdict, kind, command, body, figures: &figures };
    (page.html(), figures)
}

/// Table of one estimator.
fn estimator(cells: &[FaultCell]) -> Markup {
    const HEADER: [&str; 19] = [
        "fault",
        "survived",
        "detected",
        "after, s",
        "degraded",
        "within, s",
        "nominal",
        "within, s",
        "outage, s",
        "converged",
        "silent",
        "in flight, s",
        "recovered",
        "after, s",
        "NEES during",
        "NEES end",
        "RMS/bound",
        "RMS/clean",
        "missed",
    ];
    let Some(clean) = cells.first() else { return html! {} };
    let alarms = format!("{} of {} clean flights", clean.false_alarms, clean.runs);
    let rows: Vec<Vec<String>> = cells.iter().map(fault_row).collect();
    section(
        &format!("{}, {}", clean.estimator, clean.precision),
        html! { (facts(&[("false alarms", alarms)])) (table(&HEADER, &rows)) },
    )
}

/// Names of the faults, in the order of the first estimator.
fn names(report: &FaultsReport) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for name in report.cells.iter().filter_map(|cell| cell.fault.as_deref()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Panels by fault: one series for each estimator in each precision.
fn by_fault(
    report: &FaultsReport,
    panel: Panel,
    value: impl Fn(&FaultCell) -> Option<f64>,
) -> Panel {
    let names = names(report);
    let methods: Vec<&[FaultCell]> = report
        .cells
        .chunk_by(|a, b| a.estimator == b.estimator && a.precision == b.precision)
        .collect();
    let count = methods.len().max(1) as f64;
    let panel = panel.categories(&names);
    methods.iter().enumerate().fold(panel, |panel, (index, cells)| {
        let offset = 0.7 * ((index as f64 + 0.5) / count - 0.5);
        let dot = |cell: &FaultCell| {
            let place = names.iter().position(|name| Some(*name) == cell.fault.as_deref())?;
            Some(Dot { x: place as f64 + offset, value: value(cell)?, reach: 0.0 })
        };
        let name = format!("{}, {}", cells[0].estimator, cells[0].precision);
        let colour = Colour::ALL[index % Colour::ALL.len()];
        panel.with(Series::dots(&name, colour, cells.iter().filter_map(dot)))
    })
}

/// Shares of runs that detect and recover.
fn outcomes(report: &FaultsReport) -> Figure {
    let share = |count: u64, cell: &FaultCell| {
        (cell.runs > 0).then(|| 100.0 * count as f64 / cell.runs as f64)
    };
    let detected =
        by_fault(report, Panel::new("detected, % of runs"), |cell| share(cell.detected, cell));
    let recovered =
        by_fault(report, Panel::new("recovered, % of runs"), |cell| share(cell.recovered, cell));
    let panels = vec![detected.span(-4.0, 104.0), recovered.span(-4.0, 104.0)];
    Figure::stacked("Detection and recovery", "", panels).named("data/outcomes")
}

/// Final error over that of the clean flights.
fn errors(report: &FaultsReport) -> Figure {
    let panel = by_fault(report, Panel::new("RMS error over clean").logarithmic(), |cell| {
        cell.rmse_over_clean
    });
    let title = format!("Final error over that of the clean flights, RMS of {} runs", report.runs);
    Figure::stacked(title, "", vec![panel]).named("data/errors")
}
