//! `diagnose`: single causes that explain the residuals of a log.

use std::path::PathBuf;

use clap::Args;

use super::{Failure, print};
use crate::diagnosis::diagnose;
use crate::input::{Craft, RecordedLog, log_file};
use crate::report::{DiagnosisReport, table};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Properties of the craft: wheels, gyro noise, prior
    #[arg(long, value_name = "CRAFT.toml")]
    craft: PathBuf,
    /// Recorded log with the columns t_s, gyro_x_rad_s, …
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

/// Diagnosis of a log as recorded; `file` is its name in errors.
pub(super) fn diagnosis(
    file: String,
    craft: &Craft,
    mut log: RecordedLog,
) -> Result<DiagnosisReport, Failure> {
    log.correct(&craft.hardware);
    let rows = log.rows.len();
    let diagnosis = diagnose(craft, &log.rows).ok_or(Failure::TooShort { file, rows })?;
    Ok(DiagnosisReport::from(&diagnosis))
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { craft, log, json } = arguments;
    let file = log.display().to_string();
    let craft = Craft::load(craft)?;
    let log = log_file::load(log, &craft)?;
    for note in &log.notes {
        eprintln!("note: {note}");
    }
    let report = diagnosis(file, &craft, log)?;
    print(*json, &report, &table::diagnosis(&report))
}
