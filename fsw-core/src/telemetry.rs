//! 6. One plain record per step, and counts of what became of the samples.

use crate::gate::Rejection;
use crate::outcome::{Coasting, Outcome, Reset};

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
    use crate::attitude::NoAttitude;

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
