//! Flies every campaign of the accuracy tables and rewrites them in their pages.
//!
//! `cargo run --release -p tests --bin accuracy` takes a quarter of an hour on two cores. With
//! `--check` nothing is written: two runs of each campaign are flown, and the pages are compared
//! with the list as far as that is possible without the figures.

use std::path::PathBuf;

use anyhow::Result;
use clap::Parser;
use tests::accuracy::tables::TABLES;
use tests::accuracy::{Runs, fly_all, page};
use tests::program::HostSim;

/// Runs of each campaign with `--check`.
const FEW: u64 = 2;

/// Rewrite the accuracy tables of README.md and of the pages.
#[derive(Debug, Parser)]
struct Arguments {
    /// Fly two runs of each campaign, compare the pages with the list of campaigns, write nothing.
    #[arg(long)]
    check: bool,
    /// Program to run in place of `cargo run --release -p host-sim --`.
    #[arg(long, value_name = "PROGRAM")]
    host_sim: Option<PathBuf>,
}

fn main() -> Result<()> {
    let Arguments { check, host_sim } = Arguments::parse();
    let host_sim = host_sim.map_or(HostSim::ByCargo, HostSim::Built);
    let progress = |command: &str| eprintln!("{command}");
    if check {
        TABLES.iter().try_for_each(page::check)?;
        fly_all(&host_sim, Runs::Few(FEW), progress)?;
        return Ok(());
    }
    for (table, rows) in TABLES.iter().zip(fly_all(&host_sim, Runs::AsListed, progress)?) {
        page::rewrite(table, &rows)?;
    }
    Ok(())
}
