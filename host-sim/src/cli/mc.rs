//! `mc`: Monte Carlo over the gyro's noise and what the scenario disperses, beside the bound.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use super::campaign::{progress_bar, stop_on_ctrl_c};
use super::estimate::{note_ignored_unknowns, note_what_changes, status};
use super::{Failure, Method, print};
use crate::campaign::statistics::Verdict;
use crate::campaign::statistics::{Statistics, reduce};
use crate::campaign::{Campaign, Run, Truths};
use crate::input::Scenario;
use crate::report::runs::{RunRow, RunsFile};
use crate::report::{McReport, table};

#[derive(Debug, Args)]
pub struct Arguments {
    /// A SCENARIO.toml, or the name of a built-in one.
    scenario: String,
    /// How many runs.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Seed of the first run's gyro noise and dispersion; run i has this plus i.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    method: Method,
    /// Write one CSV row for each run into this file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, runs: asked, seed, method, out, json } = arguments;
    let scenario = Scenario::load(scenario)?;
    note_ignored_unknowns(method.estimator, &scenario.craft());
    note_what_changes(&scenario);
    let truths = Truths::simulate(&scenario)?;
    let campaign = Campaign {
        scenario: &scenario,
        truths: &truths,
        estimator: method.estimator,
        precision: method.precision,
        first_seed: *seed,
        runs: *asked,
    };
    let stop = stop_on_ctrl_c();
    let out = out.as_deref().map(RunsFile::create).transpose()?;

    let begun = Instant::now();
    let bar = progress_bar(*asked, "runs");
    let runs = campaign.fly(&stop, || bar.inc(1));
    bar.finish_and_clear();
    let (runs, wall) = (runs?, begun.elapsed());

    let complete = runs.len() as u64;
    if complete < *asked {
        if complete == 0 {
            return Err(Failure::Interrupted);
        }
        eprintln!("note: stopped after {complete} of {asked} runs; this is their result");
    }
    if let Some(file) = out {
        file.write(runs.iter().map(row))?;
    }
    let report = report(&campaign, &runs, wall);
    print(*json, &report, &table::mc(&report))
}

fn report(campaign: &Campaign<'_>, runs: &[Run], wall: Duration) -> McReport {
    let statistics = reduce(runs.iter().map(|run| &run.score));
    let Statistics {
        used,
        not_shown,
        diverged,
        not_converged,
        rmse_kg_m2,
        bias_kg_m2,
        rmse_over_bound,
        bias_over_bound,
        nees_per_dof,
        nees_runs,
        nees_95,
        ..
    } = statistics;
    let shown = runs.iter().filter(|run| run.score.verdict != Verdict::NotShown);
    let yardstick = campaign.truths.typical(shown.map(|run| run.yardstick));
    let count = |is: &dyn Fn(&Run) -> bool| runs.iter().filter(|run| is(run)).count() as u64;
    let steps = runs.iter().map(|run| run.steps).sum();
    let estimator_s = runs.iter().map(|run| run.estimator_time.as_secs_f64()).sum::<f64>();
    McReport {
        scenario: campaign.scenario.name.clone(),
        estimator: campaign.estimator.to_string(),
        precision: campaign.precision.to_string(),
        seed: campaign.first_seed,
        runs: runs.len() as u64,
        used: used as u64,
        not_shown: not_shown as u64,
        diverged: diverged as u64,
        not_converged: not_converged as u64,
        changes: count(&|run| run.changes > 0),
        residuals_not_white: count(&|run| run.residuals_white == Some(false)),
        truth_kg_m2: yardstick.truth_kg_m2,
        rmse_kg_m2,
        bias_kg_m2,
        bound_kg_m2: yardstick.bound_kg_m2,
        rmse_over_bound,
        rmse_over_bound_of_all: statistics.rmse_over_bound_of_all(),
        bias_over_bound,
        nees_per_dof,
        nees_runs: nees_runs as u64,
        nees_95,
        steps,
        wall_s: wall.as_secs_f64(),
        steps_per_s_per_core: (estimator_s > 0.0).then(|| steps as f64 / estimator_s),
    }
}

fn row(run: &Run) -> RunRow {
    let score = &run.score;
    RunRow {
        run: run.index,
        seed: run.seed,
        status: status(score.status),
        inertia_kg_m2: score.inertia_kg_m2,
        sigma_kg_m2: score.sigma_kg_m2,
        error_kg_m2: score.error_kg_m2,
        nees: score.nees,
        converged: score.verdict == Verdict::Converged,
        diverged: score.verdict == Verdict::Diverged,
        restarts: run.restarts,
        changes: run.changes,
        residuals_white: run.residuals_white,
        shown: score.verdict != Verdict::NotShown,
    }
}
