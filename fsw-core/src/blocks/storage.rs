//! Blocks of a window in fixed storage, and their compaction.
//!
//! When storage is nearly full, two sweeps make room:
//!
//! 1. *Rest*: groups of sixteen blocks whose rates agree with their mean by a chi-square test become one
//!    block. Groups are judged rather than neighbours: a cut placed where noise peaks would bias
//!    the residuals. Rest before any motion is not even a block: its mean rate and weight become the
//!    measurement of the rate at the start ([`Rest`](super::stretch::Rest)).
//! 2. *Pairs*: where that did not suffice, the number of samples of a usual block doubles, and blocks are
//!    merged two by two as long as they turn little.
//!
//! A sweep goes on by one group a slice, while further blocks are appended.

use super::block::Block;
use super::span::Span;
use super::stretch::{Stretch, largest};
use crate::dynamics::wheels::Momenta;
use crate::math::{Mat, Vec3, largest_component, scalar::Real};
use crate::persist::{Archive, Persist, mix, name};
use heapless::Vec;

/// Blocks judged together.
const GROUP: usize = 16;
/// Share of storage that stays free while a sweep is due: it takes N / 16 slices.
const RESERVE_SHARE: usize = 8;
/// Blocks above which the sweep for rest is followed by that for pairs: three quarters of storage.
const FULL_NUM: usize = 3;
const FULL_DEN: usize = 4;
/// Change of mean wheel momentum below which a leading group still belongs to the rest: as a share of
/// its largest change in the window, and in standard errors of the group's mean by its own scatter, which
/// is that of the tachometers. A ramp over the group moves its mean by seven standard errors, and that of
/// its first half by 3.5.
const STILL_SHARE: f64 = 1e-3;
const STILL_ERRORS: f64 = 3.0;
/// Largest angle of a block of rest within the motion, rad: the mean of a longer one would hide motion.
const REST_TURN: f64 = 0.1;

/// Newest groups that are left as they are: motion that begins in them may not stand out yet.
const NEWEST_GROUPS: usize = 3;

/// No storage is larger.
const MOST_BLOCKS: usize = 1 << 16;

/// Indices that a sweep keeps as boundaries between blocks, and moves along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Marks {
    /// Next block of the front.
    pub front: usize,
    /// Ends of the stretches that are being closed; zero for none.
    pub split: [usize; 2],
}

/// Sweep in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sweep {
    /// Removal of the blocks before `from`.
    Drop,
    Rest,
    Pairs,
}

crate::persist!([] enum Sweep { 0 => Drop, 1 => Rest, 2 => Pairs });

/// Sweep, and the block that it reads and writes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Compaction {
    sweep: Sweep,
    from: usize,
    to: usize,
}

crate::persist!([] Compaction { sweep, from, to }
    if |this| this.to <= this.from && this.from <= MOST_BLOCKS);

/// Up to N blocks.
#[derive(Clone, Debug)]
pub struct Storage<T: Real, const W: usize, const N: usize> {
    blocks: Vec<Block<T, W>, N>,
    compaction: Option<Compaction>,
    /// Number of samples of a usual block.
    usual: T,
    /// True where the last sweep for pairs did not make room.
    is_incompressible: bool,
}

impl<T: Real, const W: usize, const N: usize> Persist for Storage<T, W, N> {
    fn layout() -> u32 {
        let blocks = mix(const { name("Storage") }, <[Block<T, W>; N]>::layout());
        mix(mix(blocks, Option::<Compaction>::layout()), <(T, bool)>::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Self { blocks, compaction, usual, is_incompressible } = self;
        let mut len = blocks.len();
        len.persist(archive);
        if blocks.resize(len, Block::empty()).is_err() {
            return archive.refuse("Storage");
        }
        for block in blocks {
            block.persist(archive);
        }
        compaction.persist(archive);
        usual.persist(archive);
        is_incompressible.persist(archive);
    }
}

impl<T: Real, const W: usize, const N: usize> Storage<T, W, N> {
    /// Empty storage.
    #[inline(always)]
    pub fn new() -> Self {
        Self { blocks: Vec::new(), compaction: None, usual: T::one(), is_incompressible: false }
    }

    /// Removes all blocks; a usual one has this number of samples from now on.
    pub fn clear(&mut self, usual: T) {
        self.blocks.clear();
        self.compaction = None;
        self.usual = usual;
        self.is_incompressible = false;
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Number of samples of a usual block.
    pub fn usual(&self) -> T {
        self.usual
    }

    /// Block `index`.
    pub fn block(&self, index: usize) -> Option<&Block<T, W>> {
        self.blocks.get(index)
    }

    /// Block `index` of a stretch with its wheels and torque times `unit`; samples come every `period_s`. With
    /// its neighbours where the model has a time offset.
    pub fn span(
        &self,
        index: usize,
        start: &Stretch<T, W>,
        unit: T,
        period_s: T,
        has_offset: bool,
    ) -> Option<Span<T, W>> {
        let mut span = self.span_alone(index, start, unit, period_s)?;
        if has_offset {
            let course = |index: usize| {
                self.span_alone(index, start, unit, period_s).map(|span| span.courses())
            };
            span.before = index.checked_sub(1).and_then(course);
            span.after = course(index + 1);
        }
        Some(span)
    }

    fn span_alone(
        &self,
        index: usize,
        start: &Stretch<T, W>,
        unit: T,
        period_s: T,
    ) -> Option<Span<T, W>> {
        let block = self.blocks.get(index)?;
        let before = index.checked_sub(1).and_then(|i| self.blocks.get(i));
        let wheels_at_start = before.map_or(start.wheels_n_m_s, |b| b.wheels_end_n_m_s) * unit;
        let block = Block {
            wheels_n_m_s: block.wheels_n_m_s * unit,
            wheels_end_n_m_s: block.wheels_end_n_m_s * unit,
            impulse_n_m_s: block.impulse_n_m_s * unit,
            beyond_ramp_n_m_s: block.beyond_ramp_n_m_s * unit,
            ..*block
        };
        let samples = (block.duration_s / period_s).max(T::one());
        Some(Span { block, wheels_at_start, samples, before: None, after: None })
    }

    /// Appends a block. Without a free place it joins the last one, so that no time is missing.
    pub fn push(&mut self, block: &Block<T, W>) {
        if self.blocks.push(*block).is_err()
            && let Some(last) = self.blocks.last_mut()
        {
            *last = last.merge(block);
        }
    }

    /// Removes the blocks from `len` on.
    pub fn truncate(&mut self, len: usize) {
        self.blocks.truncate(len);
    }

    /// True while a sweep is in progress: no block may be read.
    pub fn is_compacting(&self) -> bool {
        self.compaction.is_some()
    }

    /// True where it is time to make room.
    pub fn is_nearly_full(&self) -> bool {
        self.len() + N / RESERVE_SHARE >= N
    }

    /// True where the last sweep for pairs did not make room: the blocks turn too far.
    pub fn is_incompressible(&self) -> bool {
        self.is_incompressible
    }

    /// A usual block has this number of samples from now on.
    pub fn set_usual(&mut self, samples: T) {
        self.usual = samples;
    }

    /// Begins to make room.
    pub fn compact(&mut self) {
        self.compaction = Some(Compaction { sweep: Sweep::Rest, from: 0, to: 0 });
    }

    /// Begins to remove the blocks before `index`.
    pub fn drop_before(&mut self, index: usize) {
        let from = index.min(self.len());
        self.compaction = Some(Compaction { sweep: Sweep::Drop, from, to: 0 });
    }

    /// One slice of a sweep: a group of blocks. Rest before the first block goes to `start`.
    #[inline(never)]
    pub fn sweep(
        &mut self,
        marks: &mut Marks,
        start: &mut Stretch<T, W>,
        noise_rad_s: T,
        limits: &PairLimits<T>,
        axes: &Mat<T, 3, W>,
    ) {
        let Some(Compaction { sweep, from, to }) = self.compaction else { return };
        if from >= self.len() {
            self.end_sweep(sweep, from, to, marks);
            return;
        }
        marks.move_to(from, to);
        let end = marks.next_after(from).min(from + GROUP).min(self.len());
        let to = match sweep {
            Sweep::Drop => self.copy(from, end, to),
            Sweep::Rest if end + NEWEST_GROUPS * GROUP > self.len() => self.copy(from, end, to),
            Sweep::Rest => self.sweep_rest(from, end, to, marks, start, noise_rad_s),
            Sweep::Pairs => self.sweep_pairs(from, end, to, start, limits, axes),
        };
        self.compaction = Some(Compaction { sweep, from: end, to });
    }

    /// Ends a sweep, and begins that for pairs where the one for rest did not suffice.
    fn end_sweep(&mut self, sweep: Sweep, from: usize, to: usize, marks: &mut Marks) {
        marks.move_to(from, to);
        self.blocks.truncate(to);
        self.compaction = None;
        self.is_incompressible = sweep == Sweep::Pairs && to + N / 16 > N - N / RESERVE_SHARE;
        if self.is_incompressible {
            // Longer blocks hide motion or drive.
            self.usual *= T::lit(0.5);
        }
        if sweep == Sweep::Rest && self.len() > N * FULL_NUM / FULL_DEN {
            self.usual += self.usual;
            self.compaction = Some(Compaction { sweep: Sweep::Pairs, from: 0, to: 0 });
        }
    }

    /// Copies blocks to their new places; returns the next one.
    fn copy(&mut self, from: usize, end: usize, mut to: usize) -> usize {
        for index in from..end {
            let block = self.blocks.get(index).copied();
            self.put(to, block);
            to += 1;
        }
        to
    }

    fn put(&mut self, index: usize, block: Option<Block<T, W>>) {
        if let (Some(place), Some(block)) = (self.blocks.get_mut(index), block) {
            *place = block;
        }
    }

    fn sweep_rest(
        &mut self,
        from: usize,
        end: usize,
        to: usize,
        marks: &Marks,
        start: &mut Stretch<T, W>,
        noise_rad_s: T,
    ) -> usize {
        let Some(all) = self.rest_of(from, end, noise_rad_s) else {
            return self.copy(from, end, to);
        };
        let is_leading = to == 0 && marks.split == [0; 2] && !start.has_torque;
        if is_leading && self.is_still(from, end, &start.wheels_n_m_s, start) {
            start.absorb(&all, noise_rad_s);
            return to;
        }
        let half = self.blocks.get(from..(from + end) / 2).unwrap_or(&[]);
        let of_half = mean_wheels(half);
        let has_torque = all.impulse_n_m_s != Vec3::zeros();
        let turns = all.turn_square() > T::lit(REST_TURN * REST_TURN);
        if has_torque || turns || !self.is_still(from, end, &of_half, start) {
            return self.copy(from, end, to);
        }
        self.put(to, Some(all));
        to + 1
    }

    /// True where the mean wheel momentum of a group is `reference`, N m s, to its standard error.
    fn is_still(
        &self,
        from: usize,
        end: usize,
        reference: &Momenta<T, W>,
        start: &Stretch<T, W>,
    ) -> bool {
        let blocks = self.blocks.get(from..end).unwrap_or(&[]);
        let mean = mean_wheels(blocks);
        let mut scatter = T::zero();
        for block in blocks {
            let apart = block.wheels_n_m_s - mean;
            scatter += apart.dot(&apart);
        }
        let count = T::count(blocks.len().max(2) as u32);
        let error = (scatter / (count * (count - T::one()))).sqrt();
        let most = start.wheels_span_n_m_s * T::lit(STILL_SHARE) + error * T::lit(STILL_ERRORS);
        largest(&(mean - reference)) <= most
    }

    /// The blocks as one, if their rates agree with its mean. Two tests, each exceeded by chance once in 10⁴
    /// groups: chi-square of all blocks, at its expectation and four sigmas, and that of the difference of both
    /// halves, three degrees of freedom, which shows a trend sooner.
    fn rest_of(&self, from: usize, end: usize, noise_rad_s: T) -> Option<Block<T, W>> {
        let blocks = self.blocks.get(from..end)?;
        let (first, others) = blocks.split_first()?;
        if others.is_empty() {
            return None;
        }
        let all = others.iter().fold(*first, |all, block| all.merge(block));
        let mut chi_square = T::zero();
        for block in blocks {
            let apart = block.rate_rad_s - all.rate_rad_s;
            chi_square += apart.dot(&apart) * block.weight;
        }
        let variance = noise_rad_s * noise_rad_s;
        let degrees = T::count(3 * others.len() as u32);
        let most = degrees + (degrees + degrees).sqrt() * T::lit(4.0);
        let (a, b) = blocks.split_at(blocks.len() / 2);
        let trend = mean_rate(a) - mean_rate(b);
        let is_level = trend.dot(&trend) * all.weight <= T::lit(4.0 * 21.1) * variance;
        (chi_square <= most * variance && is_level).then_some(all)
    }

    fn sweep_pairs(
        &mut self,
        from: usize,
        end: usize,
        mut to: usize,
        start: &Stretch<T, W>,
        limits: &PairLimits<T>,
        axes: &Mat<T, 3, W>,
    ) -> usize {
        let most = self.usual * T::lit(1.01);
        let mut index = from;
        while index < end {
            let Some(mut block) = self.blocks.get(index).copied() else { break };
            let before = to.checked_sub(1).and_then(|i| self.blocks.get(i));
            let wheels = before.map_or(start.wheels_n_m_s, |b| b.wheels_end_n_m_s);
            index += 1;
            while index < end
                && let Some(next) = self.blocks.get(index)
            {
                let both = block.merge(next);
                if both.weight > most || !limits.permit(&block, &both, &wheels, axes) {
                    break;
                }
                block = both;
                index += 1;
            }
            self.put(to, Some(block));
            to += 1;
        }
        to
    }
}

/// Limits of a pair of blocks.
#[derive(Clone, Copy, Debug)]
pub struct PairLimits<T: Real> {
    /// Largest turn, rad.
    pub turn_rad: T,
    /// Momentum that one sigma of a sample is for the body, N m s.
    pub noise_n_m_s: T,
}

impl<T: Real> PairLimits<T> {
    /// True for a pair that turns little, and in which a parabola still represents the drive.
    ///
    /// The parabola of the pair misses the known value e of wheels and impulse where the blocks meet. Its mean
    /// is right, so that the error enters with the turn: of the rate it is below `κ |e| φ / 10`, which is to
    /// stay below a tenth of the block's noise, `σ / √n`.
    fn permit<const W: usize>(
        &self,
        first: &Block<T, W>,
        both: &Block<T, W>,
        wheels_at_start: &Momenta<T, W>,
        axes: &Mat<T, 3, W>,
    ) -> bool {
        let turn = both.turn_square().sqrt();
        let x = first.duration_s / both.duration_s;
        let (one, six) = (T::one(), T::lit(6.0));
        let bulge = six * x * (one - x);
        let (start, end) = (*wheels_at_start, both.wheels_end_n_m_s);
        let line = start + (end - start) * x;
        let wheels = line + (both.wheels_n_m_s - (start + end) * T::lit(0.5)) * bulge;
        let impulse = both.impulse_n_m_s * x + both.beyond_ramp_n_m_s * bulge;
        let missed = axes * (first.wheels_end_n_m_s - wheels) - (first.impulse_n_m_s - impulse);
        let most = self.noise_n_m_s / both.weight.max(one).sqrt();
        turn <= self.turn_rad && largest_component(&missed) * turn <= most
    }
}

/// Mean rate of blocks of about the same weight, rad/s.
fn mean_rate<T: Real, const W: usize>(blocks: &[Block<T, W>]) -> Vec3<T> {
    let sum = blocks.iter().fold(Vec3::zeros(), |sum, block| sum + block.rate_rad_s);
    sum * (T::one() / T::count(blocks.len().max(1) as u32))
}

/// Mean momentum of each wheel over blocks, N m s.
fn mean_wheels<T: Real, const W: usize>(blocks: &[Block<T, W>]) -> Momenta<T, W> {
    let sum = blocks.iter().fold(Momenta::zeros(), |sum, block| sum + block.wheels_n_m_s);
    sum * (T::one() / T::count(blocks.len().max(1) as u32))
}

impl Marks {
    /// The marks at block `from` belong to block `to` now.
    fn move_to(&mut self, from: usize, to: usize) {
        for mark in self.split.iter_mut().chain([&mut self.front]) {
            if *mark == from {
                *mark = to;
            }
        }
    }

    /// The first mark beyond a block.
    fn next_after(&self, index: usize) -> usize {
        let beyond = |mark: usize| if mark > index { mark } else { usize::MAX };
        let [closing, waiting] = self.split;
        beyond(self.front).min(beyond(closing)).min(beyond(waiting))
    }
}
