//! Flies the campaign of `diagnose` and prints its table.
//!
//! ```text
//! cargo run --release -p tests --bin diagnose -- --runs 20
//! cargo run --release -p tests --bin diagnose -- wheel gyro --scenario microsat-slew --prior
//! ```
//!
//! `shows` counts the flights in which the planted error shows, `first` those of them in which it is the first
//! explanation, `named` those in which it is the first or not distinguished from it.

use anyhow::Result;
use clap::Parser;
use tests::diagnose::{Row, SCENARIOS, fly};

/// Fly the campaign of `diagnose`: one planted error at a time.
#[derive(Debug, Parser)]
struct Arguments {
    /// Parts of names of errors; all errors without a part.
    names: Vec<String>,
    /// Flights of each error.
    #[arg(long, default_value_t = 20)]
    runs: u64,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// This scenario only.
    #[arg(long)]
    scenario: Option<String>,
    /// The craft states a prior of the inertia, 30 % of each moment.
    #[arg(long)]
    prior: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let names = &arguments.names;
    let is_selected =
        |name: &str| names.is_empty() || names.iter().any(|part| name.contains(part.as_str()));
    println!(
        "{:<18}{:<34}{:>6}{:>6}{:>6}  mistaken for",
        "scenario", "error", "shows", "first", "named"
    );
    let mut all = Vec::new();
    for scenario in SCENARIOS {
        if arguments.scenario.as_ref().is_some_and(|only| only != scenario) {
            continue;
        }
        let rows = fly(scenario, arguments.runs, arguments.seed, arguments.prior, is_selected)?;
        rows.iter().for_each(print);
        all.extend(rows);
    }
    for (kind, is_mistake) in [("mistakes", true), ("hardware", false)] {
        let rows = all.iter().filter(|row| row.is_mistake == is_mistake);
        let sums = rows.map(Row::counts).fold([0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]));
        println!("{kind}: shows {}, first {}, named {}", sums[0], sums[1], sums[2]);
    }
    Ok(())
}

fn print(row: &Row) {
    let [shows, first, named] = row.counts();
    println!(
        "{:<18}{:<34}{shows:>6}{first:>6}{named:>6}  {}",
        row.scenario,
        row.error,
        row.mistaken_for().unwrap_or("")
    );
}
