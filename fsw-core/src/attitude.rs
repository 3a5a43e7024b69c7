//! Attitude of the body in inertial space, as a star tracker or attitude filter tells it.
//!
//! A unit quaternion, scalar last, that turns the *components* of a vector from inertial into
//! body axes: with rotation angle φ about the unit axis e, `q = (e sin φ/2, cos φ/2)`, and a body
//! turned by +φ about its x axis has `q₁ = +sin φ/2`. `q` and `−q` are the same attitude.

use crate::math::{Mat, scalar::Real};

/// How far the square of the norm may be from 1. Ours: 1e-3. Four elements rounded to 16 bits
/// are within 1e-4, and what is further off is no rounding.
const NORM_TOLERANCE: f64 = 1e-3;

/// `q₁ q₂ q₃ q₄` as in \[Kim2010\] Eq. (6). Any numbers: see [`to_body`](Self::to_body).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<T: Real> {
    elements: [T; 4],
}

/// Why a sample's attitude can't be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NoAttitude {
    /// The sample has none.
    Missing,
    /// An element is infinite or not a number.
    NotFinite,
    /// The norm isn't one: not a rotation, or not scaled to one.
    NotUnit,
}

impl NoAttitude {
    /// The reason in a word or two: for logs.
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

    /// Body axes along inertial axes.
    pub fn identity() -> Self {
        let o = T::zero();
        Self::new([o, o, o, T::one()])
    }

    /// `q₁ q₂ q₃ q₄`, scalar last.
    pub fn elements(&self) -> [T; 4] {
        self.elements
    }

    /// P, which turns components in inertial axes into components in body axes:
    /// \[Kim2010\] Eq. (6).
    ///
    /// Divided by the squared norm, so that rounding of the elements doesn't stretch vectors.
    ///
    /// # Errors
    /// An element isn't finite, or the squared norm is more than 1e-3 from 1.
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

    #[test]
    fn a_body_turned_about_x_sees_inertial_y_behind() {
        let half = 0.5f64 * 30.0f64.to_radians();
        let p = Quaternion::new([half.sin(), 0.0, 0.0, half.cos()]).to_body().unwrap();
        let y = p * Vec3::y();
        let (sin, cos) = 30.0f64.to_radians().sin_cos();
        assert!((y - Vec3::new(0.0, cos, -sin)).norm() < 1e-15);
    }

    #[test]
    fn what_is_no_rotation_is_refused_with_the_reason() {
        let to_body = |q: [f32; 4]| Quaternion::new(q).to_body();
        assert!(Quaternion::<f32>::identity().to_body().is_ok());
        assert_eq!(to_body([0.0; 4]), Err(NoAttitude::NotUnit));
        assert_eq!(to_body([0.0, 0.0, 0.0, 1.001]), Err(NoAttitude::NotUnit));
        assert_eq!(to_body([1e30, 0.0, 0.0, 1.0]), Err(NoAttitude::NotUnit));
        assert_eq!(to_body([f32::NAN, 0.0, 0.0, 1.0]), Err(NoAttitude::NotFinite));
        assert!(to_body([0.0, 0.0, 0.0, 1.0004]).is_ok());
    }

    proptest! {
        #[test]
        fn it_is_a_rotation_whatever_the_rounding_of_the_norm(
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
