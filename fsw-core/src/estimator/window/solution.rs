//! Tensor, covariance and observed directions of a solution for shape and scale.

use crate::estimate::{Estimate, Status};
use crate::math::{Entries, Mat, Vec3, scalar::Real};
use crate::monitor::observability::observed;
use crate::prior::Prior;
use crate::tensor::Inertia;
use crate::trajectory::unknowns::Point;

/// Sigma of the inverse trace over itself above which the scale is not observed, as of any direction.
const SCALE_OBSERVED: f64 = 0.1;
/// Sigmas by which the inverse trace of a scale that is not observed may be too large, for one sigma of the trace: exceeded by
/// chance once in 30,000.
const SIGMAS_OF_SCALE: f64 = 4.0;
/// Least inverse trace that it may have instead, over its own or that of a body of unit trace: that of one twenty times
/// as heavy.
const LEAST_OF_SCALE: f64 = 0.05;

/// Shape and scale with their information.
pub(super) struct Solution<T: Real, const U: usize> {
    pub point: Point<T, U>,
    pub unit_per_kg_m2: T,
    /// Factor of the covariance of shape and scale, upper triangular: `P = R⁻¹ R⁻ᵀ`.
    pub root: Mat<T, 6, 6>,
    /// Relative sigma of the trace that enters the sigma of a product of ratio and trace; zero where the scale is known well.
    pub spread: T,
    /// Sigma of the scale over that of the linear problem.
    pub curvature: T,
}

impl<T: Real, const U: usize> Solution<T, U> {
    /// Place for a solution.
    pub fn blank() -> Self {
        let point = Point::sphere(Vec3::zeros());
        let (one, spread) = (T::one(), T::zero());
        Self { point, unit_per_kg_m2: one, root: Mat::zeros(), spread, curvature: one }
    }

    /// The solution with the curvature of `tr(J) = 1 / κ` in the sigma of a weakly observed scale.
    ///
    /// The data are linear in κ, and the sigma of the trace goes with `1 / κ²`: an estimate of κ that is large
    /// by its sigma s, in units of κ, reports a sigma too small by `(1 − s)²`. It is divided by that. A scale that
    /// is not observed has the sigma `1 / max(κ − 4 s κ, κ₀) − 1 / κ`. κ₀ is [`LEAST_OF_SCALE`] times κ or, without a prior, the
    /// inverse trace of a body of unit trace, if that is smaller: the data permit any trace then, as without torque. Both as far
    /// as the scale comes from the data rather than from a prior of the elements.
    ///
    /// The sigma of an element from that of its ratio n goes with the trace t: `var(n t) = t² var(n) +
    /// n² var(t) + var(n) var(t)`. The last term is not negligible where the data know the scale, but badly.
    fn add_curvature(&mut self, alone: &Self, has_scale: bool, has_prior: bool) {
        let relative = |of: &Self| of.root.at(5, 5) / of.point.scale();
        let (s, of_data) = (relative(self), relative(alone));
        let one = T::one();
        let curved = if !has_scale {
            // Nothing but the range of any body.
            one
        } else if of_data > T::lit(SCALE_OBSERVED) {
            let of_unit_trace = one / (self.unit_per_kg_m2 * self.point.scale());
            let least = if has_prior { one } else { of_unit_trace.min(one) };
            let share = (one - s * T::lit(SIGMAS_OF_SCALE)).max(least * T::lit(LEAST_OF_SCALE));
            (one / share - one) / s
        } else {
            one / ((one - s) * (one - s))
        };
        let share = (s / of_data).min(one);
        let factor = one + (curved - one) * share * share;
        if factor.is_finite() {
            *self.root.at_mut(5, 5) *= factor;
            self.curvature = factor;
        }
        if has_scale && of_data > T::lit(SCALE_OBSERVED) {
            self.spread = relative(self);
        }
    }

    /// Covariance of the six elements, kg² m⁴: `A Aᵀ` with `A = J R⁻¹`, and the square of the spread times that
    /// of the shape alone.
    #[inline(never)]
    pub fn of_elements(&self, covariance: &mut Mat<T, 6, 6>) {
        let mut a = self.jacobian();
        let mut by_shape = [T::zero(); 6];
        for row in 0..6 {
            // In the place of J: R⁻¹ is upper triangular, and its last column is needed first.
            for column in (0..6).rev() {
                let by_scale = a.at(row, column) * self.root.at(column, column);
                let mut sum = T::zero();
                for k in 0..column {
                    sum += a.at(row, k) * self.root.at(k, column);
                }
                if column == 5 {
                    by_shape[row] = sum;
                }
                *a.at_mut(row, column) = sum + by_scale;
            }
        }
        let square = self.spread * self.spread;
        for i in 0..6 {
            for k in 0..i + 1 {
                let mut both = T::zero();
                for m in 0..5 {
                    both += a.at(i, m) * a.at(k, m);
                }
                let of_shape = both + by_shape[i] * by_shape[k];
                let sum = both + a.at(i, 5) * a.at(k, 5) + of_shape * square;
                *covariance.at_mut(i, k) = sum;
                *covariance.at_mut(k, i) = sum;
            }
        }
    }

    /// Inertia and covariance, for the solution of the data alone, with or without a prior of the elements.
    #[inline(never)]
    pub fn report(
        &mut self,
        alone: &Self,
        (has_scale, has_prior): (bool, bool),
        estimate: &mut Estimate<T>,
    ) {
        let trace = self.trace_kg_m2();
        estimate.inertia = Inertia::new(self.point.over_trace().map(|n| n * trace));
        self.add_curvature(alone, has_scale, has_prior);
        estimate.trace_spread = self.spread;
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Inverse trace of 200 1/(kg m²): the trace is kept. Its sigma reaches to a body of twenty times the unit trace where the
    /// inverse trace is below four of its sigmas and there is no prior.
    #[test]
    fn sigma_of_a_weak_scale_reaches_to_unit_trace() {
        let relative = |sigma: f64, has_prior: bool| {
            let solution = || {
                let mut solution = Solution::<f64, 6>::blank();
                solution.point.set_scale(200.0);
                solution.root = Mat::identity() * 1e-4;
                *solution.root.at_mut(5, 5) = sigma;
                solution
            };
            let mut estimate = Estimate::of_nothing();
            solution().report(&solution(), (true, has_prior), &mut estimate);
            let trace_kg_m2 = estimate.inertia.trace_kg_m2();
            assert!((trace_kg_m2 - 0.005).abs() < 1e-12);
            estimate.covariance_kg2_m4.fixed_view::<3, 3>(0, 0).sum().sqrt() / trace_kg_m2
        };
        for (sigma, has_prior, expected) in [
            (51.0, false, 20.0 * 200.0 - 1.0),
            (51.0, true, 19.0),
            (40.0, false, 4.0),
            (40.0, true, 4.0),
            (19.0, false, 0.095 / (0.905 * 0.905)),
        ] {
            let found = relative(sigma, has_prior);
            assert!((found / expected - 1.0).abs() < 0.01, "{sigma} {has_prior}: {found}");
        }
    }

    /// Ratios of the shape alone, whatever the trace: as with a trace that is known.
    #[test]
    fn sigma_of_a_ratio_is_that_of_the_shape() {
        let sigmas = |of_scale: f64| {
            let solution = || {
                let mut solution = Solution::<f64, 6>::blank();
                solution.point.set_shape(&[0.1, -0.05, 0.02, 0.03, -0.01]);
                solution.point.set_scale(200.0);
                solution.root =
                    Mat::from_fn(|i, k| if i <= k { 0.01 / (1 + i + k) as f64 } else { 0.0 });
                for row in 0..5 {
                    *solution.root.at_mut(row, 5) = 0.0;
                }
                *solution.root.at_mut(5, 5) = of_scale;
                solution
            };
            let mut estimate = Estimate::of_nothing();
            solution().report(&solution(), (true, false), &mut estimate);
            estimate.over_trace().1
        };
        let known = sigmas(1e-3);
        for of_scale in [30.0, 45.0, 300.0] {
            for (found, known) in sigmas(of_scale).into_iter().zip(known) {
                assert!((found / known - 1.0).abs() < 1e-6, "{of_scale}: {found} {known}");
            }
        }
    }

    proptest! {
        /// Sigmas of shape and scale over twelve decades, in `f32`: symmetric, and no eigenvalue of the correlations below
        /// rounding. With `J P Jᵀ` the fuzzer found −0.01.
        #[test]
        fn covariance_of_elements_has_no_negative_eigenvalue(
            decades in prop::array::uniform6(-6.0f32..6.0),
            off_diagonal in prop::array::uniform32(-1.0f32..1.0),
            spread in prop::sample::select(std::vec![0.0f32, 0.3, 9.0]),
        ) {
            let mut solution = Solution::<f32, 6>::blank();
            solution.spread = spread;
            solution.root = Mat::from_fn(|i, k| {
                let sigma = 10.0f32.powf(decades[k]);
                if i == k { sigma } else if i < k { sigma * off_diagonal[6 * i.min(4) + k] } else { 0.0 }
            });
            let mut covariance = Mat::zeros();
            solution.of_elements(&mut covariance);
            prop_assert_eq!(covariance, covariance.transpose());
            let covariance = covariance.map(f64::from);
            let sigmas = covariance.diagonal().map(f64::sqrt);
            let correlations =
                Mat::<f64, 6, 6>::from_fn(|i, k| covariance[(i, k)] / (sigmas[i] * sigmas[k]));
            let least = correlations.symmetric_eigenvalues().min();
            prop_assert!(least > -1e-5, "{least}");
        }
    }
}
