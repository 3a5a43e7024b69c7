//! Lag of the rate filter: the steady part of its innovations, which a wrong nominal inertia
//! causes.
//!
//! Input: innovations. Output: each innovation without the lag, for the spike gate and the monitor,
//! and the error that the lag leaves in the equation of motion.
//!
//! A nominal inertia whose inverse is wrong by the share q leaves, at constant acceleration,
//! innovations of mean `ν̄ ≈ q ω̇ Δt / K` (rad/s): the prediction error per step is corrected by
//! the gain K. This mean is no evidence of a spike, and its share `1 − K` remains as an error of
//! the filtered rate.
//!
//! Assumption: the lag changes slowly beside 64 samples.
//!
//! Ours: neither paper treats the lag.

use crate::math::{Mat, Vec3, scalar::Real};
use crate::monitor::innovation::Innovation;

/// Time constant of the running mean, in innovations: long beside the filter, short beside the
/// manoeuvre.
const MEMORY: f64 = 64.0;

/// Running mean of the innovations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lag<T: Real> {
    /// `ν̄`: zero where the nominal inertia is the true one.
    mean_innovation_rad_s: Vec3<T>,
}

crate::persist!([T: Real] Lag<T> { mean_innovation_rad_s });

impl<T: Real> Default for Lag<T> {
    fn default() -> Self {
        Self { mean_innovation_rad_s: Vec3::zeros() }
    }
}

impl<T: Real> Lag<T> {
    /// `ν − ν̄`, with the variance of ν.
    pub(super) fn removed_from(&self, innovation: &Innovation<T>) -> Innovation<T> {
        let rate_rad_s = innovation.rate_rad_s - self.mean_innovation_rad_s;
        Innovation { rate_rad_s, ..*innovation }
    }

    /// Updates the mean with an innovation from which the lag was removed:
    /// `ν̄ ← ν̄ + (ν − ν̄) / 64`.
    pub(super) fn update(&mut self, without_lag: &Innovation<T>) {
        self.mean_innovation_rad_s += without_lag.rate_rad_s * T::lit(1.0 / MEMORY);
    }

    /// Error that the lag leaves in the equation of motion, N m.
    ///
    /// The rate that remains after a correction with gain K is wrong by `e = (1 − K) ν̄` (rad/s),
    /// and the left-hand side then by
    ///
    /// `e × (J ω + h_w) + ω × J e`
    ///
    /// with the nominal `J` (kg m²), ω the filtered rate (rad/s), `h_w` the wheels' momentum (N m
    /// s). The derivative of the lag is left out: it is smaller by the ratio of the lag's change to
    /// the body's turning.
    pub(super) fn imbalance_n_m(
        &self,
        gain: T,
        nominal_kg_m2: &Mat<T, 3, 3>,
        rate_rad_s: &Vec3<T>,
        wheel_momentum_n_m_s: &Vec3<T>,
    ) -> Vec3<T> {
        let j = nominal_kg_m2;
        let lag = self.mean_innovation_rad_s * (T::one() - gain);
        lag.cross(&(j * rate_rad_s + wheel_momentum_n_m_s)) + rate_rad_s.cross(&(j * lag))
    }
}
