//! `list`: built-in scenarios and estimators.

use clap::Args;
use serde::Serialize;

use super::{Failure, print};
use crate::estimation::EstimatorName;
use crate::input::Scenario;
use crate::input::scenario::{built_in_names, built_in_summary};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

/// The document of `--json`.
#[derive(Serialize)]
struct List {
    scenarios: Vec<ScenarioRow>,
    estimators: Vec<EstimatorRow>,
}

#[derive(Serialize)]
struct ScenarioRow {
    name: &'static str,
    summary: String,
    wheels: usize,
    duration_s: f64,
    gyro_rate_hz: f64,
}

#[derive(Serialize)]
struct EstimatorRow {
    name: &'static str,
    source: Option<&'static str>,
    summary: &'static str,
    needs_attitude: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = |name: &'static str| {
        let scenario = Scenario::load(name)?;
        Ok(ScenarioRow {
            name,
            summary: built_in_summary(name),
            wheels: scenario.wheels.len(),
            duration_s: scenario.duration_s,
            gyro_rate_hz: scenario.gyro.rate_hz,
        })
    };
    let scenarios = built_in_names().map(scenario).collect::<Result<_, Failure>>()?;
    let estimators = EstimatorName::all().map(|estimator| {
        let properties = estimator.properties();
        EstimatorRow {
            name: properties.name,
            source: properties.paper,
            summary: properties.summary,
            needs_attitude: properties.needs_attitude,
        }
    });
    let list = List { scenarios, estimators: estimators.collect() };
    print(arguments.json, &list, &table(&list))
}

fn table(list: &List) -> String {
    let mut text = "Scenarios, for run, mc, crlb and pil:\n".to_owned();
    for row in &list.scenarios {
        text += &format!("  {:<38} {}\n", row.name, row.summary);
    }
    text += "\nEstimators, for --estimator:\n";
    for row in &list.estimators {
        let source = row.source.map_or(String::new(), |source| format!(" [{source}]"));
        text += &format!("  {:<38} {}{source}\n", row.name, row.summary);
    }
    text
}
