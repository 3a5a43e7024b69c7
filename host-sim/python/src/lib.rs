//! Extension module `host_sim._native`: the verbs of `host-sim` as functions on numpy arrays.
//!
//! ```text
//! arrays, paths, dictionaries ─► input ─► host_sim::cli::verbs ─► JSON document and arrays ─► host_sim/*.py
//! ```
//!
//! A result is the document of `--json`, as text: the numbers are those of the command to the last bit. Bad input is a
//! `ValueError` with the message of the command, a run that could not finish a `RuntimeError`.

mod arrays;
mod campaign;
mod estimator;
mod input;
mod interrupt;

use host_sim::cli::verbs::{self, VerbFailed};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use arrays::history;
use input::{Log, Source, method};

/// Exception of a failure.
fn raised(failure: &VerbFailed) -> PyErr {
    match failure.is_bad_input() {
        true => PyValueError::new_err(failure.to_string()),
        false => PyRuntimeError::new_err(failure.to_string()),
    }
}

/// The document of a result as text.
fn json(report: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(report).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Document and time history of one log.
#[pyfunction]
fn replay<'py>(
    py: Python<'py>,
    craft: Source,
    log: Log,
    estimator: &str,
    precision: &str,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let method = method(estimator, precision)?;
    let craft = craft.craft()?;
    let result = py.detach(|| verbs::replay(&craft, log.read(&craft)?, method));
    let (report, rows) = result.map_err(|failure| raised(&failure))?;
    Ok((json(&report)?, history(py, &rows)?))
}

/// Document and time history of a simulated flight.
#[pyfunction]
fn run<'py>(
    py: Python<'py>,
    scenario: Source,
    seed: u64,
    estimator: &str,
    precision: &str,
) -> PyResult<(String, Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let method = method(estimator, precision)?;
    let scenario = scenario.scenario()?;
    let result = py.detach(|| verbs::run(&scenario, seed, method));
    let flown = result.map_err(|failure| raised(&failure))?;
    Ok((json(&flown.report)?, history(py, &flown.history)?, arrays::log(py, &flown.log)?))
}

/// Document of a Cramér-Rao bound.
#[pyfunction]
#[pyo3(signature = (scenario, seed=None))]
fn crlb(py: Python<'_>, scenario: Source, seed: Option<u64>) -> PyResult<String> {
    let scenario = scenario.scenario()?;
    let report = py.detach(|| verbs::crlb(&scenario, seed));
    json(&report.map_err(|failure| raised(&failure))?)
}

/// Document of a diagnosis.
#[pyfunction]
fn diagnose(py: Python<'_>, craft: Source, log: Log) -> PyResult<String> {
    let craft = craft.craft()?;
    let report = py.detach(|| verbs::diagnose(&craft, log.read(&craft)?));
    json(&report.map_err(|failure| raised(&failure))?)
}

/// Text of the craft file that a log suggests.
#[pyfunction]
fn draft_craft(py: Python<'_>, log: Log) -> PyResult<String> {
    py.detach(|| log.draft()).map_err(|failure| raised(&failure))
}

/// Document of a designed manoeuvre; `arguments` are those of the command line.
#[pyfunction]
fn design(py: Python<'_>, arguments: Vec<String>) -> PyResult<String> {
    let found = interrupt::interruptible(py, |stop| verbs::design(&arguments, stop))?;
    json(&found.map_err(|failure| raised(&failure))?)
}

/// Names of the estimators, the default first.
#[pyfunction]
fn estimators() -> Vec<String> {
    host_sim::estimation::EstimatorName::all().map(|name| name.to_string()).collect()
}

/// Names of the built-in scenarios, the default first.
#[pyfunction]
fn scenarios() -> Vec<&'static str> {
    host_sim::input::scenario::built_in_names().collect()
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::campaign::mc;
    #[pymodule_export]
    use super::estimator::Estimator;
    #[pymodule_export]
    use super::{crlb, design, diagnose, draft_craft, estimators, replay, run, scenarios};
}
