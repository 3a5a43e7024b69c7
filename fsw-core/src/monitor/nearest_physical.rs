//! The physical tensor nearest to an estimate that no body has.
//!
//! `j` is physical where `Σ = ½ tr(J) 1 − J` is positive semidefinite, that is where `vᵀ Σ v ≥ 0` for
//! every direction v. Sought is the one that minimises `(j − ĵ)ᵀ P⁻¹ (j − ĵ)`, with P the estimate's
//! own covariance: what is known well stays, what is vague gives way.
//!
//! `vᵀ Σ v = aᵀ j` is linear in j, so each v makes a plane that cuts the unphysical away. Cut by cut,
//! each along the eigenvector of the most negative eigenvalue, the set of planes closes in on the
//! physical set (Kelley, J. SIAM 8, 1960); the nearest point behind a few planes is found by going
//! round them (Hildreth, Naval Res. Logist. Q. 4, 1957):
//! `j = ĵ + P Σᵢ λᵢ aᵢ`, each `λᵢ ≥ 0` in turn such that `aᵢᵀ j = 0` or `λᵢ = 0`.

use crate::math::{Mat, Vec3, column, eigen::symmetric_eigen, scalar::Real};
use crate::tensor::Inertia;

/// Cuts at most. A tensor on the boundary needs one to three directions; the others are refinements
/// of them.
const CUTS: usize = 24;
/// Rounds over the planes for each cut.
const ROUNDS: usize = 64;
/// A lamina has an eigenvalue of Σ of zero. Inside by this share of the trace, and cut until no
/// eigenvalue is outside at all: rounding then doesn't matter.
const INSIDE: f64 = 1e-5;

/// The nearest physical tensor in the metric of `covariance` (kg² m⁴, positive definite), or `None`
/// where the tensor is physical already, or nothing near it is.
#[inline(never)]
pub fn nearest_physical<T: Real>(
    inertia: &Inertia<T>,
    covariance: &Mat<T, 6, 6>,
) -> Option<Inertia<T>> {
    if inertia.check().is_ok() {
        return None;
    }
    let size = inertia.elements_kg_m2().iter().fold(T::zero(), |max, x| max.max(x.abs()));
    let per = T::one() / size;
    let estimate = Mat::<T, 6, 1>::from(inertia.elements_kg_m2().map(|x| x * per));
    // Scaled one after the other: the square of a small inertia may underflow in f32.
    let mut p = *covariance;
    p *= per;
    p *= per;
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
    // What the last cut leaves: a sphere adds half of itself to each eigenvalue of Σ.
    let short = j[0] + j[1] + j[2] - largest_moment(&j) - largest_moment(&j);
    let missing = (T::lit(INSIDE) - short).max(T::zero());
    for i in 0..3 {
        j[i] += missing;
    }
    let nearest = Inertia::new(core::array::from_fn(|i| j[i] * size));
    nearest.check().is_ok().then_some(nearest)
}

fn largest_moment<T: Real>(j: &Mat<T, 6, 1>) -> T {
    let [_, _, largest] = Inertia::new((*j).into()).principal_moments_kg_m2();
    largest
}

/// `aᵀ j ≥ INSIDE tr(J)`. Of a, which half as many numbers make, only those are kept.
#[derive(Clone, Copy)]
struct Plane<T: Real> {
    /// The direction, v.
    direction: Vec3<T>,
    /// P a, and aᵀ P a.
    pa: Mat<T, 6, 1>,
    apa: T,
    /// λ.
    multiplier: T,
}

impl<T: Real> Plane<T> {
    /// No plane.
    fn none() -> Self {
        let o = T::zero();
        Self { direction: Vec3::zeros(), pa: Mat::zeros(), apa: o, multiplier: o }
    }

    /// Of the direction in which Σ is the most negative, with its eigenvalue there.
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

    /// Moves j onto the plane, or as far back as it was pushed by this plane before.
    fn push(&mut self, j: &mut Mat<T, 6, 1>) {
        let wanted = self.multiplier - normal(&self.direction).dot(j) / self.apa;
        let multiplier = wanted.max(T::zero());
        *j += self.pa * (multiplier - self.multiplier);
        self.multiplier = multiplier;
    }
}

/// a, of the direction v.
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

    fn distance(a: &Inertia<f64>, b: &Inertia<f64>, covariance: &Mat<f64, 6, 6>) -> f64 {
        let difference: Mat<f64, 6, 1> =
            Mat::from_fn(|i, _| a.elements_kg_m2()[i] - b.elements_kg_m2()[i]);
        let weighted = covariance.try_inverse().unwrap() * difference;
        difference.dot(&weighted)
    }

    fn covariance(x: &[f64; 32]) -> Mat<f64, 6, 6> {
        let factor = Mat::<f64, 6, 6>::from_fn(|i, k| x[(6 * i + k) % 32]);
        factor * factor.transpose() * 0.01 + Mat::identity() * 0.01
    }

    /// Any tensor of masses: physical.
    fn physical(x: &[f64; 32]) -> Inertia<f64> {
        let mut j = Mat::<f64, 3, 3>::zeros();
        for k in 0..6 {
            let r = Vec3::new(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
            j += Mat::identity() * r.norm_squared() - r * r.transpose();
        }
        Inertia::new([j[(0, 0)], j[(1, 1)], j[(2, 2)], j[(0, 1)], j[(0, 2)], j[(1, 2)]])
    }

    proptest! {
        /// The set is convex: the projection is the nearest point if and only if from there every
        /// other physical tensor lies on the far side of the plane through it.
        #[test]
        fn nothing_physical_is_nearer(
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

    #[test]
    fn what_is_physical_stays_as_it_is() {
        let inertia = Inertia::new([1.0, 2.0, 2.5, 0.1, 0.0, 0.0]);
        assert_eq!(nearest_physical(&inertia, &Mat::<f64, 6, 6>::identity()), None);
    }

    #[test]
    fn what_is_known_well_stays() {
        // Jzz exceeds the sum of the others; only Jyy is vague.
        let inertia = Inertia::new([1.0f32, 1.0, 2.2, 0.0, 0.0, 0.0]);
        let mut covariance = Mat::<f32, 6, 6>::identity() * 1e-8;
        covariance[(1, 1)] = 1.0;
        let [x, y, z, ..] = nearest_physical(&inertia, &covariance).unwrap().elements_kg_m2();
        assert!((x - 1.0).abs() < 1e-4 && (z - 2.2).abs() < 1e-4 && (y - 1.2).abs() < 1e-3);
    }
}
