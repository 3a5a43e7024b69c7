//! A scenario with its true motion and its bound, flown by several estimators and seeds.

use super::paper::PapersFailed;
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

/// The own estimator in the precision that flies, for comparison with the published ones.
pub const OWN: Method = Method { estimator: EstimatorName::Window, precision: Precision::F32 };

/// A scenario and its true motion.
#[derive(Clone, Debug)]
pub struct Case {
    /// Scenario.
    pub scenario: Scenario,
    /// True motion and Cramér-Rao bound.
    pub flight: Flight,
    craft: Craft,
}

impl Case {
    /// The built-in scenario `name`.
    ///
    /// # Errors
    /// A scenario that cannot be read or integrated.
    pub fn load(name: &str) -> Result<Self, PapersFailed> {
        Self::new(Scenario::load(name)?)
    }

    /// Simulates the true motion of a scenario.
    ///
    /// # Errors
    /// A scenario that cannot be integrated.
    pub fn new(scenario: Scenario) -> Result<Self, PapersFailed> {
        let flight = Flight::simulate(&scenario)?;
        let craft = scenario.craft();
        Ok(Self { scenario, flight, craft })
    }

    /// Craft data of the estimators.
    pub fn craft(&self) -> &Craft {
        &self.craft
    }

    /// True elements, kg m².
    pub fn truth_kg_m2(&self) -> &[f64; 6] {
        &self.scenario.spacecraft.inertia_kg_m2
    }

    /// Truth and bound, against which an estimate is scored.
    pub fn reference(&self) -> Reference {
        let bound_kg_m2 = self.flight.bound.sigma_kg_m2;
        Reference { truth_kg_m2: *self.truth_kg_m2(), bound_kg_m2, joint_bound_kg_m2: [None; 6] }
    }

    /// Bound of an element, one sigma, kg m². None if the element is not observed.
    pub fn bound_kg_m2(&self, element: usize) -> Option<f64> {
        self.flight.bound.sigma_kg_m2[element]
    }

    /// Bound of an element, per cent of the true element. None if the element is zero.
    pub fn bound_percent(&self, element: usize) -> Option<f64> {
        let truth = self.truth_kg_m2()[element].abs();
        let bound = self.bound_kg_m2(element)?;
        (truth > 0.0).then(|| 100.0 * bound / truth)
    }

    /// Absolute error, per cent of the true element.
    pub fn error_percent(&self, element: usize, estimate_kg_m2: f64) -> f64 {
        let truth = self.truth_kg_m2()[element];
        100.0 * ((estimate_kg_m2 - truth) / truth).abs()
    }

    /// Flies the log of this seed. `watch` is called after each sample with the sample's index.
    ///
    /// # Errors
    /// An estimator that rejects its configuration.
    pub fn fly(
        &self,
        method: Method,
        seed: u64,
        mut watch: impl FnMut(usize, &dyn AnyEstimator),
    ) -> Result<EstimationResult, SetUpError> {
        let log = log_of(&self.scenario, &self.flight, seed);
        let mut index = 0;
        Ok(estimate_log(&log, self.set_up(method)?, |_, _, estimator| {
            watch(index, estimator);
            index += 1;
        }))
    }

    /// Flies the log of this seed. Output: the log and the estimate after each sample.
    ///
    /// # Errors
    /// An estimator that rejects its configuration.
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
            gyro_noise_rad_s: self.craft.gyro.reading_sigma_rad_s(),
            sample_period_s: 1.0 / self.scenario.gyro.rate_hz,
            refuse_spikes: true,
        })
    }
}
