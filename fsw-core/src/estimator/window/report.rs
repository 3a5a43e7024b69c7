//! Estimate at any time: tensor, covariance, observed directions, status.
//!
//! The front's factor with all beliefs gives shape and scale with their covariance, the tensor `J = n / κ`
//! and its covariance follow to first order. What is observed is judged against the data alone: the same
//! solution without the prior, with nothing but the ranges of any rigid body.

use super::Window;
use super::belief::Beliefs;
use super::front::Front;
use super::pass::{Pass, Residuals};
use super::unknowns::{Belief, FIRST_GROUP, Group, Point, by_shape, groups_of};
use crate::estimate::{Estimate, Status};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Entries, Mat, Vec3, scalar::Real};
use crate::monitor::nearest_physical::nearest_physical;
use crate::monitor::observability::observed;
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Excess of the residuals over the noise that is still called white, and the number of sigmas of its
/// sampling error `1 / √(2 · 3 · blocks)`.
const WHITE_EXCESS: f64 = 0.05;
const WHITE_EXCESS_SIGMA: f64 = 5.4;
/// The same of the correlation from block to block, with the sampling error `1 / √(3 · blocks)`. A
/// correlation of 0.1 makes the sigma 10 % too small.
const CORRELATED: f64 = 0.1;
const CORRELATED_SIGMA: f64 = 4.0;
/// Largest correlation that enters the inflation.
const MOST_CORRELATED: f64 = 0.97;
/// Contradiction of an assumed absence of torque: chi-square of three degrees of freedom exceeds it once
/// in 150 windows.
const TORQUE_SHOWN: f64 = 12.2;
/// Degrees of freedom that the stated noise weighs, and the measured one, against the residuals.
const STATED_DEGREES: f64 = 30.0;
const MEASURED_DEGREES: f64 = 10.0;
/// Fewest residuals that are tested.
const ENOUGH_ROWS: u32 = 30;
/// Sigma of the inverse trace over itself above which the scale is not observed, as of any direction.
const SCALE_OBSERVED: f64 = 0.1;
/// The same above which the data know nothing of the scale: near the range of any body, 2.3.
const NO_SCALE: f64 = 1.5;
/// Sigma of a torque or bias over its range, below which it is reported.
const SEEN: f64 = 0.5;

/// Statistics of windows that ended.
#[derive(Clone, Copy, Debug)]
pub struct Ended<T> {
    residual_rms_rad_s: T,
    residuals_white: Option<bool>,
    is_explained: bool,
}

crate::persist!([T: Real] Ended<T> { residual_rms_rad_s, residuals_white, is_explained });

impl<T: Real> Ended<T> {
    /// No window has ended.
    pub fn nothing() -> Self {
        Self { residual_rms_rad_s: T::zero(), residuals_white: None, is_explained: true }
    }
}

/// Adds the rounding of each element to its variance; false where a number is not finite.
#[inline(never)]
fn is_finite_with_floor<T: Real>(estimate: &mut Estimate<T>) -> bool {
    let elements = estimate.inertia.elements_kg_m2();
    let covariance = &mut estimate.covariance_kg2_m4;
    for i in 0..6 {
        let rounded = elements[i] * T::EPSILON;
        *covariance.at_mut(i, i) *= T::one() + T::EPSILON * T::lit(16.0);
        *covariance.at_mut(i, i) += rounded * rounded;
    }
    elements.iter().all(|x| x.is_finite()) && covariance.iter().all(|x| x.is_finite())
}

/// Brings the tensor to the nearest physical one.
#[inline(never)]
fn bring_to_nearest_physical<T: Real>(estimate: &mut Estimate<T>) {
    if let Some(nearest) = nearest_physical(&estimate.inertia, &estimate.covariance_kg2_m4) {
        estimate.inertia = nearest;
        estimate.projected = true;
    }
}

/// Shape and scale with their information.
struct Solution<T: Real> {
    point: Point<T>,
    unit_per_kg_m2: T,
    covariance: Mat<T, 6, 6>,
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// The estimate.
    #[inline(never)]
    pub(super) fn report(&self) -> Estimate<T> {
        let mut estimate = Estimate::of_nothing();
        let is_found = match &self.front {
            Some(front) => self.report_front(front, &mut estimate),
            None => self.past.is_some() && self.report_past(&mut estimate),
        };
        if is_found {
            bring_to_nearest_physical(&mut estimate);
        } else {
            self.report_nothing(&mut estimate);
        }
        estimate
    }

    /// Estimate of the front; false where it has no finite solution.
    #[inline(never)]
    fn report_front(&self, front: &Front<T, U>, estimate: &mut Estimate<T>) -> bool {
        let pass = &front.pass;
        let (window, sigma) = self.window_alone(pass);
        let unit = pass.unit_per_kg_m2;
        if !self.report_inertia(&window, &pass.point, unit, sigma, estimate) {
            return false;
        }
        estimate.residual_rms_rad_s = rms(&pass.residuals, U);
        estimate.residuals_white = self.is_white(front);
        self.report_groups(pass, sigma, estimate);
        if !self.is_good(front) {
            estimate.status = Status::Diverged;
        }
        true
    }

    /// Estimate of earlier windows; false where it is not finite.
    #[inline(never)]
    fn report_past(&self, estimate: &mut Estimate<T>) -> bool {
        let Some(past) = &self.past else { return false };
        let mut point = Point::sphere(Vec3::zeros());
        point.shape = past.shape;
        // The past enters as a belief: there are no blocks.
        let nothing = SquareRootInformation::default();
        let unit = past.per_kg_m2;
        if !self.report_inertia(&nothing, &point, unit, T::one(), estimate) {
            return false;
        }
        estimate.residual_rms_rad_s = self.ended.residual_rms_rad_s;
        estimate.residuals_white = self.ended.residuals_white;
        if !self.ended.is_explained {
            estimate.status = Status::Diverged;
        }
        true
    }

    /// Prior where nothing has been found.
    #[inline(never)]
    fn report_nothing(&self, estimate: &mut Estimate<T>) {
        let prior = self.config.prior.filter(|_| self.has_prior).unwrap_or(Prior::unknown());
        *estimate = Estimate::of_nothing();
        estimate.inertia = Inertia::new(prior.inertia_kg_m2);
        for i in 0..6 {
            *estimate.covariance_kg2_m4.at_mut(i, i) = prior.sigma_kg_m2[i] * prior.sigma_kg_m2[i];
        }
    }

    /// Inertia, covariance, observed directions and status of information on shape and scale.
    fn report_inertia(
        &self,
        window: &SquareRootInformation<T, 6>,
        point: &Point<T>,
        unit_per_kg_m2: T,
        sigma: T,
        estimate: &mut Estimate<T>,
    ) -> bool {
        let mut walked = self.past;
        if let Some(past) = &mut walked {
            past.walk(self.walk_kg_m2());
        }
        let past = walked.as_ref();
        let all = Beliefs { past, noise_rad_s: sigma, ..self.beliefs(unit_per_kg_m2) };
        let data = Beliefs { prior: None, ..all };
        let (mut solution, mut alone) = (Solution::blank(), Solution::blank());
        if !solve(window, point, &all, &mut solution) || !solve(window, point, &data, &mut alone) {
            return false;
        }
        let trace = T::one() / (solution.point.scale * unit_per_kg_m2);
        let n = solution.point.over_trace();
        estimate.inertia = Inertia::new(n.map(|n| n * trace));
        solution.add_curvature(&alone);
        solution.of_elements(&mut estimate.covariance_kg2_m4);
        if !is_finite_with_floor(estimate) {
            return false;
        }
        // At the estimate, with the information of the data.
        alone.point = solution.point;
        let range = Prior::of_size(trace * T::lit(1.0 / 3.0)).sigma_kg_m2;
        // In the place of a covariance that is no longer needed.
        alone.of_elements(&mut solution.covariance);
        estimate.observed = observed(&solution.covariance, &range);
        estimate.status = Status::of(&estimate.observed);
        true
    }

    /// Torque and bias where the data determine them.
    #[inline(never)]
    fn report_groups(&self, pass: &Pass<T, U>, sigma: T, estimate: &mut Estimate<T>) {
        if self.groups.place.iter().all(|at| !matches!(at, Some((_, Belief::Within(_))))) {
            return;
        }
        let unit = pass.unit_per_kg_m2;
        let mut factor = pass.factor;
        let beliefs = Beliefs { noise_rad_s: sigma, ..self.beliefs(unit) };
        beliefs.add(&mut factor, &pass.point);
        let (Some(step), Some(variances)) = (factor.solve(), factor.variances()) else { return };
        let solved = pass.point.stepped(&step);
        let trace = T::one() / (solved.scale * unit);
        for place in 0..groups_of(U) {
            let Some((group, Belief::Within(range))) = self.groups.place[place] else { continue };
            let to_physical = if group == Group::Torque { trace } else { T::one() };
            let most = range * T::lit(SEEN) / (to_physical * sigma);
            let first = FIRST_GROUP + 3 * place;
            if !variances.iter().skip(first).take(3).all(|v| *v < most * most) {
                continue;
            }
            let value = solved.group[place] * to_physical;
            match group {
                // An inertia that is not observed is free to imitate a torque.
                Group::Torque if estimate.observed.directions == 6 => {
                    estimate.disturbance_torque_n_m = Some(value);
                }
                Group::Bias if self.config.gyro_bias_rad_s.is_some() => {
                    estimate.gyro_bias_rad_s = Some(value);
                }
                _ => {}
            }
        }
    }

    /// Random walk of each element since the past was current, one sigma, kg m².
    pub(super) fn walk_kg_m2(&self) -> T {
        self.config.inertia_walk_kg_m2_sqrt_s * self.past_age_s.max(T::zero()).sqrt()
    }

    /// One sigma of a sample for the covariance, rad/s: stated or measured noise and residuals, weighted by
    /// their degrees of freedom; larger by `√((1 + ρ) / (1 − ρ))` where the residuals are correlated by ρ from
    /// block to block, so that fewer of them are independent;
    /// and by the distance to the minimum that rounding leaves.
    pub(super) fn sigma_of_sample(&self, pass: &Pass<T, U>) -> T {
        let residuals = &pass.residuals;
        let unsettled = T::one() + pass.decrement / T::count(U as u32);
        let noise = self.noise_rad_s();
        let weight = match self.config.gyro_noise_rad_s {
            Some(_) => T::lit(STATED_DEGREES),
            None => T::lit(MEASURED_DEGREES),
        };
        let degrees = T::count(residuals.degrees(U as u32));
        let variance = (noise * noise * weight + residuals.squares) / (weight + degrees);
        let rho = residuals.correlation().min(T::lit(MOST_CORRELATED));
        let inflation = if rho > correlation_limit(residuals) {
            (T::one() + rho) / (T::one() - rho)
        } else {
            T::one()
        };
        (variance * inflation * unsettled)
            .sqrt()
            .max(self.largest_rad_s * (T::EPSILON + T::EPSILON))
    }

    /// Result of the tests for white residuals: of their size against the noise, of their correlation,
    /// and of a torque that is not among the unknowns.
    fn is_white(&self, front: &Front<T, U>) -> Option<bool> {
        let residuals = &front.pass.residuals;
        if residuals.rows < ENOUGH_ROWS {
            return None;
        }
        let share = T::lit(WHITE_EXCESS_SIGMA) / (T::count(residuals.blocks) * T::lit(6.0)).sqrt();
        let most = self.reference_rad_s() * (T::lit(1.0 + WHITE_EXCESS) + share);
        let is_small = rms(residuals, U) <= most;
        let is_correlated = residuals.correlation().abs() > correlation_limit(residuals);
        let mut factor = front.pass.factor;
        let beliefs = self.beliefs(front.pass.unit_per_kg_m2);
        let contradiction = beliefs.add(&mut factor, &front.pass.point);
        let shows_torque = contradiction.iter().any(|x| *x > T::lit(TORQUE_SHOWN));
        let is_suspect = self.schedule.blocks < self.suspect_until;
        Some(is_small && !is_correlated && !shows_torque && front.is_settled && !is_suspect)
    }

    /// Statistics of a window that ends with this front.
    pub(super) fn ended_with(&self, front: &Front<T, U>) -> Ended<T> {
        Ended {
            residual_rms_rad_s: rms(&front.pass.residuals, U),
            residuals_white: self.is_white(front),
            is_explained: self.is_good(front),
        }
    }
}

/// Root mean square of the residuals of a sample, one axis, rad/s.
pub(super) fn rms<T: Real>(residuals: &Residuals<T>, unknowns: usize) -> T {
    (residuals.squares / T::count(residuals.degrees(unknowns as u32).max(1))).sqrt()
}

/// Correlation from block to block that chance and a harmless one explain.
fn correlation_limit<T: Real>(residuals: &Residuals<T>) -> T {
    T::lit(CORRELATED) + T::lit(CORRELATED_SIGMA) / T::count(residuals.rows.max(1)).sqrt()
}

/// Solution of a window's information with beliefs, at the beliefs' noise; false where there is none.
#[inline(never)]
fn solve<T: Real>(
    window: &SquareRootInformation<T, 6>,
    point: &Point<T>,
    beliefs: &Beliefs<'_, T>,
    solution: &mut Solution<T>,
) -> bool {
    let mut factor = *window;
    beliefs.add_inertia(&mut factor, point);
    let Some(step) = factor.solve() else { return false };
    if !factor.covariance_of_last(&mut solution.covariance) {
        return false;
    }
    solution.covariance *= beliefs.noise_rad_s;
    solution.covariance *= beliefs.noise_rad_s;
    solution.point = point.stepped(&step);
    solution.unit_per_kg_m2 = beliefs.unit_per_kg_m2;
    true
}

impl<T: Real> Solution<T> {
    /// Place for a solution.
    fn blank() -> Self {
        let point = Point::sphere(Vec3::zeros());
        Self { point, unit_per_kg_m2: T::one(), covariance: Mat::zeros() }
    }

    /// The solution with the curvature of `tr(J) = 1 / κ` in the sigma of a weakly observed scale.
    ///
    /// The data are linear in κ, and the sigma of the trace goes with `1 / κ²`: an estimate of κ that is large
    /// by its sigma s, in units of κ, reports a sigma too small by `(1 − s)²`. It is divided by that. A scale that
    /// is not observed has the sigma `1 / (κ − 3 s κ) − 1 / κ`, with 3 s up to 0.9. Both as far as the scale comes
    /// from the data rather than from a prior of the elements.
    fn add_curvature(&mut self, alone: &Self) {
        let relative = |of: &Self| of.covariance.at(5, 5).max(T::zero()).sqrt() / of.point.scale;
        let (s, of_data) = (relative(self), relative(alone));
        let one = T::one();
        let curved = if of_data > T::lit(NO_SCALE) {
            // Nothing but the range of any body.
            one
        } else if of_data > T::lit(SCALE_OBSERVED) {
            (one / (one - (s * T::lit(3.0)).min(T::lit(0.9))) - one) / s
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
    }

    /// Covariance of the six elements, kg² m⁴, by `∂j/∂q = B / κ` and `∂j/∂x = −j / x`.
    #[inline(never)]
    fn of_elements(&self, covariance: &mut Mat<T, 6, 6>) {
        let trace = T::one() / (self.point.scale * self.unit_per_kg_m2);
        let n = self.point.over_trace();
        let mut jacobian = Mat::<T, 6, 6>::zeros();
        for element in 0..6 {
            let mut of_element = [T::zero(); 6];
            of_element[element] = trace;
            let by = by_shape::<T, T>(&of_element);
            for k in 0..5 {
                *jacobian.at_mut(element, k) = by[k];
            }
            *jacobian.at_mut(element, 5) = -n[element] * trace / self.point.scale;
        }
        *covariance = jacobian * self.covariance * jacobian.transpose();
    }
}
