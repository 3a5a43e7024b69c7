//! Output folders of campaigns and of several logs: page, document, table of the runs or cells, points of the plots.
//!
//! | file | content |
//! |---|---|
//! | `report.html` | statistics and plots |
//! | `result.json` | the document of `--json` |
//! | `runs.csv`, `runs.parquet`; `cells.csv`, `cells.parquet` | a row for each run of `mc`; for each cell of `faults` |
//! | `data/….csv` | the points of each plot |
//! | `scenario/` | the scenario that was flown, with its tables |

use std::path::Path;

use serde::Serialize;

use super::files::{Folder, OutputError};
use super::frame::{Cells, Frame};
use super::json::{FaultCell, FaultsReport, LogReport, McReport};
use super::page;
use super::plots::Figure;
use super::record::CampaignRecord;
use super::runs::{Rows, write_csv, write_parquet};
use crate::input::scenario::SourceFile;

/// Writes a Monte Carlo campaign.
///
/// # Errors
/// A path that cannot be written, or rows that cannot be read.
pub fn write_campaign(
    mut folder: Folder,
    report: &McReport,
    rows: &dyn Rows,
    record: &CampaignRecord,
    command: &str,
) -> Result<(), OutputError> {
    const FILES: [(&str, &str); 4] = [
        ("result.json", "the result as numbers"),
        ("runs.csv", "a row for each run"),
        ("runs.parquet", "the same"),
        ("scenario/scenario.toml", "the scenario that was flown"),
    ];
    let mut distributions = page::Distributions::new(report);
    rows.each(&mut |row| {
        distributions.add(&row.run.score);
        Ok(())
    })?;
    let (page, figures) = page::campaign(report, &distributions, command, &record.notes, &FILES);
    folder.rows("runs.csv", |out, path| write_csv(out, path, rows))?;
    folder.rows("runs.parquet", |out, path| write_parquet(out, path, rows, record))?;
    write(folder, (&page, &figures), report, record.scenario_files())
}

/// Writes a fault matrix into `folder`, which is created if it does not exist; files of an earlier report are removed.
///
/// # Errors
/// A path that cannot be written.
pub fn write_faults(
    folder: &Path,
    report: &FaultsReport,
    command: &str,
    scenario: &[SourceFile],
) -> Result<(), OutputError> {
    const FILES: [(&str, &str); 4] = [
        ("result.json", "the result as numbers"),
        ("cells.csv", "a row for each estimator and fault"),
        ("cells.parquet", "the same"),
        ("scenario/scenario.toml", "the scenario that was flown"),
    ];
    let mut folder = Folder::open(folder, &[])?;
    let (page, figures) = page::faults(report, command, &FILES);
    let cells = cells(&report.cells);
    folder.stream("cells.csv", |out| cells.write_csv(out))?;
    folder.stream("cells.parquet", |out| cells.write_parquet(out))?;
    write(folder, (&page, &figures), report, scenario)
}

/// Writes the overview of several logs into `folder`, beside the folders of the results that `links` names.
///
/// # Errors
/// A path that cannot be written.
pub fn write_logs(
    folder: &Path,
    reports: &[LogReport],
    links: &[Option<String>],
    command: &str,
) -> Result<(), OutputError> {
    const FILES: [(&str, &str); 1] = [("result.json", "all results as numbers")];
    let mut folder = Folder::open(folder, &[])?;
    let (page, figures) = page::logs(reports, links, command, &FILES);
    folder.text("report.html", &page)?;
    folder.json("result.json", &reports)?;
    for figure in &figures {
        folder.stream(&format!("{}.csv", figure.name), |out| figure.write_csv(out))?;
    }
    Ok(())
}

fn write(
    mut folder: Folder,
    (page, figures): (&str, &[Figure]),
    report: &impl Serialize,
    scenario: &[SourceFile],
) -> Result<(), OutputError> {
    folder.text("report.html", page)?;
    folder.json("result.json", report)?;
    for figure in figures {
        folder.stream(&format!("{}.csv", figure.name), |out| figure.write_csv(out))?;
    }
    folder.sources(scenario)
}

/// Name of a column, and its value in a cell of the matrix.
type Named<T> = (&'static str, fn(&FaultCell) -> T);

/// Cells of a fault matrix as a table, named as in the document.
fn cells(cells: &[FaultCell]) -> Frame {
    let mut frame = Frame::default();
    let mut text = |name: &str, value: fn(&FaultCell) -> Option<String>| {
        frame.add(name, Cells::Text(cells.iter().map(value).collect()));
    };
    text("estimator", |cell| Some(cell.estimator.clone()));
    text("precision", |cell| Some(cell.precision.clone()));
    text("fault", |cell| cell.fault.clone());
    text("missed", |cell| Some(cell.missed.join("; ")));
    let counts: [Named<u64>; 11] = [
        ("runs", |cell| cell.runs),
        ("panics", |cell| cell.panics),
        ("not_finite", |cell| cell.not_finite),
        ("detected", |cell| cell.detected),
        ("false_alarms", |cell| cell.false_alarms),
        ("converged", |cell| cell.converged),
        ("silent_lies", |cell| cell.silent_lies),
        ("silent_in_flight", |cell| cell.silent_in_flight),
        ("recovered", |cell| cell.recovered),
        ("degraded", |cell| cell.degraded),
        ("nominal", |cell| cell.nominal),
    ];
    for (name, count) in counts {
        frame.add(name, Cells::Count(cells.iter().map(|cell| Some(count(cell))).collect()));
    }
    let numbers: [Named<Option<f64>>; 11] = [
        ("detection_s", |cell| cell.detection_s),
        ("detection_worst_s", |cell| cell.detection_worst_s),
        ("silent_worst_s", |cell| Some(cell.silent_worst_s)),
        ("recovery_worst_s", |cell| cell.recovery_worst_s),
        ("degraded_worst_s", |cell| cell.degraded_worst_s),
        ("nominal_worst_s", |cell| cell.nominal_worst_s),
        ("outage_worst_s", |cell| Some(cell.outage_worst_s)),
        ("nees_during", |cell| cell.nees_during),
        ("nees_after", |cell| cell.nees_after),
        ("rmse_over_bound", |cell| cell.rmse_over_bound),
        ("rmse_over_clean", |cell| cell.rmse_over_clean),
    ];
    for (name, number) in numbers {
        frame.add(name, Cells::Number(cells.iter().map(number).collect()));
    }
    frame
}
