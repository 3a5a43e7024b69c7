//! A scenario with its truth, to be flown many times.

use super::PapersFailed;
use crate::campaign::Reference;
use crate::estimation::{
    AnyEstimator, EstimationResult, EstimatorName, Method, Precision, SetUpError, Setup,
    estimate_log, set_up,
};
use crate::input::log::LogRow;
use crate::input::{Craft, Scenario};
use crate::report::HistoryRow;
use crate::simulation::log_of;
use crate::truth::Flight;

/// What our own estimator is, in the arithmetic that flies: it stands beside the published ones.
pub const OWN: Method = Method { estimator: EstimatorName::Window, precision: Precision::F32 };

/// A scenario, flown once as physics.
#[derive(Clone, Debug)]
pub struct Course {
    /// The scenario.
    pub scenario: Scenario,
    /// Its truth and bound.
    pub flight: Flight,
    craft: Craft,
}

impl Course {
    /// The built-in scenario of this name.
    pub fn load(name: &str) -> Result<Self, PapersFailed> {
        Self::new(Scenario::load(name)?)
    }

    /// A scenario.
    pub fn new(scenario: Scenario) -> Result<Self, PapersFailed> {
        let flight = Flight::simulate(&scenario)?;
        let craft = scenario.craft();
        Ok(Self { scenario, flight, craft })
    }

    /// What the estimators are told of the craft.
    pub fn craft(&self) -> &Craft {
        &self.craft
    }

    /// The true elements, kg m².
    pub fn truth_kg_m2(&self) -> &[f64; 6] {
        &self.scenario.spacecraft.inertia_kg_m2
    }

    /// What an estimate is measured with.
    pub fn reference(&self) -> Reference {
        let bound_kg_m2 = self.flight.bound.sigma_kg_m2;
        Reference { truth_kg_m2: *self.truth_kg_m2(), bound_kg_m2 }
    }

    /// The bound of an element, kg m².
    pub fn bound_kg_m2(&self, element: usize) -> Option<f64> {
        self.flight.bound.sigma_kg_m2[element]
    }

    /// The same in per cent of the element; none of an element that is zero.
    pub fn bound_percent(&self, element: usize) -> Option<f64> {
        let truth = self.truth_kg_m2()[element].abs();
        let bound = self.bound_kg_m2(element)?;
        (truth > 0.0).then(|| 100.0 * bound / truth)
    }

    /// Size of an error in per cent of the true element.
    pub fn error_percent(&self, element: usize, estimate_kg_m2: f64) -> f64 {
        let truth = self.truth_kg_m2()[element];
        100.0 * ((estimate_kg_m2 - truth) / truth).abs()
    }

    /// Streams the log of this seed through an estimator, and shows each sample to `watch`, with
    /// its number.
    pub fn fly(
        &self,
        method: Method,
        seed: u64,
        mut watch: impl FnMut(usize, &dyn AnyEstimator),
    ) -> Result<EstimationResult, SetUpError> {
        let log = log_of(&self.scenario, &self.flight, seed);
        let mut number = 0;
        Ok(estimate_log(&log, self.set_up(method)?, |_, _, estimator| {
            watch(number, estimator);
            number += 1;
        }))
    }

    /// The same, written down sample by sample.
    pub fn history(
        &self,
        method: Method,
        seed: u64,
    ) -> Result<(Vec<LogRow>, Vec<HistoryRow>), SetUpError> {
        let log = log_of(&self.scenario, &self.flight, seed);
        let mut history = Vec::with_capacity(log.len());
        estimate_log(&log, self.set_up(method)?, |row, outcome, estimator| {
            history.push(HistoryRow::new(row, outcome, estimator));
        });
        Ok((log, history))
    }

    fn set_up(&self, method: Method) -> Result<Box<dyn AnyEstimator>, SetUpError> {
        set_up(&Setup {
            estimator: method.estimator,
            precision: method.precision,
            craft: &self.craft,
            gyro_noise_rad_s: Some(self.scenario.gyro.noise_rad_s),
            sample_period_s: 1.0 / self.scenario.gyro.rate_hz,
            refuse_spikes: true,
        })
    }
}
