//! Tensor, covariance and observed directions of a solution for shape and scale.

use crate::estimate::{Estimate, Status};
use crate::math::{Entries, Mat, Vec3, scalar::Real};
use crate::monitor::observability::observed;
use crate::prior::Prior;
use crate::tensor::Inertia;
use crate::trajectory::unknowns::Point;

/// Sigma of the inverse trace over itself above which the scale is not observed, as of any direction.
const SCALE_OBSERVED: f64 = 0.1;
/// Largest share of the inverse trace by which it may be too large: it may be that of a body twenty times as
/// heavy.
const MOST_OF_SCALE: f64 = 0.95;
/// Largest relative sigma of the trace that enters the sigma of a product: a factor of ten.
const MOST_SPREAD: f64 = 9.0;

/// Shape and scale with their information.
pub(super) struct Solution<T: Real, const U: usize> {
    pub point: Point<T, U>,
    pub unit_per_kg_m2: T,
    pub covariance: Mat<T, 6, 6>,
}

impl<T: Real, const U: usize> Solution<T, U> {
    /// Place for a solution.
    pub fn blank() -> Self {
        let point = Point::sphere(Vec3::zeros());
        Self { point, unit_per_kg_m2: T::one(), covariance: Mat::zeros() }
    }

    /// The solution with the curvature of `tr(J) = 1 / κ` in the sigma of a weakly observed scale.
    ///
    /// The data are linear in κ, and the sigma of the trace goes with `1 / κ²`: an estimate of κ that is large
    /// by its sigma s, in units of κ, reports a sigma too small by `(1 − s)²`. It is divided by that. A scale that
    /// is not observed has the sigma `1 / (κ − 3 s κ) − 1 / κ`, with 3 s up to [`MOST_OF_SCALE`]. Both as far as the scale comes
    /// from the data rather than from a prior of the elements.
    ///
    /// The sigma of an element from that of its ratio n goes with the trace t: `var(n t) = t² var(n) +
    /// n² var(t) + var(n) var(t)`. The last term is not negligible where the data know the scale, but badly.
    fn add_curvature(&mut self, alone: &Self, has_scale: bool) {
        let relative = |of: &Self| of.covariance[(5, 5)].max(T::zero()).sqrt() / of.point.scale();
        let (s, of_data) = (relative(self), relative(alone));
        let one = T::one();
        let curved = if !has_scale {
            // Nothing but the range of any body.
            one
        } else if of_data > T::lit(SCALE_OBSERVED) {
            (one / (one - (s * T::lit(3.0)).min(T::lit(MOST_OF_SCALE))) - one) / s
        } else {
            one / ((one - s) * (one - s))
        };
        let share = (s / of_data).min(one);
        let factor = one + (curved - one) * share * share;
        if factor.is_finite() {
            for i in 0..6 {
                *self.covariance.at_mut(i, 5) *= factor;
                *self.covariance.at_mut(5, i) *= factor;
            }
        }
        if has_scale && of_data > T::lit(SCALE_OBSERVED) {
            let s = relative(self).min(T::lit(MOST_SPREAD));
            let spread = one + s * s;
            for row in 0..5 {
                for column in 0..5 {
                    self.covariance[(row, column)] *= spread;
                }
            }
        }
    }

    /// Covariance of the six elements, kg² m⁴.
    #[inline(never)]
    pub fn of_elements(&self, covariance: &mut Mat<T, 6, 6>) {
        let jacobian = self.jacobian();
        // Row by row: no further matrix on the stack.
        for i in 0..6 {
            let row = jacobian.row(i) * self.covariance;
            for k in 0..6 {
                let mut sum = row[0] * jacobian[(k, 0)];
                for m in 1..6 {
                    sum += row[m] * jacobian[(k, m)];
                }
                *covariance.at_mut(i, k) = sum;
            }
        }
    }

    /// Adds the covariance to that of an estimate.
    #[inline(never)]
    pub fn add_elements(&self, estimate: &mut Estimate<T>) {
        let mut covariance = Mat::<T, 6, 6>::zeros();
        self.of_elements(&mut covariance);
        estimate.covariance_kg2_m4 += covariance;
    }

    /// Inertia and covariance, for the solution of the data alone.
    #[inline(never)]
    pub fn report(&mut self, alone: &Self, has_scale: bool, estimate: &mut Estimate<T>) {
        let trace = self.trace_kg_m2();
        estimate.inertia = Inertia::new(self.point.over_trace().map(|n| n * trace));
        self.add_curvature(alone, has_scale);
        self.of_elements(&mut estimate.covariance_kg2_m4);
    }

    /// Directions that the covariance of the data alone observes, and the status. `covariance` is overwritten.
    #[inline(never)]
    pub fn report_observed(&self, covariance: &mut Mat<T, 6, 6>, estimate: &mut Estimate<T>) {
        self.of_elements(covariance);
        let range = Prior::of_size(self.trace_kg_m2() * T::lit(1.0 / 3.0)).sigma_kg_m2;
        estimate.observed = observed(covariance, &range);
        estimate.status = Status::of(&estimate.observed);
    }

    /// Trace of the tensor, kg m².
    pub fn trace_kg_m2(&self) -> T {
        T::one() / (self.point.scale() * self.unit_per_kg_m2)
    }

    /// Derivatives of the six elements, kg m², by shape and scale.
    pub fn jacobian(&self) -> Mat<T, 6, 6> {
        let trace = self.trace_kg_m2();
        let mut jacobian = Mat::<T, 6, 6>::zeros();
        for element in 0..6 {
            for (k, by) in self.point.of_element(element, trace).into_iter().enumerate() {
                *jacobian.at_mut(element, k) = by;
            }
        }
        jacobian
    }
}
