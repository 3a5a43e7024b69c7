//! Estimators that Python steps, one sample at a time.

use fsw_core::outcome::OutcomeCounts;
use host_sim::estimation::{AnyEstimator, EstimationResult, Events, Method, Setup, set_up};
use host_sim::input::Craft;
use host_sim::input::craft::LogFormat;
use host_sim::input::log::LogRow;
use host_sim::report::ReplayReport;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::input::{Source, method};
use crate::json;

/// Note on a craft that maps the columns of a log.
const LOG_IGNORED: &str =
    "[log] of the craft is for logs; samples are in µs, rad/s and N m, and are not converted";

/// An estimator of the flight core.
#[pyclass(unsendable, module = "host_sim._native")]
pub struct Estimator {
    estimator: Box<dyn AnyEstimator>,
    method: Method,
    craft: Craft,
    counts: OutcomeCounts,
    events: Events,
    samples: usize,
    first_us: Option<u64>,
}

#[pymethods]
impl Estimator {
    #[new]
    fn new(name: &str, craft: Source, sample_period_s: f64, precision: &str) -> PyResult<Self> {
        if !(sample_period_s.is_finite() && sample_period_s > 0.0) {
            let message = format!("sample_period_s is {sample_period_s}; it must be positive");
            return Err(PyValueError::new_err(message));
        }
        let (method, craft) = (method(name, precision)?, craft.craft()?);
        let setup = Setup {
            estimator: method.estimator,
            precision: method.precision,
            craft: &craft,
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
            sample_period_s,
            refuse_spikes: true,
        };
        let failed = |error: host_sim::estimation::SetUpError| {
            PyValueError::new_err(format!("craft: {error}"))
        };
        let estimator = set_up(&setup).map_err(failed)?;
        let (counts, events) = (OutcomeCounts::default(), Events::default());
        Ok(Self { estimator, method, craft, counts, events, samples: 0, first_us: None })
    }

    /// Processes a sample: time in µs, body rate in rad/s, wheel speeds in rad/s, external torque in N m, attitude from
    /// inertial to body axes, scalar last. Returns the name of the outcome, and true for a sample that was used.
    #[pyo3(signature = (time_us, rate_rad_s, wheel_speed_rad_s, torque_n_m, attitude=None))]
    fn step(
        &mut self,
        time_us: u64,
        rate_rad_s: [f64; 3],
        wheel_speed_rad_s: Vec<f64>,
        torque_n_m: [f64; 3],
        attitude: Option<[f64; 4]>,
    ) -> PyResult<(&'static str, bool)> {
        let (given, wheels) = (wheel_speed_rad_s.len(), self.craft.wheels.len());
        if given != wheels {
            let message =
                format!("wheel_speed_rad_s has {given} speeds; the craft has {wheels} wheels");
            return Err(PyValueError::new_err(message));
        }
        let rate_rad_s = self.craft.hardware.corrected_rate_rad_s(&rate_rad_s.into());
        let first_us = *self.first_us.get_or_insert(time_us);
        self.samples += 1;
        let row = LogRow {
            line: self.samples as u64,
            time_us: time_us.wrapping_sub(first_us),
            rate_rad_s,
            wheel_speed_rad_s,
            torque_n_m: torque_n_m.into(),
            attitude,
        };
        let outcome = self.estimator.step(&row);
        self.counts.add(&outcome);
        self.events.add(row.time_us, &outcome);
        Ok((outcome.name(), outcome.used_sample()))
    }

    /// Completes the work that is due on the samples so far.
    fn finish(&mut self) {
        self.estimator.finish();
    }

    /// Filtered body rate, rad/s.
    fn rate_rad_s(&self) -> [f64; 3] {
        self.estimator.rate_rad_s().into()
    }

    /// The document of `replay` for the samples so far.
    fn estimate(&self) -> PyResult<String> {
        let result = EstimationResult {
            counts: self.counts,
            events: self.events.clone(),
            estimate: self.estimator.estimate(),
            hardware: self.estimator.hardware(),
        };
        let mut report = ReplayReport::new(self.method, self.samples, &result);
        if self.craft.log != LogFormat::default() {
            report.notes.push(LOG_IGNORED.to_owned());
        }
        json(&report)
    }
}
