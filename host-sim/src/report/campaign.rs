//! Report and rows of a Monte Carlo campaign, assembled from its runs.

use std::collections::BTreeMap;
use std::time::Duration;

use super::json::McReport;
use super::runs::RunRow;
use crate::campaign::{Campaign, CampaignRun, Statistics, Verdict, reduce};

impl McReport {
    /// Report of the completed runs of a campaign; `wall` is the time that they took.
    pub fn new(campaign: &Campaign<'_>, runs: &[CampaignRun], wall: Duration) -> Self {
        let statistics = reduce(runs.iter().map(|run| &run.score));
        let Statistics { used, unobserved, diverged, not_converged, nees_runs, .. } = statistics;
        let observed = runs.iter().filter(|run| run.score.verdict != Verdict::Unobserved);
        let reference = campaign.truths.typical(observed.map(|run| run.reference));
        let count =
            |is: &dyn Fn(&CampaignRun) -> bool| runs.iter().filter(|run| is(run)).count() as u64;
        let steps = runs.iter().map(|run| run.steps).sum();
        let estimator_s = runs.iter().map(|run| run.estimator_time.as_secs_f64()).sum::<f64>();
        Self {
            scenario: campaign.scenario.name.clone(),
            estimator: campaign.estimator.to_string(),
            precision: campaign.precision.to_string(),
            seed: campaign.first_seed,
            runs: runs.len() as u64,
            used: used as u64,
            not_shown: unobserved as u64,
            diverged: diverged as u64,
            not_converged: not_converged as u64,
            changes: count(&|run| run.changes > 0),
            residuals_not_white: count(&|run| run.residuals_white == Some(false)),
            silent_lies: count(&CampaignRun::is_silent_lie),
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
            largest_systematic: most_frequent(runs.iter().filter_map(|run| run.largest_systematic)),
            nees_per_dof: statistics.nees_per_dof,
            nees_runs: nees_runs as u64,
            nees_95: statistics.nees_95,
            steps,
            wall_s: wall.as_secs_f64(),
            steps_per_s_per_core: (estimator_s > 0.0).then(|| steps as f64 / estimator_s),
        }
    }
}

/// The name that occurs most often; the first in the alphabet of equals.
fn most_frequent(names: impl Iterator<Item = &'static str>) -> Option<String> {
    let mut counts = BTreeMap::<&str, usize>::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    let most = counts.into_iter().rev().max_by_key(|(_, count)| *count);
    most.map(|(name, _)| name.to_owned())
}

impl From<&CampaignRun> for RunRow {
    fn from(run: &CampaignRun) -> Self {
        let score = &run.score;
        Self {
            run: run.index,
            seed: run.seed,
            status: score.status.into(),
            inertia_kg_m2: score.inertia_kg_m2,
            sigma_kg_m2: score.sigma_kg_m2,
            error_kg_m2: score.error_kg_m2,
            nees: score.nees,
            converged: score.verdict == Verdict::Converged,
            diverged: score.verdict == Verdict::Diverged,
            restarts: run.restarts,
            changes: run.changes,
            residuals_white: run.residuals_white,
            shown: score.verdict != Verdict::Unobserved,
            silent_lie: run.is_silent_lie(),
        }
    }
}
