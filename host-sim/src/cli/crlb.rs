//! `crlb`: Cramér-Rao bound of a scenario.

use clap::Args;

use super::estimate::note_changes;
use super::notes::Notes;
use super::{Failure, print};
use crate::input::Scenario;
use crate::input::scenario::DEFAULT_SCENARIO;
use crate::report::{CrlbReport, table};
use crate::truth::{Flight, torque_effect};

#[derive(Debug, Args)]
pub struct Arguments {
    /// SCENARIO.toml, or name of a built-in scenario
    #[arg(default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// Seed of a truth that differs from run to run; without it, the truth of the file, or of seed 0
    /// for random spacecraft
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

/// Bound of the scenario, or of that of a seed.
pub(super) fn bound(
    scenario: &Scenario,
    seed: Option<u64>,
    mut notes: Notes,
) -> Result<CrlbReport, Failure> {
    let of_seed = seed.map(|seed| scenario.of_seed(seed));
    let scenario = of_seed.as_ref().unwrap_or(scenario);
    note_changes(scenario, &mut notes);
    let bound = Flight::simulate(scenario)?.bound;
    let torque = torque_effect(scenario, &bound)?;
    Ok(CrlbReport::of_bound(scenario, &bound, torque.as_ref()))
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = Scenario::load(&arguments.scenario)?;
    let report = bound(&scenario, arguments.seed, Notes::default())?;
    print(arguments.json, &report, &table::crlb(&report))
}
