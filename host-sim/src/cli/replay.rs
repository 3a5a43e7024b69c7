//! `replay`: estimate from a recorded log.

use std::path::PathBuf;

use clap::Args;

use super::estimate::estimate;
use super::notes::Notes;
use super::{Failure, Options, command_line, print};
use crate::diagnosis::diagnose;
use crate::input::{Craft, RecordedLog, units};
use crate::report::{ExplanationReport, ReportFolder, table};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Properties of the craft: wheels, gyro noise, prior
    #[arg(long, value_name = "CRAFT.toml")]
    craft: PathBuf,
    /// Recorded log with the columns t_s, gyro_x_rad_s, …
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    #[command(flatten)]
    options: Options,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { craft, log, options } = arguments;
    let file = log.display().to_string();
    let craft = Craft::load(craft)?;
    let mut log = RecordedLog::load(log, craft.wheels.len())?;
    log.correct(&craft.hardware);
    let mut notes = Notes::default();
    log.notes.iter().for_each(|note| notes.add(note));
    if let Some(note) = units::note(&craft, &log.rows) {
        notes.add(format!("{file}: {note}"));
    }
    let mut estimated = estimate(options, &craft, &log.rows, &file, (&[], 0), notes)?;
    let skipped = log.skipped_rows.iter().map(|(reason, rows)| ((*reason).to_owned(), *rows));
    estimated.report.skipped_rows = skipped.collect();
    if estimated.report.is_unexplained() {
        let diagnosis = diagnose(&craft, &log.rows);
        let explanations = diagnosis.iter().flat_map(|found| &found.explanations);
        estimated.report.explanations = explanations.map(ExplanationReport::from).collect();
    }
    let table = table::replay(&estimated.report);
    if let Some(folder) = &options.out {
        ReportFolder {
            title: &file,
            command: &command_line(),
            table: &table,
            result: &estimated.report,
            history: &estimated.history,
            notes: &estimated.report.notes,
            simulated: None,
        }
        .write(folder)?;
    }
    print(options.json, &estimated.report, &table)
}
