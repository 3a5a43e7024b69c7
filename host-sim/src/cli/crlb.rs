//! `crlb`: what no unbiased estimator can beat on a scenario.

use clap::Args;

use super::estimate::note_what_changes;
use super::{Failure, print};
use crate::input::Scenario;
use crate::input::scenario::DEFAULT_SCENARIO;
use crate::report::{CrlbReport, table};
use crate::truth::{Bound, Flight, IntegrationFailed, TorqueEffect};

#[derive(Debug, Args)]
pub struct Arguments {
    /// A SCENARIO.toml, or the name of a built-in one.
    #[arg(default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// What this seed makes of a scenario whose truth differs from run to run; left out: the truth that
    /// its file gives, or of spacecraft at random that of seed 0.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = Scenario::load(&arguments.scenario)?;
    let scenario = match arguments.seed {
        Some(seed) => scenario.of_seed(seed),
        None => scenario,
    };
    note_what_changes(&scenario);
    let bound = Flight::simulate(&scenario)?.bound;
    let report = CrlbReport::new(
        &scenario.name,
        bound.unknowns.names().into_iter().map(str::to_owned).collect(),
        scenario.final_inertia_kg_m2(),
        bound.sigma_kg_m2,
        bound.observed_directions,
    );
    let report = match torque_effect(&scenario, bound)? {
        Some(asked) if scenario.solve_for.torque => report.with_torque(None, asked.together_n_m),
        Some(unmodelled) => {
            report.with_torque(Some(unmodelled.inertia_error_kg_m2_per_n_m), unmodelled.alone_n_m)
        }
        None => report,
    };
    print(arguments.json, &report, &table::crlb(&report))
}

/// What a constant torque does, which takes another flight if the scenario doesn't ask for it.
fn torque_effect(
    scenario: &Scenario,
    bound: Bound,
) -> Result<Option<TorqueEffect>, IntegrationFailed> {
    if scenario.solve_for.torque {
        return Ok(bound.torque);
    }
    let mut asking = scenario.clone();
    asking.solve_for.torque = true;
    Ok(Flight::simulate(&asking)?.bound.torque)
}
