//! Report of a Monte Carlo campaign, assembled from the sums of its runs.

use std::time::Duration;

use super::json::McReport;
use super::record::CampaignRecord;
use crate::campaign::{Statistics, Tally};

impl McReport {
    /// Report of the runs in `tally`, which are those of `record`. `wall` is the time that they took; none for runs that
    /// are read from files: the report is then the same wherever they were flown.
    pub fn new(record: &CampaignRecord, tally: &Tally, wall: Option<Duration>) -> Self {
        let statistics = tally.statistics();
        let Statistics { used, unobserved, diverged, not_converged, nees_runs, .. } = statistics;
        let reference = record.shared_reference().unwrap_or_else(|| tally.typical());
        Self {
            scenario: record.scenario.clone(),
            estimator: record.estimator.clone(),
            precision: record.precision.clone(),
            seed: record.first_seed(),
            runs: tally.runs(),
            used: used as u64,
            not_shown: unobserved as u64,
            diverged: diverged as u64,
            not_converged: not_converged as u64,
            changes: tally.changes(),
            residuals_not_white: tally.residuals_not_white(),
            silent_lies: tally.silent_lies(),
            truth_kg_m2: reference.truth_kg_m2,
            rmse_kg_m2: statistics.rmse_kg_m2,
            bias_kg_m2: statistics.bias_kg_m2,
            bound_kg_m2: reference.bound_kg_m2,
            joint_bound_kg_m2: reference.joint_bound_kg_m2,
            rmse_over_joint_bound: statistics.rmse_over_joint_bound,
            rmse_over_bound: statistics.rmse_over_bound,
            rmse_over_bound_of_all: statistics.rmse_over_bound_of_all(),
            bias_over_bound: statistics.bias_over_bound,
            sigma_kg_m2: statistics.sigma_kg_m2,
            sigma_random_kg_m2: statistics.sigma_random_kg_m2,
            sigma_systematic_kg_m2: std::array::from_fn(|i| {
                let (total, random) =
                    (statistics.sigma_kg_m2[i]?, statistics.sigma_random_kg_m2[i]?);
                Some((total * total - random * random).max(0.0).sqrt())
            }),
            largest_systematic: tally.largest_systematic().map(str::to_owned),
            nees_per_dof: statistics.nees_per_dof,
            nees_runs: nees_runs as u64,
            nees_95: statistics.nees_95,
            steps: tally.steps(),
            wall_s: wall.map(|wall| wall.as_secs_f64()),
            steps_per_s_per_core: wall.and_then(|_| tally.steps_per_s()),
        }
    }
}
