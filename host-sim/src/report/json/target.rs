//! Document of `pil`: the estimate of the firmware in QEMU, and its comparison with the host.

use serde::Serialize;

use super::estimate::RunReport;

/// Result of `pil`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PilReport {
    /// Result of `run` for the firmware's flight.
    #[serde(flatten)]
    pub run: RunReport,
    /// Comparison of firmware and host.
    pub target: TargetReport,
}

/// Comparison of firmware and host. Absent if they differ, which is an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetReport {
    /// Samples with identical telemetry on firmware and host: all of the flight.
    pub identical_samples: u64,
    /// Number of samples before the power cut, after which the firmware resumed from its checkpoint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restarted_at: Option<usize>,
    /// Largest use of the stack on the processor, bytes.
    pub stack_high_water_bytes: u32,
    /// Duration of the comparison, s.
    pub wall_s: f64,
}
