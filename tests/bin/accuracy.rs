//! Flies every campaign of the accuracy tables and rewrites them in their pages.
//!
//! `cargo run --release -p tests --bin accuracy` takes a quarter of an hour on two cores. With
//! `--check` nothing is written: two runs of each campaign are flown, and the pages are compared
//! with the list as far as that is possible without the figures.

use anyhow::Result;
use clap::Parser;
use tests::accuracy::tables::TABLES;
use tests::accuracy::{Runs, fly_all, page};

/// Runs of each campaign with `--check`.
const FEW: u64 = 2;

/// Rewrite the accuracy tables of README.md and of the pages.
#[derive(Debug, Parser)]
struct Arguments {
    /// Fly two runs of each campaign, compare the pages with the list of campaigns, write nothing.
    #[arg(long)]
    check: bool,
}

fn main() -> Result<()> {
    let Arguments { check } = Arguments::parse();
    let progress = |command: &str| eprintln!("{command}");
    if check {
        TABLES.iter().try_for_each(page::check)?;
        fly_all(Runs::Few(FEW), progress)?;
        return Ok(());
    }
    for (table, rows) in TABLES.iter().zip(fly_all(Runs::AsListed, progress)?) {
        page::rewrite(table, &rows)?;
    }
    Ok(())
}
