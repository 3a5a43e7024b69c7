//! Flies the catalogue of imperfections and prints its matrix.
//!
//! ```text
//! cargo run --release -p tests --bin hardware                       all cells, 100 flights each
//! cargo run --release -p tests --bin hardware -- wheel --runs 20    rows whose name has this part
//! ```
//!
//! A cell reads `NEES / lies % / flagged %`. A limit that does not hold is printed as MISSED, and the exit status is
//! then 1.

use std::io::{Write, stdout};
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use host_sim::estimation::{EstimatorName, Precision};
use host_sim::input::Scenario;
use tests::hardware::catalogue::{DATA_SHEET, SCENARIOS, all};
use tests::hardware::cell::{Cell, Flown};

/// Fly the catalogue of imperfections, hardware stated at the level flown.
#[derive(Debug, Parser)]
struct Arguments {
    /// Parts of names: rows that have any of them; all rows without a part.
    names: Vec<String>,
    /// Flights of a cell.
    #[arg(long, default_value_t = 100)]
    runs: u64,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Estimator.
    #[arg(long, value_enum, default_value_t = EstimatorName::Window)]
    estimator: EstimatorName,
    /// Precision.
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    precision: Precision,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let Arguments { estimator, precision, seed, runs, .. } = arguments;
    let flown = Flown { estimator, precision, seed, runs };
    let is_wanted = |name: &str| {
        arguments.names.is_empty()
            || arguments.names.iter().any(|part| name.contains(part.as_str()))
    };
    let ideal = SCENARIOS.map(Scenario::load);
    let mut cells = 0;
    let mut missed = 0;
    let mut print = |name: &str, level: &str, of: Vec<Option<Cell>>| -> Result<()> {
        let mut line = format!("{name:34} {level:18}");
        for cell in of {
            line += &format!("  {:30}", text(cell.as_ref()));
            cells += usize::from(cell.is_some());
            missed += usize::from(cell.is_some_and(|cell| !cell.missed().is_empty()));
        }
        writeln!(stdout(), "{}", line.trim_end())?;
        Ok(())
    };
    for case in all().iter().filter(|case| is_wanted(case.name)) {
        let mut of_scenarios = Vec::new();
        for scenario in &ideal {
            let scenario = scenario.as_ref().map_err(|error| anyhow::anyhow!("{error}"))?;
            of_scenarios.push(Cell::of_case(case, scenario, &flown)?);
        }
        print(case.name, &case.level, of_scenarios)?;
    }
    if is_wanted("everything at once") {
        let fly = |name: &str| -> Result<Option<Cell>> {
            Ok(Some(Cell::fly(&Scenario::load(name)?, &flown)?))
        };
        let of_scenarios = DATA_SHEET.into_iter().map(fly).collect::<Result<_>>()?;
        print("everything at once", "data sheet", of_scenarios)?;
    }
    writeln!(stdout(), "{cells} cells, {missed} MISSED")?;
    Ok(if missed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(cell: Option<&Cell>) -> String {
    let Some(cell) = cell else { return "–".to_owned() };
    let percent = |count: usize| 100.0 * count as f64 / cell.runs as f64;
    let nees = cell.nees.map_or("–".to_owned(), |nees| format!("{nees:.2}"));
    let missed = cell.missed();
    let mark =
        if missed.is_empty() { String::new() } else { format!(" MISSED {}", missed.join(", ")) };
    format!("{nees} / {:.0} / {:.0}{mark}", percent(cell.lies), percent(cell.flagged))
}
