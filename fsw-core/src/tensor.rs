//! Inertia tensor as six elements, its regressor, and the test for a physical tensor.
//!
//! Order everywhere: `Jxx Jyy Jzz Jxy Jxz Jyz`. The first three are the moments of inertia (MOI),
//! the last three the products of inertia (POI). An off-diagonal element is the tensor entry
//! itself, `Jxy = −∫ x y dm`, as in all four papers; some simulators use the other sign.
//!
//! `J = ∫ (|r|² 1 − r rᵀ) dm`, r from the centre of mass, wheels included and locked.
//!
//! | property | condition | function |
//! |---|---|---|
//! | invertible | `det J ≠ 0` | [`Inertia::inverse`] |
//! | positive definite | leading minors positive | [`Inertia::is_positive_definite`] |
//! | physical | positive definite and `C ≤ A + B` | [`Inertia::check`], [`Inertia::is_physical`] |
//!
//! `A ≤ B ≤ C` are the principal moments. The last condition states that
//! `½ tr(J) 1 − J = ∫ r rᵀ dm`, the second moment of the mass, is positive semidefinite.

use crate::error::NotPhysical;
use crate::math::{Mat, Vec3, column, eigen::symmetric_eigen, inverse_symmetric, scalar::Real};

/// Inertia tensor about the centre of mass in body axes, kg m², wheels included and locked.
///
/// Any six numbers are accepted, since a filter passes through unphysical tensors;
/// [`check`](Self::check) states whether a rigid body has them.
///
/// ```
/// use fsw_core::Inertia;
///
/// let inertia = Inertia::new([14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016]);
/// assert!(inertia.check().is_ok());
/// assert_eq!(inertia.matrix_kg_m2()[(0, 1)], 0.0867);
/// let [smallest, _, largest] = inertia.principal_moments_kg_m2();
/// assert!(14.1 < smallest && largest < 20.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia<T: Real> {
    /// Elements `Jxx Jyy Jzz Jxy Jxz Jyz`, kg m².
    elements: [T; 6],
}

crate::persist!([T: Real] Inertia<T> { elements });

impl<T: Real> Inertia<T> {
    /// From `Jxx Jyy Jzz Jxy Jxz Jyz`, kg m². Any numbers are accepted.
    pub fn new(elements_kg_m2: [T; 6]) -> Self {
        Self { elements: elements_kg_m2 }
    }

    /// Equal moment about every axis, no products: `J = m 1`, kg m².
    pub fn spherical(moment_kg_m2: T) -> Self {
        let (m, o) = (moment_kg_m2, T::zero());
        Self::new([m, m, m, o, o, o])
    }

    /// Elements `Jxx Jyy Jzz Jxy Jxz Jyz`, kg m².
    pub fn elements_kg_m2(&self) -> [T; 6] {
        self.elements
    }

    /// Symmetric 3×3 matrix, kg m².
    pub fn matrix_kg_m2(&self) -> Mat<T, 3, 3> {
        let [xx, yy, zz, xy, xz, yz] = self.elements;
        Mat::<T, 3, 3>::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Trace `Jxx + Jyy + Jzz`, kg m²: the same in all axes.
    pub fn trace_kg_m2(&self) -> T {
        self.elements[0] + self.elements[1] + self.elements[2]
    }

    /// Inverse matrix, 1/(kg m²). `None` where the tensor is singular or not finite.
    pub fn inverse(&self) -> Option<Mat<T, 3, 3>> {
        inverse_symmetric(&self.matrix_kg_m2())
    }

    /// Positive definite by Sylvester's criterion: all leading minors are positive. Cheap enough
    /// for every step.
    #[inline(never)]
    pub fn is_positive_definite(&self) -> bool {
        // A comparison that is false for NaN.
        self.leading_minors().iter().all(|minor| *minor > T::zero())
    }

    /// Leading principal minors: determinants of the upper left 1×1, 2×2 and 3×3 blocks, in kg m²
    /// to the power of 1, 2 and 3.
    pub fn leading_minors(&self) -> [T; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.elements;
        let minor = xx * yy - xy * xy;
        let determinant = zz * minor - yz * (xx * yz - xy * xz) + xz * (xy * yz - yy * xz);
        [xx, minor, determinant]
    }

    /// Physical without an eigenproblem: `J` and `½ tr(J) 1 − J` are both positive definite.
    ///
    /// Agrees with [`check`](Self::check) but for rounding at a lamina, and is cheap enough for
    /// every step.
    ///
    /// ```
    /// use fsw_core::Inertia;
    ///
    /// assert!(Inertia::new([1.0, 2.0, 2.9, 0.0, 0.0, 0.0f32]).is_physical());
    /// assert!(!Inertia::new([1.0, 2.0, 3.1, 0.0, 0.0, 0.0f32]).is_physical());
    /// ```
    pub fn is_physical(&self) -> bool {
        let half_trace = self.trace_kg_m2() * T::lit(0.5);
        let [xx, yy, zz, xy, xz, yz] = self.elements;
        let spread = Self::new([half_trace - xx, half_trace - yy, half_trace - zz, -xy, -xz, -yz]);
        self.is_positive_definite() && spread.is_positive_definite()
    }

    /// Condition for a rigid body: positive definite, and no principal moment larger than the sum
    /// of the others. Equality, a lamina, is accepted to rounding.
    ///
    /// # Errors
    /// The violated condition.
    ///
    /// ```
    /// use fsw_core::Inertia;
    /// use fsw_core::error::NotPhysical;
    ///
    /// let lamina = Inertia::new([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
    /// assert_eq!(lamina.check(), Ok(()));
    /// let none = Inertia::new([1.0, 2.0, 3.1, 0.0, 0.0, 0.0]);
    /// assert_eq!(none.check(), Err(NotPhysical::TriangleInequality));
    /// ```
    pub fn check(&self) -> Result<(), NotPhysical> {
        if !self.elements.iter().all(|x| x.is_finite()) {
            return Err(NotPhysical::NotFinite);
        }
        let [a, b, c] = self.principal_moments_kg_m2();
        if a <= T::zero() {
            return Err(NotPhysical::NotPositiveDefinite);
        }
        // Eigenvalues are accurate to a few units in the last place of the largest.
        let rounding = c * T::EPSILON * T::lit(8.0);
        if c > a + b + rounding {
            return Err(NotPhysical::TriangleInequality);
        }
        Ok(())
    }

    /// Principal moments, kg m², ascending.
    pub fn principal_moments_kg_m2(&self) -> [T; 3] {
        self.principal().0
    }

    /// Principal moments, kg m², ascending, and the matrix whose columns are the principal axes in
    /// body axes: unit vectors, right-handed.
    ///
    /// `J = V diag(A, B, C) Vᵀ`.
    ///
    /// ```
    /// use fsw_core::Inertia;
    /// use fsw_core::math::Mat;
    ///
    /// let inertia = Inertia::new([1.5, 1.2, 1.8, 0.1, -0.2, 0.05]);
    /// let (moments, axes) = inertia.principal();
    /// let again = axes * Mat::<f64, 3, 3>::from_diagonal(&moments.into()) * axes.transpose();
    /// assert!((again - inertia.matrix_kg_m2()).abs().max() < 1e-14);
    /// ```
    pub fn principal(&self) -> ([T; 3], Mat<T, 3, 3>) {
        let (moments, axes) = symmetric_eigen(&self.matrix_kg_m2());
        let of = |i: usize| (moments[i], column(&axes, i));
        let in_order = |a: (T, Vec3<T>), b: (T, Vec3<T>)| if b.0 < a.0 { (b, a) } else { (a, b) };
        let (a, b) = in_order(of(0), of(1));
        let (b, c) = in_order(b, of(2));
        let (a, b) = in_order(a, b);
        let third = a.1.cross(&b.1);
        ([a.0, b.0, c.0], Mat::<T, 3, 3>::from_columns(&[a.1, b.1, third]))
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format> defmt::Format for Inertia<T> {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{} kg m2", self.elements);
    }
}

/// Regressor G(v), 3×6: `J v = G(v) j`, in the unit of `v`.
///
/// Serves rates (`G(ω) j` is angular momentum) and accelerations.
///
/// ```
/// use fsw_core::math::Mat;
/// use fsw_core::tensor::regressor;
/// use fsw_core::{Inertia, Vec3};
///
/// let j = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
/// let rate = Vec3::new(0.1, -0.2, 0.3);
/// let momentum = regressor(&rate) * Mat::<f64, 6, 1>::from(j);
/// assert!((momentum - Inertia::new(j).matrix_kg_m2() * rate).norm() < 1e-15);
/// ```
pub fn regressor<T: Real>(v: &Vec3<T>) -> Mat<T, 3, 6> {
    let o = T::zero();
    let (x, y, z) = (v.x, v.y, v.z);
    Mat::<T, 3, 6>::new(
        x, o, o, y, z, o, //
        o, y, o, x, o, z, //
        o, o, z, o, x, y,
    )
}

/// Expectation of the noise in the regressor's square, element by element, in units of `σ²`:
///
/// `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)`
///
/// for one vector v (rad/s or rad/s²) whose three axes are uncorrelated, of zero mean and of variance
/// σ² each. Returns the diagonal entry of `element`, 0 to 5 in the order `Jxx Jyy Jzz Jxy Jxz Jyz`.
///
/// Derivation: a column of [`regressor`] holds the components of v that the element multiplies, one
/// for a moment (`Jxx`: x) and two for a product (`Jxy`: y in the first row, x in the second), so
/// the expectation of its square is σ² or 2 σ². Two different columns share a row only with
/// different components, whose product has the expectation zero.
///
/// This is the share by which noise of a measured rate inflates the information `Σ Gᵀ G`, and so
/// pulls a least-squares solution towards zero.
pub fn regressor_noise_share<T: Real>(element: usize) -> T {
    if element < 3 { T::one() } else { T::lit(2.0) }
}

/// Regressor of the gyroscopic torque, 3×6: `ω × J ω = ω^× G(ω) j`, written out, rad²/s².
///
/// With the [`regressor`] of the acceleration it forms the matrix that \[Kim2016\] Eqs. (4), (5)
/// lost in printing: `J ω̇ + ω × J ω = [G(ω̇) + ω^× G(ω)] j`.
///
/// Row x: `(0, −yz, yz, −xz, xy, y² − z²)` for `ω = (x, y, z)`; the other rows follow by cyclic
/// permutation. Each row sums moments to zero: a sphere has no gyroscopic torque.
///
/// ```
/// use fsw_core::math::Mat;
/// use fsw_core::tensor::gyroscopic_regressor;
/// use fsw_core::{Inertia, Vec3};
///
/// let rate = Vec3::new(0.1, -0.2, 0.3);
/// let sphere = Mat::<f64, 6, 1>::from(Inertia::spherical(2.0).elements_kg_m2());
/// assert!((gyroscopic_regressor(&rate) * sphere).norm() < 1e-15);
/// ```
pub fn gyroscopic_regressor<T: Real>(rate: &Vec3<T>) -> Mat<T, 3, 6> {
    let o = T::zero();
    let (x, y, z) = (rate.x, rate.y, rate.z);
    let (xy, xz, yz) = (x * y, x * z, y * z);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    Mat::<T, 3, 6>::new(
        o,
        -yz,
        yz,
        -xz,
        xy,
        yy - zz, //
        xz,
        o,
        -xz,
        yz,
        zz - xx,
        -xy, //
        -xy,
        xy,
        o,
        xx - yy,
        -yz,
        xz,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::skew;
    use proptest::prelude::*;

    /// Elements of the satellite STSAT-3, kg m².
    const STSAT_3: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];

    proptest! {
        /// Both regressors against matrix products, for random tensors and vectors.
        #[test]
        fn regressors_are_linear_forms_of_the_tensor(
            j in prop::array::uniform6(-2.0..2.0f64), w in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let (inertia, w) = (Inertia::new(j), Vec3::from(w));
            let momentum = inertia.matrix_kg_m2() * w;
            prop_assert!((regressor(&w) * Mat::<f64, 6, 1>::from(j) - momentum).norm() < 1e-14);
            let gyroscopic = w.cross(&momentum);
            let ours = gyroscopic_regressor(&w) * Mat::<f64, 6, 1>::from(j);
            prop_assert!((ours - gyroscopic).norm() < 1e-13);
            prop_assert!((gyroscopic_regressor(&w) - skew(&w) * regressor(&w)).norm() < 1e-14);
        }

        /// The sum over v = ±σ on each axis is the expectation.
        #[test]
        fn noise_of_the_regressor_is_uncorrelated(sigma in 0.1..2.0f64) {
            let mut mean = Mat::<f64, 6, 6>::zeros();
            for signs in 0..8u32 {
                let g = regressor(&Vec3::from_fn(|i, _| {
                    if signs & (1 << i) == 0 { sigma } else { -sigma }
                }));
                mean += g.transpose() * g / 8.0;
            }
            let share = Mat::from_fn(|i, k| if i == k { regressor_noise_share(i) } else { 0.0 });
            prop_assert!((mean - share * (sigma * sigma)).abs().max() < 1e-14);
        }

        /// The tensor of any eight point masses is physical.
        #[test]
        fn a_cloud_of_masses_is_physical(
            points in prop::array::uniform8(prop::array::uniform3(-1.0..1.0f64)),
        ) {
            let mut j = Mat::<f64, 3, 3>::zeros();
            for p in points.map(Vec3::from) {
                j += Mat::identity() * p.norm_squared() - p * p.transpose();
            }
            let i = Inertia::new([j[(0, 0)], j[(1, 1)], j[(2, 2)], j[(0, 1)], j[(0, 2)], j[(1, 2)]]);
            prop_assert_eq!(i.check(), Ok(()));
            prop_assert!(i.is_positive_definite() && i.is_physical());
        }

        /// Diagonalisation, order and handedness, and agreement with the leading minors.
        #[test]
        fn principal_axes_diagonalise(j in prop::array::uniform6(-2.0..2.0f64)) {
            let inertia = Inertia::new(j);
            let (m, axes) = inertia.principal();
            let d = axes.transpose() * inertia.matrix_kg_m2() * axes;
            prop_assert!((d - Mat::<f64, 3, 3>::from_diagonal(&m.into())).abs().max() < 1e-13);
            prop_assert!(m[0] <= m[1] && m[1] <= m[2]);
            prop_assert!((axes.determinant() - 1.0).abs() < 1e-13);
            prop_assert_eq!(inertia.is_positive_definite(), m[0] > 0.0);
        }
    }

    /// Limits of both conditions, in both tests.
    #[test]
    fn physical_means_positive_and_triangular() {
        let check = |j: [f64; 6]| Inertia::new(j).check();
        assert_eq!(check(STSAT_3), Ok(()));
        assert_eq!(check([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]), Ok(()), "a lamina is the limit");
        assert_eq!(check([1.0, 2.0, 3.01, 0.0, 0.0, 0.0]), Err(NotPhysical::TriangleInequality));
        assert_eq!(check([1.0, 1.0, 1.0, 1.5, 0.0, 0.0]), Err(NotPhysical::NotPositiveDefinite));
        assert_eq!(check([f64::NAN, 1.0, 1.0, 0.0, 0.0, 0.0]), Err(NotPhysical::NotFinite));
        assert_eq!(check([0.0; 6]), Err(NotPhysical::NotPositiveDefinite));
        assert!(Inertia::new(STSAT_3).is_physical());
        assert!(!Inertia::new([1.0, 2.0, 3.01, 0.0, 0.0, 0.0]).is_physical());
        assert!(!Inertia::new([1.0, 1.0, 1.0, 1.5, 0.0, 0.0]).is_physical());
        assert!(!Inertia::new([f64::NAN, 1.0, 1.0, 0.0, 0.0, 0.0]).is_physical());
    }

    /// Equality `C = A + B` is accepted to rounding, in rotated axes.
    #[test]
    fn a_lamina_is_physical_in_single_precision_in_any_axes() {
        // 1, 2, 3 turned by an arbitrary rotation.
        let (s, c) = (0.6f32, 0.8f32);
        let r = Mat::<f32, 3, 3>::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
            * Mat::<f32, 3, 3>::new(1.0, 0.0, 0.0, 0.0, s, -c, 0.0, c, s);
        let j = r * Mat::<f32, 3, 3>::from_diagonal(&Vec3::new(1.0, 2.0, 3.0)) * r.transpose();
        let i = Inertia::new([j[(0, 0)], j[(1, 1)], j[(2, 2)], j[(0, 1)], j[(0, 2)], j[(1, 2)]]);
        assert_eq!(i.check(), Ok(()));
    }
}
