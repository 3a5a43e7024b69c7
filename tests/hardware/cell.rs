//! Cell of the matrix: flights of one imperfection on one scenario.

use std::sync::atomic::AtomicBool;

use anyhow::Result;
use fsw_core::Status;
use host_sim::campaign::{Campaign, CampaignRun, Truths};
use host_sim::estimation::{EstimatorName, Precision};
use host_sim::input::Scenario;

use super::catalogue::Case;

/// Largest share of silent lies.
pub const MOST_LIES: f64 = 0.01;
/// Range of the mean NEES.
pub const NEES: [f64; 2] = [0.7, 1.3];
/// Share of flagged flights from which on the NEES is free.
pub const FLAGGED: f64 = 0.95;

/// Estimator and number of flights.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    /// Estimator under test.
    pub estimator: EstimatorName,
    /// Its arithmetic.
    pub precision: Precision,
    /// First seed, and number of flights.
    pub seed: u64,
    /// Number of flights.
    pub runs: u64,
}

/// Figures of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Flights.
    pub runs: usize,
    /// Flights that are called diverged or not white.
    pub flagged: usize,
    /// Flights that are called converged and white with an element beyond five sigmas.
    pub lies: usize,
    /// Mean NEES over its degrees of freedom of the flights that are not flagged; none without one.
    pub nees: Option<f64>,
    /// Its sampling error, one sigma, for a consistent covariance.
    pub nees_sigma: f64,
}

impl Cell {
    /// Flies a case on a scenario; none where it does not apply.
    ///
    /// # Errors
    /// As of a campaign.
    pub fn of_case(case: &Case, ideal: &Scenario, flown: &Flown) -> Result<Option<Self>> {
        if !case.is_drawn {
            return case.of(ideal, flown.seed).map(|it| Self::fly(&it, flown)).transpose();
        }
        let mut runs = Vec::new();
        for seed in flown.seed..flown.seed + flown.runs {
            let Some(scenario) = case.of(ideal, seed) else { return Ok(None) };
            runs.extend(runs_of(&scenario, &Flown { seed, runs: 1, ..*flown })?);
        }
        Ok(Some(Self::of(&runs)))
    }

    /// Flies a scenario.
    ///
    /// # Errors
    /// As of a campaign.
    pub fn fly(scenario: &Scenario, flown: &Flown) -> Result<Self> {
        Ok(Self::of(&runs_of(scenario, flown)?))
    }

    /// Figures of these flights.
    pub fn of(runs: &[CampaignRun]) -> Self {
        let is_flagged = |run: &&CampaignRun| {
            run.score.status == Status::Diverged || run.residuals_white == Some(false)
        };
        let flagged = runs.iter().filter(is_flagged).count();
        let usable: Vec<f64> = runs
            .iter()
            .filter(|run| !is_flagged(run))
            .map(|run| run.score.nees.unwrap_or(f64::INFINITY) / 6.0)
            .collect();
        let count = usable.len() as f64;
        Self {
            runs: runs.len(),
            flagged,
            lies: runs.iter().filter(|run| run.is_silent_lie()).count(),
            nees: (!usable.is_empty()).then(|| usable.iter().sum::<f64>() / count),
            nees_sigma: (1.0 / (3.0 * count.max(1.0))).sqrt(),
        }
    }

    /// Limits that do not hold. A NEES beyond its range by less than three sampling errors is not one.
    pub fn missed(&self) -> Vec<&'static str> {
        let runs = self.runs as f64;
        let mut missed = Vec::new();
        if self.lies as f64 > MOST_LIES * runs {
            missed.push("lies");
        }
        let margin = 3.0 * self.nees_sigma;
        let is_consistent =
            self.nees.is_none_or(|nees| (NEES[0] - margin..=NEES[1] + margin).contains(&nees));
        if !is_consistent && (self.flagged as f64) < FLAGGED * runs {
            missed.push("NEES");
        }
        missed
    }
}

fn runs_of(scenario: &Scenario, flown: &Flown) -> Result<Vec<CampaignRun>> {
    let truths = Truths::simulate(scenario)?;
    let campaign = Campaign {
        scenario,
        truths: &truths,
        estimator: flown.estimator,
        precision: flown.precision,
        first_seed: flown.seed,
        runs: flown.runs,
    };
    Ok(campaign.run_all(&AtomicBool::new(false), || ())?)
}
