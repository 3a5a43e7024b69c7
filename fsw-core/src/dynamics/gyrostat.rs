//! Equation of motion of the gyrostat: a rigid body with spinning wheels.
//!
//! `J ω̇ + ḣ_w + ω × (J ω + h_w) = τ`, `J` including the locked wheels.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `ω`, `ω̇` | rate, acceleration of the body | rad/s, rad/s² |
//! | `J` | inertia tensor | kg m² |
//! | `h_w` | momentum of the wheels relative to the body | N m s |
//! | `τ` | external torque | N m |
//!
//! # Derivation
//!
//! Total angular momentum about the centre of mass is `H = J ω + h_w`: the locked wheels turn with
//! the body, and `h_w` is their motion relative to it. Its derivative in inertial space equals the
//! external torque; in body axes, `Ḣ + ω × H = τ`. Insertion of H gives the equation above. Motor
//! torque is internal and does not appear.
//!
//! # Observability
//!
//! Both terms with J are linear in its elements, `[G(ω̇) + ω^× G(ω)] j = τ − ḣ_w − ω × h_w`.
//! Without external torque and wheel momentum the right-hand side is zero, and j is determined up
//! to a factor: the scale needs a known torque or a known wheel momentum.
//!
//! Tachometer speeds are sufficient: neither motor torque nor the derivative of a measured speed
//! enters ([`step`](super::step) integrates total momentum).

use crate::math::{Mat, Vec3, scalar::Real, skew};
use crate::tensor::{Inertia, gyroscopic_regressor, regressor};

/// Body of a given inertia, with its inverse.
///
/// ```
/// use fsw_core::dynamics::gyrostat::Gyrostat;
/// use fsw_core::{Inertia, Vec3};
///
/// // A body that spins about a principal axis without torque keeps its rate.
/// let body = Gyrostat::new(&Inertia::new([1.0f32, 2.0, 2.5, 0.0, 0.0, 0.0])).unwrap();
/// let acceleration = body.acceleration_rad_s2(&Vec3::z(), &Vec3::zeros(), &Vec3::zeros());
/// assert_eq!(acceleration, Vec3::zeros());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gyrostat<T: Real> {
    inertia_kg_m2: Mat<T, 3, 3>,
    inverse: Mat<T, 3, 3>,
}

crate::persist!([T: Real] Gyrostat<T> { inertia_kg_m2, inverse });

/// Derivatives of the acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobians<T: Real> {
    /// By the rate, `∂ω̇/∂ω`, 3×3, 1/s.
    pub rate: Mat<T, 3, 3>,
    /// By the six inertia elements, `∂ω̇/∂j`, 3×6, rad/s² per kg m².
    pub inertia: Mat<T, 3, 6>,
}

impl<T: Real> Gyrostat<T> {
    /// `None` where the tensor has no inverse. It need not be physical: a filter may pass through
    /// unphysical tensors.
    pub fn new(inertia: &Inertia<T>) -> Option<Self> {
        Some(Self { inertia_kg_m2: inertia.matrix_kg_m2(), inverse: inertia.inverse()? })
    }

    /// Inertia tensor `J`, kg m².
    pub fn inertia_kg_m2(&self) -> &Mat<T, 3, 3> {
        &self.inertia_kg_m2
    }

    /// Inverse `J⁻¹`, 1/(kg m²).
    pub fn inverse(&self) -> &Mat<T, 3, 3> {
        &self.inverse
    }

    /// Acceleration `ω̇ = J⁻¹ (τ − ω × (J ω + h_w))`, rad/s².
    ///
    /// `torque_n_m` is the external torque, less `ḣ_w` where the wheels accelerate.
    ///
    /// ```
    /// use fsw_core::dynamics::gyrostat::Gyrostat;
    /// use fsw_core::{Inertia, Vec3};
    ///
    /// // A wheel along z with 0.5 N m s precesses a body that turns about x at 0.1 rad/s.
    /// let body = Gyrostat::new(&Inertia::spherical(2.0f64)).unwrap();
    /// let (rate, wheel) = (Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.5));
    /// let acceleration = body.acceleration_rad_s2(&rate, &wheel, &Vec3::zeros());
    /// assert!((acceleration.y - 0.025).abs() < 1e-15); // −(ω × h_w) / J
    /// ```
    pub fn acceleration_rad_s2(
        &self,
        rate_rad_s: &Vec3<T>,
        wheel_momentum_n_m_s: &Vec3<T>,
        torque_n_m: &Vec3<T>,
    ) -> Vec3<T> {
        let momentum = self.inertia_kg_m2 * rate_rad_s + wheel_momentum_n_m_s;
        self.inverse * (torque_n_m - rate_rad_s.cross(&momentum))
    }

    /// Jacobians at a rate, an acceleration and a wheel momentum:
    ///
    /// `∂ω̇/∂ω = J⁻¹ ([J ω + h_w]^× − ω^× J)`, `∂ω̇/∂j = −J⁻¹ (G(ω̇) + ω^× G(ω))`.
    ///
    /// `acceleration_rad_s2` is the whole of `ω̇`, the reaction of the wheels included. G is the
    /// [`regressor`].
    ///
    /// Derivation: `J ω̇ = τ − ω × (J ω + h_w)`, differentiated. By the rate,
    /// `J ∂ω̇ = −∂ω × H − ω × J ∂ω = (H^× − ω^× J) ∂ω`; by the elements,
    /// `J ∂ω̇ + G(ω̇) ∂j = −ω^× G(ω) ∂j`.
    pub fn jacobians(
        &self,
        rate_rad_s: &Vec3<T>,
        acceleration_rad_s2: &Vec3<T>,
        wheel_momentum_n_m_s: &Vec3<T>,
    ) -> Jacobians<T> {
        Jacobians {
            rate: self.rate_jacobian(rate_rad_s, wheel_momentum_n_m_s),
            inertia: -(self.inverse
                * (regressor(acceleration_rad_s2) + gyroscopic_regressor(rate_rad_s))),
        }
    }

    /// Jacobian by the rate alone, `∂ω̇/∂ω = J⁻¹ ([J ω + h_w]^× − ω^× J)`, 1/s.
    pub fn rate_jacobian(
        &self,
        rate_rad_s: &Vec3<T>,
        wheel_momentum_n_m_s: &Vec3<T>,
    ) -> Mat<T, 3, 3> {
        let momentum = self.inertia_kg_m2 * rate_rad_s + wheel_momentum_n_m_s;
        self.inverse * (skew(&momentum) - skew(rate_rad_s) * self.inertia_kg_m2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Step of the central differences, for quantities near 1: truncation about h² = 1e-10,
    /// rounding about ε/h = 2e-11.
    const STEP: f64 = 1e-5;
    /// Bound on the deviation: a hundred times the truncation error.
    const TOLERANCE: f64 = 1e-8;

    fn vector() -> impl Strategy<Value = Vec3<f64>> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(Vec3::from)
    }

    proptest! {
        /// Both Jacobians against central differences, for random motion and products of inertia.
        #[test]
        fn jacobians_agree_with_finite_differences(
            rate in vector(), wheel in vector(), torque in vector(),
            products in prop::array::uniform3(-0.3..0.3f64),
        ) {
            let j = [1.5, 1.2, 1.8, products[0], products[1], products[2]];
            let acceleration = |rate: &Vec3<f64>, j: [f64; 6]| {
                Gyrostat::new(&Inertia::new(j)).unwrap().acceleration_rad_s2(rate, &wheel, &torque)
            };
            let jacobians = Gyrostat::new(&Inertia::new(j)).unwrap()
                .jacobians(&rate, &acceleration(&rate, j), &wheel);
            for i in 0..3 {
                let mut d = Vec3::zeros();
                d[i] = STEP;
                let slope = (acceleration(&(rate + d), j) - acceleration(&(rate - d), j))
                    / (2.0 * STEP);
                prop_assert!((jacobians.rate.column(i) - slope).abs().max() < TOLERANCE);
            }
            for i in 0..6 {
                let (mut up, mut down) = (j, j);
                up[i] += STEP;
                down[i] -= STEP;
                let slope = (acceleration(&rate, up) - acceleration(&rate, down)) / (2.0 * STEP);
                prop_assert!((jacobians.inertia.column(i) - slope).abs().max() < TOLERANCE);
            }
        }
    }

    #[test]
    fn a_singular_tensor_is_rejected() {
        assert!(Gyrostat::new(&Inertia::new([0.0f32; 6])).is_none());
    }
}
