//! `faults`: the fault matrix.

use std::path::PathBuf;

use clap::Args;

use super::notes::Notes;
use super::progress::{Progress, stop_on_signal};
use super::{Failure, command_line, print};
use crate::campaign::Truths;
use crate::estimation::{EstimatorName, Method, Precision, SetUpError};
use crate::fault::{Entry, Matrix, catalogue};
use crate::input::scenario::FAULTS_SCENARIO;
use crate::input::{Scenario, scenario};
use crate::report::campaign_dir::write_faults;
use crate::report::{FaultsReport, table};
use crate::truth::Flight;

#[derive(Debug, Args)]
pub struct Arguments {
    /// SCENARIO.toml, or name of a built-in scenario. Its faults are the rows of the matrix; the catalogue
    /// of faults if it has none
    #[arg(default_value = FAULTS_SCENARIO)]
    scenario: String,
    /// Runs of a cell
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Seed of the first run; run i has this plus i
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Estimators; repeat the option for several
    #[arg(long, value_enum, default_values = ["window", "joint-ekf", "ekf-sgf-rls"])]
    estimator: Vec<EstimatorName>,
    /// Arithmetic; repeat the option for both. Default: both
    #[arg(long, value_enum, default_values = ["f32", "f64"])]
    precision: Vec<Precision>,
    /// Fly only the faults whose name contains this text
    #[arg(long, value_name = "TEXT")]
    fault: Option<String>,
    /// Write a report for the browser, and the cells as CSV and Parquet, into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of tables
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, runs, seed, json, out, .. } = arguments;
    let sources = scenario::sources(scenario);
    let mut scenario = Scenario::load(scenario)?;
    let entries = arguments.entries(&scenario)?;
    scenario.faults.clear();
    let methods = arguments.methods(&scenario, &mut Notes::default());
    let matrix = Matrix {
        scenario: &scenario,
        truths: &Truths::simulate(&scenario)?,
        entries: &entries,
        methods: &methods,
        first_seed: *seed,
        runs: *runs,
    };
    let stop = stop_on_signal();
    let bar = Progress::new(runs * methods.len() as u64, "runs");
    let cells = matrix.fly(&stop, || bar.inc(1));
    bar.finish();
    let failure = |error| Failure::Campaign { scenario: scenario.name.clone(), error };
    let cells = cells.map_err(failure)?;
    if cells.is_empty() {
        return Err(Failure::Interrupted);
    }
    if cells.iter().any(|cell| (cell.row.runs as u64) < *runs) {
        eprintln!("note: stopped early; each cell has the number of its completed runs");
    }
    let report = FaultsReport::new(&matrix, &cells);
    if let Some(folder) = out {
        write_faults(folder, &report, &command_line(), &sources?)?;
    }
    print(*json, &report, &table::faults(&report))
}

impl Arguments {
    /// The faults to fly.
    fn entries(&self, scenario: &Scenario) -> Result<Vec<Entry>, Failure> {
        let mut entries = match scenario.faults.as_slice() {
            [] => {
                let first = scenario.of_seed(self.seed);
                catalogue(&first, &Flight::simulate(&first)?)
            }
            _ => Entry::of_scenario(scenario),
        };
        let Some(wanted) = &self.fault else { return Ok(entries) };
        let names: Vec<String> = entries.iter().map(|entry| entry.name.clone()).collect();
        entries.retain(|entry| entry.name.contains(wanted));
        if entries.is_empty() {
            return Err(Failure::NoFault { wanted: wanted.clone(), names: names.join(", ") });
        }
        Ok(entries)
    }

    /// Each estimator in each precision, without those that need a prior where there is none.
    fn methods(&self, scenario: &Scenario, notes: &mut Notes) -> Vec<Method> {
        let mut methods = Vec::new();
        for &estimator in &self.estimator {
            let needs_prior =
                matches!(estimator, EstimatorName::EkfSgfRls | EstimatorName::EkfSgfLls);
            if needs_prior && scenario.prior.is_none() && self.estimator.len() > 1 {
                let error = SetUpError::NoNominalInertia { estimator };
                notes.add(format!("{error}; left out"));
                continue;
            }
            methods.extend(self.precision.iter().map(|&precision| Method { estimator, precision }));
        }
        methods
    }
}
