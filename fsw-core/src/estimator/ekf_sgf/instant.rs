//! Terms of the regression's equation, from the polynomial through the differentiator's window.
//!
//! Input: value and derivative of nine channels at the evaluation point. Output: an [`Instant`].
//!
//! Departure from the papers, which leave the pairing of the terms open: rate, torque and wheel
//! momentum come from the same polynomial as the derivative, so that all belong to one instant.

use super::regression::Instant;
use super::{CHANNELS, EkfSgf};
use crate::math::savgol::Fitted;
use crate::math::{Vec3, scalar::Real};
use crate::tensor::Inertia;

impl<T: Real, const W: usize, const C: usize> EkfSgf<T, W, C> {
    /// All terms of `[G(ω̇) + ω^× G(ω)] j = τ − ḣ_w − ω × h_w` at the evaluation point.
    ///
    /// Input: value and derivative of ω (rad/s), `h_w` (N m s) and τ (N m), in this order.
    pub(super) fn instant(&self, fitted: &Fitted<T, CHANNELS>) -> Instant<T> {
        let [wx, wy, wz, hx, hy, hz, tx, ty, tz] = fitted.value;
        let [ax, ay, az, gx, gy, gz, ..] = fitted.derivative_per_s;
        let rate_rad_s = Vec3::new(wx, wy, wz);
        let wheel_momentum = Vec3::new(hx, hy, hz);
        let wheels = Vec3::new(gx, gy, gz) + rate_rad_s.cross(&wheel_momentum);
        let gain = self.rate.mean_gain();
        let nominal = Inertia::new(self.config.nominal.inertia_kg_m2).matrix_kg_m2();
        Instant {
            rate_rad_s,
            acceleration_rad_s2: Vec3::new(ax, ay, az),
            torque_n_m: Vec3::new(tx, ty, tz) - wheels,
            acceleration_sigma_rad_s2: self.acceleration_sigma_rad_s2(gain, fitted.period_s),
            imbalance_n_m: self.lag.imbalance_n_m(gain, &nominal, &rate_rad_s, &wheel_momentum),
        }
    }

    /// One sigma of the noise in each axis of the acceleration, rad/s²:
    ///
    /// `σ √(K / (2 − K) · g(1 − K)) / Δt`
    ///
    /// with σ the gyro's sigma (rad/s), K the rate filter's gain, Δt the sample period (s). The
    /// noise that remains in the filtered rate is the gyro's through a first-order lag: variance
    /// `K / (2 − K) σ²`, correlation `1 − K` from sample to sample. g is the differentiator's noise
    /// gain for noise of that correlation, in units of 1/Δt².
    fn acceleration_sigma_rad_s2(&self, gain: T, period_s: T) -> T {
        let share = gain / (T::lit(2.0) - gain);
        let differentiated = self.differentiator.derivative_noise_gain(T::one() - gain);
        let noise = (share * differentiated.max(T::EPSILON)).sqrt() / period_s;
        noise * self.config.rate_ekf.gyro_noise_rad_s
    }
}
