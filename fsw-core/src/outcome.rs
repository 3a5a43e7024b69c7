//! 5. Outcome of one step: updated, coasting or reset, with the reason; counts of outcomes.
//!
//! A sample that is not usable is an outcome and not an error: the caller decides on a reaction,
//! and the counts go into telemetry.
//!
//! | outcome | rate | inertia | counted as |
//! |---|---|---|---|
//! | `Updated` | updated | updated | accepted |
//! | `Coasting(Rejected)` | kept | kept | by reason |
//! | `Coasting(Spike)` | predicted, or the reading (`window`) | kept | `spike` |
//! | `Coasting(Aligning)` | updated | not yet estimated | accepted |
//! | `Coasting(Refilling)` | updated | kept | accepted |
//! | `Coasting(NoAttitude)` | kept | kept | `no_attitude` |
//! | `Coasting(WaitingForRest)` | kept | kept | `waiting_for_rest` |
//! | `Reset(FirstSample)` | from the sample | prior | accepted |
//! | `Reset(Aligned)` | updated | first estimate | accepted |
//! | `Reset(Gap)` | from the sample | kept | accepted, `gap_resets` |
//! | `Reset(Clock)` | from the sample | kept | accepted, `clock_resets` |
//! | `Reset(Lockout)` | from the sample | discarded; by `joint_ekf` kept and not used until newer data agree | accepted, `lockout_resets` |
//! | `Reset(Interrupted)` | updated | data of a fault discarded, earlier data used again | accepted, `interruption_resets` |
//! | `Reset(Changed)` | updated | earlier data discarded | accepted, `change_resets` |
//! | `Reset(Diverged)` | from the sample | discarded | accepted, `divergence_resets` |
//!
//! After `Changed` and `Diverged` an inertia taken from an earlier estimate is no longer valid. After `Lockout` it is
//! in doubt until the status is converged with residuals that are not called non-white, or `Changed` follows.

use crate::attitude::NoAttitude;
use crate::gate::{self, Rejection};

/// Outcome of one step.
///
/// ```
/// use fsw_core::gate::Rejection;
/// use fsw_core::{Coasting, Outcome, Reset};
///
/// let rejected = Outcome::Coasting(Coasting::Rejected(Rejection::Stuck));
/// assert_eq!((rejected.name(), rejected.used_sample()), ("stuck", false));
/// let gap = Outcome::Reset(Reset::Gap);
/// assert_eq!((gap.name(), gap.used_sample()), ("reset_gap", true));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// The sample updated the estimate.
    Updated,
    /// The estimate is unchanged, or was only predicted.
    Coasting(Coasting),
    /// Part of the state was initialised.
    Reset(Reset),
}

/// Reason for which a sample did not update the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Coasting {
    /// Rejected by the gate.
    Rejected(Rejection),
    /// Difference from the prediction beyond the gyro's noise; the state was predicted without the
    /// sample. A sample refused by an outlier gate is reported two steps later, or more.
    Spike,
    /// Used, but the motion is not yet sufficient for a first estimate.
    Aligning,
    /// Used for the rate alone: the window of the differentiator is filling after a start or after
    /// an uneven interval. The inertia is unchanged.
    Refilling,
    /// The estimator needs the attitude, and that of the sample is unusable.
    NoAttitude(NoAttitude),
    /// The estimator starts from rest, and the body moves.
    WaitingForRest,
}

/// Reason for which part of the state was initialised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reset {
    /// First usable sample: the rate starts from it.
    FirstSample,
    /// First estimate of the inertia from the motion: the filter starts from it.
    Aligned,
    /// Interval too long for a prediction: the rate is initialised, the inertia is kept.
    Gap,
    /// Change of the clock, by a run of samples out of order: as after a gap.
    Clock,
    /// Series of spikes that only a wrong estimate or a fault that lasts explains (a deployment, a docking, a sensor): the
    /// whole state is initialised from the motion, and the prior is discarded.
    Lockout,
    /// Fault in mid-motion that has ended: the data since then agree with those before it, or none are left to compare with.
    /// The data of the fault are discarded, earlier data and the prior are used again. From the contradiction to this verdict
    /// the estimate is that of the newer data, and its residuals are called not white.
    Interrupted,
    /// Data of a manoeuvre contradict the inertia known before it (a prior, or earlier manoeuvres), or
    /// their own first part, by a chi-square test: the earlier inertia is discarded.
    Changed,
    /// State not finite, or inertia without inverse: the whole state is initialised. By `window`: full
    /// storage that no fit explains; its blocks are discarded.
    Diverged,
}

crate::persist!([] enum Reset {
    0 => FirstSample, 1 => Aligned, 2 => Gap, 3 => Lockout, 4 => Changed, 5 => Diverged, 6 => Clock, 7 => Interrupted
});

/// Reset after a gap, by its cause.
impl From<gate::Gap> for Reset {
    fn from(cause: gate::Gap) -> Self {
        match cause {
            gate::Gap::Interval => Self::Gap,
            gate::Gap::Clock => Self::Clock,
        }
    }
}

impl Outcome {
    /// Name of the outcome and its reason in logs and telemetry.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Updated => "updated",
            Self::Coasting(Coasting::Rejected(why)) => why.name(),
            Self::Coasting(Coasting::Spike) => "spike",
            Self::Coasting(Coasting::Aligning) => "aligning",
            Self::Coasting(Coasting::Refilling) => "refilling",
            Self::Coasting(Coasting::NoAttitude(why)) => why.name(),
            Self::Coasting(Coasting::WaitingForRest) => "waiting_for_rest",
            Self::Reset(Reset::FirstSample) => "reset_first_sample",
            Self::Reset(Reset::Aligned) => "reset_aligned",
            Self::Reset(Reset::Gap) => "reset_gap",
            Self::Reset(Reset::Clock) => "reset_clock",
            Self::Reset(Reset::Lockout) => "reset_lockout",
            Self::Reset(Reset::Interrupted) => "reset_interrupted",
            Self::Reset(Reset::Changed) => "reset_changed",
            Self::Reset(Reset::Diverged) => "reset_diverged",
        }
    }

    /// True where the sample entered the state.
    pub fn used_sample(&self) -> bool {
        match self {
            Self::Updated | Self::Reset(_) => true,
            Self::Coasting(Coasting::Aligning | Coasting::Refilling) => true,
            Self::Coasting(
                Coasting::Rejected(_)
                | Coasting::Spike
                | Coasting::NoAttitude(_)
                | Coasting::WaitingForRest,
            ) => false,
        }
    }
}

/// Number of samples by outcome. The counters saturate.
///
/// Every sample is counted once, as accepted or as rejected for one reason; resets are counted
/// besides.
///
/// ```
/// use fsw_core::outcome::OutcomeCounts;
/// use fsw_core::{Coasting, Outcome, Reset};
///
/// let mut counts = OutcomeCounts::default();
/// for outcome in [
///     Outcome::Reset(Reset::FirstSample),
///     Outcome::Updated,
///     Outcome::Coasting(Coasting::Spike),
///     Outcome::Reset(Reset::Gap),
/// ] {
///     counts.add(&outcome);
/// }
/// assert_eq!((counts.accepted, counts.spike, counts.gap_resets), (3, 1, 1));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutcomeCounts {
    /// Used, for an update or an initialisation.
    pub accepted: u32,
    /// Rejected: infinite or NaN.
    pub not_finite: u32,
    /// Rejected: beyond the range of the gyro.
    pub out_of_range: u32,
    /// Rejected: time stamp not later than the last.
    pub out_of_order: u32,
    /// Rejected: repeated reading.
    pub stuck: u32,
    /// Rejected: too far from the prediction.
    pub spike: u32,
    /// Rejected: attitude needed and unusable.
    pub no_attitude: u32,
    /// Rejected: start from rest needed, and the body moves.
    pub waiting_for_rest: u32,
    /// Resets after a gap in time.
    pub gap_resets: u32,
    /// Resets after a change of the clock.
    pub clock_resets: u32,
    /// Resets after a series of spikes.
    pub lockout_resets: u32,
    /// Resets after a fault in mid-motion that has ended.
    pub interruption_resets: u32,
    /// Resets of an inertia that newer data contradict.
    pub change_resets: u32,
    /// Resets of a state that was not finite.
    pub divergence_resets: u32,
}

impl OutcomeCounts {
    /// Counts one outcome.
    pub fn add(&mut self, outcome: &Outcome) {
        if outcome.used_sample() {
            self.accepted = self.accepted.saturating_add(1);
        }
        let counter = match outcome {
            Outcome::Coasting(Coasting::Rejected(Rejection::NotFinite)) => &mut self.not_finite,
            Outcome::Coasting(Coasting::Rejected(Rejection::OutOfRange)) => &mut self.out_of_range,
            Outcome::Coasting(Coasting::Rejected(Rejection::OutOfOrder)) => &mut self.out_of_order,
            Outcome::Coasting(Coasting::Rejected(Rejection::Stuck)) => &mut self.stuck,
            Outcome::Coasting(Coasting::Spike) => &mut self.spike,
            Outcome::Coasting(Coasting::NoAttitude(_)) => &mut self.no_attitude,
            Outcome::Coasting(Coasting::WaitingForRest) => &mut self.waiting_for_rest,
            Outcome::Reset(Reset::Gap) => &mut self.gap_resets,
            Outcome::Reset(Reset::Clock) => &mut self.clock_resets,
            Outcome::Reset(Reset::Lockout) => &mut self.lockout_resets,
            Outcome::Reset(Reset::Interrupted) => &mut self.interruption_resets,
            Outcome::Reset(Reset::Changed) => &mut self.change_resets,
            Outcome::Reset(Reset::Diverged) => &mut self.divergence_resets,
            Outcome::Updated
            | Outcome::Coasting(Coasting::Aligning | Coasting::Refilling)
            | Outcome::Reset(Reset::FirstSample | Reset::Aligned) => return,
        };
        *counter = counter.saturating_add(1);
    }

    /// Number of rejected samples by reason.
    pub fn rejected(&self) -> [(&'static str, u32); 7] {
        [
            ("not_finite", self.not_finite),
            ("out_of_range", self.out_of_range),
            ("out_of_order", self.out_of_order),
            ("stuck", self.stuck),
            ("spike", self.spike),
            ("no_attitude", self.no_attitude),
            ("waiting_for_rest", self.waiting_for_rest),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Accepted plus rejected equals the number of samples; a reset also counts as accepted.
    #[test]
    fn every_sample_is_either_accepted_or_rejected() {
        let mut counts = OutcomeCounts::default();
        counts.add(&Outcome::Reset(Reset::FirstSample));
        counts.add(&Outcome::Updated);
        counts.add(&Outcome::Coasting(Coasting::Spike));
        counts.add(&Outcome::Coasting(Coasting::Rejected(Rejection::Stuck)));
        counts.add(&Outcome::Coasting(Coasting::NoAttitude(NoAttitude::Missing)));
        counts.add(&Outcome::Reset(Reset::Gap));
        let rejected: u32 = counts.rejected().iter().map(|(_, n)| n).sum();
        assert_eq!((counts.accepted, rejected, counts.gap_resets), (3, 3, 1));
    }
}
