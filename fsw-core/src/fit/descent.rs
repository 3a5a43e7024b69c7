//! Descent of Gauss-Newton: from a first point to the solution, one pass after another.
//!
//! After each pass the undamped step decides: its Newton decrement, the decrease of cost that it
//! promises, ends the descent where it is far below one sigma², or where that of the next step will be: steps
//! shrink by a constant ratio at least. The covariance is that of the
//! undamped system. A pass whose robust cost exceeds that of the last one is rejected, and the step from
//! there repeated with damping (Levenberg and Marquardt). Robust costs compare for the same weights alone: a point that
//! is rejected leaves their scale as it was.
//!
//! Several starts are tried in turn until the residuals are explained:
//!
//! | attempt | start |
//! |---|---|
//! | [`Attempt::Carried`] | solution of the last fit |
//! | [`Attempt::Linear`] | linear start without disturbance torque: it is small as a rule |
//! | [`Attempt::Torque`] | linear start with disturbance torque, where that is an unknown |
//! | [`Attempt::Sphere`] | equal moments, with the scale of the linear start; with modes, the linear start and modal inertias |
//! | [`Attempt::Prior`] | the prior, or earlier windows |

use super::belief::{Beliefs, information_on};
use super::front::Fit;
use super::pass::Pass;
use crate::dynamics::wheels::Momenta;
use crate::math::square_root_information::{SquareRootInformation, unit_row};
use crate::math::{Entries, Vec3, largest_component, scalar::Real};
use crate::trajectory::axes_at;
use crate::trajectory::modes::{Oscillator, of_body};
use crate::trajectory::unknowns::{FIRST_GROUP, Groups, Point, shape_of};

/// Newton decrement that ends a descent, σ²: a thirtieth of a sigma from the minimum. Of the point, or expected of the
/// next one.
const SETTLED: f64 = 1e-3;
/// Decrement below which steps that no longer shrink end it: rounding, not the model, moves them.
const NEAR: f64 = 0.3;
/// Decrease of the cost over the promised one, above which it is not rounding that moves the steps.
const FALLING: f64 = 0.25;
/// Rounding errors, in ε, of the inverse of a tensor that changes by less: some of the nine products in each
/// of its elements.
const ROUNDINGS: f64 = 4.0;
/// Typical residual over the scale of the robust weights from which on the weights are wrong: an octave, the resolution of
/// the typical one.
const GROWN: f64 = 2.0;
/// Passes of a descent at most. From linear starts of random spacecraft it takes 4 to 8.
const MOST_PASSES: u8 = 25;
/// Decrease of chi-square from which on a mode is shown: of eight degrees of freedom, exceeded by chance once in 1,000. A
/// mode below it is linear about no inertia, and its phase over a long record would not be.
const MODE_SHOWN: f64 = 26.1;
/// Passes with the hardware held at most.
const MOST_HELD_PASSES: u8 = 12;
/// Passes in which the inertia walks at most.
const MOST_WALKING_PASSES: u8 = 6;
/// First damping, as a share of each column's norm, and the largest one.
const FIRST_DAMPING: f64 = 0.01;
const LARGEST_DAMPING: f64 = 1e4;
/// Steps from a point at most.
const MOST_REFUSED: u8 = 8;
/// Smallest principal moment over the trace of a point that is tried.
const LEAST_MOMENT: f64 = 1e-5;

/// Scale of the robust weights over the noise in the first pass from a new start: no block is an outlier
/// yet.
pub const UNKNOWN_SCALE: f64 = 1e6;

/// Start of a descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Attempt {
    Carried,
    Linear,
    Torque,
    Sphere,
    Prior,
    /// The best of the others again, in order to have its factor.
    Best,
}

crate::persist!([] enum Attempt { 0 => Carried, 1 => Linear, 2 => Torque, 3 => Sphere, 4 => Prior, 5 => Best });

/// Passes for the considered hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Considering {
    /// Not yet: the descent has not settled.
    Not,
    /// The pass of the group with this index.
    Group(u8),
    /// All groups have been considered, and the last pass is about the solution again.
    Done,
}

crate::persist!([] enum Considering { 0 => Not, 1 => Group(index: u8), 2 => Done });

/// Descent in progress.
#[derive(Clone, Copy, Debug)]
pub struct Descent<T: Real, const W: usize, const U: usize, const M: usize> {
    pub pass: Pass<T, W, U, M>,
    /// Blocks from the first to before the last one.
    pub from: usize,
    pub end: usize,
    pub attempt: Attempt,
    /// Point of the linear start, once there is one.
    pub linear: Option<Point<T, U>>,
    /// Accepted point of this attempt and its cost, rad²/s².
    best: Option<(Point<T, U>, T)>,
    /// Solution of an earlier attempt, its cost, and the unit of its scale.
    pub chosen: Option<(Point<T, U>, (T, T))>,
    damping: T,
    /// Decrement of the step to the point of the pass, σ²; the largest number where it is unknown.
    pub last_decrement: T,
    /// Residual that the robust weights take for noise, rad/s: the smallest typical one of the accepted points.
    /// Zero before the first.
    pub typical_rad_s: T,
    is_near: bool,
    /// True until the descent has settled with the hardware held.
    holds_hardware: bool,
    /// True in a pass that repeats the accepted point for a damped step.
    is_repeated: bool,
    /// True in the pass that judges the residuals at the solution.
    is_final: bool,
    /// True in the last pass, in which a torque of fields walks about the solution for a constant one.
    pub has_walk: bool,
    pub considering: Considering,
    passes: u8,
    /// Steps from the point of the pass whose end no body has.
    refused: u8,
    /// The fit once it has ended, with the pass of the descent.
    pub fit: Option<Fit>,
}

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] Descent<T, W, U, M> {
    pass, from, end, attempt, linear, best, chosen, damping, last_decrement, typical_rad_s, is_near, holds_hardware, is_repeated, is_final, has_walk,
    considering, passes, refused, fit
});

/// Consequence of a completed pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next<T: Real, const U: usize> {
    /// Another pass about this point.
    Pass(Point<T, U>),
    /// The same pass again, with residuals judged at the solution: at the step that is below the
    /// rounding of the point.
    Final,
    /// The step from the point of the pass leads to no body: once more, with more damping.
    Again,
    /// The descent has ended at the point of the pass, settled or not.
    End { is_settled: bool },
    /// The descent has ended, unsettled, and the point of the pass is not the best one.
    Failed,
}

impl<T: Real, const W: usize, const U: usize, const M: usize> Descent<T, W, U, M> {
    /// Descent over these blocks, without a first point yet.
    pub fn new(from: usize, end: usize, attempt: Attempt) -> Self {
        Self {
            pass: Pass::blank(),
            from,
            end,
            attempt,
            linear: None,
            best: None,
            chosen: None,
            damping: T::zero(),
            last_decrement: T::MAX,
            typical_rad_s: T::zero(),
            is_near: false,
            holds_hardware: attempt != Attempt::Carried,
            is_repeated: false,
            is_final: false,
            has_walk: false,
            considering: Considering::Not,
            passes: 0,
            refused: 0,
            fit: None,
        }
    }

    /// Begins an attempt anew.
    pub fn restart(&mut self, attempt: Attempt) {
        self.attempt = attempt;
        self.best = None;
        self.damping = T::zero();
        self.last_decrement = T::MAX;
        self.typical_rad_s = T::zero();
        self.is_near = false;
        self.holds_hardware = attempt != Attempt::Best;
        self.is_repeated = false;
        self.is_final = false;
        self.has_walk = false;
        self.considering = Considering::Not;
        (self.passes, self.refused) = (0, 0);
        self.pass.holds_modes = M > 0;
    }

    /// Decides after a pass over all blocks.
    #[inline(never)]
    pub fn after_pass(
        &mut self,
        beliefs: &Beliefs<'_, T, U>,
        wheels: &Momenta<T, W>,
    ) -> Next<T, U> {
        self.holds_hardware &= beliefs.groups.has_hardware();
        let (holds_hardware, holds_modes) = (self.holds_hardware, self.pass.holds_modes);
        let held = &Beliefs { holds_hardware, holds_modes, ..*beliefs };
        if self.refused > 0 {
            let beliefs = if self.has_walk { beliefs } else { held };
            return self.step(None, beliefs, wheels);
        }
        self.passes = self.passes.saturating_add(1);
        if self.has_walk {
            return self.after_walk(beliefs, wheels);
        }
        let beliefs = held;
        let cost = self.cost(beliefs);
        let variance = beliefs.noise_rad_s * beliefs.noise_rad_s;
        let is_worse = !self.pass.is_finite() || self.is_worse(cost, variance);
        if is_worse && !self.is_repeated {
            return self.reject();
        }
        if self.weights_grow() {
            return Next::Pass(self.pass.point);
        }
        let is_falling = self.is_falling(cost, variance);
        if !self.is_repeated {
            self.damping =
                if self.damping < T::lit(1e-3) { T::zero() } else { self.damping * T::lit(0.1) };
        }
        let is_first = self.best.is_none();
        self.best = Some((self.pass.point, cost));
        let Some((step, decrement)) = solve(&self.pass, beliefs, T::zero()) else {
            return Next::End { is_settled: false };
        };
        self.pass.decrement = decrement;
        self.is_near = decrement < T::lit(NEAR) + self.rounding(beliefs);
        let is_at_minimum = decrement < T::lit(SETTLED) || self.is_linear(decrement);
        let is_rounded = !is_first
            && self.is_near
            && !is_falling
            && decrement > T::lit(0.3) * self.last_decrement;
        if is_at_minimum || is_rounded {
            self.pass.offset = step;
        }
        if let Some(next) = self.at_minimum(beliefs, decrement, (is_at_minimum, is_rounded)) {
            return next;
        }
        if !self.is_repeated {
            self.last_decrement = decrement;
        }
        self.is_repeated = false;
        self.step(Some(step), beliefs, wheels)
    }

    /// Lets torque and inertia walk from the next pass on.
    pub fn let_walk(&mut self) {
        self.has_walk = true;
        self.passes = 0;
    }

    /// Decides after a pass in which torque or inertia walk. A torque walks about the solution for a constant one, to first
    /// order. About the inertia at the end of the blocks the motion is linear for the blocks that still count.
    fn after_walk(&mut self, beliefs: &Beliefs<'_, T, U>, wheels: &Momenta<T, W>) -> Next<T, U> {
        if !beliefs.has_varying_inertia {
            return Next::End { is_settled: true };
        }
        let Some((step, decrement)) = solve(&self.pass, beliefs, T::zero()) else {
            return Next::End { is_settled: false };
        };
        (self.pass.decrement, self.pass.offset) = (decrement, step);
        let is_settled = decrement < T::lit(NEAR);
        if is_settled || self.passes >= MOST_WALKING_PASSES {
            return Next::End { is_settled };
        }
        self.step(Some(step), beliefs, wheels)
    }

    /// True where the step from the point ends at the minimum: the decrement there is expected to be `λ₂⁴ / λ₁²`, for λ₁² of
    /// the last step and λ₂² of this one. Undamped steps of Gauss-Newton shrink by a constant ratio at least. The solution
    /// contains the step: it needs no pass.
    fn is_linear(&self, decrement: T) -> bool {
        let is_undamped = self.damping <= T::zero() && !self.is_repeated;
        let is_shown = self.last_decrement < T::MAX;
        is_undamped
            && is_shown
            && decrement < T::lit(NEAR)
            && decrement * decrement < self.last_decrement * T::lit(SETTLED)
    }

    /// True where the cost still falls by more than rounding: a damped step leaves most of its decrement, and a step
    /// along a curved valley finds another one.
    fn is_falling(&self, cost: T, variance: T) -> bool {
        let promised = self.last_decrement * variance;
        self.damping > T::zero()
            || self.best.is_some_and(|(_, best)| best - cost > promised * T::lit(FALLING))
    }

    /// True for a point that is worse than the accepted one by more than rounding. The robust cost is bounded: far from the
    /// solution it no longer grows, but the typical residual does.
    fn is_worse(&self, cost: T, variance: T) -> bool {
        let Some((_, best)) = self.best else { return false };
        let rounded = if self.is_near { variance * T::lit(NEAR) } else { T::zero() };
        cost > best + rounded || self.outgrows_weights()
    }

    /// True where the typical residual is no longer what the robust weights take for noise.
    fn outgrows_weights(&self) -> bool {
        let typical = self.pass.residuals.typical(self.pass.unit_rad_s);
        typical > self.pass.scale_rad_s * T::lit(GROWN)
    }

    /// Adapts the scale of the robust weights to an accepted point. True where it grows, as at a start that is worse than
    /// assumed: costs of different weights do not compare, and the point is to be passed again.
    fn weights_grow(&mut self) -> bool {
        let typical = self.pass.residuals.typical(self.pass.unit_rad_s);
        let grows = self.best.is_none() && self.outgrows_weights();
        let is_known = self.typical_rad_s > T::zero() && !grows;
        self.typical_rad_s = if is_known { typical.min(self.typical_rad_s) } else { typical };
        grows && self.passes < MOST_PASSES
    }

    /// Next pass of a descent that has settled or reached its limit of passes: with held unknowns released, with robust
    /// weights, with a walk of the torque; or its end. None: Gauss-Newton continues.
    #[inline(never)]
    fn at_minimum(
        &mut self,
        beliefs: &Beliefs<'_, T, U>,
        decrement: T,
        (is_at_minimum, is_rounded): (bool, bool),
    ) -> Option<Next<T, U>> {
        let is_settled = is_at_minimum || is_rounded;
        let is_first = self.pass.scale_rad_s > beliefs.noise_rad_s * T::lit(0.5 * UNKNOWN_SCALE);
        let may_release = is_settled || self.passes >= MOST_HELD_PASSES;
        if may_release && self.holds_hardware {
            return Some(self.release(self.pass.point));
        }
        if M > 0 && may_release && self.shows_modes(beliefs, decrement) {
            self.pass.holds_modes = false;
            return Some(self.release(self.pass.point));
        }
        if is_settled && is_first {
            // Once more, with weights.
            return Some(Next::Pass(self.pass.point));
        }
        if is_settled && (beliefs.has_varying_torque || beliefs.has_varying_inertia) {
            self.let_walk();
            return Some(Next::Pass(self.pass.point));
        }
        if is_rounded && !is_at_minimum && !self.is_final {
            self.is_final = true;
            return Some(Next::Final);
        }
        let ends = is_settled || self.is_final || self.passes >= MOST_PASSES;
        ends.then_some(Next::End { is_settled: is_settled || self.is_final || self.is_near })
    }

    /// True where modes that are held would explain more than noise does, beyond the decrement of the step with them held.
    fn shows_modes(&self, beliefs: &Beliefs<'_, T, U>, decrement: T) -> bool {
        let released = &Beliefs { holds_modes: false, ..*beliefs };
        self.pass.holds_modes
            && solve(&self.pass, released, T::zero())
                .is_some_and(|(_, by_all)| by_all - decrement > T::lit(MODE_SHOWN))
    }

    /// Goes on from a point with the hardware as stated.
    fn release(&mut self, point: Point<T, U>) -> Next<T, U> {
        self.holds_hardware = false;
        self.is_repeated = false;
        self.best = None;
        self.damping = T::zero();
        self.last_decrement = T::MAX;
        Next::Pass(point)
    }

    /// Accepted point of the attempt, and its cost in rad²/s².
    pub fn accepted(&self) -> Option<(Point<T, U>, T)> {
        self.best
    }

    /// Robust cost of the pass and its point, rad²/s². Rounding of it is not a decrease.
    fn cost(&self, beliefs: &Beliefs<'_, T, U>) -> T {
        let cost = self.pass.residuals.cost + beliefs.cost(&self.pass.point);
        cost * (T::one() - T::EPSILON * T::lit(64.0))
    }

    /// Goes back to the accepted point, with more damping.
    fn reject(&mut self) -> Next<T, U> {
        let Some((point, _)) = self.best else { return Next::Failed };
        let first = T::lit(FIRST_DAMPING);
        self.damping = if self.damping < first { first } else { self.damping * T::lit(10.0) };
        self.is_repeated = true;
        let is_stuck = self.damping > T::lit(LARGEST_DAMPING);
        if self.holds_hardware && (is_stuck || self.passes >= MOST_HELD_PASSES) {
            return self.release(point);
        }
        if is_stuck || self.passes >= MOST_PASSES {
            if !self.is_near {
                return Next::Failed;
            }
            self.is_final = true;
        }
        Next::Pass(point)
    }

    /// The next point: by the undamped step `newton`, or by one with the present damping. More of it is needed where the
    /// tensor there is not positive definite: one solution at a time, which bounds the work of a decision.
    fn step(
        &mut self,
        newton: Option<[T; U]>,
        beliefs: &Beliefs<'_, T, U>,
        wheels: &Momenta<T, W>,
    ) -> Next<T, U> {
        let damped = match newton {
            Some(_) if self.damping <= T::zero() => newton,
            _ => solve(&self.pass, beliefs, self.damping).map(|(step, _)| step).or(newton),
        };
        let point = damped.map(|step| self.pass.point_after(&step, wheels, beliefs.groups));
        if let Some(point) = point.filter(|point| is_usable::<T, U, M>(point, beliefs.groups)) {
            self.refused = 0;
            return Next::Pass(point);
        }
        self.refused = self.refused.saturating_add(1);
        if self.refused >= MOST_REFUSED {
            self.refused = 0;
            return Next::End { is_settled: false };
        }
        let first = T::lit(FIRST_DAMPING);
        self.damping = if self.damping < first { first } else { self.damping * T::lit(10.0) };
        Next::Again
    }

    /// Decrement that rounding of the unknowns and of the inverse tensor alone makes, σ².
    fn rounding(&self, beliefs: &Beliefs<'_, T, U>) -> T {
        let factor = &self.pass.factor;
        let size = |column: usize| match column {
            0..FIRST_GROUP => largest_component(&self.pass.point.momentum()),
            _ => T::lit(0.3),
        };
        let mut sum = T::zero();
        for column in (0..FIRST_GROUP).chain(shape_of(U)..shape_of(U) + 5) {
            let rounded = size(column) * T::EPSILON * T::lit(ROUNDINGS);
            sum += information_on(factor, column) * rounded * rounded;
        }
        sum / (beliefs.noise_rad_s * beliefs.noise_rad_s)
    }
}

/// True for a point whose tensor, without the modal inertias of M modes, is positive definite with a margin, and all of
/// it finite.
fn is_usable<T: Real, const U: usize, const M: usize>(
    point: &Point<T, U>,
    groups: &Groups<T>,
) -> bool {
    let least = T::lit(LEAST_MOMENT);
    let modes: [Oscillator<T>; M] =
        core::array::from_fn(|i| Oscillator::new(point, groups, i as u8));
    let [xx, yy, zz, xy, xz, yz] = of_body(&point.over_trace(), &modes).elements_kg_m2();
    let inside = [xx - least, yy - least, zz - least, xy, xz, yz];
    crate::tensor::Inertia::new(inside).is_positive_definite() && point.is_finite()
}

/// Step of a pass with all beliefs, damped by a share of each column's norm, and its Newton decrement in
/// σ².
#[inline(never)]
fn solve<T: Real, const W: usize, const U: usize, const M: usize>(
    pass: &Pass<T, W, U, M>,
    beliefs: &Beliefs<'_, T, U>,
    damping: T,
) -> Option<([T; U], T)> {
    let mut factor = pass.factor;
    beliefs.add(&mut factor, &pass.point);
    if damping > T::zero() {
        damp(&mut factor, damping);
    }
    let step = factor.solve()?;
    let mut decrement = T::zero();
    for i in 0..U {
        let d = factor.right_hand_side[i];
        decrement += factor.factor[i][i] * d * d;
    }
    Some((step, decrement / (beliefs.noise_rad_s * beliefs.noise_rad_s)))
}

/// Adds `damping²` times the information on each unknown with all others known.
fn damp<T: Real, const U: usize>(factor: &mut SquareRootInformation<T, U>, damping: T) {
    let mut information = [T::zero(); U];
    for (column, of_column) in information.iter_mut().enumerate() {
        *of_column = information_on(factor, column) * (damping * damping);
    }
    for column in 0..U {
        factor.fold(&unit_row(column), T::zero(), information[column]);
    }
}

impl<T: Real, const W: usize, const U: usize, const M: usize> Pass<T, W, U, M> {
    /// The point after a step.
    ///
    /// The rate at the start, not the momentum, moves linearly: momentum follows from the new tensor and
    /// that rate, `m = n ω₀ + x w`. It is the rate that the data determine, whatever the tensor.
    pub fn point_after(
        &self,
        step: &[T; U],
        wheels: &Momenta<T, W>,
        groups: &Groups<T>,
    ) -> Point<T, U> {
        let model = &self.trajectory.model;
        let mut rate = model.rate_rad_s(&self.point.momentum(), wheels);
        let before = rate;
        for axis in 0..3 {
            let row = self.trajectory.rate_at_start(&before, wheels, axis);
            for column in 0..U {
                *rate.at_mut(axis, 0) += row[column] * step[column];
            }
        }
        let mut point = self.point.stepped(step);
        let axes = axes_at(&point, groups, model.configured_axes());
        point.set_momentum(&momentum_of(&point, &rate, &(axes * wheels)));
        point
    }

    /// Step to the solution with all beliefs, and its Newton decrement, σ².
    pub fn solution(&self, beliefs: &Beliefs<'_, T, U>) -> Option<([T; U], T)> {
        solve(self, beliefs, T::zero())
    }
}

/// `m = n ω + x w`, rad/s.
pub fn momentum_of<T: Real, const U: usize>(
    point: &Point<T, U>,
    rate: &Vec3<T>,
    wheels: &Vec3<T>,
) -> Vec3<T> {
    let n = crate::tensor::Inertia::new(point.over_trace()).matrix_kg_m2();
    n * rate + wheels * point.scale()
}
