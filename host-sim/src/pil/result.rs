//! Result of a flight of firmware and host: the flight, or the error that ended it.

use std::fmt;

use fsw_core::outcome::OutcomeCounts;
use fsw_target::flight::selected::SelectedEstimator;
use thiserror::Error;

use super::compare::Difference;
use super::firmware::LineFailed;
use super::setup::NotFlown;
use crate::estimation::Events;
use crate::truth::IntegrationFailed;

/// A flight did not reach its end.
#[derive(Debug, Error)]
pub enum PilFailed {
    /// A scenario that the flight computer cannot fly.
    #[error(transparent)]
    NotFlown(#[from] NotFlown),
    /// The motion between the samples cannot be integrated.
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
    /// No image, or no QEMU.
    #[error("{0:#}")]
    Machine(#[from] anyhow::Error),
    /// A line to the firmware failed.
    #[error("{error}, {progress}")]
    Line {
        /// Error of the line.
        error: LineFailed,
        /// Progress of the flight.
        progress: Progress,
    },
    /// Another version or build of the firmware. No sample is flown.
    #[error("{0}")]
    OtherBuild(LineFailed),
    /// Firmware and host differ.
    #[error(transparent)]
    Differs(#[from] Box<Difference>),
}

/// Progress of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Samples compared.
    pub compared: usize,
    /// True once the firmware has requested its craft data after its last start.
    pub has_started: bool,
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.has_started, self.compared) {
            (false, 0) => {
                f.write_str("before its first request: is the image a pil of this version?")
            }
            (false, compared) => write!(f, "in its restart after {compared} samples"),
            (true, 0) => f.write_str("before the first sample"),
            (true, compared) => write!(f, "after {compared} samples"),
        }
    }
}

/// Result of a complete flight, equal on firmware and host.
#[derive(Debug)]
pub struct PilFlight {
    /// Estimators.
    pub estimator: SelectedEstimator,
    /// Counts of the outcomes of all steps.
    pub outcomes: OutcomeCounts,
    /// Restarts, gaps, changes and spikes with their times.
    pub events: Events,
    /// Samples skipped because the gyro could not be read.
    pub gyro_failures: u32,
    /// Samples skipped because a tachometer could not be read.
    pub wheel_failures: u32,
    /// Estimate reports in which a wheel did not follow its commanded torque.
    pub wheel_doubts: u32,
    /// Samples compared: all of the flight.
    pub compared: usize,
    /// Largest use of the firmware's stack by its telemetry, bytes.
    pub stack_high_water_bytes: u32,
}
