//! `run`: simulate one flight, estimate, compare.

use clap::Args;

use super::estimate::{estimate, note_what_changes};
use super::{Failure, Options, command_line, print};
use crate::input::Scenario;
use crate::input::scenario::DEFAULT_SCENARIO;
use crate::report::{ReportFolder, RunReport, Simulated, table};
use crate::simulation::log_of;
use crate::truth::Flight;

#[derive(Debug, Args)]
pub struct Arguments {
    /// A SCENARIO.toml, or the name of a built-in one.
    #[arg(default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// Seed of the gyro's noise, and of what the scenario disperses.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    options: Options,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, seed, options } = arguments;
    let scenario = Scenario::load(scenario)?.of_seed(*seed);
    note_what_changes(&scenario);
    let flight = Flight::simulate(&scenario)?;
    let log = log_of(&scenario, &flight, *seed);
    let craft = scenario.craft();
    let estimated = estimate(options, &craft, &log, &scenario.name)?;
    let truth_kg_m2 = scenario.final_inertia_kg_m2();
    let bound_kg_m2 = flight.bound.sigma_kg_m2;
    let report = RunReport::new(&scenario.name, *seed, estimated.report, truth_kg_m2, bound_kg_m2);
    let table = table::run(&report);
    if let Some(folder) = &options.out {
        let title = format!("{}, {}", scenario.name, options.method.estimator);
        ReportFolder {
            title: &title,
            command: &command_line(),
            table: &table,
            result: &report,
            history: &estimated.history,
            simulated: Some(Simulated { log: &log, craft: &craft, flight: &flight }),
        }
        .write(folder)?;
    }
    print(options.json, &report, &table)
}
