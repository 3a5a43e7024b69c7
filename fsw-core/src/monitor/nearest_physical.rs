//! Physical tensor nearest to an unphysical estimate.
//!
//! Input: estimate `ĵ`, kg m², and its covariance P, kg² m⁴. Output: the j that minimises
//! `(j − ĵ)ᵀ P⁻¹ (j − ĵ)` among the physical tensors: well-known combinations of elements stay,
//! vague ones change.
//!
//! # Physical set
//!
//! `Σ = ½ tr(J) 1 − J = ∫ r rᵀ dm` is the second moment of the mass. `J` is physical where Σ is
//! positive semidefinite, that is `vᵀ Σ v ≥ 0` for every direction v. The set is convex. Since
//! `vᵀ Σ v = aᵀ j` is linear in j, each v defines a plane that cuts off unphysical tensors:
//!
//! `a = ½ (1 1 1 0 0 0) − (v_x² v_y² v_z² 2v_x v_y 2v_x v_z 2v_y v_z)` for a unit vector v.
//!
//! # Method
//!
//! * Cutting planes \[Kelley1960\]: each cut is along the eigenvector of the most negative
//!   eigenvalue of Σ; the planes close in on the physical set.
//! * The nearest point behind a few planes by cyclic projection \[Hildreth1957\]:
//!   `j = ĵ + P Σᵢ λᵢ aᵢ`, each `λᵢ ≥ 0` in turn such that `aᵢᵀ j = 0` or `λᵢ = 0`.
//!
//! # Limits
//!
//! Work is bounded by 24 cuts of 64 rounds each. The squared distance exceeds the smallest one by
//! less than 0.2 % (test against random physical tensors). P must be positive definite.

use crate::math::{Mat, Vec3, column, eigen::symmetric_eigen, scalar::Real};
use crate::tensor::Inertia;

/// Largest number of cuts. A tensor on the boundary needs one to three directions; the others
/// refine them.
const CUTS: usize = 24;
/// Rounds over the planes after each cut.
const ROUNDS: usize = 64;
/// Margin inside the boundary, relative to the trace. A lamina has an eigenvalue of Σ of zero; with
/// the margin, rounding cannot move the result outside.
const INSIDE: f64 = 1e-5;

/// Nearest physical tensor in the metric of `covariance` (kg² m⁴, positive definite). `None` where
/// the tensor is physical already, and where the iteration does not reach a physical one.
///
/// ```
/// use fsw_core::Inertia;
/// use fsw_core::math::Mat;
/// use fsw_core::monitor::nearest_physical::nearest_physical;
///
/// // Jzz exceeds Jxx + Jyy by 0.2 kg m².
/// let estimate = Inertia::new([1.0, 1.0, 2.2, 0.0, 0.0, 0.0f64]);
/// let nearest = nearest_physical(&estimate, &Mat::identity()).unwrap();
/// assert!(nearest.check().is_ok());
/// assert!((nearest.trace_kg_m2() - 4.2).abs() < 0.1);
/// ```
#[inline(never)]
pub fn nearest_physical<T: Real>(
    inertia: &Inertia<T>,
    covariance: &Mat<T, 6, 6>,
) -> Option<Inertia<T>> {
    if inertia.check().is_ok() {
        return None;
    }
    let size = inertia.elements_kg_m2().iter().fold(T::zero(), |max, x| max.max(x.abs()));
    let inverse_size = T::one() / size;
    let estimate = Mat::<T, 6, 1>::from(inertia.elements_kg_m2().map(|x| x * inverse_size));
    // Two products: the square of a small inertia may underflow in f32.
    let mut p = *covariance;
    p *= inverse_size;
    p *= inverse_size;
    let mut j = estimate;
    let mut planes = [Plane::none(); CUTS];
    for cut in 0..CUTS {
        let trace = j[0] + j[1] + j[2];
        let (plane, lowest) = Plane::deepest(&j, &p)?;
        if cut > 0 && lowest > T::lit(0.5 * INSIDE) * trace {
            break;
        }
        planes[cut] = plane;
        for _ in 0..ROUNDS {
            for plane in planes.iter_mut().take(cut + 1) {
                plane.push(&mut j);
            }
        }
    }
    // Remainder of the last cut: a sphere adds half of itself to each eigenvalue of Σ.
    let short = j[0] + j[1] + j[2] - largest_moment(&j) - largest_moment(&j);
    let missing = (T::lit(INSIDE) - short).max(T::zero());
    for i in 0..3 {
        j[i] += missing;
    }
    let nearest = Inertia::new(core::array::from_fn(|i| j[i] * size));
    nearest.check().is_ok().then_some(nearest)
}

/// Largest principal moment.
fn largest_moment<T: Real>(j: &Mat<T, 6, 1>) -> T {
    let [_, _, largest] = Inertia::new((*j).into()).principal_moments_kg_m2();
    largest
}

/// Plane `aᵀ j ≥ INSIDE tr(J)`. Only the direction v is stored; [`normal`] computes a from it.
#[derive(Clone, Copy)]
struct Plane<T: Real> {
    /// Direction v.
    direction: Vec3<T>,
    /// Product P a.
    pa: Mat<T, 6, 1>,
    /// Product aᵀ P a.
    apa: T,
    /// Multiplier λ.
    multiplier: T,
}

impl<T: Real> Plane<T> {
    /// Plane without effect.
    fn none() -> Self {
        let o = T::zero();
        Self { direction: Vec3::zeros(), pa: Mat::zeros(), apa: o, multiplier: o }
    }

    /// Plane of the direction in which Σ is the most negative, and the eigenvalue there. `None`
    /// where it is not finite.
    #[inline(never)]
    fn deepest(j: &Mat<T, 6, 1>, p: &Mat<T, 6, 6>) -> Option<(Self, T)> {
        let inertia = Inertia::new((*j).into());
        let (moments, axes) = symmetric_eigen(&inertia.matrix_kg_m2());
        let (mut largest, mut axis) = (moments[0], 0);
        for i in 1..3 {
            if moments[i] > largest {
                (largest, axis) = (moments[i], i);
            }
        }
        let direction = column(&axes, axis);
        let a = normal(&direction);
        let pa = p * a;
        let apa = a.dot(&pa);
        let lowest = T::lit(0.5) * inertia.trace_kg_m2() - largest;
        let is_usable = apa > T::zero() && apa.is_finite() && lowest.is_finite();
        is_usable.then_some((Self { direction, pa, apa, multiplier: T::zero() }, lowest))
    }

    /// Hildreth's step for one plane: moves j onto the plane, or back by the full earlier
    /// displacement along its normal.
    ///
    /// `λ⁺ = max(0, λ − aᵀ j / (aᵀ P a))`, `j⁺ = j + P a (λ⁺ − λ)`. \[Hildreth1957\]
    fn push(&mut self, j: &mut Mat<T, 6, 1>) {
        let wanted = self.multiplier - normal(&self.direction).dot(j) / self.apa;
        let multiplier = wanted.max(T::zero());
        *j += self.pa * (multiplier - self.multiplier);
        self.multiplier = multiplier;
    }
}

/// Normal a of the direction v, `aᵀ j = vᵀ Σ v − INSIDE tr(J)`, for a unit vector v.
fn normal<T: Real>(v: &Vec3<T>) -> Mat<T, 6, 1> {
    let (inside, two) = (T::lit(0.5) - T::lit(INSIDE), T::lit(2.0));
    Mat::<T, 6, 1>::from([
        inside - v[0] * v[0],
        inside - v[1] * v[1],
        inside - v[2] * v[2],
        -two * v[0] * v[1],
        -two * v[0] * v[2],
        -two * v[1] * v[2],
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Squared distance in the metric of the covariance.
    fn distance(a: &Inertia<f64>, b: &Inertia<f64>, covariance: &Mat<f64, 6, 6>) -> f64 {
        let difference: Mat<f64, 6, 1> =
            Mat::from_fn(|i, _| a.elements_kg_m2()[i] - b.elements_kg_m2()[i]);
        let weighted = covariance.try_inverse().unwrap() * difference;
        difference.dot(&weighted)
    }

    /// Random positive definite covariance.
    fn covariance(x: &[f64; 32]) -> Mat<f64, 6, 6> {
        let factor = Mat::<f64, 6, 6>::from_fn(|i, k| x[(6 * i + k) % 32]);
        factor * factor.transpose() * 0.01 + Mat::identity() * 0.01
    }

    /// Tensor of six random point masses: physical.
    fn physical(x: &[f64; 32]) -> Inertia<f64> {
        let mut j = Mat::<f64, 3, 3>::zeros();
        for k in 0..6 {
            let r = Vec3::new(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
            j += Mat::identity() * r.norm_squared() - r * r.transpose();
        }
        Inertia::new([j[(0, 0)], j[(1, 1)], j[(2, 2)], j[(0, 1)], j[(0, 2)], j[(1, 2)]])
    }

    proptest! {
        /// The set is convex: a point is the nearest one exactly where a step from it towards any
        /// other physical tensor increases the distance.
        #[test]
        fn no_physical_tensor_is_nearer(
            shape in prop::array::uniform32(-0.5..0.5f64),
            other in prop::array::uniform32(-0.5..0.5f64),
            off in prop::array::uniform6(-2.0..2.0f64),
        ) {
            let covariance = covariance(&other);
            let start = physical(&shape).elements_kg_m2();
            let estimate = Inertia::new(core::array::from_fn(|i| start[i] + off[i]));
            prop_assume!(estimate.check().is_err());
            let nearest = nearest_physical(&estimate, &covariance).unwrap();
            prop_assert_eq!(nearest.check(), Ok(()));
            let ours = distance(&nearest, &estimate, &covariance);
            for rival in [physical(&other), physical(&shape)] {
                for share in [1.0, 0.1, 0.01] {
                    let (a, b) = (nearest.elements_kg_m2(), rival.elements_kg_m2());
                    let between =
                        Inertia::new(core::array::from_fn(|i| a[i] + share * (b[i] - a[i])));
                    let theirs = distance(&between, &estimate, &covariance);
                    prop_assert!(theirs > ours * (1.0 - 2e-3), "{theirs} {ours}");
                }
            }
        }
    }

    /// No projection is reported.
    #[test]
    fn a_physical_tensor_is_unchanged() {
        let inertia = Inertia::new([1.0, 2.0, 2.5, 0.1, 0.0, 0.0]);
        assert_eq!(nearest_physical(&inertia, &Mat::<f64, 6, 6>::identity()), None);
    }

    /// `Jzz` exceeds the sum of the others, and only `Jyy` is vague: it alone changes.
    #[test]
    fn well_known_elements_stay() {
        let inertia = Inertia::new([1.0f32, 1.0, 2.2, 0.0, 0.0, 0.0]);
        let mut covariance = Mat::<f32, 6, 6>::identity() * 1e-8;
        covariance[(1, 1)] = 1.0;
        let [x, y, z, ..] = nearest_physical(&inertia, &covariance).unwrap().elements_kg_m2();
        assert!((x - 1.0).abs() < 1e-4 && (z - 2.2).abs() < 1e-4 && (y - 1.2).abs() < 1e-3);
    }
}
