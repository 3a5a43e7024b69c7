//! The work beside taking in samples, in slices of bounded cost.
//!
//! | slice | bound of its cost |
//! |---|---|
//! | sweep of storage | a group of sixteen blocks |
//! | pass | a block: up to three steps and three rows |
//! | front | the same, and a comparison with earlier estimates: a solution of the factor, a covariance of six |
//! | linear start | a block, or the singular values of its triangle |
//! | decision after a pass | up to three solutions of the factor: a step, a damped one, a test |
//! | judgement of a fit | a report: two solutions of the factor, an eigenproblem of six |
//! | result of a fit | two solutions of the factor: whether the blocks explain it and determine the shape |
//! | comparison | up to three solutions of the factor: tests against earlier windows, the prior, and what is doubted |
//! | begin of a fit | norms of all blocks, or a solution of the factor |
//! | conclusion of a window | a solution of six unknowns |

mod attempts;
mod results;

use super::{FIRST_FIT_BLOCKS, Window};
use crate::blocks::storage::{Marks, PairLimits};
use crate::blocks::stretch::Stretch;
use crate::fit::belief::information_from;
use crate::fit::descent::{Attempt, Descent};
use crate::fit::front::{Fit, Front};
use crate::fit::start::LinearStart;
use crate::math::scalar::Real;
use crate::trajectory::unknowns::Point;

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
    /// Comparison of a fit with what is known beside its blocks.
    Comparison,
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
    /// The front is a new fit, explained, and not yet compared with what is known beside its blocks.
    Comparison,
}

/// Solution of an attempt, its cost in rad²/s², and the unit of its scale, 1/(kg m²).
pub type Chosen<T, const U: usize> = (Point<T, U>, (T, T));

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] enum Work<T, W, U, M> {
    0 => Idle,
    1 => Start { linear: LinearStart<T>, from: usize, end: usize, chosen: Option<Chosen<T, U>> },
    2 => Descent(descent: Descent<T, W, U, M>),
    3 => Comparison
});

/// Blocks after which the length of further ones is reconsidered.
const GROUP: u32 = 16;
/// Slices after which [`finish`](Window::finish) gives up: no work is that long. Four attempts of 25
/// passes over 512 blocks, twice for a trial of the blocks since a change, and again for drag.
const MOST_SLICES: u32 = 400_000;
/// Mean square of the walk within a window, over the variance of its end: the first blocks weigh a thirtieth there, and the next
/// window has their information.
const MOST_WALKED: f64 = 30.0;

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

    /// Completes all work on the samples so far. The present block ends with the newest sample. Order: the closing
    /// window, the waiting one, the open one.
    pub(super) fn complete(&mut self) {
        self.drain();
        if let Some(block) = self.averager.as_mut().and_then(super::Averager::finish) {
            self.add_block(&block);
            self.schedule.count_rest();
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
            Work::Comparison => Some(Slice::Comparison),
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
            Some(Slice::Result) => self.end_fit(),
            Some(Slice::Comparison) => self.compare(),
        }
        true
    }

    /// True where a fit is to begin.
    fn is_due(&self) -> bool {
        let schedule = &self.schedule;
        let enough = self.end() * 3 >= 9;
        let is_grown = !self.is_quiet && schedule.blocks >= schedule.due_at;
        self.has_asked() || enough && (schedule.is_final || is_grown)
    }

    #[inline(never)]
    fn sweep(&mut self) {
        let mut marks = Marks {
            front: self.front.as_ref().map_or(0, |front| front.pass.next),
            split: [self.closing, self.waiting].map(|at| at.map_or(0, |closing| closing.end)),
        };
        let (noise, limits) = (self.reference_rad_s(), self.pair_limits());
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

    /// Limits of blocks that are merged.
    fn pair_limits(&self) -> PairLimits<T> {
        let unit = self.front.as_ref().map_or(self.unit_per_kg_m2, |f| f.pass.unit_per_kg_m2);
        let nutation = self.front.as_ref().map(|front| front.pass.trajectory.nutation_rad_s());
        PairLimits {
            turn_rad: self.config.block_turn_rad,
            noise_n_m_s: self.noise_rad_s() / unit,
            nutation_rad_s: nutation.unwrap_or(T::zero()),
            period_s: self.period_s,
        }
    }

    /// Blocks of a motion that has become faster are shorter from now on. After each group of blocks.
    #[inline(never)]
    fn watch_length(&mut self) {
        let least = T::count(self.config.block_samples);
        let is_newest =
            self.front.as_ref().is_some_and(|front| front.pass.next == self.blocks.len());
        let is_group = is_newest && self.schedule.blocks.is_multiple_of(GROUP);
        if !is_group || self.blocks.usual() <= least {
            return;
        }
        let (noise, limits) = (self.reference_rad_s(), self.pair_limits());
        if self.blocks.is_coarse(&limits, noise, self.wheels.axes()) {
            self.blocks.shorten();
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
            if let Some(front) = &mut self.front {
                front.pass.residuals.forget_instant();
            }
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
        self.watch_steadiness();
        self.watch_length();
        true
    }

    /// True where the inertia may have walked by many sigmas of a window since it began: its first blocks no longer count.
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

    /// Joins the short blocks of a record that is no longer short, before its first fit; false where there are none.
    fn joins_short_blocks(&mut self) -> bool {
        let is_due = self.is_first_fit() && !self.is_short_record();
        is_due && self.blocks.join_short(self.config.block_turn_rad)
    }

    /// Begins a fit over all blocks, or the one that an inquiry asks for.
    #[inline(never)]
    fn begin_fit(&mut self) {
        if self.begins_asked() || self.joins_short_blocks() {
            return;
        }
        let is_grown = self.schedule.blocks >= self.schedule.grown_at(FIRST_FIT_BLOCKS / 2);
        let fitted = core::mem::replace(&mut self.schedule.fitted, self.schedule.blocks);
        let is_final = core::mem::take(&mut self.schedule.is_final);
        // Set again when it ends.
        self.schedule.due_at = u32::MAX;
        if !is_final && self.continues_inquiry() {
            return;
        }
        if self.is_doubtful {
            self.note_contradiction();
        }
        let (from, end) = (0, self.end());
        let carried = self.carried_point();
        if let Some((_, _, decrement)) = carried
            && C == 0
            && !is_final
            && !is_grown
            && self.is_front_linear(decrement)
        {
            self.schedule.fitted = fitted;
            return self.judge_front();
        }
        match carried {
            Some((point, unit, decrement)) => {
                self.prepare_descent(from, end, Attempt::Carried);
                if let (Work::Descent(descent), Some(Front { pass, .. })) =
                    (&mut self.work, &self.front)
                {
                    descent.pass.holds_modes = pass.holds_modes;
                    descent.pass.curvature_per_sigma2 = pass.curvature_per_sigma2;
                    descent.last_decrement = decrement;
                    if self.config.is_walking() {
                        descent.let_walk();
                    }
                }
                self.begin_pass(&point, unit);
            }
            None => self.begin_start(from, end, None),
        }
    }
}
