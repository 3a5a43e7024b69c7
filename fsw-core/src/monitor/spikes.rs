//! Spike gate: samples too far from their prediction, and the lock-out after many in a row.
//!
//! Input: the squared test ratio of an innovation, `r² = maxᵢ νᵢ² / Sᵢᵢ`
//! ([`Innovation::squared_test_ratio`](super::innovation::Innovation::squared_test_ratio)).
//! Output: a [`Decision`]. The caller predicts across a rejected sample and restarts after a
//! lock-out.
//!
//! Assumption: a spike is a fault of one sample. A run of [`Config::lockout_after`] of them has its
//! cause in the prediction instead: a deployment, a docking, a diverged filter.
//!
//! | `r²` | run before | decision | run after |
//! |---|---|---|---|
//! | `≤ limit²`, or NaN | n | [`Decision::Accept`] | 0 |
//! | `> limit²` | `n + 1 < lockout_after` | [`Decision::Reject`] | n + 1 |
//! | `> limit²` | `n + 1 ≥ lockout_after` | [`Decision::LockOut`] | n + 1 |
//!
//! ```
//! use fsw_core::monitor::spikes::{Config, Decision, SpikeGate};
//!
//! let config = Config { limit_sigma: 6.0f32, lockout_after: 10 };
//! let mut gate = SpikeGate::default();
//! assert_eq!(gate.judge(2.5 * 2.5, &config), Decision::Accept);
//! assert_eq!(gate.judge(8.0 * 8.0, &config), Decision::Reject);
//! ```

use crate::error::ConfigError;
use crate::math::range::positive;
use crate::math::scalar::Real;

/// Limits of the gate, fixed for the estimator's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// Largest accepted innovation on any axis, in sigmas of that axis. `T::MAX` accepts every
    /// sample: its square overflows to infinity, which no ratio exceeds.
    pub limit_sigma: T,
    /// Consecutive spikes that make a lock-out. 0 and 1 lock out at the first.
    pub lockout_after: u16,
}

crate::persist!([T: Real] Config<T> { limit_sigma, lockout_after });

impl<T: Real> Config<T> {
    /// Checks the ranges.
    ///
    /// # Errors
    /// `spikes.limit_sigma`, unless it is finite and above zero.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("spikes.limit_sigma", self.limit_sigma)
    }
}

/// Decision on one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Within the limit.
    Accept,
    /// A spike: not to be used.
    Reject,
    /// A spike that completes a run: the estimate is wrong, not the gyro.
    LockOut,
}

/// The gate's state: the length of the present run of spikes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpikeGate {
    spikes_in_a_row: u16,
}

crate::persist!([] SpikeGate { spikes_in_a_row });

impl SpikeGate {
    /// Ends the present run, as after a restart of the estimator.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// Decides on a sample: a spike where `r² > limit_sigma²`, dimensionless.
    ///
    /// A ratio that is NaN is accepted, an infinite one is a spike; an estimator that treats
    /// numbers beyond its range as divergence tests for that first. After a lock-out the run
    /// continues until [`restart`](Self::restart).
    #[inline]
    pub fn judge<T: Real>(&mut self, squared_test_ratio: T, config: &Config<T>) -> Decision {
        let limit = config.limit_sigma * config.limit_sigma;
        let is_spike = squared_test_ratio > limit;
        if !is_spike {
            self.spikes_in_a_row = 0;
            return Decision::Accept;
        }
        self.spikes_in_a_row = self.spikes_in_a_row.saturating_add(1);
        if self.spikes_in_a_row < config.lockout_after {
            Decision::Reject
        } else {
            Decision::LockOut
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: Config<f32> = Config { limit_sigma: 6.0, lockout_after: 3 };

    #[test]
    fn the_limit_is_in_sigmas_and_still_accepted() {
        let mut gate = SpikeGate::default();
        assert_eq!(gate.judge(36.0, &CONFIG), Decision::Accept);
        assert_eq!(gate.judge(36.1, &CONFIG), Decision::Reject);
        assert_eq!(gate.judge(f32::INFINITY, &CONFIG), Decision::Reject);
        assert_eq!(gate.judge(f32::NAN, &CONFIG), Decision::Accept);
    }

    #[test]
    fn a_run_of_spikes_locks_out() {
        let mut gate = SpikeGate::default();
        let decisions = [100.0; 4].map(|ratio| gate.judge(ratio, &CONFIG));
        use Decision::{LockOut, Reject};
        assert_eq!(decisions, [Reject, Reject, LockOut, LockOut]);
        gate.restart();
        assert_eq!(gate.judge(100.0, &CONFIG), Reject);
    }

    #[test]
    fn an_accepted_sample_ends_the_run() {
        let mut gate = SpikeGate::default();
        for ratio in [100.0, 100.0, 1.0, 100.0, 100.0] {
            assert_ne!(gate.judge(ratio, &CONFIG), Decision::LockOut);
        }
    }

    #[test]
    fn the_largest_limit_accepts_every_ratio() {
        let config = Config { limit_sigma: f32::MAX, ..CONFIG };
        let mut gate = SpikeGate::default();
        assert_eq!(gate.judge(f32::INFINITY, &config), Decision::Accept);
    }
}
