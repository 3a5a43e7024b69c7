//! Reaction wheels: where they point, and the momentum that their speeds mean.

use crate::error::{ConfigError, Invalid};
use crate::math::{Vec3, norm, range::not_negative, scalar::Real};

/// W balanced, axisymmetric wheels. None is fine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelArray<T: Real, const W: usize> {
    /// Spin inertia times unit axis, so that momentum is one product a wheel.
    momentum_per_speed: [Vec3<T>; W],
}

crate::persist!([T: Real, const W: usize] WheelArray<T, W> { momentum_per_speed });

impl<T: Real, const W: usize> WheelArray<T, W> {
    /// Wheels along `axes` (body axes, normalised here), of `spin_inertia_kg_m2` each. A place without
    /// a wheel has no spin inertia, and any axis.
    ///
    /// # Errors
    /// `wheel.axis` of no length or not finite, `wheel.spin_inertia_kg_m2` negative or not finite.
    pub fn new(axes: [Vec3<T>; W], spin_inertia_kg_m2: [T; W]) -> Result<Self, ConfigError> {
        let mut momentum_per_speed = [Vec3::zeros(); W];
        for i in 0..W {
            not_negative("wheel.spin_inertia_kg_m2", spin_inertia_kg_m2[i])?;
            let length = norm(&axes[i]);
            if !length.is_finite() {
                return Err(ConfigError { field: "wheel.axis", reason: Invalid::NotFinite });
            }
            if length <= T::zero() {
                return Err(ConfigError { field: "wheel.axis", reason: Invalid::ZeroAxis });
            }
            momentum_per_speed[i] = axes[i] * (spin_inertia_kg_m2[i] / length);
        }
        Ok(Self { momentum_per_speed })
    }

    /// `h_w = Σ Iₛᵢ Ωᵢ aᵢ`, N m s in body axes, for speeds Ω relative to the body, rad/s.
    ///
    /// With the locked wheels in `J`, total momentum is exactly `J ω + h_w`.
    pub fn momentum_n_m_s(&self, speed_rad_s: &[T; W]) -> Vec3<T> {
        let mut h = Vec3::zeros();
        for i in 0..W {
            h += self.momentum_per_speed[i] * speed_rad_s[i];
        }
        h
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn momentum_is_along_the_axis() {
        let axis = Vec3::new(0.0, 3.0, 4.0);
        let wheels = WheelArray::new([axis], [2e-3f64]).unwrap();
        let h = wheels.momentum_n_m_s(&[100.0]);
        assert!((h - Vec3::new(0.0, 0.12, 0.16)).norm() < 1e-15);
    }

    #[test]
    fn a_place_without_a_wheel_adds_nothing() {
        let axes = [Vec3::new(0.0, 3.0, 4.0), Vec3::x()];
        let [alone, beside] = [0.0, 300.0].map(|speed| {
            let wheels = WheelArray::new(axes, [2e-3f32, 0.0]).unwrap();
            wheels.momentum_n_m_s(&[100.0, speed])
        });
        assert_eq!(alone, beside);
        let one = WheelArray::new([axes[0]], [2e-3f32]).unwrap();
        assert_eq!(alone, one.momentum_n_m_s(&[100.0]));
    }

    #[test]
    fn names_the_field_that_is_wrong() {
        let new = |axis, inertia| WheelArray::<f32, 1>::new([axis], [inertia]).unwrap_err();
        assert_eq!(new(Vec3::zeros(), 1.0).reason, Invalid::ZeroAxis);
        assert_eq!(new(Vec3::new(f32::NAN, 0.0, 0.0), 1.0).reason, Invalid::NotFinite);
        assert_eq!(new(Vec3::x(), -1.0).field, "wheel.spin_inertia_kg_m2");
        assert_eq!(new(Vec3::x(), f32::NAN).reason, Invalid::NotFinite);
    }
}
