//! Quadrature decoding of one wheel: position and direction from the edges of two channels, with
//! glitch rejection.
//!
//! Input: every edge of channel A, from the board's capture interrupt, with its captured time and the
//! levels of both channels just after it. Output: position in edges and the time of the last edge.
//!
//! Channel B lags A by a quarter period in forward rotation, so the levels differ after a forward
//! edge. Each edge of A lies at one angle of the wheel, in either direction. A reversal passes the
//! same edge again: the direction changes, the count does not. Dither on one edge has no net count.

use super::Captured;

/// An accepted edge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Edge {
    /// Position, edges since start-up.
    position: i32,
    ticks: u32,
    forward: bool,
}

/// Edge filter of one wheel.
#[derive(Debug, Clone, Copy)]
pub struct EdgeFilter {
    /// Shortest time between two edges, ticks. A shorter interval is a glitch.
    shortest_ticks: u32,
    last: Option<Edge>,
    /// The edge before `last`, restored after a glitch.
    before: Option<Edge>,
    /// Level of A after its last edge.
    a: Option<bool>,
    glitches: u32,
}

impl EdgeFilter {
    /// A filter before its first edge. `shortest_ticks` lies below the interval between edges at the
    /// highest speed and above the duration of line disturbances; half of the former suits.
    pub const fn new(shortest_ticks: u32) -> Self {
        Self { shortest_ticks, last: None, before: None, a: None, glitches: 0 }
    }

    /// Adds an edge of channel A: its time, and the levels of both channels just after it.
    ///
    /// * Level of A unchanged: a pulse that ended before the interrupt read the level. Ignored.
    /// * Less than `shortest_ticks` after the last edge, in the other direction: a short pulse. The
    ///   last edge is removed.
    /// * Less than `shortest_ticks` after the last edge, in the same direction: faster than the
    ///   fastest wheel. Ignored.
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
            _ => position, // reversal: the same edge again
        };
        self.before = self.last;
        self.last = Some(Edge { position, ticks, forward });
    }

    /// Position and time of the last edge, for the instant `now_ticks`.
    pub fn captured(&self, now_ticks: u32) -> Captured {
        let Edge { position, ticks, .. } = self.last.unwrap_or_default();
        Captured { edges: position, last_edge_ticks: ticks, now_ticks, lost: false }
    }

    /// Rejected edges since start-up; saturates.
    pub fn glitches(&self) -> u32 {
        self.glitches
    }
}
