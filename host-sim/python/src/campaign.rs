//! Monte Carlo campaigns.

use host_sim::cli::verbs;
use host_sim::report::runs::Cells;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::input::{Source, method};
use crate::interrupt::interruptible;
use crate::{json, raised};

/// Document of a campaign, and its rows by column. Ctrl-C ends it; no run is left over.
#[pyfunction]
pub fn mc<'py>(
    py: Python<'py>,
    scenario: Source,
    runs: u64,
    seed: u64,
    estimator: &str,
    precision: &str,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let method = method(estimator, precision)?;
    let scenario = scenario.scenario()?;
    let flown = interruptible(py, |stop| verbs::mc(&scenario, runs, seed, method, stop))?;
    let (report, columns) = flown.map_err(|failure| raised(&failure))?;
    let rows = PyDict::new(py);
    for (name, cells) in columns {
        match cells {
            Cells::Count(cells) => {
                let counts = cells.iter().map(|cell| cell.unwrap_or_default());
                rows.set_item(name, PyArray1::from_iter(py, counts))?;
            }
            Cells::Number(cells) => {
                let numbers = cells.iter().map(|cell| cell.unwrap_or(f64::NAN));
                rows.set_item(name, PyArray1::from_iter(py, numbers))?;
            }
            Cells::Text(cells) => rows.set_item(name, cells)?,
            Cells::Flag(cells) => rows.set_item(name, cells)?,
        }
    }
    Ok((json(&report)?, rows))
}
