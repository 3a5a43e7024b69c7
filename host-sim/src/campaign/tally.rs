//! Sums over the runs of a campaign, one run at a time, in constant memory.

use std::collections::BTreeMap;

use super::statistics::Sums;
use super::truths::Typical;
use super::{CampaignRun, Reference, Statistics, Verdict};

/// Counts and sums of the runs added so far. Sums depend on the order of the runs in their last bits: the order is that
/// of the seeds.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    sums: Sums,
    typical: Typical,
    runs: u64,
    changes: u64,
    residuals_not_white: u64,
    silent_lies: u64,
    steps: u64,
    estimator_s: f64,
    systematic: BTreeMap<&'static str, u64>,
}

impl Tally {
    /// Sums of these runs.
    pub fn of<'a>(runs: impl IntoIterator<Item = &'a CampaignRun>) -> Self {
        let mut tally = Self::default();
        runs.into_iter().for_each(|run| tally.add(run));
        tally
    }

    /// Adds the next run.
    pub fn add(&mut self, run: &CampaignRun) {
        self.runs += 1;
        self.sums.add(&run.score);
        if run.score.verdict != Verdict::Unobserved {
            self.typical.add(&run.reference);
        }
        self.changes += u64::from(run.changes > 0);
        self.residuals_not_white += u64::from(run.residuals_white == Some(false));
        self.silent_lies += u64::from(run.is_silent_lie());
        self.steps += run.steps;
        self.estimator_s += run.estimator_time.as_secs_f64();
        if let Some(kind) = run.largest_systematic {
            *self.systematic.entry(kind).or_default() += 1;
        }
    }

    /// Statistics of the scores.
    pub fn statistics(&self) -> Statistics {
        self.sums.statistics()
    }

    /// Mean of the true elements and RMS of the bounds of the runs that are not unobserved.
    pub fn typical(&self) -> Reference {
        self.typical.reference()
    }

    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// Number of runs that discarded an earlier estimate at least once.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Number of runs whose last residuals fail the test for white noise.
    pub fn residuals_not_white(&self) -> u64 {
        self.residuals_not_white
    }

    /// Number of silent lies: see [`CampaignRun::is_silent_lie`].
    pub fn silent_lies(&self) -> u64 {
        self.silent_lies
    }

    /// Steps of the estimator.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Steps over the time spent in the estimator, 1/s; none without a time.
    pub fn steps_per_s(&self) -> Option<f64> {
        (self.estimator_s > 0.0).then(|| self.steps as f64 / self.estimator_s)
    }

    /// Kind of hardware error with the largest effect in most runs; the first in the alphabet of equals.
    pub fn largest_systematic(&self) -> Option<&'static str> {
        let most = self.systematic.iter().rev().max_by_key(|(_, count)| **count);
        most.map(|(kind, _)| *kind)
    }
}
