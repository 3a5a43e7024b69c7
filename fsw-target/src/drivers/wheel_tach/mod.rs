//! Reaction-wheel speed from the edges of a Hall sensor or an encoder.
//!
//! Input: edges, time-stamped by a capture timer. Output: each wheel's speed in rad/s at the instant
//! that the gyro sampled.
//!
//! ```text
//!  edge, by interrupt          at a sample                    for the flight loop
//!  edges::EdgeFilter      ->   CaptureTimer::captured    ->   speed::SpeedTracker  ->  rad/s
//!  direction, glitches         position, time of an edge      WheelTach
//! ```
//!
//! 1. [`edges`]: what a board calls for each edge. Direction comes from the level of a second channel,
//!    not from the commanded direction: while a wheel is braked through zero the two differ, and then
//!    its momentum changes fastest.
//! 2. [`CaptureTimer`]: what a board offers to the driver.
//! 3. [`speed`]: period and count method in one, to first order at the instant that is asked for.
//!
//! # Resolution
//!
//! With `P` edges a turn (both flanks of one channel), a timer of `f` ticks a second and `T` between
//! samples:
//!
//! * Fast: four edges, each stamped to a whole tick, leave at most `3.4 Ω / (f T)`, and `1.1 Ω / (f T)`
//!   RMS. With 1 MHz and 10 Hz, 628 rad/s (6000 rpm) is seen to 0.021 rad/s, and 0.007 rad/s RMS. Uneven
//!   edges are worse: one that is off by ε of the angle between edges counts as `2 π ε / (P T)`.
//! * Slow: below one edge a sample, `2 π / (P T)`, the speed is the last that edges told, and is
//!   corrected once an edge that should have come doesn't. What is slower than an edge in
//!   [`Config::zero_after_s`] is zero: with 24 edges a turn and 0.5 s, below 0.52 rad/s.

pub mod edges;
pub mod speed;

pub use edges::EdgeFilter;

use crate::flight::sensors::WheelTachometers;
use speed::SpeedTracker;

/// What is known of a wheel's edges at one instant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Captured {
    /// Where the wheel was at its last edge, in edges since start-up, signed by direction; wraps.
    pub edges: i32,
    /// When that was, ticks; wraps.
    pub last_edge_ticks: u32,
    /// The instant that the speed is wanted for, ticks: the gyro's data-ready, if the same timer
    /// captures it, else that of the reading. May lie before the last edge.
    pub now_ticks: u32,
}

/// A timer that time-stamps the edges of `W` wheels: what a board offers.
///
/// Its ticks wrap at 2³². It must be read at least once in half of that, with 1 MHz every half an hour.
pub trait CaptureTimer<const W: usize> {
    /// What may go wrong in reading it.
    type Error;

    /// Ticks in a second, above zero.
    fn ticks_per_s(&self) -> u32;

    /// The edges of each wheel so far, all for the same instant.
    fn captured(&mut self) -> Result<[Captured; W], Self::Error>;
}

/// How the wheels' sensors are made and mounted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config<const W: usize> {
    /// Edges in a turn of each wheel, both flanks of its first channel counted. Zero: there is no
    /// wheel in this place, and its speed is zero.
    pub edges_per_turn: [u16; W],
    /// Whether the edges of a wheel count up as it turns against its axis.
    pub reversed: [bool; W],
    /// A wheel without an edge for so long stands still, s. The slowest speed that is seen is one edge
    /// in this time; longer sees slower wheels, and notices later that one has stopped.
    pub zero_after_s: f32,
}

/// Why there are no speeds. `E` is the error of the capture timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Error<E> {
    /// The timer failed.
    Timer(E),
    /// Since start-up a wheel has shown neither three readings with edges, nor no edge for so long
    /// that it must stand still. A made-up speed would be worse than none.
    Starting {
        /// Which, from zero.
        wheel: usize,
    },
}

/// A [`Config`] that can't be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum ConfigError {
    /// A timer that stands still.
    TicksPerS,
    /// `zero_after_s` isn't above zero, or is beyond half of the timer's range.
    ZeroAfter,
}

/// The tachometers of `W` wheels on a capture timer `C`.
#[derive(Debug, Clone, Copy)]
pub struct WheelTach<C, const W: usize> {
    timer: C,
    /// Of the wheels that there are.
    trackers: [Option<SpeedTracker>; W],
}

impl<C: CaptureTimer<W>, const W: usize> WheelTach<C, W> {
    /// Tachometers that have seen no edge yet.
    ///
    /// # Errors
    /// Names what can't be.
    pub fn new(timer: C, config: &Config<W>) -> Result<Self, ConfigError> {
        let ticks_per_s = timer.ticks_per_s();
        let Config { edges_per_turn, reversed, zero_after_s } = *config;
        if ticks_per_s == 0 {
            return Err(ConfigError::TicksPerS);
        }
        let half_range_s = i32::MAX as f32 / ticks_per_s as f32;
        if !(zero_after_s > 0.0 && zero_after_s < half_range_s) {
            return Err(ConfigError::ZeroAfter);
        }
        let mut signs = reversed.into_iter().map(|reversed| if reversed { -1.0 } else { 1.0 });
        let trackers = edges_per_turn.map(|edges| {
            let sign = signs.next().unwrap_or(1.0);
            let step_rad = sign * core::f32::consts::TAU / f32::from(edges);
            (edges > 0).then(|| SpeedTracker::new(step_rad, ticks_per_s, zero_after_s))
        });
        Ok(Self { timer, trackers })
    }

    /// The timer.
    pub fn timer(&mut self) -> &mut C {
        &mut self.timer
    }
}

impl<C: CaptureTimer<W>, const W: usize> WheelTachometers<W> for WheelTach<C, W> {
    type Error = Error<C::Error>;

    /// Every wheel is looked at, also after one that gives no speed yet. After a failure of the
    /// timer, which may have lost edges, all begin anew.
    fn speed_rad_s(&mut self) -> Result<[f32; W], Self::Error> {
        let captured = self.timer.captured().map_err(|error| {
            self.trackers.iter_mut().flatten().for_each(SpeedTracker::forget);
            Error::Timer(error)
        })?;
        let mut speed_rad_s = [0.0; W];
        let mut starting = None;
        let wheels = speed_rad_s.iter_mut().zip(&mut self.trackers).zip(&captured);
        for (wheel, ((speed_rad_s, tracker), captured)) in wheels.enumerate() {
            let Some(tracker) = tracker else { continue };
            match tracker.speed_rad_s(captured) {
                Some(speed) => *speed_rad_s = speed,
                None => starting = starting.or(Some(Error::Starting { wheel })),
            }
        }
        starting.map_or(Ok(speed_rad_s), Err)
    }
}

#[cfg(test)]
mod tests;
