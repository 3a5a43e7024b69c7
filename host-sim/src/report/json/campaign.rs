//! Document of `mc`: statistics of many simulated flights.

use serde::Serialize;

/// Result of `mc`: statistics over runs that differ in gyro noise and in the dispersed quantities.
///
/// A run counts as diverged if its status is `diverged`, or if the error of an element is not finite
/// or exceeds 20 bounds, joint bounds with stated hardware, and 5 of the reported sigmas. Diverged runs are counted, and left out of
/// `rmse_*`, `bias_*` and NEES. If each run draws its own spacecraft, runs whose motion does not
/// observe all six elements are left out too.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct McReport {
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the estimator, as `joint-ekf`.
    pub estimator: String,
    /// Precision of the flight core: `f32` or `f64`.
    pub precision: String,
    /// Seed of the first run. Run `i` has `seed + i`.
    pub seed: u64,
    /// Completed runs: the number requested, or fewer after Ctrl-C.
    pub runs: u64,
    /// Runs in the statistics: all except `diverged` and `not_shown`.
    pub used: u64,
    /// Runs with a spacecraft of their own whose motion leaves the bound of an element above a tenth of
    /// the mean moment.
    pub not_shown: u64,
    /// Runs that diverged: by their status, or by an error far beyond the reported sigma.
    pub diverged: u64,
    /// Runs that did not diverge, with another status than `converged` or an error far beyond the
    /// bound.
    pub not_converged: u64,
    /// Runs, of all, that discarded an earlier estimate at least once because new data contradicted
    /// it.
    pub changes: u64,
    /// Runs, of all, whose last residuals fail the test for white noise. Zero if not tested.
    pub residuals_not_white: u64,
    /// Runs, of all, with the status `converged` and residuals that do not fail the test for white
    /// noise, in which the error of an element exceeds 5 of its reported sigmas.
    pub silent_lies: u64,
    /// True elements at the end of the flight, kg m². Mean over the runs if they differ.
    pub truth_kg_m2: [f64; 6],
    /// RMS of estimated minus true, kg m². Null if all runs diverged.
    pub rmse_kg_m2: [Option<f64>; 6],
    /// Mean of estimated minus true, kg m². Null if all runs diverged.
    pub bias_kg_m2: [Option<f64>; 6],
    /// Cramér-Rao bound of each element, one sigma, kg m². Null if the element is unobserved. RMS of
    /// the bounds if the runs differ.
    pub bound_kg_m2: [Option<f64>; 6],
    /// Bound with the stated errors of the hardware among the unknowns, their sigmas as prior, kg m². Null
    /// if an element is unobserved or the hardware is ideal. RMS of the bounds if the runs differ.
    pub joint_bound_kg_m2: [Option<f64>; 6],
    /// RMS of each run's error over its own joint bound. Null without a joint bound.
    pub rmse_over_joint_bound: [Option<f64>; 6],
    /// RMS of each run's error over its own bound. Null without a bound.
    pub rmse_over_bound: [Option<f64>; 6],
    /// RMS over all elements. Null if an element has no bound.
    pub rmse_over_bound_of_all: Option<f64>,
    /// Mean of each run's error over its own bound. Null without a bound.
    pub bias_over_bound: [Option<f64>; 6],
    /// RMS of the reported sigma, kg m²: root sum of squares of the random and the systematic one. Null if all runs
    /// diverged.
    pub sigma_kg_m2: [Option<f64>; 6],
    /// RMS of its part by the noise alone, kg m².
    pub sigma_random_kg_m2: [Option<f64>; 6],
    /// RMS of its part by errors of the hardware, kg m².
    pub sigma_systematic_kg_m2: [Option<f64>; 6],
    /// Kind of hardware error that has the largest effect on the tensor in most runs. Null for ideal hardware.
    pub largest_systematic: Option<String>,
    /// Mean normalised estimation error squared over its six degrees of freedom: 1 for a consistent
    /// covariance, above 1 for an overconfident one. Null without a positive definite covariance.
    pub nees_per_dof: Option<f64>,
    /// Runs in `nees_per_dof`: those used with a positive definite covariance.
    pub nees_runs: u64,
    /// Lower and upper limit of the 95 % interval of `nees_per_dof` for a consistent covariance.
    pub nees_95: Option<[f64; 2]>,
    /// Steps of the estimator in all runs.
    pub steps: u64,
    /// Duration of the runs, s. Truth and bound count only if each run has its own. Null from `merge`.
    pub wall_s: Option<f64>,
    /// Steps over the time spent in the estimator, summed over threads, 1/s. Null from `merge`.
    pub steps_per_s_per_core: Option<f64>,
}

/// The bound that errors are measured by.
pub struct Measure {
    /// Heading of its column.
    pub name: &'static str,
    /// Errors that it includes beside the noise, as the end of a sentence; empty for the noise alone.
    pub of: &'static str,
    /// One sigma of each element, kg m².
    pub bound_kg_m2: [Option<f64>; 6],
    /// RMS error over it.
    pub rmse_over_bound: [Option<f64>; 6],
    /// The same over all elements. None if an element has no bound.
    pub rmse_over_bound_of_all: Option<f64>,
    /// Mean error over it: over each run's own, over the RMS of the joint bounds.
    pub bias_over_bound: [Option<f64>; 6],
}

impl McReport {
    /// The joint bound where errors of the hardware are stated: no estimator reaches that of the noise alone.
    pub fn measure(&self) -> Measure {
        if self.joint_bound_kg_m2.iter().all(Option::is_none) {
            return Measure {
                name: "bound",
                of: "",
                bound_kg_m2: self.bound_kg_m2,
                rmse_over_bound: self.rmse_over_bound,
                rmse_over_bound_of_all: self.rmse_over_bound_of_all,
                bias_over_bound: self.bias_over_bound,
            };
        }
        let squares: Option<f64> =
            self.rmse_over_joint_bound.iter().map(|ratio| ratio.map(|ratio| ratio * ratio)).sum();
        Measure {
            name: "joint bound",
            of: ", errors of the hardware among the unknowns",
            bound_kg_m2: self.joint_bound_kg_m2,
            rmse_over_bound: self.rmse_over_joint_bound,
            rmse_over_bound_of_all: squares.map(|sum| (sum / 6.0).sqrt()),
            bias_over_bound: std::array::from_fn(|i| {
                Some(self.bias_kg_m2[i]? / self.joint_bound_kg_m2[i]?)
            }),
        }
    }
}
