//! Gyro bias, disturbance torque and inertia that walk: process noise of groups of unknowns, and residuals without the bias.
//!
//! The bias `b` of each axis takes independent steps of variance `q² Δt` from block to block, with q in (rad/s)/√s.
//! A reading is linear in the bias and the motion does not depend on it, so that one nominal bias serves the whole
//! window; all that the walk changes is the statistics.
//!
//! # Factor
//!
//! The unknown is the bias of the newest block. With `b' = b + w` the equations `R x = d` hold for `b = b' − w`,
//! and w joins them with `0 = w ± q √Δt`. Rotations eliminate w
//! ([`walk`](crate::math::square_root_information::SquareRootInformation::walk)): what remains is the information on
//! the other unknowns for any path of the bias, weighted by its probability. Rows that follow leave the innovation of
//! a Kalman filter, white and of unit variance.
//!
//! # Bias instability
//!
//! A bias of instability B, the floor of its Allan deviation, flickers: its spectral density is `h / f` with
//! `B² = 2 ln 2 h` (IEEE Std 952-1997, annex C). That of a walk is `2 q² / (2π f)²`, one-sided as the former. Both are
//! equal at `f = 1/T`, the slowest motion that a window of length T shows, for
//!
//! ```text
//! q² = π² B² / (T ln 2)
//! ```
//!
//! The walk over the window has the sigma 3.77 B then. Faster flicker exceeds that of the walk, and where it exceeds the
//! gyro noise too the residuals are not white.
//!
//! # Torque of fields
//!
//! A magnetic dipole, the gravity gradient and air exert torques that are fixed neither in body nor in inertial axes. About
//! each body axis they vary like the cosine of the angle Φ by which the field turns in body axes: by the turn of the body
//! and by that of the field along the orbit. The torque d over the trace takes steps of variance `q² ΔΦ`. With the torque
//! d' after a step w, and the momentum m' at the start of the window that leads to the present one under d',
//!
//! ```text
//! d = d' − w,   m₀ = m' + S w,   S = (∂m/∂m₀)⁻¹ ∂m/∂d
//! ```
//!
//! holds in the equations of the blocks before, and rotations eliminate w again. Over a window of angle Φ a cosine of
//! variance σ² has the variance `σ² Φ² / (12 + Φ²)` about its mean, exact for small and for large angles and within
//! 30 % between, and the walk `q² Φ / 6`. Equal variances are the choice:
//!
//! ```text
//! q² = 6 σ² Φ / (12 + Φ²)
//! ```
//!
//! With the nine products of a moment and a field among the unknowns (module `field` of the trajectory), Φ contains the turn of
//! the field alone: the turn of the body is in the model.
//!
//! The model of the motion has a constant torque otherwise. A descent therefore ends with the solution for that, and the torque
//! walks in one more pass about it, to first order.
//!
//! # Inertia
//!
//! Shape q and scale x walk as the elements do, each by independent steps: variances `κ² σ²` of a moment's coordinate, `2 κ² σ²`
//! of a product's, `3 κ² σ² x²` of the scale. The momentum of the body is continuous, and its rate jumps by `−n⁻¹ δn ω`. As
//! for the torque,
//!
//! ```text
//! q = q' − w,   m₀ = m' + S w,   S = (∂m/∂m₀)⁻¹ ∂m/∂q
//! x = x' − w,   S = (∂m/∂m₀)⁻¹ (∂m/∂x − m/x)
//! ```
//!
//! since `m = κ h` follows the trace at constant h. The mean reading of a block sees a walk w over the block with the
//! covariance `⟨w̄ w⟩ = ⟨w²⟩ / 2`: half of the walk comes before its rows, half after.
//!
//! A pass with a walk is about the inertia at its end. Blocks from which the inertia has moved are predicted worse, and count for
//! less. Earlier windows walk too: a pass begins with them, since an end value that both inform about would have
//! the same walk twice.
//!
//! # Residuals at the point
//!
//! Robust weights and the cost of a point need residuals there. Those of a constant bias would contain the walk. A
//! scalar filter for each axis, all with the same variance P, follows the bias:
//!
//! ```text
//! P ← P + q² Δt      ν = r − b̂      S = P + σ² / n      b̂ ← b̂ + P/S ν      P ← P − P²/S
//! ```
//!
//! with r the residual of the block's mean reading over n samples. `Σ ν² / S` is the least sum of squares over all
//! paths of the bias. The nominal bias is that of the end of the last pass: P begins with the variance of a walk over
//! the whole window. Without a walk `ν = r` and `S = σ² / n` in every bit.

use crate::math::{Vec3, scalar::Real};

/// `π² / ln 2`.
const FLICKER: f64 = 14.2388;

/// One sigma of the walk over a window of this duration, rad/s: of a walk in (rad/s)/√s and of an instability in rad/s.
pub fn walked_rad_s<T: Real>(walk_rad_s_sqrt_s: T, instability_rad_s: T, duration_s: T) -> T {
    let (q, b) = (walk_rad_s_sqrt_s, instability_rad_s);
    if q == T::zero() && b == T::zero() {
        return T::zero();
    }
    (q * q * duration_s + b * b * T::lit(FLICKER)).sqrt()
}

/// Rate of the field of a low orbit against inertial space, rad/s: the magnetic field turns twice in an orbit of 95
/// minutes, and so does the gravity gradient.
const FIELD_RAD_S: f64 = 2.2e-3;

/// Angle by which a field turns in axes of a body that turns by `turn_rad` in a time, rad.
pub fn turn_against_field<T: Real>(turn_rad: T, duration_s: T) -> T {
    turn_rad + duration_s * T::lit(FIELD_RAD_S)
}

/// `q² / σ²` of the torque of fields over a window of angle Φ, 1/rad.
pub fn per_rad<T: Real>(angle_rad: T) -> T {
    T::lit(6.0) * angle_rad / (T::lit(12.0) + angle_rad * angle_rad)
}

/// Walk of the bias over a pass. Variances are those of a sample, σ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift<T: Real> {
    /// Variance of a step, σ²/s; zero for a constant bias.
    per_s: T,
    /// Variance of the mean over the rest before the first block against the bias at its end, σ².
    of_rest: T,
    /// Bias beyond that of the point, rad/s, and its variance, σ².
    bias_rad_s: Vec3<T>,
    variance: T,
}

crate::persist!([T: Real] Drift<T> { per_s, of_rest, bias_rad_s, variance }
    if |this| this.per_s >= T::zero() && this.variance >= T::zero());

impl<T: Real> Drift<T> {
    /// Constant bias.
    pub fn none() -> Self {
        let (o, none) = (T::zero(), Vec3::zeros());
        Self { per_s: o, of_rest: o, bias_rad_s: none, variance: o }
    }

    /// Walk of `walked_rad_s` over a window of this duration, beside gyro noise of `noise_rad_s` and after a rest.
    pub fn new(walked_rad_s: T, noise_rad_s: T, duration_s: T, rest_s: T) -> Self {
        if !(walked_rad_s > T::zero() && duration_s > T::zero()) {
            return Self::none();
        }
        let share = walked_rad_s / noise_rad_s;
        let variance = share * share;
        let per_s = variance / duration_s;
        // The mean of a walk over a time T differs from its end by q² T / 3.
        let of_rest = per_s * rest_s * T::lit(1.0 / 3.0);
        Self { per_s, of_rest, variance, ..Self::none() }
    }

    /// Variance of the rest's mean against the bias at the first block, σ²; none for a constant bias.
    pub fn after_rest(&self) -> Option<T> {
        (self.of_rest > T::zero()).then_some(self.of_rest)
    }

    /// Step to a block of this duration. Returns its variance, σ²; none for a constant bias.
    pub fn advance(&mut self, duration_s: T) -> Option<T> {
        let variance = self.per_s * duration_s;
        self.variance += variance;
        (variance > T::zero()).then_some(variance)
    }

    /// Innovation ν of a block of weight n with the residual r, rad/s, and its weight `σ² / S`.
    pub fn innovation(&self, residual_rad_s: &Vec3<T>, n: T) -> (Vec3<T>, T) {
        (residual_rad_s - self.bias_rad_s, n / (T::one() + n * self.variance))
    }

    /// Takes in the innovation of a block with its weight, `σ² / S` times the robust weight.
    pub fn update(&mut self, innovation_rad_s: &Vec3<T>, weight: T) {
        let gain = self.variance * weight;
        self.bias_rad_s += innovation_rad_s * gain;
        self.variance -= gain * self.variance;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::square_root_information::SquareRootInformation;

    /// Sum of squared innovations against that of a factor whose only unknown walks.
    #[test]
    fn innovations_leave_the_least_sum_of_squares() {
        let (noise, walk, duration_s) = (2e-3, 3e-4, 0.5);
        let mut drift = Drift::<f64>::new(walk * 20f64.sqrt(), noise, 20.0, 0.0);
        // The bias before the first block, with the variance that the filter begins with.
        let variance = (walk / noise).powi(2) * 20.0;
        let mut factor = SquareRootInformation::of_each([0.0], [1.0 / variance]);
        let (mut direct, mut of_factor) = (0.0, 0.0);
        for k in 0..40 {
            let residual = 1e-3 * ((k * k % 7) as f64 - 3.0);
            let n = 4.0 + f64::from(k % 3);
            let step = drift.advance(duration_s).unwrap();
            let (innovation, weight) = drift.innovation(&Vec3::repeat(residual), n);
            direct += innovation.x * innovation.x * weight;
            drift.update(&innovation, weight);
            factor.walk(0, step);
            of_factor += factor.add_weighted(&[1.0], residual, n).square();
        }
        assert!((direct / of_factor - 1.0).abs() < 1e-12, "{direct} {of_factor}");
    }

    #[test]
    fn a_constant_bias_changes_no_bit() {
        let mut drift = Drift::<f32>::new(0.0, 1e-4, 600.0, 60.0);
        assert_eq!((drift.advance(0.4), drift.after_rest()), (None, None));
        let residual = Vec3::new(1.7e-5, -0.1, 3.3e-9);
        assert_eq!(drift.innovation(&residual, 4.02), (residual, 4.02));
        drift.update(&residual, 4.02);
        assert_eq!(drift, Drift::none());
    }
}
