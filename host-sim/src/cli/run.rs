//! `run`: simulate one flight, estimate, compare with truth and bound.

use clap::Args;

use super::estimate::{estimate, note_changes};
use super::notes::Notes;
use super::{Failure, Options, command_line, print};
use crate::input::scenario::DEFAULT_SCENARIO;
use crate::input::{Scenario, plausible, scenario};
use crate::report::{FlightResult, ReportFolder, RunReport, Simulated, table};
use crate::simulation::log_of;
use crate::truth::Flight;

#[derive(Debug, Args)]
pub struct Arguments {
    /// SCENARIO.toml, or name of a built-in scenario
    #[arg(default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// Seed of gyro noise and dispersion
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    options: Options,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, seed, options } = arguments;
    let sources = scenario::sources(scenario);
    let scenario = Scenario::load(scenario)?.of_seed(*seed);
    let mut notes = Notes::default();
    note_changes(&scenario, &mut notes);
    plausible::scenario(&scenario).into_iter().for_each(|note| notes.add(note));
    let flight = Flight::simulate(&scenario)?;
    plausible::flight(&scenario, &flight.instants).into_iter().for_each(|note| notes.add(note));
    let log = log_of(&scenario, &flight, *seed);
    let craft = scenario.craft();
    let estimated = estimate(
        options.method,
        options.out.is_some(),
        &craft,
        &log,
        &scenario.name,
        (&scenario.faults, *seed),
        notes,
    )?;
    let report = RunReport::of_flight(&scenario, *seed, &flight, estimated.report);
    let table = table::run(&report);
    if let Some(folder) = &options.out {
        let title = format!("{}, {}", scenario.name, options.method.estimator);
        ReportFolder {
            title: &title,
            command: &command_line(),
            result: FlightResult::Run(&report),
            history: &estimated.history,
            inputs: &[],
            simulated: Some(Simulated {
                log: &log,
                craft: &craft,
                flight: &flight,
                scenario: &sources?,
            }),
        }
        .write(folder)?;
    }
    print(options.json, &report, &table)
}
