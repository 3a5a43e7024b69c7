//! Events of a log: the outcomes that a user looks for in the log, with their times.

use fsw_core::{Coasting, Outcome, Reset};

/// Times of the events of a log, µs since its first row, ascending.
///
/// The time is that of the step that reported the event. An estimator may report a spike a few
/// samples late.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// Restarts: the state was not finite, or too many spikes came in a row.
    pub restarts_us: Vec<u64>,
    /// Gaps in time that are too long for a prediction, and clocks that were set; the inertia was kept.
    pub gaps_us: Vec<u64>,
    /// Interruptions: a fault or a change in mid-motion; the earlier inertia was put in doubt.
    pub interruptions_us: Vec<u64>,
    /// Changes: the earlier inertia was discarded because new data contradicted it.
    pub changes_us: Vec<u64>,
    /// Spikes: samples rejected because they were too far from the prediction.
    pub spikes_us: Vec<u64>,
}

impl Events {
    /// Adds the outcome of the step at this time.
    pub fn add(&mut self, time_us: u64, outcome: &Outcome) {
        match outcome {
            Outcome::Coasting(Coasting::Spike) => self.spikes_us.push(time_us),
            Outcome::Reset(Reset::Gap | Reset::Clock) => self.gaps_us.push(time_us),
            Outcome::Reset(Reset::Changed) => self.changes_us.push(time_us),
            Outcome::Reset(Reset::Interrupted) => self.interruptions_us.push(time_us),
            Outcome::Reset(Reset::Diverged | Reset::Lockout) => self.restarts_us.push(time_us),
            Outcome::Updated
            | Outcome::Coasting(_)
            | Outcome::Reset(Reset::FirstSample | Reset::Aligned) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_have_the_times_of_their_outcomes() {
        let mut events = Events::default();
        let outcomes = [
            Outcome::Reset(Reset::FirstSample),
            Outcome::Coasting(Coasting::Spike),
            Outcome::Reset(Reset::Gap),
            Outcome::Updated,
            Outcome::Reset(Reset::Lockout),
            Outcome::Reset(Reset::Changed),
            Outcome::Reset(Reset::Diverged),
            Outcome::Reset(Reset::Interrupted),
        ];
        for (outcome, time_us) in outcomes.iter().zip(0..) {
            events.add(time_us, outcome);
        }
        let expected = Events {
            restarts_us: vec![4, 6],
            gaps_us: vec![2],
            interruptions_us: vec![7],
            changes_us: vec![5],
            spikes_us: vec![1],
        };
        assert_eq!(events, expected);
    }
}
