//! The counts of a flight's steps, and what they come to.

/// Up to N steps.
pub struct Tally<const N: usize> {
    counts: [u32; N],
    steps: usize,
    worst: u32,
    worst_at: usize,
}

impl<const N: usize> Tally<N> {
    /// No step yet.
    pub fn new() -> Self {
        Self { counts: [0; N], steps: 0, worst: 0, worst_at: 0 }
    }

    /// Adds the instructions of the next step; beyond N steps only the worst is kept.
    pub fn add(&mut self, instructions: u32) {
        if instructions > self.worst {
            (self.worst, self.worst_at) = (instructions, self.steps);
        }
        if let Some(place) = self.counts.get_mut(self.steps) {
            *place = instructions;
        }
        self.steps += 1;
    }

    /// One line of the log, as `target_tools::bench` reads it.
    pub fn report(&mut self, name: &'static str, flight: &'static str) {
        let kept = self.steps.min(N);
        let counts = self.counts.get_mut(..kept).unwrap_or_default();
        counts.sort_unstable();
        let median = counts.get(kept / 2).copied().unwrap_or_default();
        defmt::info!(
            "count name={=str} flight={=str} steps={=usize} worst={=u32} at={=usize} median={=u32}",
            name,
            flight,
            self.steps,
            self.worst,
            self.worst_at,
            median
        );
    }
}
