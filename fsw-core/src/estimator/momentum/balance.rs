//! Balance of angular momentum in inertial space.
//!
//! Input: wheel momentum, external torque and attitude at each sample. Output: the body's own share
//! `Q` of the momentum, N m s.
//!
//! With P the matrix from inertial into body axes, from a start at rest
//!
//! `J ω(t) = Q(t) = P(t) H(t) − h_w(t)`, `H(t) = P(0)⁻¹ h_w(0) + ∫ P⁻¹ τ dt`
//!
//! which without torque is \[Kim2010\] Eqs. (8), (11). The integral is by the trapezoidal rule; the
//! paper has no torque.

use crate::dynamics::wheels::WheelArray;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::sample::Sample;

/// Momentum in inertial axes, and the last torque that changed it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Balance<T: Real> {
    /// `H`, N m s.
    momentum_n_m_s: Vec3<T>,
    /// Time of the last update.
    time_us: u64,
    /// `P⁻¹ τ` then, N m.
    torque_n_m: Vec3<T>,
}

impl<T: Real> Balance<T> {
    /// The wheels' momentum and the torque of one sample: the whole balance of a body at rest.
    /// `to_body` is P.
    pub(super) fn at_rest<const W: usize>(
        wheels: &WheelArray<T, W>,
        sample: &Sample<T, W>,
        to_body: &Mat<T, 3, 3>,
    ) -> Self {
        let to_inertial = to_body.transpose();
        Self {
            momentum_n_m_s: to_inertial * wheels.momentum_n_m_s(&sample.wheel_speed_rad_s),
            time_us: sample.time_us,
            torque_n_m: to_inertial * sample.torque_n_m,
        }
    }

    /// True if the impulse between the two is unknown: a torque, and longer than `max_gap_us` or
    /// across a change of the clock. Without torque the momentum is conserved across any gap.
    pub(super) fn has_unknown_impulse(&self, now: &Self, max_gap_us: u64) -> bool {
        let has_torque = [self.torque_n_m, now.torque_n_m].iter().any(|t| *t != Vec3::zeros());
        has_torque && (self.elapsed_us(now) > max_gap_us || !self.is_before(now))
    }

    /// The balance at the time and with the torque of `now`: `H + ½ (τ₀ + τ₁) Δt`. `None` where the
    /// sum is not finite.
    pub(super) fn advanced_to(&self, now: &Self) -> Option<Self> {
        let half_elapsed_s = T::seconds(self.elapsed_us(now)) * T::lit(0.5);
        let impulse = (self.torque_n_m + now.torque_n_m) * half_elapsed_s;
        let balance = Self { momentum_n_m_s: self.momentum_n_m_s + impulse, ..*now };
        balance.momentum_n_m_s.iter().all(|h| h.is_finite()).then_some(balance)
    }

    /// `Q = P H − h_w`, N m s, body axes, at a sample with these wheels.
    pub(super) fn body_momentum_n_m_s(
        &self,
        to_body: &Mat<T, 3, 3>,
        wheel_momentum_n_m_s: &Vec3<T>,
    ) -> Vec3<T> {
        to_body * self.momentum_n_m_s - wheel_momentum_n_m_s
    }

    /// False after a change of the clock.
    pub(super) fn is_before(&self, now: &Self) -> bool {
        self.time_us < now.time_us
    }

    fn elapsed_us(&self, now: &Self) -> u64 {
        now.time_us.saturating_sub(self.time_us)
    }
}
