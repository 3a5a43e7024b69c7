//! A recorded flight that plays the part of every sensor.
//!
//! Input: rows of a log, in order. Output: what the gyro, the tachometers and the torque command
//! would have said, one row per sample. When the rows are over no further sample is announced, and
//! the loop stays idle.

use crate::flight::sensors::{DataReady, Gyro, TorqueCommand, WheelTachometers};
use core::cell::Cell;
use fsw_core::Vec3;

/// One row of a log: all that the sensors said at one instant, in the units of an
/// [`fsw_core::Sample`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<const W: usize> {
    /// Time stamp, microseconds.
    pub time_us: u64,
    /// Body rate, rad/s.
    pub rate_rad_s: [f32; 3],
    /// Speed of each wheel relative to the body, rad/s.
    pub wheel_speed_rad_s: [f32; W],
    /// External torque in body axes, N m.
    pub torque_n_m: [f32; 3],
}

/// Plays `rows`. A shared reference to it is each of the sensors, so that one recording can be
/// all of them at once.
#[derive(Debug)]
pub struct Recording<'a, const W: usize> {
    ahead: Cell<&'a [Row<W>]>,
    current: Cell<Option<&'a Row<W>>>,
}

/// A sensor was read before the recording announced its first sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotStarted;

impl<'a, const W: usize> Recording<'a, W> {
    /// A recording that stands before its first row.
    pub fn new(rows: &'a [Row<W>]) -> Self {
        Self { ahead: Cell::new(rows), current: Cell::new(None) }
    }

    fn current(&self) -> Result<&'a Row<W>, NotStarted> {
        self.current.get().ok_or(NotStarted)
    }
}

impl<const W: usize> DataReady for &Recording<'_, W> {
    fn take_us(&mut self) -> Option<u64> {
        let (row, ahead) = self.ahead.get().split_first()?;
        self.ahead.set(ahead);
        self.current.set(Some(row));
        Some(row.time_us)
    }

    /// No row comes before it is asked for.
    fn has_newer(&mut self) -> bool {
        false
    }

    /// A row that hasn't been taken isn't announced yet.
    fn discard(&mut self) {}

    fn overruns(&self) -> u32 {
        0
    }
}

impl<const W: usize> Gyro for &Recording<'_, W> {
    type Error = NotStarted;

    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, NotStarted> {
        Ok(Vec3::from(self.current()?.rate_rad_s))
    }
}

impl<const W: usize> WheelTachometers<W> for &Recording<'_, W> {
    type Error = NotStarted;

    fn speed_rad_s(&mut self) -> Result<[f32; W], NotStarted> {
        Ok(self.current()?.wheel_speed_rad_s)
    }
}

impl<const W: usize> TorqueCommand for &Recording<'_, W> {
    fn torque_n_m(&mut self) -> Vec3<f32> {
        self.current().map_or(Vec3::zeros(), |row| Vec3::from(row.torque_n_m))
    }

    /// The recording has its own.
    fn command(&mut self, _: Vec3<f32>) {}
}

/// A CubeSat shakes itself with four wheels for a minute: `flights/cubesat_pyramid.csv` and its
/// craft file beside it, turned into constants by `build.rs`.
pub mod cubesat_pyramid {
    use super::Row;
    use crate::flight::craft::Craft;
    #[allow(unused_imports)] // unused if the craft file has no prior
    use fsw_core::Prior;

    include!(concat!(env!("OUT_DIR"), "/cubesat_pyramid.rs"));
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: [Row<1>; 2] = [
        Row {
            time_us: 0,
            rate_rad_s: [0.1, 0.2, 0.3],
            wheel_speed_rad_s: [10.0],
            torque_n_m: [0.0; 3],
        },
        Row {
            time_us: 100_000,
            rate_rad_s: [0.4, 0.5, 0.6],
            wheel_speed_rad_s: [20.0],
            torque_n_m: [1e-3, 0.0, 0.0],
        },
    ];

    #[test]
    fn rows_are_played_in_order_until_they_are_over() {
        let recording = Recording::new(&ROWS);
        let mut sensor = &recording;
        for row in &ROWS {
            assert_eq!(sensor.take_us(), Some(row.time_us));
            assert_eq!(sensor.rate_rad_s(), Ok(Vec3::from(row.rate_rad_s)));
            assert_eq!(sensor.speed_rad_s(), Ok(row.wheel_speed_rad_s));
            assert_eq!(sensor.torque_n_m(), Vec3::from(row.torque_n_m));
        }
        assert_eq!(sensor.take_us(), None);
    }

    #[test]
    fn before_the_first_row_no_sensor_answers() {
        let recording = Recording::new(&ROWS);
        let mut sensor = &recording;
        assert_eq!(sensor.rate_rad_s(), Err(NotStarted));
        assert_eq!(sensor.speed_rad_s(), Err(NotStarted));
        assert_eq!(sensor.torque_n_m(), Vec3::zeros());
    }

    #[test]
    fn the_committed_flight_runs_forward_in_time() {
        assert!(cubesat_pyramid::ROWS.windows(2).all(|pair| pair[0].time_us < pair[1].time_us));
    }
}
