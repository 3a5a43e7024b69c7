//! Reaction wheels: axes, spin inertias, momentum.
//!
//! Input: speeds relative to the body, rad/s. Output: momentum relative to the body, N m s, body
//! axes.
//!
//! `h_w = Σᵢ Iₛᵢ Ωᵢ aᵢ`
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `aᵢ` | unit spin axis in body axes | – |
//! | `Iₛᵢ` | moment of inertia about the spin axis | kg m² |
//! | `Ωᵢ` | speed relative to the body, positive about `aᵢ` | rad/s |
//!
//! The transverse inertia of a wheel, and its spin inertia when locked, are part of the tensor `J`.
//! An error of the spin inertias scales `h_w`, and with it the estimated tensor where no external
//! torque is known.

use crate::error::{ConfigError, Invalid};
use crate::math::{Mat, Vec3, norm, of_columns, range::not_negative, scalar::Real};

/// One number per wheel: its momentum about its own axis, N m s.
pub type Momenta<T, const W: usize> = Mat<T, W, 1>;

/// W balanced, axisymmetric wheels; zero is permitted.
///
/// ```
/// use fsw_core::{Vec3, WheelArray};
///
/// // Two wheels of 2e-3 kg m²; axes of any length.
/// let axes = [Vec3::new(0.0, 0.0, 2.0), Vec3::x()];
/// let wheels = WheelArray::new(axes, [2e-3f32; 2])?;
/// assert_eq!(wheels.momentum_n_m_s(&[100.0, -50.0]), Vec3::new(-0.1, 0.0, 0.2));
/// # Ok::<(), fsw_core::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelArray<T: Real, const W: usize> {
    /// Unit axes by columns, body axes.
    axes: Mat<T, 3, W>,
    /// Spin inertias, kg m².
    spin_inertia_kg_m2: [T; W],
}

crate::persist!([T: Real, const W: usize] WheelArray<T, W> { axes, spin_inertia_kg_m2 });

impl<T: Real, const W: usize> WheelArray<T, W> {
    /// Wheels with spin `axes` (body axes, normalised here) and `spin_inertia_kg_m2`.
    ///
    /// A spin inertia of zero stands for an unused place.
    ///
    /// # Errors
    /// `wheel.axis` of zero length or not finite; `wheel.spin_inertia_kg_m2` negative or not
    /// finite.
    pub fn new(axes: [Vec3<T>; W], spin_inertia_kg_m2: [T; W]) -> Result<Self, ConfigError> {
        let mut unit = axes;
        for i in 0..W {
            not_negative("wheel.spin_inertia_kg_m2", spin_inertia_kg_m2[i])?;
            let length = norm(&axes[i]);
            if !length.is_finite() {
                return Err(ConfigError { field: "wheel.axis", reason: Invalid::NotFinite });
            }
            if length <= T::zero() {
                return Err(ConfigError { field: "wheel.axis", reason: Invalid::ZeroAxis });
            }
            unit[i] = axes[i] * (T::one() / length);
        }
        Ok(Self { axes: of_columns(unit), spin_inertia_kg_m2 })
    }

    /// Momentum `h_w = Σᵢ Iₛᵢ Ωᵢ aᵢ`, N m s in body axes, for speeds Ω relative to the body, rad/s.
    ///
    /// With the locked wheels in `J`, total momentum is exactly `J ω + h_w`.
    pub fn momentum_n_m_s(&self, speed_rad_s: &[T; W]) -> Vec3<T> {
        self.axes * self.momenta_n_m_s(speed_rad_s)
    }

    /// Momentum of each wheel about its own axis, `Iₛᵢ Ωᵢ`, N m s, for speeds Ω relative to the body, rad/s.
    pub fn momenta_n_m_s(&self, speed_rad_s: &[T; W]) -> Momenta<T, W> {
        Momenta::from_fn(|i, _| self.spin_inertia_kg_m2[i] * speed_rad_s[i])
    }

    /// Unit axes by columns, body axes.
    pub fn axes(&self) -> &Mat<T, 3, W> {
        &self.axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Axis (0, 3, 4) of length 5, 2e-3 kg m² at 100 rad/s.
    #[test]
    fn momentum_is_along_the_axis() {
        let axis = Vec3::new(0.0, 3.0, 4.0);
        let wheels = WheelArray::new([axis], [2e-3f64]).unwrap();
        let h = wheels.momentum_n_m_s(&[100.0]);
        assert!((h - Vec3::new(0.0, 0.12, 0.16)).norm() < 1e-15);
    }

    /// A place with zero spin inertia at any speed equals an array without it, bit for bit.
    #[test]
    fn a_wheel_without_spin_inertia_adds_no_momentum() {
        let axes = [Vec3::new(0.0, 3.0, 4.0), Vec3::x()];
        let [alone, beside] = [0.0, 300.0].map(|speed| {
            let wheels = WheelArray::new(axes, [2e-3f32, 0.0]).unwrap();
            wheels.momentum_n_m_s(&[100.0, speed])
        });
        assert_eq!(alone, beside);
        let one = WheelArray::new([axes[0]], [2e-3f32]).unwrap();
        assert_eq!(alone, one.momentum_n_m_s(&[100.0]));
    }

    /// Zero axis, NaN in an axis, negative and NaN spin inertia.
    #[test]
    fn an_error_names_the_field() {
        let new = |axis, inertia| WheelArray::<f32, 1>::new([axis], [inertia]).unwrap_err();
        assert_eq!(new(Vec3::zeros(), 1.0).reason, Invalid::ZeroAxis);
        assert_eq!(new(Vec3::new(f32::NAN, 0.0, 0.0), 1.0).reason, Invalid::NotFinite);
        assert_eq!(new(Vec3::x(), -1.0).field, "wheel.spin_inertia_kg_m2");
        assert_eq!(new(Vec3::x(), f32::NAN).reason, Invalid::NotFinite);
    }
}
