//! `mc`: Monte Carlo campaign over gyro noise and dispersion.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::Args;

use super::estimate::{note_changes, note_ignored_disturbances};
use super::notes::Notes;
use super::progress::{Progress, note_if_stopped, stop_on_signal};
use super::{Failure, command_line, print};
use crate::campaign::{Campaign, Shard, Tally, Truths};
use crate::estimation::Method;
use crate::input::scenario::SourceFile;
use crate::input::{Scenario, plausible, scenario};
use crate::report::campaign_dir::write_campaign;
use crate::report::record::{CampaignRecord, CampaignScenario};
use crate::report::runs::{Receive, Rows, RunRow, RunsOutput, is_parquet};
use crate::report::shards::Spool;
use crate::report::{McReport, OutputError, table};

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
    /// Fly shard I of N alone, I from 1 to N, and write its rows into the Parquet file of --out: see merge
    #[arg(long, value_name = "I/N", requires = "out")]
    shard: Option<Shard>,
    /// Write a report for the browser, and a row per run as CSV and Parquet, into this folder; a name that ends in .csv
    /// or .parquet: the rows alone
    #[arg(long, value_name = "DIR|FILE")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

/// A campaign that is ready to fly.
pub(super) struct Prepared<'a> {
    scenario: &'a Scenario,
    method: Method,
    truths: Truths,
    record: CampaignRecord,
}

/// A campaign that was flown by this process: sums of its runs.
pub(super) struct Flown {
    tally: Tally,
    record: CampaignRecord,
    wall: Duration,
}

impl<'a> Prepared<'a> {
    /// Truths and record of a campaign: method, seed, number of runs and shard. `files` are those of the scenario.
    pub(super) fn new(
        scenario: &'a Scenario,
        files: &[SourceFile],
        (method, seed, runs, shard): (Method, u64, u64, Shard),
        mut notes: Notes,
    ) -> Result<Self, Failure> {
        note_ignored_disturbances(method.estimator, &scenario.craft(), &mut notes);
        note_changes(scenario, &mut notes);
        plausible::scenario(scenario).into_iter().for_each(|note| notes.add(note));
        let truths = Truths::simulate(scenario)?;
        let notes = notes.into_list();
        let of = CampaignScenario { scenario, files, truths: &truths, notes: &notes };
        let record = CampaignRecord::new(&of, method, seed, runs, shard);
        Ok(Self { scenario, method, truths, record })
    }

    /// Number of runs to fly.
    fn runs(&self) -> u64 {
        let indices = self.record.indices();
        indices.end - indices.start
    }

    /// Flies the runs, and hands each over in order. A stopped campaign is one of fewer runs; a stopped shard is a
    /// failure.
    pub(super) fn fly(
        self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
        receive: &mut Receive<'_>,
    ) -> Result<Flown, Failure> {
        let runs = self.runs();
        let Self { scenario, method, truths, mut record } = self;
        let campaign = Campaign {
            scenario,
            truths: &truths,
            estimator: method.estimator,
            precision: method.precision,
            first_seed: record.first_seed(),
            runs,
        };
        let failed = |error| Failure::Campaign { scenario: scenario.name.clone(), error };
        let first = record.indices().start;
        let (mut tally, mut wall) = (Tally::default(), Duration::ZERO);
        let mut begun = Instant::now();
        for batch in campaign.batches(stop, &done) {
            wall += begun.elapsed();
            for mut run in batch.map_err(failed)? {
                run.index += first;
                tally.add(&run);
                receive(&RunRow { run, drawn: scenario.drawn_values(run.seed) })?;
            }
            begun = Instant::now();
        }
        if tally.runs() == 0 {
            return Err(Failure::Interrupted);
        }
        if tally.runs() < runs {
            if let Some(shard) = record.shard().filter(|shard| *shard != Shard::WHOLE) {
                return Err(Failure::ShardInterrupted { shard });
            }
            record.runs = tally.runs();
        }
        Ok(Flown { tally, record, wall })
    }
}

impl Flown {
    /// Report of the runs.
    pub(super) fn report(&self) -> McReport {
        McReport::new(&self.record, &self.tally, Some(self.wall))
    }
}

impl Arguments {
    /// The shard to fly, checked with the other arguments.
    fn shard(&self) -> Result<Shard, Failure> {
        let Some(shard) = self.shard else { return Ok(Shard::WHOLE) };
        if !self.out.as_deref().is_some_and(is_parquet) {
            return Err(Failure::ShardWithoutFile { shard });
        }
        if shard.count() > self.runs {
            return Err(Failure::SurplusShards { shard, runs: self.runs });
        }
        Ok(shard)
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, runs: requested, seed, method, out, json, .. } = arguments;
    let shard = arguments.shard()?;
    let sources = scenario::sources(scenario);
    let scenario = Scenario::load(scenario)?;
    let of = (*method, *seed, *requested, shard);
    let prepared = Prepared::new(&scenario, &sources?, of, Notes::default())?;
    let stop = stop_on_signal();
    let out = out.as_deref().map(RunsOutput::create).transpose()?;
    let names = scenario.drawn_names();
    let mut spool = out.as_ref().map(|out| Spool::create(out.folder(), names)).transpose()?;

    let bar = Progress::new(prepared.runs(), "runs");
    let mut keep = |row: &RunRow| spool.as_mut().map_or(Ok(()), |spool| spool.add(row));
    let flown = prepared.fly(&stop, || bar.inc(1), &mut keep);
    bar.finish();
    let flown = flown?;
    if shard == Shard::WHOLE {
        note_if_stopped(flown.tally.runs(), *requested);
    }
    let report = flown.report();
    if let Some((out, spool)) = out.zip(spool) {
        let rows = spool.complete(&flown.record)?;
        write(out, &report, &rows, &flown.record, &command_line())?;
    }
    print(*json, &report, &table::mc(&report))
}

/// Writes the rows of a campaign, or its report.
pub(super) fn write(
    out: RunsOutput,
    report: &McReport,
    rows: &dyn Rows,
    record: &CampaignRecord,
    command: &str,
) -> Result<(), OutputError> {
    match out {
        RunsOutput::File(file) => file.write(rows, record),
        RunsOutput::Folder(folder) => write_campaign(folder, report, rows, record, command),
    }
}
