//! From the flanks of two channels to a position: direction, and glitches taken back.
//!
//! The board's capture interrupt takes both flanks of channel A and calls [`EdgeFilter::edge`] with the
//! time that the timer captured and the levels of both channels just after. B is a quarter of a period
//! behind A while the wheel turns forward, so forward means that the levels differ.
//!
//! Each flank of A lies at one angle of the wheel, passed in either direction. A wheel that turns back
//! passes the same flank again: that edge changes direction and time but not the position. So the
//! position is that of the last edge exactly, and a wheel that rests on a flank and dithers counts
//! nothing.

use super::Captured;

/// A position that flanks have told.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Edge {
    /// In edges since start-up.
    position: i32,
    ticks: u32,
    forward: bool,
}

/// The edges of one wheel.
#[derive(Debug, Clone, Copy)]
pub struct EdgeFilter {
    /// Less than this between two edges is no wheel, ticks.
    shortest_ticks: u32,
    last: Option<Edge>,
    /// The one before, to which a glitch goes back.
    before: Option<Edge>,
    /// Level of A after the last flank.
    a: Option<bool>,
    glitches: u32,
}

impl EdgeFilter {
    /// A wheel that has shown no edge yet. `shortest_ticks`: less than the time between two edges of
    /// the fastest wheel, more than a disturbance of the line lasts; half of the former is good.
    pub const fn new(shortest_ticks: u32) -> Self {
        Self { shortest_ticks, last: None, before: None, a: None, glitches: 0 }
    }

    /// Takes in a flank of channel A: its time, and the levels of both channels just after it.
    ///
    /// * A level of A that hasn't changed: the pulse was over before it could be looked at. Nothing
    ///   happened.
    /// * Too soon after the last edge and back again: a short pulse. The last edge is taken back.
    /// * Too soon and onward: no wheel is so fast. Passed over.
    pub fn edge(&mut self, ticks: u32, a: bool, b: bool) {
        let forward = a != b;
        if self.a.replace(a) == Some(a) {
            self.glitches = self.glitches.saturating_add(1);
            return;
        }
        if let Some(last) = self.last
            && ticks.wrapping_sub(last.ticks) < self.shortest_ticks
        {
            self.glitches = self.glitches.saturating_add(1);
            if forward != last.forward {
                self.last = self.before;
            }
            return;
        }
        let Edge { position, forward: was_forward, .. } =
            self.last.unwrap_or(Edge { forward, ..Edge::default() });
        let position = match (was_forward, forward) {
            (true, true) => position.wrapping_add(1),
            (false, false) => position.wrapping_sub(1),
            _ => position, // Passed again, the other way.
        };
        self.before = self.last;
        self.last = Some(Edge { position, ticks, forward });
    }

    /// What is known, for the instant `now_ticks`.
    pub fn captured(&self, now_ticks: u32) -> Captured {
        let Edge { position, ticks, .. } = self.last.unwrap_or_default();
        Captured { edges: position, last_edge_ticks: ticks, now_ticks }
    }

    /// Flanks that were none of the wheel's. Stops at its maximum.
    pub fn glitches(&self) -> u32 {
        self.glitches
    }
}
