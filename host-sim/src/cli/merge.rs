//! `merge`: the report of a campaign that was flown in shards.

use std::path::PathBuf;

use clap::Args;

use super::mc::write;
use super::{Failure, print};
use crate::campaign::Tally;
use crate::report::runs::{Rows, RunsOutput};
use crate::report::shards::Shards;
use crate::report::{McReport, table};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Parquet files of mc --shard, in any order
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Write a report for the browser, and a row per run as CSV and Parquet, into this folder; a name that ends in .csv
    /// or .parquet: the rows alone
    #[arg(long, value_name = "DIR|FILE")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { files, out, json } = arguments;
    let shards = Shards::open(files)?;
    let record = shards.record();
    record.notes.iter().for_each(|note| eprintln!("note: {note}"));
    let mut tally = Tally::default();
    shards.each(&mut |row| {
        tally.add(&row.run);
        Ok(())
    })?;
    let report = McReport::new(record, &tally, None);
    if let Some(out) = out.as_deref().map(RunsOutput::create).transpose()? {
        write(out, &report, &shards, record, &record.command())?;
    }
    print(*json, &report, &table::mc(&report))
}
