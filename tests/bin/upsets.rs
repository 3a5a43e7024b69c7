//! Flies with one flipped bit in the memory of an estimator, and counts the effects.
//!
//! ```text
//! cargo run -p tests --bin upsets -- --runs 100000                          the three estimators that fly
//! cargo run -p tests --bin upsets -- --runs 100000 --bare                   without the seal of the flight computer
//! cargo run -p tests --bin upsets -- --runs 1000 --estimator window --list  with byte, bit and sample
//! ```
//!
//! The profile `dev` is optimised and has overflow checks and debug assertions.

use std::env::current_exe;
use std::io::{Write, stdout};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::process::{Command, ExitCode};
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use clap::Parser;
use fsw_roster::EstimatorId;
use tests::upsets::campaign::{self, Runs};
use tests::upsets::{CleanFlight, Effect, Memory};

/// Flip one bit per flight in the memory of an estimator.
#[derive(Debug, Parser)]
struct Arguments {
    /// Number of flights of each estimator.
    #[arg(long, default_value_t = 1_000)]
    runs: u64,
    /// First run.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// This estimator only: window, joint-ekf, ekf-sgf-rls.
    #[arg(long)]
    estimator: Option<String>,
    /// Memory as fsw-core leaves it, without the seal of the flight computer.
    #[arg(long)]
    bare: bool,
    /// Processes at a time.
    #[arg(long, default_value_t = 2)]
    processes: u64,
    /// A line for each flight that is neither harmless nor detected.
    #[arg(long)]
    list: bool,
    /// Fly the runs in this process: the worker of a campaign.
    #[arg(long, hide = true)]
    worker: bool,
}

impl Arguments {
    fn memory(&self) -> Memory {
        if self.bare { Memory::Bare } else { Memory::Sealed }
    }
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let ids: Vec<EstimatorId> = match &arguments.estimator {
        None => EstimatorId::ALL.to_vec(),
        Some(name) => {
            let id = EstimatorId::from_name(name);
            vec![id.ok_or_else(|| anyhow!("no estimator `{name}` flies"))?]
        }
    };
    if arguments.worker {
        work(ids[0], arguments.memory(), arguments.first..arguments.first + arguments.runs)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut is_clean = true;
    for id in ids {
        is_clean &= fly(&arguments, id)?;
    }
    Ok(if is_clean { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Flies one estimator and prints its row; true without a panic, a crash, a hang, and with fewer silent flights than
/// one in a thousand.
fn fly(arguments: &Arguments, id: EstimatorId) -> Result<bool> {
    let begun = Instant::now();
    let clean = CleanFlight::new(id)?;
    let program = current_exe().context("path of this program")?;
    let command = |runs: Runs| {
        let mut command = Command::new(&program);
        command.arg("--worker").args(["--estimator", id.name()]);
        command.args(arguments.bare.then_some("--bare"));
        command.args(["--first", &runs.first.to_string()]);
        command.args(["--runs", &(runs.last - runs.first).to_string()]);
        command
    };
    let show = |run: u64, what: &str| {
        if arguments.list {
            let _ = writeln!(stdout(), "{} run {run}: {what}, {:?}", id.name(), clean.flip(run));
        }
    };
    let runs = Runs { first: arguments.first, last: arguments.first + arguments.runs };
    let tally = campaign::fly(command, runs, arguments.processes, show)?;
    let per_s = tally.flights() as f64 / begun.elapsed().as_secs_f64();
    writeln!(stdout(), "{:<12} {:>6} bytes {tally}, {per_s:.0}/s", id.name(), clean.bytes())?;
    let [_, _, silent, panicked] = tally.by_effect;
    Ok(panicked + tally.crashed + tally.hung == 0 && silent * 1_000 < tally.flights())
}

/// Flies runs, and prints the code of each.
fn work(id: EstimatorId, memory: Memory, runs: Range<u64>) -> Result<()> {
    let clean = CleanFlight::new(id)?;
    set_hook(Box::new(|_| {}));
    for run in runs {
        let flip = clean.flip(run);
        let flown = catch_unwind(AssertUnwindSafe(|| clean.fly(flip, memory)));
        writeln!(stdout(), "{}", flown.unwrap_or(Effect::Panic).code())?;
        stdout().flush()?;
    }
    Ok(())
}
