//! Limits of a simulation.

/// Most samples: twelve days at 10 Hz, about 1 GB of memory.
pub const MAX_SAMPLES: f64 = 1e7;
/// Highest gyro rate, Hz: a tenth of its period is the 1 µs resolution of time stamps.
pub const MAX_RATE_HZ: f64 = 1e5;
