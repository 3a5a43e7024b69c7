//! Flies the field campaigns and prints their table.
//!
//! ```text
//! cargo run --release -p tests --bin field                          all, with the number of runs listed
//! cargo run --release -p tests --bin field -- --list                names
//! cargo run --release -p tests --bin field -- rest/60 --runs 20     those whose name has this part
//! cargo run --release -p tests --bin field -- frame --verbose --estimator joint-ekf --precision f32
//! ```
//!
//! A limit that does not hold is printed as MISSED, and the exit status is then 1.

use std::io::{Write, stdout};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::Result;
use clap::Parser;
use host_sim::estimation::{EstimatorName, Precision};
use tests::field::campaign::{Campaign, StatedNoise};
use tests::field::campaigns::all;
use tests::field::figures::Figures;
use tests::field::flying::fly_all;
use tests::field::motion::Library;
use tests::field::table;

/// Fly the field campaigns: ordinary logs, faults, both precisions.
#[derive(Debug, Parser)]
struct Arguments {
    /// Parts of names: campaigns that have any of them; all campaigns without a part.
    names: Vec<String>,
    /// Print names, numbers of runs and items, fly nothing.
    #[arg(long)]
    list: bool,
    /// Campaigns of this item of the requirements only.
    #[arg(long)]
    item: Option<u8>,
    /// Number of runs of each campaign.
    #[arg(long)]
    runs: Option<u64>,
    /// The small version, as the test flies it.
    #[arg(long)]
    small: bool,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Estimator in place of that of the campaign.
    #[arg(long, value_enum)]
    estimator: Option<EstimatorName>,
    /// This precision only.
    #[arg(long, value_enum)]
    precision: Option<Precision>,
    /// Gyro noise not stated.
    #[arg(long)]
    unstated: bool,
    /// Only the campaigns whose limits are held.
    #[arg(long)]
    held: bool,
    /// A line for each run.
    #[arg(long)]
    verbose: bool,
}

impl Arguments {
    fn selects(&self, campaign: &Campaign) -> bool {
        let is_named = self.names.iter().any(|part| campaign.name.contains(part.as_str()));
        (self.names.is_empty() || is_named)
            && self.item.is_none_or(|item| item == campaign.item)
            && (!self.held || campaign.held)
            && (!self.small || campaign.small > 0)
    }

    fn runs(&self, campaign: &Campaign) -> u64 {
        self.runs.unwrap_or(if self.small { campaign.small } else { campaign.runs })
    }
}

/// Totals over the rows.
#[derive(Default)]
struct Totals {
    flights: usize,
    silent: usize,
    missed: usize,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let mut campaigns: Vec<Campaign> = all()?;
    campaigns.retain(|campaign| arguments.selects(campaign));
    if arguments.list {
        list(&campaigns)?;
        return Ok(ExitCode::SUCCESS);
    }
    let begun = Instant::now();
    writeln!(stdout(), "{}", table::head())?;
    let (mut library, mut totals) = (Library::default(), Totals::default());
    for campaign in &mut campaigns {
        campaign.estimator = arguments.estimator.unwrap_or(campaign.estimator);
        if arguments.unstated {
            campaign.noise = StatedNoise::Unstated;
        }
        for precision in campaign.precisions {
            if arguments.precision.is_none_or(|only| only == *precision) {
                fly(&arguments, campaign, *precision, &mut library, &mut totals)?;
            }
        }
    }
    let Totals { flights, silent, missed } = totals;
    let time_s = begun.elapsed().as_secs_f64();
    writeln!(
        stdout(),
        "{flights} flights, {silent} with a silent lie, {missed} rows MISSED, {time_s:.0} s"
    )?;
    Ok(if missed > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn list(campaigns: &[Campaign]) -> Result<()> {
    for campaign in campaigns {
        let Campaign { item, name, runs, small, held, .. } = campaign;
        let held = if *held { "held" } else { "" };
        writeln!(stdout(), "{item:>2}  {name:<50} {runs:>6} runs, small {small:>4}  {held}")?;
    }
    Ok(())
}

/// Flies and prints a row.
fn fly(
    arguments: &Arguments,
    campaign: &Campaign,
    precision: Precision,
    library: &mut Library,
    totals: &mut Totals,
) -> Result<()> {
    let runs = fly_all(campaign, precision, library, arguments.seed, arguments.runs(campaign))?;
    if arguments.verbose {
        for run in runs.iter().flatten() {
            writeln!(stdout(), "{}", table::run(run))?;
        }
    }
    let figures = Figures::of(&runs);
    writeln!(stdout(), "{}", table::row(campaign, precision, &figures))?;
    totals.flights += figures.runs;
    totals.silent += figures.silent;
    totals.missed += usize::from(!figures.missed(campaign).is_empty());
    Ok(())
}
