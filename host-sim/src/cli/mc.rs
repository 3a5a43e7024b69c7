//! `mc`: Monte Carlo campaign over gyro noise and dispersion.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::estimate::{note_changes, note_ignored_disturbances};
use super::notes::Notes;
use super::progress::{note_if_stopped, progress_bar, stop_on_ctrl_c};
use super::{Failure, command_line, print};
use crate::campaign::{Campaign, Truths};
use crate::estimation::Method;
use crate::input::{Scenario, plausible, scenario};
use crate::report::campaign_dir::write_campaign;
use crate::report::runs::{RunRow, RunsOutput};
use crate::report::{McReport, table};

#[derive(Debug, Args)]
pub struct Arguments {
    /// SCENARIO.toml, or name of a built-in scenario
    scenario: String,
    /// Number of runs
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Seed of the first run; run i has this plus i
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    method: Method,
    /// Write a report for the browser, and a row per run as CSV and Parquet, into this folder; a name that ends in .csv
    /// or .parquet: the rows alone
    #[arg(long, value_name = "DIR|FILE")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, runs: requested, seed, method, out, json } = arguments;
    let sources = scenario::sources(scenario);
    let scenario = Scenario::load(scenario)?;
    let mut notes = Notes::default();
    note_ignored_disturbances(method.estimator, &scenario.craft(), &mut notes);
    note_changes(&scenario, &mut notes);
    plausible::scenario(&scenario).into_iter().for_each(|note| notes.add(note));
    let campaign = Campaign {
        scenario: &scenario,
        truths: &Truths::simulate(&scenario)?,
        estimator: method.estimator,
        precision: method.precision,
        first_seed: *seed,
        runs: *requested,
    };
    let stop = stop_on_ctrl_c();
    let out = out.as_deref().map(RunsOutput::create).transpose()?;

    let begun = Instant::now();
    let bar = progress_bar(*requested, "runs");
    let runs = campaign.run_all(&stop, || bar.inc(1));
    bar.finish_and_clear();
    let wall = begun.elapsed();
    let runs =
        runs.map_err(|error| Failure::Campaign { scenario: scenario.name.clone(), error })?;
    if runs.is_empty() {
        return Err(Failure::Interrupted);
    }
    note_if_stopped(runs.len() as u64, *requested);
    let report = McReport::new(&campaign, &runs, wall);
    let rows = || runs.iter().map(RunRow::from).collect::<Vec<_>>();
    match out {
        Some(RunsOutput::File(file)) => file.write(&rows())?,
        Some(RunsOutput::Folder(folder)) => {
            let command = command_line();
            write_campaign(folder, &report, &rows(), &command, &notes.into_list(), &sources?)?;
        }
        None => {}
    }
    print(*json, &report, &table::mc(&report))
}
