//! A log streamed through an estimator.

use fsw_core::hardware::Finding;
use fsw_core::outcome::OutcomeCounts;
use fsw_core::{Estimate, Outcome};

use super::adapter::AnyEstimator;
use super::events::Events;
use crate::input::log::LogRow;

/// Result of a log.
pub struct EstimationResult {
    /// Number of samples by outcome.
    pub counts: OutcomeCounts,
    /// Restarts, gaps, changes and spikes with their times.
    pub events: Events,
    /// Estimate after the last sample, with the work completed that was due.
    pub estimate: Estimate<f64>,
    /// Results on the parameters of the hardware that are among the unknowns; empty without any.
    pub hardware: Vec<Finding<f64>>,
}

impl EstimationResult {
    /// Number of times that the estimator discarded its knowledge, or put it in doubt, because new data
    /// contradicted it.
    pub fn changes(&self) -> u32 {
        let counts = &self.counts;
        let discarded = counts.change_resets.saturating_add(counts.lockout_resets);
        discarded.saturating_add(counts.interruption_resets)
    }
}

/// Streams the rows of a log through an estimator, which then completes its work. `observe` is called after each row with the
/// row, its outcome and the estimator.
pub fn estimate_log(
    rows: &[LogRow],
    mut estimator: Box<dyn AnyEstimator>,
    mut observe: impl FnMut(&LogRow, &Outcome, &dyn AnyEstimator),
) -> EstimationResult {
    let (mut counts, mut events) = (OutcomeCounts::default(), Events::default());
    for row in rows {
        let outcome = estimator.step(row);
        counts.add(&outcome);
        events.add(row.time_us, &outcome);
        observe(row, &outcome, estimator.as_ref());
    }
    estimator.finish();
    EstimationResult {
        counts,
        events,
        estimate: estimator.estimate(),
        hardware: estimator.hardware(),
    }
}

/// Median time between samples, s; zero for a single sample. A clock set back counts as the time by
/// which it was set.
pub fn median_period_s(rows: &[LogRow]) -> f64 {
    let mut periods: Vec<u64> =
        rows.windows(2).map(|w| w[1].time_us.abs_diff(w[0].time_us)).collect();
    periods.sort_unstable();
    periods.get(periods.len() / 2).map_or(0.0, |us| *us as f64 * 1e-6)
}
