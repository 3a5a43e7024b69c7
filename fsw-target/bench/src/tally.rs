//! Counts of a flight's steps: worst, median, and by outcome.

use fsw_core::Outcome;
use fsw_target::log_line;

/// Number of counts kept for the median: the longest flight.
const STEPS: usize = 8_192;

/// Largest number of different outcomes of a flight; there are 19.
const OUTCOMES: usize = 24;

/// Counts of one flight.
pub struct Tally {
    counts: [u32; STEPS],
    steps: usize,
    worst: Worst,
    by_outcome: [Worst; OUTCOMES],
}

/// Most expensive of a number of steps.
#[derive(Clone, Copy)]
struct Worst {
    outcome: &'static str,
    steps: usize,
    instructions: u32,
    at: usize,
}

impl Worst {
    const NONE: Self = Self { outcome: "", steps: 0, instructions: 0, at: 0 };

    fn add(&mut self, instructions: u32, at: usize) {
        self.steps += 1;
        if instructions > self.instructions {
            (self.instructions, self.at) = (instructions, at);
        }
    }
}

impl Tally {
    /// An empty tally.
    pub const fn new() -> Self {
        Self {
            counts: [0; STEPS],
            steps: 0,
            worst: Worst::NONE,
            by_outcome: [Worst::NONE; OUTCOMES],
        }
    }

    /// Empties the tally for another flight.
    pub fn clear(&mut self) {
        (self.steps, self.worst) = (0, Worst::NONE);
        self.by_outcome = [Worst::NONE; OUTCOMES];
    }

    /// Adds the instruction count of the next step.
    pub fn add(&mut self, instructions: u32) {
        if let Some(place) = self.counts.get_mut(self.steps) {
            *place = instructions;
        }
        self.worst.add(instructions, self.steps);
        self.steps += 1;
    }

    /// As [`add`](Self::add), with the outcome of the step.
    pub fn add_outcome(&mut self, instructions: u32, outcome: &Outcome) {
        let name = outcome.name();
        let is_it = |worst: &&mut Worst| worst.steps == 0 || worst.outcome == name;
        if let Some(worst) = self.by_outcome.iter_mut().find(is_it) {
            worst.outcome = name;
            worst.add(instructions, self.steps);
        }
        self.add(instructions);
    }

    /// Logs the lines for `target_tools::bench`: one for the flight, then one per outcome.
    pub fn report(&mut self, name: &'static str, flight: &'static str, status: &'static str) {
        let kept = self.steps.min(STEPS);
        let counts = self.counts.get_mut(..kept).unwrap_or_default();
        counts.sort_unstable();
        let median = counts.get(kept / 2).copied().unwrap_or_default();
        log_line!(
            "count name={} flight={} steps={} worst={} at={} median={} status={}",
            name,
            flight,
            self.steps,
            self.worst.instructions,
            self.worst.at,
            median,
            status
        );
        for worst in self.by_outcome.iter().take_while(|worst| worst.steps > 0) {
            log_line!(
                "outcome name={} flight={} outcome={} steps={} worst={} at={}",
                name,
                flight,
                worst.outcome,
                worst.steps,
                worst.instructions,
                worst.at
            );
        }
    }
}
