//! The work beside taking in samples, in slices of bounded cost.
//!
//! | slice | bound of its cost |
//! |---|---|
//! | sweep of storage | a group of sixteen blocks |
//! | front, pass | a block: up to three steps and three rows |
//! | linear start | a block, or the singular values of its triangle |
//! | decision after a pass | up to ten solutions of the factor: damped steps, tests |
//! | judgement of a fit | a report: two solutions of the factor, an eigenproblem of six |
//! | result of a fit | up to five solutions of the factor: observed shape, tests against earlier windows |
//! | begin of a fit | norms of all blocks, or a solution of the factor |
//! | conclusion of a window | a solution of six unknowns |

use super::considered::{EXPLAINED_SQUARE, Source};
use super::{FIRST_FIT_BLOCKS, Schedule, Window};
use crate::blocks::storage::{Marks, PairLimits};
use crate::blocks::stretch::{Rest, Stretch};
use crate::dynamics::wheels::Momenta;
use crate::fit::belief::{Beliefs, Past, information_from};
use crate::fit::descent::{Attempt, Considering, Descent, Next, momentum_of};
use crate::fit::drift::{Drift, per_rad, turn_against_field};
use crate::fit::front::{Fit, Front};
use crate::fit::pass::Pass;
use crate::fit::start::{FirstPoint, LinearStart};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Vec3, scalar::Real};
use crate::trajectory::axes_at;
use crate::trajectory::unknowns::{Belief, GROUPS, Group, Point, groups_of};

/// Work that is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remaining {
    /// None: the estimate contains everything that it can.
    Nothing,
    /// At least one slice.
    Some,
}

/// Kind of a slice: its cost depends on little else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slice {
    /// Sweep of storage: a group of blocks.
    Sweep,
    /// Storage is full: begin of a sweep, or of another window.
    Room,
    /// Block of the front.
    Front,
    /// Block of the linear start.
    Start,
    /// Solution of the linear start.
    StartSolution,
    /// Block of a pass.
    Pass,
    /// Decision after a pass.
    Decision,
    /// Judgement of a fit.
    Judgement,
    /// Result of a fit.
    Result,
    /// Begin of a fit.
    Fit,
    /// Conclusion of a window.
    Conclusion,
}

/// Present task of the fit.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "without allocation, the largest task is reserved")]
pub enum Work<T: Real, const W: usize, const U: usize, const M: usize> {
    Idle,
    /// Linear start over blocks from the first to before the last one, and the solution of an earlier
    /// attempt.
    Start {
        linear: LinearStart<T>,
        from: usize,
        end: usize,
        chosen: Option<Chosen<T, U>>,
    },
    Descent(Descent<T, W, U, M>),
}

/// Next task after the last pass of an attempt.
#[derive(Clone, Copy, Debug)]
enum After<T: Real, const U: usize> {
    /// Another linear start.
    Start { has_torque: bool, from: usize, end: usize, chosen: Option<Chosen<T, U>> },
    /// The result of all attempts.
    End { is_settled: bool },
}

/// Solution of an attempt, its cost in rad²/s², and the unit of its scale, 1/(kg m²).
pub type Chosen<T, const U: usize> = (Point<T, U>, (T, T));

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] enum Work<T, W, U, M> {
    0 => Idle,
    1 => Start { linear: LinearStart<T>, from: usize, end: usize, chosen: Option<Chosen<T, U>> },
    2 => Descent(descent: Descent<T, W, U, M>)
});

/// Modal inertia of a start over the tensor. A body raises the frequency of a mode of share s by s/2: from no inertia a
/// mode of 1 % damping keeps within a radian of phase up to a share of 3 %, from this one from 3 to 9 %.
const MODAL_SHARE: f64 = 0.06;
/// Slices after which [`finish`](Window::finish) gives up: no work is that long. Four attempts of 25
/// passes over 512 blocks, twice for a trial of the blocks since a change, and again for drag.
const MOST_SLICES: u32 = 400_000;
/// Residual over noise above which a model does not explain the blocks.
const EXPLAINED: f64 = 1.3;
/// Share of the range of the shape below which it is observed.
const SHAPE_OBSERVED: f64 = 0.5;
/// Contradiction of an assumed absence of drag: chi-square of three degrees of freedom exceeds it once
/// in 10⁵.
const DRAG_SHOWN: f64 = 26.0;
/// One sigma of a gyro bias that is allowed for beside drag, rad/s: a steady rate against the air and a
/// steady error of the gyro look alike, and consumer gyros have 1 deg/s of it.
const BIAS_WITH_DRAG_RAD_S: f64 = 0.02;
/// Mean square of the walk within a window, over its variance.
const MOST_WALKED: f64 = 3.0;

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// Does up to this number of slices, each of bounded cost, and returns what is left.
    pub fn work(&mut self, slices: u32) -> Remaining {
        for _ in 0..slices {
            if !self.slice() {
                return Remaining::Nothing;
            }
        }
        if slices > 0 && self.next_slice().is_none() { Remaining::Nothing } else { Remaining::Some }
    }

    /// Completes all work on the samples so far. The present block ends with the newest sample. The window that
    /// is closing comes first, then the one that waits, then the open one.
    pub(super) fn complete(&mut self) {
        self.drain();
        if let Some(block) = self.averager.as_mut().and_then(super::Averager::finish) {
            self.add_block(&block);
        }
        for _ in 0..3 {
            let is_worth_it = self.closing.is_some() || !self.is_quiet;
            self.schedule.is_final = is_worth_it && self.schedule.fitted != self.schedule.blocks;
            self.work(MOST_SLICES);
        }
    }

    /// Kind of the slice that is due; `None` where all work has been done.
    pub fn next_slice(&self) -> Option<Slice> {
        if self.blocks.is_compacting() {
            Some(Slice::Sweep)
        } else if self.needs_room() {
            Some(Slice::Room)
        } else if self.front.as_ref().is_some_and(|front| front.pass.next < self.end()) {
            Some(Slice::Front)
        } else {
            self.next_of_fit()
        }
    }

    fn next_of_fit(&self) -> Option<Slice> {
        match &self.work {
            Work::Start { linear, end, .. } if linear.next < *end => Some(Slice::Start),
            Work::Start { .. } => Some(Slice::StartSolution),
            Work::Descent(descent) if descent.pass.next < descent.end => Some(Slice::Pass),
            Work::Descent(descent) => match &descent.fit {
                None => Some(Slice::Decision),
                Some(Fit { observed: None, .. }) => Some(Slice::Judgement),
                Some(Fit { observed: Some(_), .. }) => Some(Slice::Result),
            },
            Work::Idle if self.is_due() => Some(Slice::Fit),
            Work::Idle => self.closing.is_some().then_some(Slice::Conclusion),
        }
    }

    /// End of the blocks that are being fitted.
    pub(super) fn end(&self) -> usize {
        self.closing.as_ref().map_or(self.blocks.len(), |closing| closing.end)
    }

    pub(super) fn stretch(&self) -> Stretch<T, W> {
        self.closing.as_ref().map_or(self.open, |closing| closing.stretch)
    }

    /// One slice; false if nothing was left to do.
    #[inline(never)]
    fn slice(&mut self) -> bool {
        match self.next_slice() {
            None => return false,
            Some(Slice::Sweep) => self.sweep(),
            Some(Slice::Room) => self.make_room(),
            Some(Slice::Front) => return self.advance_front(),
            Some(Slice::Fit) => self.begin_fit(),
            Some(Slice::Conclusion) => self.conclude(),
            Some(Slice::Start | Slice::Pass) => self.take_block(),
            Some(Slice::StartSolution) => self.end_start(),
            Some(Slice::Decision) => self.decide(),
            Some(Slice::Judgement) => self.judge_fit(),
            Some(Slice::Result) => {
                self.end_fit();
                self.begin_asked();
            }
        }
        true
    }

    /// True where a fit is to begin.
    fn is_due(&self) -> bool {
        let schedule = &self.schedule;
        let enough = self.end() * 3 >= 9;
        let is_grown = !self.is_quiet && schedule.blocks >= schedule.due_at;
        enough && (schedule.is_final || is_grown)
    }

    #[inline(never)]
    fn sweep(&mut self) {
        let mut marks = Marks {
            front: self.front.as_ref().map_or(0, |front| front.pass.next),
            split: [self.closing, self.waiting].map(|at| at.map_or(0, |closing| closing.end)),
        };
        let noise = self.reference_rad_s();
        let unit = self.front.as_ref().map_or(self.unit_per_kg_m2, |f| f.pass.unit_per_kg_m2);
        let limits = PairLimits {
            turn_rad: self.config.block_turn_rad,
            noise_n_m_s: self.noise_rad_s() / unit,
        };
        self.blocks.sweep(&mut marks, &mut self.open, noise, &limits, self.wheels.axes());
        if let Some(front) = &mut self.front {
            front.pass.next = marks.front;
        }
        for (at, end) in [&mut self.closing, &mut self.waiting].into_iter().zip(marks.split) {
            if let Some(closing) = at {
                closing.end = end;
            }
        }
    }

    /// True where storage is nearly full, unless the window whose end makes room is being completed.
    fn needs_room(&self) -> bool {
        let waits = self.closing.is_some() && self.blocks.is_incompressible();
        self.blocks.is_nearly_full() && !waits
    }

    /// Makes room in storage: by a sweep, or by the end of the window where its blocks cannot be merged.
    #[inline(never)]
    fn make_room(&mut self) {
        // Indices of the task become invalid.
        self.work = Work::Idle;
        self.inquiry = None;
        self.schedule.due_at = self.schedule.due_at.min(self.schedule.blocks);
        if !self.blocks.is_incompressible() {
            self.blocks.compact();
            return;
        }
        self.end_stretch();
    }

    /// The front takes in its next block; false where there is none.
    #[inline(never)]
    fn advance_front(&mut self) -> bool {
        let (end, stretch, period_s) = (self.end(), self.stretch(), self.period_s);
        let has_offset = self.groups.has_offset();
        let Some(front) = &mut self.front else { return false };
        let next = front.pass.next;
        if next >= end {
            return false;
        }
        let unit = front.pass.unit_per_kg_m2;
        let Some(span) = self.blocks.span(next, &stretch, unit, period_s, has_offset) else {
            return false;
        };
        let residuals = &front.pass.residuals;
        let was_contradicted = residuals.is_contradicted || residuals.has_many_low();
        front.pass.take(&span);
        let is_outgrown = front.is_outgrown();
        let residuals = &front.pass.residuals;
        let is_contradicted = residuals.is_contradicted || residuals.has_many_low();
        if !front.pass.is_finite() {
            self.front = None;
            self.schedule.due_at = self.schedule.blocks;
        } else if self.closing.is_none() && self.has_walked_too_far() {
            self.end_stretch();
        } else if is_contradicted && !was_contradicted {
            self.schedule.due_at = self.schedule.blocks;
        } else if is_outgrown {
            let earliest = self.schedule.fitted.saturating_add(FIRST_FIT_BLOCKS / 2);
            self.schedule.due_at = self.schedule.due_at.min(earliest);
        }
        true
    }

    /// True where the inertia may have walked by more than the sigma of a window since it began: its mean over
    /// the window is no longer its value.
    ///
    /// The expected square of the walk in sigmas is `Σ Iᵢᵢ σᵢ²(t)` over the six coordinates, with I the
    /// information of the window.
    fn has_walked_too_far(&self) -> bool {
        let walk = self.config.inertia_walk_kg_m2_sqrt_s;
        let Some(Front { pass, .. }) = self.front.as_ref().filter(|_| walk > T::zero()) else {
            return false;
        };
        let share = walk * pass.unit_per_kg_m2 * pass.point.scale();
        let variance = share * share * self.open.duration_s;
        let first = crate::trajectory::unknowns::shape_of(U);
        let mut square = T::zero();
        for (k, times) in crate::fit::belief::WALKED.into_iter().enumerate() {
            square += information_from(first, &pass.factor, first + k) * T::count(times);
        }
        let noise = self.noise_rad_s();
        square * variance > T::lit(6.0 * MOST_WALKED) * (noise * noise)
    }

    /// Begins a fit over all blocks.
    #[inline(never)]
    fn begin_fit(&mut self) {
        self.schedule.fitted = self.schedule.blocks;
        let is_final = core::mem::take(&mut self.schedule.is_final);
        // Set again when it ends.
        self.schedule.due_at = u32::MAX;
        if !is_final && self.continues_inquiry() {
            return self.begin_asked();
        }
        let (from, end) = (0, self.end());
        match self.carried_point() {
            Some((point, unit)) => {
                let holds_modes = self.front.as_ref().is_none_or(|f| f.pass.holds_modes);
                self.prepare_descent(from, end, Attempt::Carried);
                if let Work::Descent(descent) = &mut self.work {
                    descent.pass.holds_modes = holds_modes;
                }
                self.begin_pass(&point, unit);
            }
            None => self.begin_start(from, end, None),
        }
    }

    /// Solution of the front as the start of a fit, if its data determine the shape.
    #[inline(never)]
    fn carried_point(&self) -> Option<(Point<T, U>, T)> {
        let front = self.front.as_ref().filter(|f| f.is_shape_observed && f.is_settled)?;
        let unit = front.pass.unit_per_kg_m2;
        let stretch = self.stretch();
        let wheels = stretch.wheels_n_m_s * unit;
        let holds_modes = front.pass.holds_modes;
        let step = front.pass.solution(&Beliefs { holds_modes, ..self.beliefs(unit) })?;
        let mut point = front.pass.point_after(&step, &wheels, &self.groups);
        if stretch.rest.weight > T::zero() {
            // The window may begin later now: at the end of its rest.
            let drive = axes_at(&point, &self.groups, self.wheels.axes()) * wheels;
            point.set_momentum(&momentum_of(&point, &stretch.rest.rate_rad_s, &drive));
        }
        Some((point, unit))
    }

    /// Begins a linear start, without a disturbance torque first.
    pub(super) fn begin_start(&mut self, from: usize, end: usize, chosen: Option<Chosen<T, U>>) {
        self.begin_start_with(false, from, end, chosen);
    }

    fn begin_start_with(
        &mut self,
        has_torque: bool,
        from: usize,
        end: usize,
        chosen: Option<Chosen<T, U>>,
    ) {
        let stretch = self.start_of(from);
        self.prepare_start(&stretch, has_torque, from, end, chosen);
        if let Work::Start { linear, .. } = &mut self.work {
            linear.add_rest(&stretch.rest, self.wheels.axes());
        }
    }

    /// Linear start before its first row. Not inlined: it takes a copy on the stack.
    #[inline(never)]
    fn prepare_start(
        &mut self,
        stretch: &Stretch<T, W>,
        has_torque: bool,
        from: usize,
        end: usize,
        chosen: Option<Chosen<T, U>>,
    ) {
        let blocks = (from..end).filter_map(|i| self.blocks.block(i));
        let axes = self.wheels.axes();
        let linear = LinearStart::new(blocks, axes, stretch, from, self.blocks.usual(), has_torque);
        self.work = Work::Start { linear, from, end, chosen };
    }

    /// Stretch that begins with block `from`, which is not the first one.
    pub(super) fn stretch_from(&self, from: usize) -> Stretch<T, W> {
        let before = from.checked_sub(1).and_then(|i| self.blocks.block(i));
        let wheels = before.map_or(Momenta::zeros(), |block| block.wheels_end_n_m_s);
        Stretch { wheels_n_m_s: wheels, rest: Rest::none(), ..self.stretch() }
    }

    /// Takes in a block where the task lies: a copy of the task costs as much as a block.
    #[inline(never)]
    fn take_block(&mut self) {
        let mut span = None;
        if let Work::Descent(Descent { pass, from, .. }) = &self.work {
            let stretch = self.start_of(*from);
            let has_offset = self.groups.has_offset();
            let unit = pass.unit_per_kg_m2;
            span = self.blocks.span(pass.next, &stretch, unit, self.period_s, has_offset);
        }
        match (&mut self.work, span) {
            (Work::Descent(descent), Some(span)) => descent.pass.take(&span),
            (Work::Start { linear, .. }, _) => match self.blocks.block(linear.next) {
                Some(block) => linear.take(block, self.wheels.axes()),
                None => self.work = Work::Idle,
            },
            _ => self.work = Work::Idle,
        }
    }

    /// Decides after a pass. Calls in sequence: each has one copy of a task on the stack.
    #[inline(never)]
    fn decide(&mut self) {
        match self.after_pass() {
            None => {}
            Some(After::End { is_settled }) => {
                if let Work::Descent(descent) = &mut self.work {
                    descent.fit = Some(Fit::ended(descent.from, is_settled));
                }
            }
            Some(After::Start { has_torque, from, end, chosen }) => {
                self.begin_start_with(has_torque, from, end, chosen);
            }
        }
    }

    /// Solution of the linear start, and descent from it.
    #[inline(never)]
    fn end_start(&mut self) {
        let Work::Start { linear, from, end, chosen } = &self.work else { return };
        let (from, end, chosen) = (*from, *end, *chosen);
        let attempt = if linear.has_torque { Attempt::Torque } else { Attempt::Linear };
        let first = linear.conclude(self.noise_rad_s());
        self.begin_descent(&first, attempt, from, end, chosen);
    }

    fn start_of(&self, from: usize) -> Stretch<T, W> {
        if from == 0 { self.stretch() } else { self.stretch_from(from) }
    }

    /// Descent without a first point yet. Not inlined: it takes a copy on the stack.
    #[inline(never)]
    fn prepare_descent(&mut self, from: usize, end: usize, attempt: Attempt) {
        self.work = Work::Descent(Descent::new(from, end, attempt));
    }

    /// Descent from the linear start.
    #[inline(never)]
    fn begin_descent(
        &mut self,
        first: &FirstPoint<T>,
        attempt: Attempt,
        from: usize,
        end: usize,
        chosen: Option<Chosen<T, U>>,
    ) {
        let unit = first.per_kg_m2.unwrap_or_else(|| self.known_scale());
        let mut point = Point::sphere(Vec3::zeros());
        point.set_shape(&first.shape);
        for place in 0..groups_of(U) {
            if self.groups.is_at(place, Group::Torque) {
                point.set_place(place, &first.torque);
            }
        }
        self.set_initial_rate(&mut point, from, unit);
        self.prepare_descent(from, end, attempt);
        if let Work::Descent(descent) = &mut self.work {
            (descent.linear, descent.chosen) = (Some(point), chosen);
        }
        self.begin_pass(&point, unit);
    }

    /// Inverse trace without help of the data: of earlier windows, of the prior, or of before, 1/(kg m²).
    fn known_scale(&self) -> T {
        let trace = |j: &[T; 6]| j[0] + j[1] + j[2];
        match (&self.past, &self.config.prior) {
            (Some(past), _) => past.per_kg_m2,
            (None, Some(prior)) => T::one() / trace(&prior.inertia_kg_m2),
            (None, None) => T::one(),
        }
    }

    /// Momentum of a point from the measured rate at the first block.
    #[inline(never)]
    fn set_initial_rate(&self, point: &mut Point<T, U>, from: usize, unit: T) {
        let stretch = self.start_of(from);
        let rate = if stretch.rest.weight > T::zero() {
            stretch.rest.rate_rad_s
        } else {
            self.blocks.block(from).map_or(Vec3::zeros(), |block| block.rate_rad_s)
        };
        let axes = axes_at(point, &self.groups, self.wheels.axes());
        let drive = axes * (stretch.wheels_n_m_s * unit);
        point.set_momentum(&momentum_of(point, &rate, &drive));
    }

    /// Begins a pass about a point.
    #[inline(never)]
    pub(super) fn begin_pass(&mut self, point: &Point<T, U>, unit: T) {
        let Work::Descent(descent) = &self.work else { return };
        let Descent { from, attempt, has_walk, considering, typical_rad_s, .. } = descent;
        let stretch = self.start_of(*from);
        let (noise, reference) = (self.noise_rad_s(), self.reference_rad_s());
        let typical = match &self.front {
            _ if *has_walk => noise,
            _ if *typical_rad_s > T::zero() => *typical_rad_s,
            Some(Front { pass, .. }) if *attempt == Attempt::Carried => {
                pass.residuals.typical(pass.unit_rad_s)
            }
            _ if *attempt == Attempt::Best => noise,
            _ => noise * T::lit(crate::fit::descent::UNKNOWN_SCALE),
        };
        let walked = self.bias_walked_rad_s();
        let torque_per_rad = if *has_walk { self.torque_per_rad(point, unit) } else { T::zero() };
        let rest_s = stretch.rest.weight * self.period_s;
        let of_pass = (C > 0).then(|| self.groups_of_pass(*considering));
        let groups = of_pass.as_ref().unwrap_or(&self.groups);
        let Work::Descent(Descent { pass, from, end, .. }) = &mut self.work else { return };
        pass.torque_per_rad = torque_per_rad;
        pass.drift = Drift::new(walked, noise, stretch.duration_s, rest_s);
        let (scale, explained) = (typical.max(noise), pass.explained * T::lit(EXPLAINED_SQUARE));
        let watch = scale.max(reference);
        pass.scale_rad_s = (scale * scale + explained).sqrt();
        pass.watch_rad_s = (watch * watch + explained).sqrt();
        pass.unit_rad_s = noise;
        pass.unit_per_kg_m2 = unit;
        let wheels = stretch.wheels_n_m_s * unit;
        let axes = self.wheels.axes();
        if !pass.begin(point, groups, axes, *from, &stretch.rest, &wheels) {
            pass.next = *end;
            pass.residuals.cost = T::MAX;
        }
    }

    /// Walk of the torque of fields over the trace at a point, over the noise: variance for each radian, 1/s².
    fn torque_per_rad(&self, point: &Point<T, U>, unit: T) -> T {
        let of_trace = self.config.varying_torque_n_m * unit * point.scale();
        let share = of_trace / self.noise_rad_s();
        let stretch = self.stretch();
        share * share * per_rad(turn_against_field(stretch.turn_rad, stretch.duration_s))
    }

    /// Present task, and all knowledge beside the blocks.
    fn task(&mut self, unit_per_kg_m2: T) -> (Beliefs<'_, T, U>, &mut Work<T, W, U, M>) {
        let noise_rad_s = self.noise_rad_s();
        let has_prior = self.has_prior && !self.is_doubtful;
        let bias_walked_rad_s = self.bias_walked_rad_s();
        let Self { groups, config, past, work, .. } = self;
        let prior = config.prior.as_ref().filter(|_| has_prior);
        let past = past.as_ref();
        let beliefs = Beliefs {
            groups,
            prior,
            past,
            unit_per_kg_m2,
            noise_rad_s,
            holds_hardware: false,
            holds_modes: false,
            bias_walked_rad_s,
            has_varying_torque: config.varying_torque_n_m > T::zero(),
        };
        (beliefs, work)
    }

    /// After a pass over all blocks of a descent.
    #[inline(never)]
    fn after_pass(&mut self) -> Option<After<T, U>> {
        let Work::Descent(descent) = &self.work else { return None };
        match descent.considering {
            Considering::Not => {}
            Considering::Group(index) => {
                self.take_cross(index);
                self.consider(index.saturating_add(1));
                return None;
            }
            Considering::Done => return self.after_attempt(true, true),
        }
        let unit = descent.pass.unit_per_kg_m2;
        let wheels = self.start_of(descent.from).wheels_n_m_s * unit;
        let (beliefs, work) = self.task(unit);
        let Work::Descent(descent) = work else { return None };
        match descent.after_pass(&beliefs, &wheels) {
            Next::Pass(point) => {
                self.begin_pass(&point, unit);
                None
            }
            Next::Final => {
                self.begin_final_pass(unit);
                None
            }
            Next::End { is_settled: true } if self.considers() => {
                self.consider(0);
                None
            }
            Next::End { is_settled } => self.after_attempt(is_settled, true),
            Next::Failed => self.after_attempt(false, false),
        }
    }

    /// Begins the pass that judges the residuals at the solution.
    #[inline(never)]
    fn begin_final_pass(&mut self, unit: T) {
        let (beliefs, work) = self.task(unit);
        let Work::Descent(Descent { pass, .. }) = work else { return };
        let (point, step) = (pass.point, pass.solution(&beliefs));
        self.begin_pass(&point, unit);
        if let Work::Descent(descent) = &mut self.work {
            descent.pass.offset = step.unwrap_or([T::zero(); U]);
        }
    }

    /// After an attempt: another one, or the result.
    #[inline(never)]
    fn after_attempt(&mut self, is_settled: bool, is_at_end: bool) -> Option<After<T, U>> {
        let Work::Descent(Descent { pass, attempt, .. }) = &self.work else { return None };
        let unit = pass.unit_per_kg_m2;
        let is_good = is_settled && self.is_explained(pass);
        // A change within the blocks is not a matter of where the descent starts.
        let is_sound_start =
            *attempt == Attempt::Carried || self.inquiry.is_some_and(|i| i.has_asked);
        let residuals = &pass.residuals;
        let is_changed =
            is_settled && is_sound_start && (residuals.is_contradicted || residuals.has_many_low());
        if is_good || is_changed || *attempt == Attempt::Best {
            return Some(After::End { is_settled });
        }
        if let (beliefs, Work::Descent(descent)) = self.task(unit) {
            let at_end = (
                descent.pass.point,
                descent.pass.residuals.cost + beliefs.cost(&descent.pass.point),
            );
            let ended = if is_at_end { Some(at_end) } else { descent.accepted() };
            if let Some((point, cost)) = ended
                && descent.chosen.is_none_or(|(_, (least, _))| cost < least)
            {
                descent.chosen = Some((point, (cost, unit)));
            }
        }
        self.next_attempt(is_settled)
    }

    #[inline(never)]
    fn next_attempt(&mut self, is_settled: bool) -> Option<After<T, U>> {
        let Work::Descent(descent) = &self.work else { return None };
        let &Descent { from, end, linear, chosen, .. } = descent;
        let attempt = match (descent.attempt, linear) {
            (Attempt::Carried, _) => {
                return Some(After::Start { has_torque: false, from, end, chosen });
            }
            (Attempt::Linear, _) if self.solves_for_torque() => {
                return Some(After::Start { has_torque: true, from, end, chosen });
            }
            (Attempt::Linear | Attempt::Torque, Some(_)) => Attempt::Sphere,
            (Attempt::Sphere, Some(_)) if self.has_other_start() => Attempt::Prior,
            _ => Attempt::Best,
        };
        let unit = descent.pass.unit_per_kg_m2;
        let (mut point, mut unit) = (linear.unwrap_or(descent.pass.point), unit);
        match attempt {
            Attempt::Sphere if M > 0 => self.set_modes(&mut point),
            Attempt::Sphere => {
                let scale = point.scale();
                point = Point::sphere(Vec3::zeros());
                point.set_scale(scale);
                self.set_initial_rate(&mut point, from, unit);
            }
            Attempt::Prior => {
                unit = self.known_scale();
                point = self.other_start(unit);
                self.set_initial_rate(&mut point, from, unit);
            }
            _ => match chosen {
                Some((chosen, (_, of_chosen))) => (point, unit) = (chosen, of_chosen),
                None => return Some(After::End { is_settled }),
            },
        }
        if let Work::Descent(descent) = &mut self.work {
            descent.restart(attempt);
            descent.pass.holds_modes &= attempt != Attempt::Sphere;
        }
        self.begin_pass(&point, unit);
        None
    }

    /// Sets the modal inertias to a share of the tensor.
    fn set_modes(&self, point: &mut Point<T, U>) {
        let [xx, yy, zz, xy, xz, yz] = point.over_trace().map(|n| n * T::lit(MODAL_SHARE));
        for place in 0..groups_of(U) {
            match self.groups.place.get(place) {
                Some(Some((Group::ModalMoments(_), _))) => {
                    point.set_place(place, &Vec3::new(xx, yy, zz));
                }
                Some(Some((Group::ModalProducts(_), _))) => {
                    point.set_place(place, &Vec3::new(xy, xz, yz));
                }
                _ => {}
            }
        }
    }

    fn solves_for_torque(&self) -> bool {
        if groups_of(U) == 0 {
            return false;
        }
        let is_solved = |at: &Option<(Group, Belief<T>)>| {
            matches!(at, Some((Group::Torque, Belief::Within(_))))
        };
        self.groups.place.iter().any(is_solved)
    }

    fn has_other_start(&self) -> bool {
        self.past.is_some() || self.config.prior.is_some()
    }

    /// Point of earlier windows, or of the prior.
    fn other_start(&self, unit: T) -> Point<T, U> {
        let of_past = self.past.as_ref().and_then(|past| past.point(unit));
        let of_prior = || {
            let shape = self.config.prior.as_ref().map(crate::fit::belief::shape_of_prior);
            let mut point = Point::sphere(Vec3::zeros());
            point.set_shape(&shape.unwrap_or([T::zero(); 5]));
            point
        };
        of_past.unwrap_or_else(of_prior)
    }

    /// True where the residuals of a pass agree with the noise, but for outliers: those at the point, or
    /// those at the solution of the blocks alone, from which earlier windows and the prior may differ.
    #[inline(never)]
    pub(super) fn is_explained(&self, pass: &Pass<T, W, U, M>) -> bool {
        let at_point = pass.residuals.typical(pass.unit_rad_s);
        let typical = at_point.min(super::report::rms(&pass.residuals, U));
        let most = self.reference_rad_s() * T::lit(EXPLAINED);
        typical * typical <= most * most + self.explained(pass)
            && !pass.residuals.has_many_low()
            && pass.is_finite()
    }

    /// Judges what the fit that has ended observes.
    #[inline(never)]
    fn judge_fit(&mut self) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let observed = self.observed_by(pass);
        if let Work::Descent(Descent { fit: Some(fit), .. }) = &mut self.work {
            fit.observed = Some(observed);
        }
    }

    /// The fit that has ended, with all judgements.
    fn judged_fit(&self) -> Option<Fit> {
        let Work::Descent(Descent { pass, fit: Some(fit), .. }) = &self.work else { return None };
        Some(Fit {
            is_good: self.is_good(pass, fit.is_settled),
            is_shape_observed: self.is_shape_observed(pass),
            ..*fit
        })
    }

    /// Result of all attempts: the new front, or an answer to the inquiry. Calls in sequence: each has a factor of its
    /// own on the stack.
    #[inline(never)]
    fn end_fit(&mut self) {
        let Some(fit) = self.judged_fit() else { return };
        if self.inquiry.as_ref().is_some_and(|inquiry| inquiry.has_asked) {
            self.answer(&fit);
            self.work = Work::Idle;
            return;
        }
        self.schedule.wait_for_growth(FIRST_FIT_BLOCKS / 2);
        self.take_front(&fit);
        self.work = Work::Idle;
        if fit.is_good {
            if self.lets_drag_loose() || self.drop_contradicted() {
                self.schedule.due_at = self.schedule.blocks;
            }
            self.inquiry = None;
            self.reconsider();
        } else {
            self.inquire();
        }
    }

    /// The fit that has ended becomes the front.
    #[inline(never)]
    pub(super) fn take_front(&mut self, fit: &Fit) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let rows = pass.residuals.rows;
        self.front = Some(Front::new(pass, fit));
        if let Some(front) = &mut self.front {
            front.pass.residuals.curvature.end();
        }
        self.take_front_cross(rows);
    }

    /// True for a fit at a minimum whose residuals agree with the noise from the first block to the last.
    pub(super) fn is_good(&self, pass: &Pass<T, W, U, M>, is_settled: bool) -> bool {
        is_settled && self.is_explained(pass) && !pass.residuals.is_contradicted
    }

    /// True where the sigma of every coordinate of the shape is well below its range.
    #[inline(never)]
    fn is_shape_observed(&self, pass: &Pass<T, W, U, M>) -> bool {
        let mut factor = pass.factor;
        let beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.add(&mut factor, &pass.point);
        let Some(variances) = factor.variances() else { return false };
        let most = T::lit(SHAPE_OBSERVED * crate::fit::belief::SHAPE_SIGMA) / beliefs.noise_rad_s;
        let shape = crate::trajectory::unknowns::shape_of(U);
        variances.iter().skip(shape).take(5).all(|v| *v < most * most)
    }

    /// Contradiction of each group that is assumed to be absent by the blocks of a fit: chi-square of three degrees
    /// of freedom. A stated noise that is too small does not exaggerate it.
    #[inline(never)]
    pub(super) fn contradictions(&self, pass: &Pass<T, W, U, M>) -> [T; GROUPS] {
        if groups_of(U) == 0 {
            return [T::zero(); GROUPS];
        }
        let mut factor = pass.factor;
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.noise_rad_s = beliefs.noise_rad_s.max(self.sigma_of_sample(pass));
        beliefs.add(&mut factor, &pass.point)
    }

    /// Drag becomes an unknown where the blocks of the front contradict its absence.
    #[inline(never)]
    fn lets_drag_loose(&mut self) -> bool {
        if groups_of(U) == 0 {
            return false;
        }
        let Some(drag) = self.config.drag_per_s else { return false };
        let Some(Front { pass, .. }) = &self.front else { return false };
        let contradiction = self.contradictions(pass);
        let mut is_loose = false;
        for (place, of_place) in self.groups.place.iter_mut().enumerate() {
            let is_shown = contradiction[place] > T::lit(DRAG_SHOWN);
            if is_shown && matches!(of_place, Some((Group::Drag, Belief::Zero))) {
                *of_place = Some((Group::Drag, Belief::Within([drag; 3])));
                is_loose = true;
            }
        }
        if is_loose {
            let hardware = self.groups.hardware;
            for of_place in self.groups.place.iter_mut().take(hardware) {
                if of_place.is_none() {
                    let bias = Belief::Within([T::lit(BIAS_WITH_DRAG_RAD_S); 3]);
                    *of_place = Some((Group::Bias, bias));
                    break;
                }
            }
        }
        is_loose
    }

    /// Concludes the window that is being closed: its information goes to the past.
    #[inline(never)]
    pub(super) fn conclude(&mut self) {
        let end = self.end();
        self.join_past();
        self.front = None;
        self.closing = self.waiting.take();
        self.work = Work::Idle;
        self.inquiry = None;
        self.blocks.drop_before(end);
        let further = self.blocks.len().saturating_sub(end) as u32;
        let is_final = self.closing.is_some();
        self.schedule = Schedule { blocks: further, is_final, ..Schedule::new() };
        self.schedule.reopen();
        self.config.set_groups::<U>(&mut self.groups);
    }

    /// Adds the information of the front to that of the windows before it, unless these contradict it.
    #[inline(never)]
    fn join_past(&mut self) {
        let Some(front) = &self.front else { return };
        let is_good = self.is_good(&front.pass, front.is_settled);
        self.ended = self.ended_with(front);
        if !is_good {
            return;
        }
        let walk = self.walk_kg_m2();
        if let Some(past) = &mut self.past {
            past.walk(walk);
        }
        self.drop_contradicted();
        self.reconsider();
        if self.replace_past() {
            // The mean over the window is a third of it away from its end in variance.
            self.past_age_s = self.stretch().duration_s * T::lit(1.0 / 3.0);
        }
    }

    /// Information of the front, joined with that of the windows before it, as that of earlier windows. False where it
    /// is not finite.
    #[inline(never)]
    fn replace_past(&mut self) -> bool {
        let Some(Front { pass, .. }) = &self.front else { return false };
        let mut window = SquareRootInformation::default();
        self.information(pass, &mut window);
        let unit = pass.unit_per_kg_m2;
        if let Some(past) = &self.past {
            past.add_to(&mut window, &pass.point, unit);
        }
        let (scale, sigma) = (pass.point.scale(), self.sigma_of_sample(pass));
        if C > 0 {
            self.join_cross(Source::Front, (unit, scale), sigma);
        }
        let Some(Front { pass, .. }) = &self.front else { return false };
        let is_finite = Past::replace(&mut self.past, &mut window, &pass.point, unit);
        if let (true, Some(past)) = (is_finite, &self.past) {
            self.unit_per_kg_m2 = past.per_kg_m2;
        }
        is_finite
    }

    /// Writes the information of the blocks alone on hardware and inertia, of unit variance, to `window`.
    pub(super) fn information(
        &self,
        pass: &Pass<T, W, U, M>,
        window: &mut SquareRootInformation<T, U>,
    ) {
        let sigma = self.window_alone(pass, window);
        window.rescale(T::one(), T::one() / (sigma * sigma));
        // The pins of what does not last stay as they are.
        window.eliminate(self.groups.first_kept::<U>());
    }

    /// Discards earlier windows and the prior where the blocks of the front contradict them. True if it
    /// did.
    fn drop_contradicted(&mut self) -> bool {
        let is_contradicted = self.is_contradicted();
        if is_contradicted {
            self.forget_past();
        }
        is_contradicted
    }

    /// True where the blocks of the front contradict earlier windows and the prior.
    #[inline(never)]
    fn is_contradicted(&self) -> bool {
        let Some(Front { pass, .. }) = &self.front else { return false };
        let mut window = SquareRootInformation::default();
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.noise_rad_s = self.window_alone(pass, &mut window);
        beliefs.add_hardware(&mut window, &pass.point);
        if C > 0 {
            let past = self.past.as_ref().map(|past| (past, &self.considered.past));
            self.widen(&mut window, (pass.unit_per_kg_m2, beliefs.noise_rad_s), past);
        }
        beliefs.contradiction(&mut window, &pass.point) > beliefs.contradicted()
    }

    /// Writes the information of the blocks alone on hardware and inertia to `window`, in units of a sample's variance.
    /// Returns the sigma of a sample.
    #[inline(never)]
    pub(super) fn window_alone(
        &self,
        pass: &Pass<T, W, U, M>,
        window: &mut SquareRootInformation<T, U>,
    ) -> T {
        *window = pass.factor;
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        let sigma = self.sigma_of_sample(pass);
        beliefs.noise_rad_s = sigma;
        beliefs.add_of_window(window, &pass.point);
        window.eliminate(self.groups.first_kept::<U>());
        sigma
    }
}
