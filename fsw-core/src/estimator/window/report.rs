//! Estimate at any time: tensor, covariance, observed directions, status.
//!
//! The front's factor with all beliefs gives shape and scale with their covariance, the tensor `J = n / κ`
//! and its covariance follow to first order. What is observed is judged against the data alone: the same
//! solution without the prior, with nothing but the ranges of any rigid body.

use super::Window;
use super::considered::Source;
use super::solution::Solution;
use crate::estimate::{Estimate, Status};
use crate::fit::belief::{Beliefs, Past, RARE, information_on};
use crate::fit::front::Front;
use crate::fit::pass::Pass;
use crate::hardware::{Finding, Parameter, turned_by};
use crate::math::square_root_information::{SquareRootInformation, unit_row};
use crate::math::{Entries, Mat, scalar::Real};
use crate::monitor::nearest_physical::nearest_physical;
use crate::monitor::observability::Observed;
use crate::monitor::residuals::{ROOT_OF_LAGS, Residuals};
use crate::monitor::whiteness::{
    ENOUGH_ROWS, chi_square, largest_correlation, largest_line, largest_rms,
};
use crate::prior::Prior;
use crate::tensor::Inertia;
use crate::trajectory::unknowns::{
    Belief, FIRST_GROUP, Group, Point, groups_of, may_hold_all_axes, shape_of,
};

/// Largest correlation that enters the inflation.
const MOST_CORRELATED: f64 = 0.97;
/// Contradiction of an assumed absence of torque: chi-square x of three degrees of freedom, tested after each block. Of
/// sums of n₀ = 8 to n = 512 blocks chance exceeds it at least once with the probability
/// `x √(x / 2π) e^(−x/2) ((1 − 3/x) ln(n/n₀) + 2/x)` \[Siegmund1985\]: in one of 1,000 windows, as the other tests of whiteness.
const TORQUE_SHOWN: f64 = 24.2;
/// Degrees of freedom that the stated noise weighs, and the measured one, against the residuals.
const STATED_DEGREES: f64 = 30.0;
const MEASURED_DEGREES: f64 = 10.0;
/// Information that pins a parameter to its value, over all that is known of it: 0.1 % of its variance is left.
const KNOWN: f64 = 1e3;
/// Unknowns beside the groups: three of momentum, six of inertia.
const MOMENTUM_AND_INERTIA: u32 = 9;
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

    /// True where no test has found the residuals of the last one other than white.
    pub fn is_white(&self) -> bool {
        self.residuals_white != Some(false)
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

/// Leaves what both have observed.
fn restrict(observed: &mut Observed, of_fit: &Observed) {
    observed.directions = observed.directions.min(of_fit.directions);
    observed.scale &= of_fit.scale;
    for (element, of_fit) in observed.element.iter_mut().zip(&of_fit.element) {
        *element &= of_fit;
    }
}

/// Brings the tensor to the nearest physical one.
#[inline(never)]
fn bring_to_nearest_physical<T: Real>(estimate: &mut Estimate<T>) {
    if let Some(nearest) = nearest_physical(&estimate.inertia, &estimate.covariance_kg2_m4) {
        estimate.inertia = nearest;
        estimate.projected = true;
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// The estimate, in its place.
    #[inline(never)]
    pub(super) fn report(&self, estimate: &mut Estimate<T>) {
        let is_found = match &self.front {
            Some(front) => self.report_front(front, estimate),
            None => self.report_past(estimate),
        };
        if is_found {
            bring_to_nearest_physical(estimate);
            estimate.limit_status();
        } else {
            self.report_nothing(estimate);
        }
    }

    /// Estimate of the front; false where it has no finite solution.
    #[inline(never)]
    fn report_front(&self, front: &Front<T, W, U, M>, estimate: &mut Estimate<T>) -> bool {
        let pass = &front.pass;
        if !self.report_pass(pass, Source::Front, estimate) {
            return false;
        }
        restrict(&mut estimate.observed, &front.observed);
        // A weakly excited shape has a flat minimum, or none within the physical tensors: no error of the model.
        let is_flat = !front.is_settled && self.is_good(pass, true);
        if is_flat {
            estimate.observed = Observed::default();
        }
        estimate.status = Status::of(&estimate.observed);
        estimate.residual_rms_rad_s = rms(&pass.residuals, self.unknowns());
        // Until the doubt is resolved, a fault that goes on may be all that the window contains.
        estimate.residuals_white = if self.is_doubtful || self.steadiness.is_contradicted() {
            Some(false)
        } else {
            self.is_white(pass, front.is_settled || is_flat)
        };
        self.report_groups(pass, estimate);
        if !self.is_good(pass, true) {
            estimate.status = Status::Diverged;
        }
        if self.is_doubtful && estimate.status != Status::Converged {
            self.report_doubted(estimate);
        }
        true
    }

    /// Inertia of what is doubted, where the data since then do not determine it: the status is `Diverged`, since these
    /// are not explained by it.
    #[inline(never)]
    fn report_doubted(&self, estimate: &mut Estimate<T>) {
        let Some(doubted) = &self.doubted else { return };
        let mut earlier = Estimate::of_nothing();
        if self.report_past_alone(doubted, &mut earlier) {
            earlier.status = Status::Diverged;
            earlier.residuals_white = Some(false);
            earlier.residual_rms_rad_s = estimate.residual_rms_rad_s;
            *estimate = earlier;
        }
    }

    /// Directions that a fit observes, with earlier windows.
    #[inline(never)]
    pub(super) fn observed_by(&self, pass: &Pass<T, W, U, M>) -> Observed {
        let mut estimate = Estimate::of_nothing();
        self.report_pass(pass, Source::Descent, &mut estimate);
        estimate.observed
    }

    /// Inertia of a pass with earlier windows; false where it has no finite solution.
    #[inline(never)]
    fn report_pass(&self, pass: &Pass<T, W, U, M>, of: Source, estimate: &mut Estimate<T>) -> bool {
        let sigma = self.sigma_of_sample(pass);
        let at = (&pass.point, pass.unit_per_kg_m2);
        self.report_inertia(Some(pass), at, (sigma, of), self.past_beside(), estimate)
    }

    /// Estimate of earlier windows; false where it is not finite.
    #[inline(never)]
    fn report_past(&self, estimate: &mut Estimate<T>) -> bool {
        let Some(past) = self.past.as_ref().or(self.doubted.as_ref().filter(|_| self.is_doubtful))
        else {
            return false;
        };
        if !self.report_past_alone(past, estimate) {
            return false;
        }
        estimate.residual_rms_rad_s = self.ended.residual_rms_rad_s;
        estimate.residuals_white =
            if self.is_doubtful { Some(false) } else { self.ended.residuals_white };
        if !self.ended.is_explained {
            estimate.status = Status::Diverged;
        }
        true
    }

    /// Inertia of earlier windows; false where it has no finite solution.
    #[inline(never)]
    fn report_past_alone(&self, past: &Past<T, U>, estimate: &mut Estimate<T>) -> bool {
        // The past enters as a belief: there are no blocks.
        let (at, of) = ((&past.point, past.per_kg_m2), (T::one(), Source::Nothing));
        self.report_inertia(None, at, of, Some(past), estimate)
    }

    /// Prior where nothing has been found.
    #[inline(never)]
    fn report_nothing(&self, estimate: &mut Estimate<T>) {
        let prior = self.prior.unwrap_or(Prior::unknown());
        *estimate = Estimate::of_nothing();
        estimate.inertia = Inertia::new(prior.inertia_kg_m2);
        for i in 0..6 {
            *estimate.covariance_kg2_m4.at_mut(i, i) = prior.sigma_kg_m2[i] * prior.sigma_kg_m2[i];
        }
    }

    /// Inertia, covariance, observed directions and status of information on shape and scale, about a point and for a
    /// unit of its scale, with a sigma of a sample, rad/s.
    #[inline(never)]
    fn report_inertia(
        &self,
        blocks: Option<&Pass<T, W, U, M>>,
        (point, unit_per_kg_m2): (&Point<T, U>, T),
        (sigma, source): (T, Source),
        past: Option<&Past<T, U>>,
        estimate: &mut Estimate<T>,
    ) -> bool {
        let all = Beliefs { past, noise_rad_s: sigma, ..self.beliefs(unit_per_kg_m2) };
        let data = Beliefs { prior: None, ..all };
        let (mut solution, mut alone) = (Solution::blank(), Solution::blank());
        let is_found = self.solve(blocks, point, &all, &mut solution)
            && self.solve(blocks, point, &data, &mut alone);
        if !is_found {
            return false;
        }
        let beyond = self.beyond_stated(&solution.point);
        solution.root *= beyond;
        alone.root *= beyond;
        let systematic = self.systematic(source, sigma, &solution);
        let has_scale = past.is_some() || self.stretch().has_drive();
        solution.report(&alone, (has_scale, all.prior.is_some()), estimate);
        let is_considered = self.config.hardware.mount_rad != [T::zero(); 3]
            || self.config.considered_scale() > T::zero();
        let has_hardware = groups_of(U) > 0 && self.groups.has_hardware() || systematic.is_some();
        if has_hardware || is_considered {
            self.report_random(blocks, point, &all, &mut solution, estimate);
        }
        if let Some(systematic) = systematic {
            // An error of a ratio enters its product with a trace that may be known badly.
            estimate.covariance_kg2_m4 += systematic * estimate.spread_of_variance();
        }
        if is_considered {
            self.add_considered(estimate);
        }
        // Last: beside a large common error the rounding of the sum exceeds small variances.
        if !is_finite_with_floor(estimate) {
            return false;
        }
        // At the estimate, with the information of the data.
        alone.point = solution.point;
        // In the place of a factor that is no longer needed.
        alone.report_observed(&mut solution.root, estimate);
        true
    }

    /// Solution of the information of blocks with beliefs, at the beliefs' noise; false where there is none.
    #[inline(never)]
    fn solve(
        &self,
        blocks: Option<&Pass<T, W, U, M>>,
        point: &Point<T, U>,
        beliefs: &Beliefs<'_, T, U>,
        solution: &mut Solution<T, U>,
    ) -> bool {
        let mut factor = SquareRootInformation::default();
        self.write_blocks(blocks, &mut factor);
        beliefs.add_kept(&mut factor, point);
        let Some(step) = factor.solve() else { return false };
        if !factor.covariance_factor_of_last(&mut solution.root) {
            return false;
        }
        solution.root *= beliefs.noise_rad_s;
        solution.point = point.stepped(&step);
        solution.unit_per_kg_m2 = beliefs.unit_per_kg_m2;
        true
    }

    /// Factor of all sigmas: `√(χ² / n)` with χ² the sum of squares of the n solved parameters of the hardware over their
    /// stated variances, where chance exceeds it less than once in 10⁵; one otherwise \[Birge1932\]. Parameters that far out
    /// are the effect of something that is not in the model, and the inertia takes up a part of it too.
    fn beyond_stated(&self, point: &Point<T, U>) -> T {
        let parameters = self.groups.unknowns_from::<U>(self.groups.hardware);
        if !may_hold_all_axes(U, W) || parameters == 0 {
            return T::one();
        }
        let mut square = T::zero();
        for column in self.groups.first_kept::<U>()..shape_of(U) {
            if let Some(sigma) = self.groups.sigma(column) {
                let share = point.value(column) / sigma;
                square += share * share;
            }
        }
        if square > chi_square(parameters, RARE) {
            (square / T::count(parameters)).sqrt()
        } else {
            T::one()
        }
    }

    /// Writes the information of blocks on hardware and inertia to `factor`; none without a pass. Once for each
    /// solution, rather than a copy of it: a factor of 33 unknowns takes 4.5 KB of the stack.
    #[inline(never)]
    fn write_blocks(
        &self,
        blocks: Option<&Pass<T, W, U, M>>,
        factor: &mut SquareRootInformation<T, U>,
    ) {
        match blocks {
            Some(pass) => {
                self.window_alone(pass, factor);
            }
            None => factor.eliminate(self.groups.first_kept::<U>()),
        }
    }

    /// Adds to the covariance what no motion shows: the turn of all sensors, and a common scale of all that drives the
    /// body, `s² j jᵀ`.
    #[inline(never)]
    fn add_considered(&self, estimate: &mut Estimate<T>) {
        let scale = self.config.considered_scale();
        let spread = estimate.spread_of_variance().sqrt();
        let by = Mat::<T, 6, 1>::from(estimate.inertia.elements_kg_m2()) * scale;
        estimate.covariance_kg2_m4 += by * by.transpose();
        for (axis, sigma) in self.config.hardware.mount_rad.into_iter().enumerate() {
            let by = Mat::<T, 6, 1>::from(turned_by(&estimate.inertia, axis)) * (sigma * spread);
            estimate.covariance_kg2_m4 += by * by.transpose();
        }
    }

    /// Sigma of each element for hardware that is known exactly. Leaves the factor of it in `solution`.
    #[inline(never)]
    fn report_random(
        &self,
        blocks: Option<&Pass<T, W, U, M>>,
        point: &Point<T, U>,
        all: &Beliefs<'_, T, U>,
        solution: &mut Solution<T, U>,
        estimate: &mut Estimate<T>,
    ) {
        let mut factor = SquareRootInformation::default();
        self.write_blocks(blocks, &mut factor);
        all.add_kept(&mut factor, point);
        for column in self.groups.first_kept::<U>()..shape_of(U) {
            let weight = information_on(&factor, column) * T::lit(KNOWN);
            factor.fold(&unit_row(column), T::zero(), weight);
        }
        if !factor.covariance_factor_of_last(&mut solution.root) {
            return;
        }
        solution.root *= all.noise_rad_s;
        if solution.spread > T::zero() {
            // The range of a badly known trace is that of the noise too.
            *solution.root.at_mut(5, 5) *= solution.curvature;
        }
        let mut covariance = Mat::<T, 6, 6>::zeros();
        solution.of_elements(&mut covariance);
        let total = &estimate.covariance_kg2_m4;
        estimate.sigma_random_kg_m2 = Some(core::array::from_fn(|i| {
            covariance[(i, i)].max(T::zero()).min(total[(i, i)]).sqrt()
        }));
    }

    /// Calls `visit` with the result on each parameter of the hardware, for the window's fit or, between windows,
    /// for those that ended.
    pub(super) fn findings(&self, visit: &mut dyn FnMut(Finding<T>)) {
        let mut factor = SquareRootInformation::default();
        let Some((point, sigma, unit)) = self.joint_factor(&mut factor) else { return };
        let Some(step) = factor.solve() else { return };
        let mut solution = Solution::blank();
        solution.point = point.stepped(&step);
        solution.unit_per_kg_m2 = unit;
        let sigma = sigma * self.beyond_stated(&solution.point);
        self.findings_unseen(&solution, visit);
        self.findings_considered((&factor, sigma), &solution, visit);
        let hardware = self.groups.hardware..groups_of(U);
        self.findings_solved(hardware, (&factor, sigma), &solution, visit);
        if M > 0 {
            self.findings_of_modes(visit);
        }
    }

    /// Results on the modes, for the window's fit.
    fn findings_of_modes(&self, visit: &mut dyn FnMut(Finding<T>)) {
        let Some(Front { pass, .. }) = &self.front else { return };
        let mut factor = pass.factor;
        let Some((point, sigma)) = self.solve_all(pass, &mut factor) else { return };
        let mut solution = Solution::blank();
        solution.point = point;
        solution.unit_per_kg_m2 = pass.unit_per_kg_m2;
        let trace = solution.trace_kg_m2();
        let of_window = 0..self.groups.hardware;
        self.findings_solved(of_window, (&factor, sigma), &solution, &mut |mut finding| {
            if let Parameter::ModalInertia(..) = finding.parameter {
                finding.value *= trace;
                finding.sigma *= trace;
                finding.stated *= trace;
            }
            visit(finding);
        });
    }

    /// Results on what no motion shows: the turn of all sensors, and a common scale of all that drives the body.
    fn findings_unseen(&self, solution: &Solution<T, U>, visit: &mut dyn FnMut(Finding<T>)) {
        let trace = solution.trace_kg_m2();
        let inertia = Inertia::new(solution.point.over_trace().map(|n| n * trace));
        let mut visit = |parameter, stated: T, by: [T; 6]| {
            if stated > T::zero() {
                let effect_kg_m2 = by.map(|by| by * stated);
                visit(Finding { parameter, value: T::zero(), sigma: stated, stated, effect_kg_m2 });
            }
        };
        for (axis, stated) in self.config.hardware.mount_rad.into_iter().enumerate() {
            visit(Parameter::Mount(axis as u8), stated, turned_by(&inertia, axis));
        }
        visit(Parameter::TorqueScale, self.config.considered_scale(), inertia.elements_kg_m2());
    }

    /// Results on the parameters that are among the unknowns, in these places.
    fn findings_solved(
        &self,
        places: core::ops::Range<usize>,
        (factor, sigma): (&SquareRootInformation<T, U>, T),
        solution: &Solution<T, U>,
        visit: &mut dyn FnMut(Finding<T>),
    ) {
        let jacobian = solution.jacobian();
        for place in places {
            let Some(Some((group, Belief::Within(stated)))) = self.groups.place.get(place) else {
                continue;
            };
            for i in 0..3 {
                let column = FIRST_GROUP + 3 * place + i;
                let (Some(parameter), true) = (group.parameter(i), self.groups.is_active(place, i))
                else {
                    continue;
                };
                // One column of the covariance at a time: the whole matrix exceeds a flight computer's stack.
                let Some(covariance) = factor.solve_normal(&unit_row(column)) else { continue };
                let root = covariance[column].sqrt();
                let of_step =
                    Mat::<T, 6, 1>::from_fn(|k, _| covariance[shape_of(U) + k] * (sigma / root));
                let random = root * sigma;
                let by_others = self.variance_of_solved(place, i);
                visit(Finding {
                    parameter,
                    value: solution.point.value(column),
                    sigma: (random * random + by_others).sqrt(),
                    stated: stated[i],
                    effect_kg_m2: (jacobian * of_step).into(),
                });
            }
        }
    }

    /// The same for those that are considered: the data leave all of them.
    #[inline(never)]
    fn findings_considered(
        &self,
        (factor, sigma): (&SquareRootInformation<T, U>, T),
        solution: &Solution<T, U>,
        visit: &mut dyn FnMut(Finding<T>),
    ) {
        let mut root = Mat::<T, 6, 6>::zeros();
        if C == 0 || !factor.covariance_factor_of_last(&mut root) {
            return;
        }
        root *= sigma;
        let source = if self.front.is_some() { Source::Front } else { Source::Nothing };
        let (jacobian, at) = (solution.jacobian(), (solution.unit_per_kg_m2, sigma));
        self.each_effect(source, at, &root, &mut |group, i, effect, stated| {
            if let Some(parameter) = group.parameter(i) {
                let effect_kg_m2 = (jacobian * effect * stated).into();
                visit(Finding { parameter, value: T::zero(), sigma: stated, stated, effect_kg_m2 });
            }
        });
    }

    /// Writes the information with all beliefs to `factor`. Returns the point that it is about, one sigma of a row of
    /// unit weight, and the unit of the inverse trace.
    #[inline(never)]
    fn joint_factor(
        &self,
        factor: &mut SquareRootInformation<T, U>,
    ) -> Option<(Point<T, U>, T, T)> {
        let (point, sigma, unit) = match (&self.front, &self.past) {
            (Some(Front { pass, .. }), _) => {
                let sigma = self.window_alone(pass, factor);
                (pass.point, sigma, pass.unit_per_kg_m2)
            }
            (None, Some(past)) => {
                factor.eliminate(self.groups.first_kept::<U>());
                (past.point, T::one(), past.per_kg_m2)
            }
            (None, None) => return None,
        };
        Beliefs { noise_rad_s: sigma, ..self.beliefs(unit) }.add_kept(factor, &point);
        Some((point, sigma, unit))
    }

    /// Adds all beliefs to the factor of a pass. Returns the solution for all unknowns, and one sigma of a sample.
    fn solve_all(
        &self,
        pass: &Pass<T, W, U, M>,
        factor: &mut SquareRootInformation<T, U>,
    ) -> Option<(Point<T, U>, T)> {
        let sigma = self.sigma_of_sample(pass);
        let beliefs = Beliefs { noise_rad_s: sigma, ..self.beliefs(pass.unit_per_kg_m2) };
        beliefs.add(factor, &pass.point);
        let step = factor.solve()?;
        Some((pass.point.stepped(&step), sigma))
    }

    /// Torque and bias where the data determine them.
    #[inline(never)]
    fn report_groups(&self, pass: &Pass<T, W, U, M>, estimate: &mut Estimate<T>) {
        let is_asked_for = |at: &Option<_>| matches!(at, Some((_, Belief::Within(_))));
        if groups_of(U) == 0 || !self.groups.place.iter().any(is_asked_for) {
            return;
        }
        let mut factor = pass.factor;
        let Some((solved, sigma)) = self.solve_all(pass, &mut factor) else { return };
        let Some(variances) = factor.variances() else { return };
        let trace = T::one() / (solved.scale() * pass.unit_per_kg_m2);
        for place in 0..groups_of(U) {
            let Some((group, Belief::Within(range))) = self.groups.place[place] else { continue };
            let to_physical = if group == Group::Torque { trace } else { T::one() };
            let most = range[0] * T::lit(SEEN) / (to_physical * sigma);
            let first = FIRST_GROUP + 3 * place;
            if !variances.iter().skip(first).take(3).all(|v| *v < most * most) {
                continue;
            }
            let value = solved.of_place(place) * to_physical;
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

    /// Number of unknowns in use, each of which takes a degree of freedom from the residuals.
    pub(super) fn unknowns(&self) -> u32 {
        MOMENTUM_AND_INERTIA + self.groups.unknowns_from::<U>(0)
    }

    /// One sigma of a sample for the covariance, rad/s: stated or measured noise and residuals, weighted by
    /// their degrees of freedom; larger where the residuals are correlated by ρ from block to block, so that fewer of them are
    /// independent: by `√((1 + ρ) / (1 − ρ))`, or by `√(1 + 2 Σ ρ_k)`, which is larger for a slow error beside white noise;
    /// and by the distance to the minimum that rounding leaves. At least the noise where the inertia walks: smaller innovations
    /// are then the sign of a walk that is stated too large.
    #[inline(never)]
    pub(super) fn sigma_of_sample(&self, pass: &Pass<T, W, U, M>) -> T {
        let residuals = &pass.residuals;
        let unsettled = T::one() + pass.decrement / T::count(U as u32);
        let noise = self.noise_rad_s();
        let weight = match self.config.gyro_noise_rad_s {
            Some(_) => T::lit(STATED_DEGREES),
            None => T::lit(MEASURED_DEGREES),
        };
        let degrees = T::count(residuals.degrees(self.unknowns()));
        let rows = T::count(residuals.rows);
        let beyond = (residuals.squares - noise * noise * degrees).max(T::zero());
        let explained = (self.explained(pass) * rows).min(beyond);
        let variance =
            (noise * noise * weight + residuals.squares - explained) / (weight + degrees);
        let least = if self.config.is_walking() { noise * noise } else { T::zero() };
        let variance = variance.max(least);
        let by_chance = largest_correlation(residuals.rows);
        let rho = residuals.correlation_beyond(explained).min(T::lit(MOST_CORRELATED));
        let mut inflation = T::one();
        if rho > by_chance {
            inflation = (T::one() + rho) / (T::one() - rho);
        }
        let slow = residuals.slow_correlation_beyond(explained);
        if slow > by_chance * T::lit(ROOT_OF_LAGS) {
            inflation = inflation.max(T::one() + slow + slow);
        }
        (variance * inflation * unsettled)
            .sqrt()
            .max(self.largest_rad_s * (T::EPSILON + T::EPSILON))
    }

    /// Result of the tests for white residuals: of their size against the noise, alone and in groups, of their
    /// correlation, and of a torque that is not among the unknowns.
    #[inline(never)]
    pub(super) fn is_white(&self, pass: &Pass<T, W, U, M>, is_settled: bool) -> Option<bool> {
        let residuals = &pass.residuals;
        if residuals.rows < ENOUGH_ROWS {
            return None;
        }
        let most = self.reference_rad_s() * largest_rms(residuals.blocks);
        let explained = self.explained(pass);
        let rms = rms(residuals, self.unknowns());
        let is_small = rms * rms <= most * most + explained;
        let rows = T::count(residuals.rows);
        let correlation = residuals.correlation_beyond(explained * rows);
        let is_correlated = correlation.abs() > largest_correlation(residuals.rows)
            || residuals.line_beyond(explained * rows) > largest_line(residuals.rows);
        let contradiction = self.contradictions(pass);
        let shows_torque = contradiction.iter().any(|x| *x > T::lit(TORQUE_SHOWN));
        let is_found = !is_correlated && !shows_torque && !residuals.is_alarmed();
        Some(is_small && is_found && self.are_groups_white(pass) && is_settled)
    }

    /// True where groups of residuals have the size of white noise, and none of it along the curvature of the rate.
    fn are_groups_white(&self, pass: &Pass<T, W, U, M>) -> bool {
        let share = self.reference_rad_s() / pass.unit_rad_s;
        let explained = self.explained(pass) / (pass.unit_rad_s * pass.unit_rad_s);
        let Residuals { rows, whiteness, curvature, .. } = &pass.residuals;
        whiteness.is_white_beside(share * share, explained) != Some(false)
            && curvature.is_white(pass.trajectory.inverse(), *rows, share * share, explained)
    }

    /// Statistics of a window that ends with this front.
    #[inline(never)]
    pub(super) fn ended_with(&self, front: &Front<T, W, U, M>) -> Ended<T> {
        Ended {
            residual_rms_rad_s: rms(&front.pass.residuals, self.unknowns()),
            residuals_white: self.is_white(&front.pass, front.is_settled),
            is_explained: self.is_good(&front.pass, front.is_settled),
        }
    }
}

/// Root mean square of the residuals of a sample, one axis, rad/s.
pub(super) fn rms<T: Real>(residuals: &Residuals<T>, unknowns: u32) -> T {
    (residuals.squares / T::count(residuals.degrees(unknowns).max(1))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_both_have_observed_is_left() {
        let of = |directions: u8, element: [bool; 6], scale: bool| Observed {
            directions,
            element,
            scale,
        };
        let all = of(6, [true; 6], true);
        let some = of(4, [true, false, true, false, true, true], false);
        for (mut left, right, expected) in [
            (all, some, some),
            (some, all, some),
            (all, all, all),
            (some, of(5, [false; 6], true), of(4, [false; 6], false)),
        ] {
            restrict(&mut left, &right);
            assert_eq!(left, expected);
        }
    }

    /// Elements of 1e6 kg m² without variance: that of their rounding to single precision.
    #[test]
    fn variance_has_a_floor_at_rounding_error() {
        let mut estimate = Estimate::<f32>::of_nothing();
        estimate.inertia = Inertia::new([1e6, 2e6, 2e6, 1e3, 0.0, -1e3]);
        estimate.covariance_kg2_m4 = Mat::zeros();
        assert!(is_finite_with_floor(&mut estimate));
        for (sigma, element) in estimate.sigma_kg_m2().iter().zip(estimate.inertia.elements_kg_m2())
        {
            assert!((sigma - element.abs() * f32::EPSILON).abs() <= 1e-3 * sigma);
        }
        estimate.covariance_kg2_m4[(2, 2)] = 1e30;
        assert!(is_finite_with_floor(&mut estimate));
        let grown = estimate.covariance_kg2_m4[(2, 2)] / 1e30 - 1.0;
        assert!((0.0..1e-5).contains(&grown), "{grown}");
        estimate.covariance_kg2_m4[(1, 2)] = f32::NAN;
        assert!(!is_finite_with_floor(&mut estimate));
    }
}
