//! Rows of results as numpy arrays, one per quantity.

use host_sim::input::log::LogRow;
use host_sim::report::HistoryRow;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Missing numbers.
const NONE: [f64; 3] = [f64::NAN; 3];

/// Name of a vector, and its value in a row.
type Vector = (&'static str, fn(&HistoryRow) -> [f64; 3]);

/// Estimate after each sample: vectors as rows, NaN for a missing value.
pub fn history<'py>(py: Python<'py>, rows: &[HistoryRow]) -> PyResult<Bound<'py, PyDict>> {
    let arrays = PyDict::new(py);
    arrays.set_item("t_s", numbers(py, rows, |row| row.time_s))?;
    let vectors: [Vector; 6] = [
        ("gyro_rad_s", |row| row.measured_rate_rad_s),
        ("rate_rad_s", |row| row.estimated_rate_rad_s),
        ("rate_sigma_rad_s", |row| row.rate_sigma_rad_s.unwrap_or(NONE)),
        ("acceleration_rad_s2", |row| row.acceleration.map_or(NONE, |a| a.rad_s2)),
        ("innovation_rad_s", |row| row.innovation_rad_s.unwrap_or(NONE)),
        ("innovation_sigma_rad_s", |row| row.innovation_sigma_rad_s.unwrap_or(NONE)),
    ];
    for (name, vector) in vectors {
        arrays.set_item(name, table(py, rows, vector)?)?;
    }
    let delay_s = |row: &HistoryRow| row.acceleration.map_or(f64::NAN, |a| a.delay_s);
    arrays.set_item("acceleration_delay_s", numbers(py, rows, delay_s))?;
    arrays.set_item("nis", numbers(py, rows, |row| row.nis.unwrap_or(f64::NAN)))?;
    arrays.set_item("inertia_kg_m2", table(py, rows, |row| row.inertia_kg_m2)?)?;
    arrays.set_item("sigma_kg_m2", table(py, rows, |row| row.sigma_kg_m2)?)?;
    let outcomes: Vec<&str> = rows.iter().map(|row| row.outcome).collect();
    arrays.set_item("outcome", outcomes)?;
    Ok(arrays)
}

/// A simulated log by the columns of a log file.
pub fn log<'py>(py: Python<'py>, rows: &[LogRow]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    columns.set_item("t_s", numbers(py, rows, |row| row.time_us as f64 * 1e-6))?;
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let rate = numbers(py, rows, |row| row.rate_rad_s[i]);
        columns.set_item(format!("gyro_{axis}_rad_s"), rate)?;
    }
    for i in 0..rows.first().map_or(0, |row| row.wheel_speed_rad_s.len()) {
        let speed = |row: &LogRow| row.wheel_speed_rad_s.get(i).copied().unwrap_or(f64::NAN);
        columns.set_item(format!("wheel_{}_rad_s", i + 1), numbers(py, rows, speed))?;
    }
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let torque = numbers(py, rows, |row| row.torque_n_m[i]);
        columns.set_item(format!("torque_{axis}_n_m"), torque)?;
    }
    for i in 0..4 {
        let component = |row: &LogRow| row.attitude.map_or(f64::NAN, |q| q[i]);
        columns.set_item(format!("attitude_q{}", i + 1), numbers(py, rows, component))?;
    }
    Ok(columns)
}

/// A number of each row.
pub fn numbers<'py, R>(
    py: Python<'py>,
    rows: &[R],
    of: impl Fn(&R) -> f64,
) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(py, rows.iter().map(of))
}

/// A vector of each row.
fn table<'py, R, const N: usize>(
    py: Python<'py>,
    rows: &[R],
    of: impl Fn(&R) -> [f64; N],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    PyArray1::from_iter(py, rows.iter().flat_map(of)).reshape([rows.len(), N])
}
