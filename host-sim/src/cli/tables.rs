//! `tables`: tables of the papers, published and reproduced.

use std::path::PathBuf;

use clap::Args;

use super::progress::{Progress, note_if_stopped, stop_on_signal};
use super::{Failure, command_line, print};
use crate::papers::Papers;
use crate::report::published::folder::write_papers;
use crate::report::tables_text;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Number of runs of each table; the default takes one or two minutes on two cores
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Seed of the first run; run i has this plus i
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Write a report for the browser, the tables, and a counterpart of every figure of the papers, into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of tables
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { runs, seed, out, json } = arguments;
    let stop = stop_on_signal();
    let papers = Papers::load()?;
    let bar = Progress::new(*runs, "runs");
    let results = papers.fly(*seed, *runs, &stop, || bar.inc(1));
    bar.finish();
    let results = results?;
    let complete = results.runs();
    if complete == 0 {
        return Err(Failure::Interrupted);
    }
    note_if_stopped(complete, *runs);
    let report = results.tables();
    if let Some(folder) = out {
        write_papers(folder, &report, &results.figures()?, &command_line())?;
    }
    print(*json, &report, &tables_text(&report))
}
