//! Counts of the slices of work of a flight, by their kind.

use fsw_core::estimator::window::Slice;
use fsw_target::log_line;

/// Width of a bin, instructions, and number of bins. The last one holds all larger counts.
const WIDTH: u32 = 128;
const BINS: usize = 1_024;

/// Kinds in the table, with their names in the log.
const KINDS: [(Slice, &str); 12] = [
    (Slice::Pass, "pass"),
    (Slice::Front, "front"),
    (Slice::Start, "start"),
    (Slice::StartSolution, "start-solution"),
    (Slice::Decision, "decision"),
    (Slice::Judgement, "judgement"),
    (Slice::Result, "result"),
    (Slice::Comparison, "comparison"),
    (Slice::Sweep, "sweep"),
    (Slice::Room, "room"),
    (Slice::Fit, "fit"),
    (Slice::Conclusion, "conclusion"),
];

/// Counts of one kind.
struct OfKind {
    slices: u32,
    worst: u32,
    bins: [u16; BINS],
}

impl OfKind {
    const NONE: Self = Self { slices: 0, worst: 0, bins: [0; BINS] };

    fn add(&mut self, instructions: u32) {
        self.slices += 1;
        self.worst = self.worst.max(instructions);
        let bin = (instructions / WIDTH) as usize;
        if let Some(bin) = self.bins.get_mut(bin.min(BINS - 1)) {
            *bin = bin.saturating_add(1);
        }
    }

    /// Median to half the width of a bin.
    fn median(&self) -> u32 {
        let mut before = 0;
        for (instructions, slices) in (WIDTH / 2..).step_by(WIDTH as usize).zip(self.bins) {
            before += u32::from(slices);
            if 2 * before > self.slices {
                return instructions;
            }
        }
        0
    }
}

/// Counts of one flight.
pub struct SliceTally {
    of_kind: [OfKind; KINDS.len()],
    /// Samples after whose slices work was left: all, in the present run, and in the longest run.
    busy: u32,
    run: u32,
    longest: u32,
}

impl SliceTally {
    /// An empty tally.
    pub const fn new() -> Self {
        let of_kind = [const { OfKind::NONE }; KINDS.len()];
        Self { of_kind, busy: 0, run: 0, longest: 0 }
    }

    /// Empties the tally for another flight.
    pub fn clear(&mut self) {
        (self.busy, self.run, self.longest) = (0, 0, 0);
        for of_kind in &mut self.of_kind {
            (of_kind.slices, of_kind.worst) = (0, 0);
            of_kind.bins.fill(0);
        }
    }

    /// Adds the instruction count of a slice.
    pub fn add(&mut self, kind: Slice, instructions: u32) {
        let of_kind = self.of_kind.iter_mut().zip(KINDS).find(|(_, (of_row, _))| *of_row == kind);
        if let Some((of_kind, _)) = of_kind {
            of_kind.add(instructions);
        }
    }

    /// Notes whether work is left after the slices of a sample.
    pub fn end_sample(&mut self, has_work: bool) {
        self.run = if has_work { self.run + 1 } else { 0 };
        self.busy += u32::from(has_work);
        self.longest = self.longest.max(self.run);
    }

    /// Logs the lines for `target_tools::bench`, one per kind.
    pub fn report(&self, name: &'static str, flight: &'static str) {
        if self.of_kind.iter().any(|of_kind| of_kind.slices > 0) {
            log_line!(
                "work name={} flight={} busy={} longest={}",
                name,
                flight,
                self.busy,
                self.longest
            );
        }
        for (of_kind, (_, kind)) in self.of_kind.iter().zip(KINDS).filter(|(o, _)| o.slices > 0) {
            log_line!(
                "slice name={} flight={} kind={} slices={} worst={} median={}",
                name,
                flight,
                kind,
                of_kind.slices,
                of_kind.worst,
                of_kind.median()
            );
        }
    }
}
