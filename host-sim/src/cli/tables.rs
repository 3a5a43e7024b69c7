//! `tables`: the tables of the papers, published beside reproduced.

use std::path::PathBuf;

use clap::Args;

use super::campaign::{progress_bar, stop_on_ctrl_c};
use super::{Failure, print};
use crate::papers::Papers;
use crate::report::published::folder::write_papers;
use crate::report::tables_text;

#[derive(Debug, Args)]
pub struct Arguments {
    /// How many runs of each. The default takes a minute or two on two cores.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Seed of the first run's noise; run i has this plus i.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Write the tables, and a counterpart of every figure of the papers, into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of tables.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { runs, seed, out, json } = arguments;
    let stop = stop_on_ctrl_c();
    let papers = Papers::load()?;
    let bar = progress_bar(*runs, "runs");
    let reproduction = papers.fly(*seed, *runs, &stop, || bar.inc(1));
    bar.finish_and_clear();
    let reproduction = reproduction?;
    let complete = reproduction.runs();
    if complete == 0 {
        return Err(Failure::Interrupted);
    }
    if complete < *runs {
        eprintln!("note: stopped after {complete} of {runs} runs; this is their result");
    }
    let report = reproduction.tables();
    if let Some(folder) = out {
        write_papers(folder, &report, &reproduction.figures()?)?;
    }
    print(*json, &report, &tables_text(&report))
}
