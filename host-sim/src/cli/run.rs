//! `run`: simulate one flight, estimate, compare with truth and bound.

use clap::Args;

use super::estimate::{estimate, note_changes};
use super::notes::Notes;
use super::{Failure, Options, command_line, print};
use crate::estimation::{Method, with_wheel_error};
use crate::input::log::{LogRow, correct_wheels};
use crate::input::scenario::DEFAULT_SCENARIO;
use crate::input::{Craft, Scenario, plausible, scenario};
use crate::report::{FlightResult, HistoryRow, ReportFolder, RunReport, Simulated, table};
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

/// A simulated flight and its estimate.
pub(super) struct Flown {
    pub scenario: Scenario,
    pub craft: Craft,
    pub log: Vec<LogRow>,
    pub flight: Flight,
    pub report: RunReport,
    pub history: Vec<HistoryRow>,
}

/// Flies the scenario with this seed. The history is empty unless it is kept.
pub(super) fn fly(
    scenario: &Scenario,
    seed: u64,
    method: Method,
    keep_history: bool,
    mut notes: Notes,
) -> Result<Flown, Failure> {
    let scenario = scenario.of_seed(seed);
    note_changes(&scenario, &mut notes);
    plausible::scenario(&scenario).into_iter().for_each(|note| notes.add(note));
    let flight = Flight::simulate(&scenario)?;
    plausible::flight(&scenario, &flight.instants).into_iter().for_each(|note| notes.add(note));
    let log = log_of(&scenario, &flight, seed);
    let craft = scenario.craft();
    let faults = (scenario.faults.as_slice(), seed);
    let mut rows = log.clone();
    let (known, on_wheels) = match correct_wheels(&mut rows, &craft.hardware) {
        Some(error) => with_wheel_error(method, &craft, &rows, &error)
            .map_err(|error| Failure::SetUp { source_name: scenario.name.clone(), error })?,
        None => (craft.clone(), Vec::new()),
    };
    on_wheels.into_iter().for_each(|note| notes.add(note));
    let estimated = estimate(method, keep_history, &known, &rows, &scenario.name, faults, notes)?;
    let report = RunReport::of_flight(&scenario, seed, &flight, estimated.report);
    Ok(Flown { scenario, craft, log, flight, report, history: estimated.history })
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, seed, options } = arguments;
    let sources = scenario::sources(scenario);
    let scenario = Scenario::load(scenario)?;
    let keep_history = options.out.is_some();
    let flown = fly(&scenario, *seed, options.method, keep_history, Notes::default())?;
    let table = table::run(&flown.report);
    if let Some(folder) = &options.out {
        let title = format!("{}, {}", flown.scenario.name, options.method.estimator);
        ReportFolder {
            title: &title,
            command: &command_line(),
            result: FlightResult::Run(&flown.report),
            history: &flown.history,
            inputs: &[],
            simulated: Some(Simulated {
                log: &flown.log,
                craft: &flown.craft,
                flight: &flown.flight,
                scenario: &sources?,
            }),
        }
        .write(folder)?;
    }
    print(options.json, &flown.report, &table)
}
