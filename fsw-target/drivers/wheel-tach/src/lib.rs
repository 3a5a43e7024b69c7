//! Reaction-wheel tachometer: speed from the edges of a Hall sensor or an encoder.
//!
//! Input: edges, time-stamped by a capture timer. Output: speed of each wheel, rad/s, at the gyro's
//! sampling instant.
//!
//! ```text
//!  edge, by interrupt          at a sample                    for the caller
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
//! * Dead line: no edge although the wheel must have passed some; see [`speed`].
//! * Zero: less than one edge per [`Config::zero_after_s`]. With 24 edges per turn and 0.5 s, this is
//!   below 0.52 rad/s.

#![no_std]
#![forbid(unsafe_code)]

pub mod edges;
pub mod speed;

pub use edges::EdgeFilter;

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
    /// True if edges of this wheel were lost since the last reading: its position is not comparable to
    /// that of the last reading.
    pub lost: bool,
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
    /// Largest acceleration of a wheel, rad/s²: motor torque over spin inertia, with margin. A wheel without
    /// edges that cannot have stopped has lost its signal. Infinity: no check.
    pub largest_acceleration_rad_s2: f32,
    /// Time by which the instant of the speeds precedes [`Captured::now_ticks`], µs: the delay of a gyro whose
    /// data-ready is that instant, so that speed and rate belong together.
    pub delay_us: u32,
}

/// Reason for missing speeds. `E` is the error of the capture timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// Error of the timer.
    Timer(E),
    /// Too few edges since start-up or since edges were lost: neither three readings with edges, nor
    /// [`Config::zero_after_s`] without one. The speed is unknown.
    Starting {
        /// Index of the wheel, from zero.
        wheel: usize,
    },
    /// No edges where the wheel must have passed some: a dead line. Until edges return, or the
    /// speed is assumed.
    SignalLost {
        /// Index of the wheel, from zero.
        wheel: usize,
    },
}

/// Reason for a rejected [`Config`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// The timer's tick rate is zero.
    TicksPerS,
    /// `zero_after_s` is not above zero, or is beyond half the timer's range.
    ZeroAfter,
    /// `largest_acceleration_rad_s2` is not above zero.
    LargestAcceleration,
}

/// Tachometers of `W` wheels on a capture timer `C`.
#[derive(Debug, Clone, Copy)]
pub struct WheelTach<C, const W: usize> {
    timer: C,
    delay_ticks: u32,
    /// One tracker per fitted wheel.
    trackers: [Option<SpeedTracker>; W],
    /// Speed in place of a wheel's sensor, rad/s.
    assumed_rad_s: [Option<f32>; W],
    /// True for each wheel with a speed at the last reading.
    valid: [bool; W],
}

impl<C: CaptureTimer<W>, const W: usize> WheelTach<C, W> {
    /// Tachometers before their first edge.
    ///
    /// # Errors
    /// See [`ConfigError`].
    pub fn new(timer: C, config: &Config<W>) -> Result<Self, ConfigError> {
        let ticks_per_s = timer.ticks_per_s();
        let Config { edges_per_turn, reversed, zero_after_s, .. } = *config;
        let largest_rad_s2 = config.largest_acceleration_rad_s2;
        if ticks_per_s == 0 {
            return Err(ConfigError::TicksPerS);
        }
        let half_range_s = i32::MAX as f32 / ticks_per_s as f32;
        if !(zero_after_s > 0.0 && zero_after_s < half_range_s) {
            return Err(ConfigError::ZeroAfter);
        }
        if largest_rad_s2.is_nan() || largest_rad_s2 <= 0.0 {
            return Err(ConfigError::LargestAcceleration);
        }
        let mut signs = reversed.into_iter().map(|reversed| if reversed { -1.0 } else { 1.0 });
        let trackers = edges_per_turn.map(|edges| {
            let sign = signs.next().unwrap_or(1.0);
            let step_rad = sign * core::f32::consts::TAU / f32::from(edges);
            let tracker = || SpeedTracker::new(step_rad, ticks_per_s, zero_after_s, largest_rad_s2);
            (edges > 0).then(tracker)
        });
        let delay_ticks = (config.delay_us as f32 * 1e-6 * ticks_per_s as f32) as u32;
        let (assumed_rad_s, valid) = ([None; W], [false; W]);
        Ok(Self { timer, delay_ticks, trackers, assumed_rad_s, valid })
    }

    /// The capture timer.
    pub fn timer(&mut self) -> &mut C {
        &mut self.timer
    }

    /// Speed of each wheel about its spin axis, relative to the body, rad/s.
    ///
    /// Updates every wheel, including those after a wheel without a speed. Lost edges of a wheel reset that
    /// wheel; an error of the timer, which may have lost edges of any, resets all of them.
    ///
    /// # Errors
    /// See [`Error`]: that of the first wheel without a speed.
    pub fn speed_rad_s(&mut self) -> Result<[f32; W], Error<C::Error>> {
        self.valid = [false; W];
        let captured = self.timer.captured().map_err(|error| {
            self.trackers.iter_mut().flatten().for_each(SpeedTracker::reset);
            Error::Timer(error)
        })?;
        let (mut speed_rad_s, mut missing) = ([0.0; W], None);
        let sensors = self.trackers.iter_mut().zip(&captured).zip(&self.assumed_rad_s);
        let wheels = speed_rad_s.iter_mut().zip(&mut self.valid).zip(sensors);
        for (wheel, ((speed_rad_s, valid), ((tracker, captured), assumed))) in wheels.enumerate() {
            let measured = match tracker {
                Some(tracker) => measure(tracker, captured, self.delay_ticks),
                None => Some(0.0),
            };
            match assumed.or(measured) {
                Some(speed) => (*speed_rad_s, *valid) = (speed, true),
                None if tracker.is_some_and(|tracker| tracker.is_lost()) => {
                    missing = missing.or(Some(Error::SignalLost { wheel }));
                }
                None => missing = missing.or(Some(Error::Starting { wheel })),
            }
        }
        missing.map_or(Ok(speed_rad_s), Err)
    }

    /// True for each wheel that had a speed at the last reading, or is not fitted.
    pub fn are_valid(&self) -> [bool; W] {
        self.valid
    }

    /// True for each wheel whose speed is assumed.
    pub fn are_assumed(&self) -> [bool; W] {
        self.assumed_rad_s.map(|speed| speed.is_some())
    }

    /// Assumes this speed of a wheel, rad/s, in place of its sensor's; `None`: its sensor's again. False if
    /// the wheel has no sensor.
    pub fn assume(&mut self, wheel: usize, speed_rad_s: Option<f32>) -> bool {
        let is_fitted = self.trackers.get(wheel).is_some_and(Option::is_some);
        match self.assumed_rad_s.get_mut(wheel).filter(|_| is_fitted) {
            Some(assumed) => {
                *assumed = speed_rad_s;
                true
            }
            None => false,
        }
    }
}

/// Speed of one wheel, `delay_ticks` before the instant of the capture.
fn measure(tracker: &mut SpeedTracker, captured: &Captured, delay_ticks: u32) -> Option<f32> {
    if captured.lost {
        tracker.reset();
    }
    let now_ticks = captured.now_ticks.wrapping_sub(delay_ticks);
    tracker.speed_rad_s(&Captured { now_ticks, ..*captured })
}

#[cfg(test)]
mod tests;

/// The code of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
