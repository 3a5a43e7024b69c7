//! Reaction-wheel tachometer: speed from the edges of a Hall sensor or an encoder.
//!
//! Input: edges, time-stamped by a capture timer. Output: speed of each wheel, rad/s, at the gyro's
//! sampling instant.
//!
//! ```text
//!  edge, by interrupt          at a sample                    for the flight loop
//!  edges::EdgeFilter      ->   CaptureTimer::captured    ->   speed::SpeedTracker  ->  rad/s
//!  direction, glitches         position, time of an edge      WheelTach
//! ```
//!
//! 1. [`edges`]: edge filter, called by the board for each edge. The direction comes from the level
//!    of a second channel, not from the commanded direction: the two differ while a wheel is braked
//!    through zero, when its momentum changes fastest.
//! 2. [`CaptureTimer`]: interface to the board.
//! 3. [`speed`]: period and count method combined, extrapolated to the sampling instant.
//!
//! # Resolution
//!
//! `P` edges per turn (both edges of one channel), timer of `f` ticks per second, sample interval
//! `T`, wheel speed `Ω`:
//!
//! * Fast: the time quantum of four edges leaves an error of at most `3.4 Ω / (f T)`, and
//!   `1.1 Ω / (f T)` RMS. At 1 MHz, 10 Hz and 628 rad/s (6000 rpm): 0.021 rad/s, and 0.007 rad/s RMS.
//!   An edge that is misplaced by the fraction ε of the angle between edges adds `2 π ε / (P T)`.
//! * Slow, below one edge per sample or `2 π / (P T)`: the speed is extrapolated from the last edges,
//!   and bounded from the time at which the next edge is overdue.
//! * Zero: less than one edge per [`Config::zero_after_s`]. With 24 edges per turn and 0.5 s, this is
//!   below 0.52 rad/s.

pub mod edges;
pub mod speed;

pub use edges::EdgeFilter;

use crate::flight::sensors::WheelTachometers;
use speed::SpeedTracker;

/// State of a wheel's edges at one instant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Captured {
    /// Position at the last edge, edges since start-up, signed by direction; wraps.
    pub edges: i32,
    /// Time of the last edge, ticks; wraps.
    pub last_edge_ticks: u32,
    /// Instant of the requested speed, ticks: the gyro's data-ready, if the same timer captures it,
    /// otherwise the instant of the reading. It may precede the last edge.
    pub now_ticks: u32,
}

/// A timer that time-stamps the edges of `W` wheels: the interface to the board.
///
/// Its ticks wrap at 2³². Readings must be less than half of that apart: 35 minutes at 1 MHz.
pub trait CaptureTimer<const W: usize> {
    /// Error of a reading.
    type Error;

    /// Tick rate, 1/s, above zero.
    fn ticks_per_s(&self) -> u32;

    /// Edges of each wheel, all for the same instant.
    fn captured(&mut self) -> Result<[Captured; W], Self::Error>;
}

/// Design and mounting of the wheels' sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config<const W: usize> {
    /// Edges per turn of each wheel, both edges of its first channel. Zero: no wheel, speed zero.
    pub edges_per_turn: [u16; W],
    /// True if a wheel's edges count up while it turns against its axis.
    pub reversed: [bool; W],
    /// Time without an edge after which a wheel counts as standing, s. The slowest measurable speed
    /// is one edge in this time; a longer time lowers it and detects a stop later.
    pub zero_after_s: f32,
}

/// Reason for missing speeds. `E` is the error of the capture timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Error<E> {
    /// Error of the timer.
    Timer(E),
    /// Too few edges since start-up: neither three readings with edges, nor
    /// [`Config::zero_after_s`] without one. The speed is unknown.
    Starting {
        /// Index of the wheel, from zero.
        wheel: usize,
    },
}

/// Reason for a rejected [`Config`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum ConfigError {
    /// The timer's tick rate is zero.
    TicksPerS,
    /// `zero_after_s` is not above zero, or is beyond half the timer's range.
    ZeroAfter,
}

/// Tachometers of `W` wheels on a capture timer `C`.
#[derive(Debug, Clone, Copy)]
pub struct WheelTach<C, const W: usize> {
    timer: C,
    /// One tracker per fitted wheel.
    trackers: [Option<SpeedTracker>; W],
}

impl<C: CaptureTimer<W>, const W: usize> WheelTach<C, W> {
    /// Tachometers before their first edge.
    ///
    /// # Errors
    /// See [`ConfigError`].
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

    /// The capture timer.
    pub fn timer(&mut self) -> &mut C {
        &mut self.timer
    }
}

impl<C: CaptureTimer<W>, const W: usize> WheelTachometers<W> for WheelTach<C, W> {
    type Error = Error<C::Error>;

    /// Updates every wheel, including those after a wheel without a speed. An error of the timer,
    /// which may have lost edges, resets all of them.
    fn speed_rad_s(&mut self) -> Result<[f32; W], Self::Error> {
        let captured = self.timer.captured().map_err(|error| {
            self.trackers.iter_mut().flatten().for_each(SpeedTracker::reset);
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
