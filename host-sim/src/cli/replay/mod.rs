//! `replay`: estimate from recorded logs.

mod many;
mod one;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::notes::Notes;
use super::{Failure, command_line, print};
use crate::estimation::{EstimatorName, Precision};
use crate::input::Craft;
use crate::input::log_file::expand;
use crate::report::{ReplayReport, Status, table};
pub(super) use one::replayed;
use one::{Replay, write_folder};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Craft file: wheels, gyro noise, prior, and columns and units of the logs
    #[arg(long, value_name = "CRAFT.toml")]
    craft: PathBuf,
    /// Recorded logs: CSV or Parquet files, plain or compressed by gzip, folders of them, or - for
    /// standard input
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    /// Estimator; may be given several times
    #[arg(long = "estimator", value_enum, default_value = "window", value_name = "ESTIMATOR")]
    estimators: Vec<EstimatorName>,
    /// Arithmetic of the estimator
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    precision: Precision,
    /// Exit with status 3 if a result is of this kind; may be given several times
    #[arg(long, value_enum, value_name = "KIND", value_delimiter = ',')]
    fail_on: Vec<Kind>,
    /// Write a report for the browser, time history and plot data into this folder; several results: into a
    /// folder each
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table; several results: an array
    #[arg(long)]
    json: bool,
}

/// A kind of result that a script may have to stop at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Status `diverged`
    Diverged,
    /// Status `partial` or `unobservable`
    Partial,
    /// Residuals that are not white
    NotWhite,
}

impl Kind {
    fn is_of(self, report: &ReplayReport) -> bool {
        match self {
            Self::Diverged => report.status == Status::Diverged,
            Self::Partial => matches!(report.status, Status::Partial | Status::Unobservable),
            Self::NotWhite => report.residuals_white == Some(false),
        }
    }

    fn name(self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let craft = Craft::load(&arguments.craft)?;
    let mut logs = Vec::new();
    for path in &arguments.logs {
        logs.extend(expand(path, &craft.log)?);
    }
    let mut estimators = arguments.estimators.clone();
    estimators.dedup();
    let is_single = estimators.len() == 1 && logs.len() == 1 && !arguments.logs[0].is_dir();
    match (logs.as_slice(), estimators.as_slice()) {
        ([log], [estimator]) if is_single => {
            let replay = Replay { craft: &craft, log, precision: arguments.precision };
            single(arguments, &replay, estimator)
        }
        _ => many::run(arguments, &craft, &logs, &estimators),
    }
}

/// One log, one estimator.
fn single(
    arguments: &Arguments,
    replay: &Replay<'_>,
    estimator: &EstimatorName,
) -> Result<(), Failure> {
    let read = replay.read(&mut Notes::default())?;
    let estimated =
        replay.estimate(&read, *estimator, arguments.out.is_some(), Notes::default())?;
    let table = table::replay(&estimated.report);
    if let Some(folder) = &arguments.out {
        let (title, inputs) = (title(&read.file, *estimator), [replay.log, &arguments.craft]);
        write_folder(folder, &title, &command_line(), &inputs, &estimated)?;
    }
    print(arguments.json, &estimated.report, &table)?;
    stop_at(&arguments.fail_on, [&estimated.report].into_iter())
}

/// Heading of a report.
fn title(log: &str, estimator: EstimatorName) -> String {
    format!("{log}, {estimator}")
}

/// The failure that `--fail-on` asks for.
fn stop_at<'a>(
    kinds: &[Kind],
    reports: impl Iterator<Item = &'a ReplayReport> + Clone,
) -> Result<(), Failure> {
    let counted =
        kinds.iter().map(|kind| (kind, reports.clone().filter(|r| kind.is_of(r)).count()));
    let found: Vec<String> = counted
        .filter(|(_, count)| *count > 0)
        .map(|(kind, count)| format!("{count} {}", kind.name()))
        .collect();
    if found.is_empty() {
        return Ok(());
    }
    Err(Failure::OfKind { found: found.join(", "), results: reports.count() })
}
