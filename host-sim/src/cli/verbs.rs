//! The verbs as functions, for programs other than the command line: the documents of `--json`, nothing printed.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use flight_input::csv_source::CsvSource;
use thiserror::Error;

use super::notes::Notes;
use super::{BAD_INPUT, Cli, Failure, Verb, in_two_lines};
use crate::campaign::Shard;
use crate::estimation::Method;
use crate::input::log::LogRow;
use crate::input::{Craft, InputError, RecordedLog, Scenario, guess, log_file};
use crate::report::runs::{Cells, RunRow, columns};
use crate::report::{
    CrlbReport, DesignReport, DiagnosisReport, HistoryRow, McReport, ReplayReport, RunReport,
};

/// Name of a log of columns in errors.
const LOG: &str = "log";

/// A verb did not finish. The message is that of the command line.
#[derive(Debug, Error)]
#[error("{message}")]
pub struct VerbFailed {
    message: String,
    is_bad_input: bool,
}

impl VerbFailed {
    /// The input was rejected; otherwise a run could not finish.
    pub fn is_bad_input(&self) -> bool {
        self.is_bad_input
    }
}

impl VerbFailed {
    /// An input that cannot be used.
    fn of_input(message: String) -> Self {
        Self { message, is_bad_input: true }
    }
}

impl From<Failure> for VerbFailed {
    fn from(failure: Failure) -> Self {
        let is_bad_input = failure.exit_code() == BAD_INPUT;
        Self { message: failure.to_string(), is_bad_input }
    }
}

impl From<InputError> for VerbFailed {
    fn from(error: InputError) -> Self {
        Failure::from(error).into()
    }
}

/// A simulated flight, its estimate, and the estimate after each sample.
pub struct Flown {
    /// Document of `run`.
    pub report: RunReport,
    /// Estimate after each sample.
    pub history: Vec<HistoryRow>,
    /// Log of the flight.
    pub log: Vec<LogRow>,
}

/// The log in a file, as recorded.
///
/// # Errors
/// Here and below: bad input, or a run that could not finish.
pub fn log_of_file(path: &Path, craft: &Craft) -> Result<RecordedLog, VerbFailed> {
    Ok(log_file::load(path, craft)?)
}

/// A log of columns: their names, and the cells of each as a CSV file has them.
pub fn log_of_columns(
    names: Vec<String>,
    cells: &[Vec<String>],
    craft: &Craft,
) -> Result<RecordedLog, VerbFailed> {
    let log = &craft.log;
    let sensors = [&log.gyro, &log.wheels, &log.torque, &log.attitude].into_iter().flatten();
    let mut files = log.file.iter().chain(sensors.filter_map(|sensor| sensor.file.as_ref()));
    if let Some(file) = files.next() {
        return Err(VerbFailed::of_input(format!(
            "log: [log] of the craft names the file {file}, and columns in memory are one log; merge \
             those of the sensors by time, with empty cells between, and remove `file`"
        )));
    }
    Ok(log_file::of_columns(LOG, names, cells, craft)?)
}

/// `init --from`: the text of a craft file that a log suggests, with lines to confirm and to fill in.
pub fn draft_of_file(path: &Path) -> Result<String, VerbFailed> {
    let source = log_file::read(path, &Default::default())?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    draft_of(&name, &source)
}

/// The same of columns: their names, and the cells of each as a CSV file has them.
pub fn draft_of_columns(names: Vec<String>, cells: &[Vec<String>]) -> Result<String, VerbFailed> {
    draft_of(LOG, &log_file::source_of_columns(LOG, names, cells)?)
}

fn draft_of(name: &str, source: &CsvSource) -> Result<String, VerbFailed> {
    guess::draft(name, source).map_err(|error| VerbFailed::of_input(format!("{name}: {error}")))
}

/// `replay`: the estimate from a log as recorded, and the estimate after each sample.
pub fn replay(
    craft: &Craft,
    log: RecordedLog,
    method: Method,
) -> Result<(ReplayReport, Vec<HistoryRow>), VerbFailed> {
    let estimated = super::replay::replayed(LOG, craft, log, method)?;
    Ok((estimated.report, estimated.history))
}

/// `run`: a simulated flight.
pub fn run(scenario: &Scenario, seed: u64, method: Method) -> Result<Flown, VerbFailed> {
    let flown = super::run::fly(scenario, seed, method, true, Notes::quiet())?;
    Ok(Flown { report: flown.report, history: flown.history, log: flown.log })
}

/// `mc`: a campaign, and the columns of its runs. It ends early once `stop` is set.
pub fn mc(
    scenario: &Scenario,
    runs: u64,
    seed: u64,
    method: Method,
    stop: &AtomicBool,
) -> Result<(McReport, Vec<(String, Cells)>), VerbFailed> {
    if runs == 0 {
        let message = "runs is 0; give at least 1".to_owned();
        return Err(VerbFailed { message, is_bad_input: true });
    }
    let of = (method, seed, runs, Shard::WHOLE);
    let prepared = super::mc::Prepared::new(scenario, &[], of, Notes::quiet())?;
    let mut rows = Vec::new();
    let mut keep = |row: &RunRow| {
        rows.push(row.clone());
        Ok(())
    };
    let flown = prepared.fly(stop, || (), &mut keep)?;
    Ok((flown.report(), columns(&rows, &scenario.drawn_names())))
}

/// `crlb`: the bound of a scenario, or of that of a seed.
pub fn crlb(scenario: &Scenario, seed: Option<u64>) -> Result<CrlbReport, VerbFailed> {
    Ok(super::crlb::bound(scenario, seed, Notes::quiet())?)
}

/// `diagnose`: causes that explain the residuals of a log as recorded.
pub fn diagnose(craft: &Craft, log: RecordedLog) -> Result<DiagnosisReport, VerbFailed> {
    Ok(super::diagnose::diagnosis(LOG.to_owned(), craft, log)?)
}

/// `design`: a manoeuvre by the arguments of the command line. It ends with the best one so far once `stop` is set.
pub fn design(arguments: &[String], stop: &AtomicBool) -> Result<DesignReport, VerbFailed> {
    let words = ["host-sim", "design"].into_iter().chain(arguments.iter().map(String::as_str));
    let rejected = |message: String| VerbFailed { message, is_bad_input: true };
    let cli = Cli::try_parse_from(words).map_err(|error| {
        let message = error.render().to_string();
        rejected(in_two_lines(message.trim_start_matches("error: ")))
    })?;
    match cli.verb {
        Verb::Design(arguments) => Ok(super::design::report(&arguments, stop)?),
        _ => Err(rejected("these are not the arguments of design".to_owned())),
    }
}
