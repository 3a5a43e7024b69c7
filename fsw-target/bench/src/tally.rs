//! The counts of a flight's steps, and what they come to.

use fsw_core::Outcome;
use fsw_target::log_line;

/// Steps of which the median is taken: those of the longest flight.
const STEPS: usize = 8_192;

/// Different outcomes of a flight, at most: there are 19.
const OUTCOMES: usize = 24;

/// What the steps of one flight cost.
pub struct Tally {
    counts: [u32; STEPS],
    steps: usize,
    worst: Worst,
    by_outcome: [Worst; OUTCOMES],
}

/// The most expensive of so many steps, and which one it was.
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
    /// No step yet.
    pub const fn new() -> Self {
        Self {
            counts: [0; STEPS],
            steps: 0,
            worst: Worst::NONE,
            by_outcome: [Worst::NONE; OUTCOMES],
        }
    }

    /// No step yet, of another flight.
    pub fn clear(&mut self) {
        (self.steps, self.worst) = (0, Worst::NONE);
        self.by_outcome = [Worst::NONE; OUTCOMES];
    }

    /// Adds the instructions of the next step.
    pub fn add(&mut self, instructions: u32) {
        if let Some(place) = self.counts.get_mut(self.steps) {
            *place = instructions;
        }
        self.worst.add(instructions, self.steps);
        self.steps += 1;
    }

    /// The same, with what the step said of its sample.
    pub fn add_outcome(&mut self, instructions: u32, outcome: &Outcome) {
        let name = outcome.name();
        let is_it = |worst: &&mut Worst| worst.steps == 0 || worst.outcome == name;
        if let Some(worst) = self.by_outcome.iter_mut().find(is_it) {
            worst.outcome = name;
            worst.add(instructions, self.steps);
        }
        self.add(instructions);
    }

    /// Lines of the log, as `target_tools::bench` reads them: one for the flight, then one for
    /// each outcome.
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
