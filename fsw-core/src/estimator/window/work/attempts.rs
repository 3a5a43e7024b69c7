//! Attempts of a fit: linear start, descent from it, and further starts where its end is not explained.

use super::Chosen;
use super::Work;
use crate::blocks::stretch::{Rest, Stretch};
use crate::dynamics::wheels::Momenta;
use crate::estimator::window::Window;
use crate::estimator::window::considered::EXPLAINED_SQUARE;
use crate::fit::belief::Beliefs;
use crate::fit::descent::{Attempt, Considering, Descent, Next, momentum_of};
use crate::fit::drift::{Drift, per_rad, turn_against_field};
use crate::fit::front::{Fit, Front};
use crate::fit::start::{FirstPoint, LinearStart};
use crate::math::{Vec3, scalar::Real};
use crate::trajectory::axes_at;
use crate::trajectory::unknowns::{Belief, Group, Point, groups_of};

/// Next task after the last pass of an attempt.
#[derive(Clone, Copy, Debug)]
enum After<T: Real, const U: usize> {
    /// Another linear start.
    Start { has_torque: bool, from: usize, end: usize, chosen: Option<Chosen<T, U>> },
    /// The result of all attempts.
    End { is_settled: bool },
}

/// Modal inertia of a start over the tensor. A body raises the frequency of a mode of share s by s/2: from no inertia a
/// mode of 1 % damping keeps within a radian of phase up to a share of 3 %, from this one from 3 to 9 %.
const MODAL_SHARE: f64 = 0.06;
/// Newton decrement up to which the front is judged without a pass, σ²: a sixth of a sigma from the minimum.
const LINEAR: f64 = 0.03;

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// Solution of the front as the start of a fit, if its data determine the shape: with its unit, and the decrement of
    /// the step to it.
    #[inline(never)]
    pub(super) fn carried_point(&self) -> Option<(Point<T, U>, T, T)> {
        let front = self.front.as_ref().filter(|f| f.is_shape_observed && f.is_settled)?;
        let unit = front.pass.unit_per_kg_m2;
        let stretch = self.stretch();
        let wheels = stretch.wheels_n_m_s * unit;
        let holds_modes = front.pass.holds_modes;
        let beliefs = Beliefs { holds_modes, ..self.beliefs(unit) };
        let (step, decrement) = front.pass.solution(&beliefs)?;
        let mut point = front.pass.point_after(&step, &wheels, &self.groups);
        if stretch.rest.weight > T::zero() && !self.config.is_walking() {
            // The window may begin later now: at the end of its rest.
            let drive = axes_at(&point, &self.groups, self.wheels.axes()) * wheels;
            point.set_momentum(&momentum_of(&point, &stretch.rest.rate_rad_s, &drive));
        }
        Some((point, unit, decrement))
    }

    /// True for a front that is outgrown, but explained, and linear enough for a step of this decrement from its point: the
    /// error of a step grows with the square of the step. With places for considered hardware a fit is needed: its passes
    /// find the effect of the hardware.
    pub(super) fn is_front_linear(&self, decrement: T) -> bool {
        let is_open = self.inquiry.is_some() || self.is_doubtful;
        let may_judge = C == 0 && !is_open;
        let front = self.front.as_ref().filter(|front| may_judge && front.is_outgrown());
        front.is_some_and(|Front { pass, is_settled, .. }| {
            let expected = pass.curvature_per_sigma2 * decrement * decrement;
            expected < T::lit(LINEAR) && self.is_good(pass, *is_settled)
        })
    }

    /// Begins the judgement of the front as a fit that has ended.
    #[inline(never)]
    pub(super) fn judge_front(&mut self) {
        self.prepare_descent(0, self.end(), Attempt::Carried);
        if let (Work::Descent(descent), Some(front)) = (&mut self.work, &self.front) {
            descent.pass = front.pass;
            descent.fit = Some(Fit::ended(0, true));
        }
    }

    /// Begins a linear start, without a disturbance torque first.
    pub(in super::super) fn begin_start(
        &mut self,
        from: usize,
        end: usize,
        chosen: Option<Chosen<T, U>>,
    ) {
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
        self.blocks.fill_holes(from, end, self.period_s);
        let blocks = (from..end).filter_map(|i| self.blocks.block(i));
        let axes = self.wheels.axes();
        let linear = LinearStart::new(blocks, axes, stretch, from, self.blocks.usual(), has_torque);
        self.work = Work::Start { linear, from, end, chosen };
    }

    /// Stretch that begins with block `from`, which is not the first one.
    pub(in super::super) fn stretch_from(&self, from: usize) -> Stretch<T, W> {
        let before = from.checked_sub(1).and_then(|i| self.blocks.block(i));
        let wheels = before.map_or(Momenta::zeros(), |block| block.wheels_end_n_m_s);
        Stretch { wheels_n_m_s: wheels, rest: Rest::none(), ..self.stretch() }
    }

    /// Takes in a block where the task lies: a copy of the task costs as much as a block.
    #[inline(never)]
    pub(super) fn take_block(&mut self) {
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
    pub(super) fn decide(&mut self) {
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
    pub(super) fn end_start(&mut self) {
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
    pub(super) fn prepare_descent(&mut self, from: usize, end: usize, attempt: Attempt) {
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

    /// Inverse trace without help of the present blocks: of earlier windows, of the prior, or of the fit before, 1/(kg m²).
    fn known_scale(&self) -> T {
        let trace = |j: &[T; 6]| j[0] + j[1] + j[2];
        match (&self.past, &self.config.prior) {
            (Some(past), _) => past.per_kg_m2,
            (None, Some(prior)) => T::one() / trace(&prior.inertia_kg_m2),
            (None, None) => self
                .front
                .as_ref()
                .map_or(T::one(), |Front { pass, .. }| pass.unit_per_kg_m2 * pass.point.scale()),
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
    pub(in super::super) fn begin_pass(&mut self, point: &Point<T, U>, unit: T) {
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
        let (torque_per_rad, inertia_per_s) = if *has_walk {
            (self.torque_per_rad(point, unit), self.inertia_per_s(point, unit))
        } else {
            (T::zero(), T::zero())
        };
        let rest_s = stretch.rest.weight * self.period_s;
        let of_pass = (C > 0).then(|| self.groups_of_pass(*considering));
        let groups = of_pass.as_ref().unwrap_or(&self.groups);
        let past = self.past.as_ref().filter(|_| inertia_per_s > T::zero() && *from == 0);
        let Work::Descent(Descent { pass, from, end, .. }) = &mut self.work else { return };
        (pass.torque_per_rad, pass.inertia_per_s) = (torque_per_rad, inertia_per_s);
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
        } else if let Some(past) = past {
            pass.begin_with(past, groups);
        }
    }

    /// Walk of the torque of fields over the trace at a point, over the noise: variance for each radian, 1/s².
    fn torque_per_rad(&self, point: &Point<T, U>, unit: T) -> T {
        let of_trace = self.config.varying_torque_n_m * unit * point.scale();
        let share = of_trace / self.noise_rad_s();
        let stretch = self.stretch();
        let has_field = self.config.has_field::<U>();
        let turn_rad = if has_field { T::zero() } else { stretch.turn_rad };
        share * share * per_rad(turn_against_field(turn_rad, stretch.duration_s))
    }

    /// Walk of a moment over the trace at a point, over the noise: variance for each second, s.
    fn inertia_per_s(&self, point: &Point<T, U>, unit: T) -> T {
        let share =
            self.config.inertia_walk_kg_m2_sqrt_s * unit * point.scale() / self.noise_rad_s();
        share * share
    }

    /// Present task, and all knowledge beside the blocks.
    fn task(&mut self, unit_per_kg_m2: T) -> (Beliefs<'_, T, U>, &mut Work<T, W, U, M>) {
        let noise_rad_s = self.noise_rad_s();
        let is_doubtful = self.is_doubtful;
        let bias_walked_rad_s = self.bias_walked_rad_s();
        let Self { groups, config, prior, past, work, .. } = self;
        let prior = prior.as_ref().filter(|_| !is_doubtful);
        let is_in_pass =
            matches!(work, Work::Descent(Descent { has_walk: true, .. })) && config.is_walking();
        let past = past.as_ref().filter(|_| !is_in_pass);
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
            has_varying_inertia: config.is_walking(),
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
        let (of_step, is_first) = (descent.last_decrement, descent.accepted().is_none());
        let next = descent.after_pass(&beliefs, &wheels);
        if C == 0 && is_first && descent.accepted().is_some() {
            descent.pass.note_curvature(of_step);
        }
        match next {
            Next::Pass(point) => {
                self.begin_pass(&point, unit);
                None
            }
            Next::Final => {
                self.repeat_pass();
                None
            }
            Next::Again => None,
            Next::End { is_settled: true } if self.considers() => {
                self.consider(0);
                None
            }
            Next::End { is_settled } => self.after_attempt(is_settled, true),
            Next::Failed => self.after_attempt(false, false),
        }
    }

    /// Begins a pass about the same point and for the same solution: it judges the residuals there.
    #[inline(never)]
    pub(in super::super) fn repeat_pass(&mut self) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let (point, offset, unit) = (pass.point, pass.offset, pass.unit_per_kg_m2);
        self.begin_pass(&point, unit);
        if let Work::Descent(descent) = &mut self.work {
            descent.pass.offset = offset;
        }
    }

    /// After an attempt: another one, or the result.
    #[inline(never)]
    fn after_attempt(&mut self, is_settled: bool, is_at_end: bool) -> Option<After<T, U>> {
        let Work::Descent(Descent { pass, attempt, .. }) = &self.work else { return None };
        let unit = pass.unit_per_kg_m2;
        let is_good = is_settled && self.is_explained(pass);
        // A change within the blocks is not a matter of where the descent starts.
        let is_sound_start = *attempt == Attempt::Carried || self.has_asked();
        let residuals = &pass.residuals;
        let is_changed =
            is_settled && is_sound_start && (residuals.is_contradicted || residuals.has_many_low());
        if is_good || is_changed || *attempt == Attempt::Best {
            return Some(After::End { is_settled });
        }
        let cost = pass.residuals.cost + self.beliefs(unit).cost(&pass.point);
        let at_end = (pass.point, cost);
        if let Work::Descent(descent) = &mut self.work {
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
}
