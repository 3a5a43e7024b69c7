//! Outcome of one step: updated, coasting or reset, with the reason.

use crate::attitude::NoAttitude;
use crate::gate::Rejection;

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// It updated the estimate.
    Updated,
    /// The estimate stands as it was, or was only predicted.
    Coasting(Coasting),
    /// Part of the state was set anew.
    Reset(Reset),
}

/// Why a sample didn't update the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Coasting {
    /// The gate refused it.
    Rejected(Rejection),
    /// Too far from the prediction to be the gyro's noise; the state was predicted without it.
    Spike,
    /// It was taken in, but what has moved so far isn't enough for a first estimate.
    Aligning,
    /// It went into the rate, but the window of the differentiator is still filling (after a
    /// start, or because this sample came unevenly spaced): the inertia waits.
    Refilling,
    /// This estimator needs the attitude, and the sample's can't be used.
    NoAttitude(NoAttitude),
    /// This estimator starts from rest, and the body moves.
    WaitingForRest,
}

/// Why part of the state was set anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reset {
    /// The first usable sample: the rate starts from it.
    FirstSample,
    /// The motion so far gave a first estimate of the inertia; the filter starts from it.
    Aligned,
    /// Too long without samples to predict across: the rate starts anew, the inertia stays.
    Gap,
    /// So many spikes in a row that it is the estimate that must be wrong (a deployment, a
    /// docking): all starts anew from the motion, and no prior is believed any more.
    Lockout,
    /// A manoeuvre's data contradict, by a chi-square test, what was known of the inertia before
    /// it (a prior, or earlier manoeuvres): that is dropped.
    Changed,
    /// The state left the finite numbers, or its inertia had no inverse: all starts anew.
    Diverged,
}

crate::persist!([] enum Reset {
    0 => FirstSample, 1 => Aligned, 2 => Gap, 3 => Lockout, 4 => Changed, 5 => Diverged
});

impl Outcome {
    /// What and why, in a word or two: for logs.
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
            Self::Reset(Reset::Lockout) => "reset_lockout",
            Self::Reset(Reset::Changed) => "reset_changed",
            Self::Reset(Reset::Diverged) => "reset_diverged",
        }
    }

    /// Whether the sample was made use of.
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

/// How many samples ended how. Saturates rather than wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutcomeCounts {
    /// Used, whether for an update or a start.
    pub accepted: u32,
    /// Refused: infinite or NaN.
    pub not_finite: u32,
    /// Refused: saturated.
    pub out_of_range: u32,
    /// Refused: time stamp not after the last.
    pub out_of_order: u32,
    /// Refused: the gyro repeats itself.
    pub stuck: u32,
    /// Refused: too far from the prediction.
    pub spike: u32,
    /// Refused: an estimator that needs the attitude got none that it could use.
    pub no_attitude: u32,
    /// Refused: an estimator that starts from rest found the body moving.
    pub waiting_for_rest: u32,
    /// Resets after a gap in time.
    pub gap_resets: u32,
    /// Resets after many spikes in a row.
    pub lockout_resets: u32,
    /// Resets of what was known before, since new data contradict it.
    pub change_resets: u32,
    /// Resets of a state that left the finite numbers.
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
            Outcome::Reset(Reset::Lockout) => &mut self.lockout_resets,
            Outcome::Reset(Reset::Changed) => &mut self.change_resets,
            Outcome::Reset(Reset::Diverged) => &mut self.divergence_resets,
            Outcome::Updated
            | Outcome::Coasting(Coasting::Aligning | Coasting::Refilling)
            | Outcome::Reset(Reset::FirstSample | Reset::Aligned) => return,
        };
        *counter = counter.saturating_add(1);
    }

    /// Samples refused, by reason.
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
