//! Attitude of the body relative to inertial space, from a star tracker or an attitude filter.
//!
//! A unit quaternion, scalar last, that transforms the *components* of a vector from inertial to
//! body axes. With rotation angle φ about the unit axis e,
//!
//! `q = (e sin φ/2, cos φ/2)`.
//!
//! A body turned by +φ about its x axis has `q₁ = +sin φ/2`. `q` and `−q` are the same attitude.
//!
//! | other convention | conversion |
//! |---|---|
//! | scalar first, `(q₀, q₁, q₂, q₃)` | `(q₁, q₂, q₃, q₀)` |
//! | body to inertial components | conjugate, `(−q₁, −q₂, −q₃, q₄)` |
//!
//! Kinematics with the body rate ω, rad/s: `q̇ = ½ (q₄ ω − ω × ρ, −ω · ρ)`, `ρ = (q₁, q₂, q₃)`.
//!
//! Only the estimator [`momentum`](crate::estimator::momentum) uses the attitude. It needs angular
//! momentum in inertial axes, `H_inertial = Pᵀ (J ω + h_w)`.

use crate::math::{Mat, scalar::Real};

/// Largest deviation of the squared norm from 1. Ours: 1e-3. Four elements rounded to 16 bits are
/// within 1e-4; a larger deviation is not due to rounding.
const NORM_TOLERANCE: f64 = 1e-3;

/// Quaternion `q₁ q₂ q₃ q₄`, scalar last, as in \[Kim2010\] Eq. (6). Any numbers are accepted;
/// [`to_body`](Self::to_body) rejects the ones that are not a rotation.
///
/// ```
/// use fsw_core::{Quaternion, Vec3};
///
/// // A body turned by 90° about x: inertial y lies along body −z.
/// let half = core::f64::consts::FRAC_PI_4;
/// let q = Quaternion::new([half.sin(), 0.0, 0.0, half.cos()]);
/// let y = q.to_body().unwrap() * Vec3::y();
/// assert!((y - Vec3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<T: Real> {
    elements: [T; 4],
}

/// Reason for which the attitude of a sample is unusable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NoAttitude {
    /// The sample has none.
    Missing,
    /// An element is infinite or NaN.
    NotFinite,
    /// The squared norm deviates from 1 by more than 1e-3.
    NotUnit,
}

impl NoAttitude {
    /// Name of the reason in logs and telemetry.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Missing => "attitude_missing",
            Self::NotFinite => "attitude_not_finite",
            Self::NotUnit => "attitude_not_unit",
        }
    }
}

impl<T: Real> Quaternion<T> {
    /// From `q₁ q₂ q₃ q₄`, scalar last.
    pub fn new(elements: [T; 4]) -> Self {
        Self { elements }
    }

    /// Body axes along inertial axes: `(0, 0, 0, 1)`, `P = 1`.
    pub fn identity() -> Self {
        let o = T::zero();
        Self::new([o, o, o, T::one()])
    }

    /// Elements `q₁ q₂ q₃ q₄`, scalar last.
    pub fn elements(&self) -> [T; 4] {
        self.elements
    }

    /// Rotation matrix P from inertial to body components, \[Kim2010\] Eq. (6):
    /// `v_body = P v_inertial`.
    ///
    /// `P = (q₄² − |ρ|²) 1 + 2 ρ ρᵀ − 2 q₄ ρ^×`, `ρ = (q₁, q₂, q₃)`, divided by the squared norm so
    /// that rounding of the elements does not stretch vectors.
    ///
    /// # Errors
    /// An element is not finite, or the squared norm deviates from 1 by more than 1e-3.
    pub fn to_body(&self) -> Result<Mat<T, 3, 3>, NoAttitude> {
        if !self.elements.iter().all(|q| q.is_finite()) {
            return Err(NoAttitude::NotFinite);
        }
        let [q1, q2, q3, q4] = self.elements;
        let square = q1 * q1 + q2 * q2 + q3 * q3 + q4 * q4;
        let is_unit = (square - T::one()).abs() <= T::lit(NORM_TOLERANCE);
        if !is_unit {
            return Err(NoAttitude::NotUnit);
        }
        let one = T::one();
        let two = T::lit(2.0) / square;
        Ok(Mat::<T, 3, 3>::new(
            one - two * (q2 * q2 + q3 * q3),
            two * (q1 * q2 + q3 * q4),
            two * (q1 * q3 - q2 * q4),
            two * (q1 * q2 - q3 * q4),
            one - two * (q1 * q1 + q3 * q3),
            two * (q2 * q3 + q1 * q4),
            two * (q1 * q3 + q2 * q4),
            two * (q2 * q3 - q1 * q4),
            one - two * (q1 * q1 + q2 * q2),
        ))
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format> defmt::Format for Quaternion<T> {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{}", self.elements);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use proptest::prelude::*;

    /// Turn by 30° about x: inertial y has the body components (0, cos 30°, −sin 30°).
    #[test]
    fn a_positive_turn_about_x_moves_inertial_y_towards_minus_z() {
        let half = 0.5f64 * 30.0f64.to_radians();
        let p = Quaternion::new([half.sin(), 0.0, 0.0, half.cos()]).to_body().unwrap();
        let y = p * Vec3::y();
        let (sin, cos) = 30.0f64.to_radians().sin_cos();
        assert!((y - Vec3::new(0.0, cos, -sin)).norm() < 1e-15);
    }

    /// Zero, wrong norm, infinite square and NaN.
    #[test]
    fn a_quaternion_that_is_no_rotation_is_rejected_with_the_reason() {
        let to_body = |q: [f32; 4]| Quaternion::new(q).to_body();
        assert!(Quaternion::<f32>::identity().to_body().is_ok());
        assert_eq!(to_body([0.0; 4]), Err(NoAttitude::NotUnit));
        assert_eq!(to_body([0.0, 0.0, 0.0, 1.001]), Err(NoAttitude::NotUnit));
        assert_eq!(to_body([1e30, 0.0, 0.0, 1.0]), Err(NoAttitude::NotUnit));
        assert_eq!(to_body([f32::NAN, 0.0, 0.0, 1.0]), Err(NoAttitude::NotFinite));
        assert!(to_body([0.0, 0.0, 0.0, 1.0004]).is_ok());
    }

    proptest! {
        /// Orthogonal with determinant 1 for norms within 0.04 % of one.
        #[test]
        fn the_matrix_is_a_rotation_for_any_rounding_of_the_norm(
            q in prop::array::uniform4(-1.0..1.0f64), stretch in 0.9996..1.0004f64,
        ) {
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            prop_assume!(norm > 0.1);
            let p = Quaternion::new(q.map(|x| x / norm * stretch)).to_body().unwrap();
            prop_assert!((p * p.transpose() - Mat::identity()).abs().max() < 1e-14);
            prop_assert!((p.determinant() - 1.0).abs() < 1e-14);
        }
    }
}
