//! Blocks of a window in fixed storage, and their compaction.
//!
//! When storage is nearly full, two sweeps make room:
//!
//! 1. *Rest*: groups of sixteen blocks whose rates agree become one block. Groups are judged rather than neighbours: a cut
//!    placed where noise peaks would bias the residuals. Rest before any motion is not even a block: its mean rate and
//!    weight become the measurement of the rate at the start ([`Rest`](super::stretch::Rest)).
//! 2. *Pairs*: where that did not suffice, the number of samples of a usual block doubles, and blocks are
//!    merged two by two as long as they turn little, and in groups that keep their information.
//!
//! # Rest
//!
//! A group is at rest if a straight line to the mean rates of the groups before and after it changes the rate within the
//! group by less than its noise. The decision depends on means, which a merger keeps, and not on the trend within the group,
//! which it discards. Decided by that trend, groups whose noise hides a slow motion are merged, and those whose noise
//! exaggerates it stay: 2 % of slow tumbles were then not white. The scatter has a limit that noise alone exceeds once
//! in 10⁴ groups.
//!
//! # Information that pairs lose
//!
//! Two blocks of n samples whose means of the rate are z₁ and z₂ have `n |z₁ − z₂|² / 2σ²` more information than their
//! pair. Of a motion of angular frequency w, averages over L keep the share `sinc²(wL/2)`, and pairs lose `sin²(wL/2)`
//! of it. A group in which they lose more than [`LOSS`] stays as it is: blocks of a sine grow to a seventh of its period
//! at most, and have lost a fifteenth then, a third of it before. Of a straight line over m blocks pairs lose
//! `3 / (m² − 1)`, by the length of the group alone, and that is permitted too.
//!
//! # Momentum that pairs drift away by
//!
//! Of a torque the parabola of a pair has the right mean, but misses that of its halves by ∓e, which is known. After a pair of
//! blocks of length L the momentum is off by `L (z₁ − z₂) × e`, and by as much again since the rate follows e. Where
//! a torque turns about two axes in step with the motion, all N pairs of a window miss it in the same direction, 2δ: as
//! a ramp of the momentum, of chi-square `4 N³ δ² / 3` over the variance that a pair has for it. The mean δ of a group is to
//! keep the root of that below 0.3: [`DRIFT`] `= 0.3 √3 / 2`.
//!
//! # Noise
//!
//! Noise looks like such a motion. The loss counts where the rates show it beyond their noise, and where it is of the
//! body's motion: drive by wheels and torque swings likewise, or the pair lasts longer than nutation permits. A flexible
//! part that swings alone carries no information, and the noise of tachometers does not move the body.
//!
//! A sweep goes on by one group a slice, while further blocks are appended.

use super::block::Block;
use super::span::{Span, of_samples};
use super::stretch::{Stretch, largest};
use crate::dynamics::wheels::Momenta;
use crate::math::{Mat, Vec3, largest_component, scalar::Real};
use crate::persist::{Archive, Persist, mix, name};
use heapless::Vec;

/// Blocks judged together.
const GROUP: usize = 16;
/// Short blocks at the start of a record at most: three for each of eight usual ones, and fewer than this.
const MOST_SHORT: usize = 32;
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
/// Largest information of a straight line within a group of rest, in variances of the noise: a change of 2.3 sigmas of a
/// block over sixteen blocks, `√(12 · 7 / 16)`.
const LINE: f64 = 7.0;
/// Chi-square of three degrees of freedom that noise exceeds once in 10⁴.
const BY_CHANCE: f64 = 21.1;

/// Largest share of the information of a group that pairs may lose: all merges of a block together lose 4/3 of it,
/// which is 3.5 % of sigma.
const LOSS: f64 = 0.05;
/// Mean drift of the momentum by a pair, over its sigma, times the number of pairs in a window to the power 3/2.
const DRIFT: f64 = 0.26;
/// The same for new blocks: `sin²` of twice the angle, of blocks whose mergers lost [`LOSS`].
const COARSE: f64 = 4.0 * LOSS;

/// Newest groups that are left as they are: motion that begins in them may not stand out yet.
const NEWEST_GROUPS: usize = 3;

/// Weight of a pair at most, in usual blocks: with rounding.
const MOST_WEIGHT: f64 = 1.01;

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
    /// Pairs, the newest group of which has been left as it is.
    AllButNewest,
}

crate::persist!([] enum Sweep { 0 => Drop, 1 => Rest, 2 => Pairs, 3 => AllButNewest });

/// Mean rate of a group of blocks; none without samples.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mean<T: Real> {
    /// Number of samples; the variance of `rate_rad_s` is σ² over this.
    weight: T,
    duration_s: T,
    rate_rad_s: Vec3<T>,
}

crate::persist!([T: Real] Mean<T> { weight, duration_s, rate_rad_s });

/// Sweep, the block that it reads and writes next, and the group before that.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Compaction<T: Real> {
    sweep: Sweep,
    from: usize,
    to: usize,
    before: Mean<T>,
}

crate::persist!([T: Real] Compaction<T> { sweep, from, to, before }
    if |this| this.to <= this.from && this.from <= MOST_BLOCKS);

impl<T: Real> Mean<T> {
    fn none() -> Self {
        Self { weight: T::zero(), duration_s: T::zero(), rate_rad_s: Vec3::zeros() }
    }

    /// Mean of blocks, without holes.
    fn of<const W: usize>(blocks: &[Block<T, W>]) -> Self {
        let mut mean = Self::none();
        for block in blocks.iter().filter(|block| !block.is_hole()) {
            mean.weight += block.weight;
            mean.duration_s += block.duration_s;
            mean.rate_rad_s += block.rate_rad_s * block.duration_s;
        }
        if mean.weight > T::zero() {
            mean.rate_rad_s *= T::one() / mean.duration_s;
        }
        mean
    }

    /// True where the straight line to the mean of a neighbouring group changes the rate within this one by less than
    /// noise of this variance, beyond the noise of both means; true without a neighbour.
    ///
    /// A change d over a group of n samples has the information `n d² / 12 σ²`.
    fn is_level_with(&self, other: &Self, variance: T) -> bool {
        let share = (self.duration_s + self.duration_s) / (self.duration_s + other.duration_s);
        let apart = other.rate_rad_s - self.rate_rad_s;
        let of_line = T::lit(12.0 * LINE) / (self.weight * share * share);
        let of_means = (T::one() / self.weight + T::one() / other.weight) * T::lit(BY_CHANCE);
        other.weight == T::zero() || apart.dot(&apart) <= (of_line + of_means) * variance
    }
}

/// Up to N blocks.
#[derive(Clone, Debug)]
pub struct Storage<T: Real, const W: usize, const N: usize> {
    blocks: Vec<Block<T, W>, N>,
    compaction: Option<Compaction<T>>,
    /// Number of samples of a usual block.
    usual: T,
    /// True where the last sweep for pairs did not make room.
    is_incompressible: bool,
}

impl<T: Real, const W: usize, const N: usize> Persist for Storage<T, W, N> {
    fn layout() -> u32 {
        let blocks = mix(const { name("Storage") }, <[Block<T, W>; N]>::layout());
        mix(mix(blocks, Option::<Compaction<T>>::layout()), <(T, bool)>::layout())
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

    /// Gives the blocks of each hole the rates of a straight line between the blocks beside it, for samples that come
    /// every `period_s`: for a linear start over the blocks from `from` to `end`.
    #[inline(never)]
    pub fn fill_holes(&mut self, from: usize, end: usize, period_s: T) {
        let mut first = from;
        for index in from..end.min(self.len()) {
            let block = self.blocks.get(index);
            let Some(after) = block.filter(|block| !block.is_hole()) else { continue };
            let (after_rad_s, is_hole) = (after.rate_rad_s, first < index);
            if is_hole && first > from {
                self.fill_hole(first, index, &after_rad_s, period_s);
            }
            first = index + 1;
        }
    }

    /// Fills the hole of these blocks, up to a rate after it, rad/s. The turning of g in the impulse of a block is
    /// that by its rate ([`Span`]).
    #[inline(never)]
    fn fill_hole(&mut self, first: usize, end: usize, after_rad_s: &Vec3<T>, period_s: T) {
        let holes = self.blocks.get(first..end).unwrap_or(&[]);
        let length_s = holes.iter().fold(T::zero(), |sum, hole| sum + hole.duration_s);
        let before = first.checked_sub(1).and_then(|i| self.blocks.get(i));
        let before_rad_s = before.map_or(*after_rad_s, |before| before.rate_rad_s);
        let change = after_rad_s - before_rad_s;
        let mut since_s = T::zero();
        for hole in self.blocks.get_mut(first..end).unwrap_or(&mut []) {
            let middle_s = since_s + hole.duration_s * T::lit(0.5);
            let rate_rad_s = before_rad_s + change * (middle_s / length_s);
            let samples = (hole.duration_s / period_s).max(T::one());
            let of_ramp = hole.beyond_ramp_n_m_s * (hole.duration_s * of_samples(samples));
            hole.impulse_n_m_s += (hole.rate_rad_s - rate_rad_s).cross(&of_ramp);
            hole.rate_rad_s = rate_rad_s;
            since_s += hole.duration_s;
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

    /// True where the newest blocks are too long for the motion: pairs of a group would lose more than fits the merger that
    /// made blocks of this length.
    pub fn is_coarse(&self, limits: &PairLimits<T>, noise_rad_s: T, axes: &Mat<T, 3, W>) -> bool {
        let group = self.blocks.get(self.len().saturating_sub(GROUP)..).unwrap_or(&[]);
        !limits.keep_information(group, T::lit(COARSE), T::MAX, noise_rad_s, axes)
    }

    /// Halves the number of samples of a usual block.
    pub fn shorten(&mut self) {
        self.usual *= T::lit(0.5);
    }

    /// Joins short blocks at the start of a record to usual ones, of the first [`MOST_SHORT`], as long as they turn by less
    /// than `turn_rad`. False if there are none.
    #[inline(never)]
    pub fn join_short(&mut self, turn_rad: T) -> bool {
        let (end, len) = (MOST_SHORT.min(self.len()), self.len());
        let most = self.usual * T::lit(MOST_WEIGHT);
        let (mut to, mut index) = (0, 0);
        while index < end {
            let Some(mut block) = self.blocks.get(index).copied() else { break };
            index += 1;
            while index < end
                && let Some(next) = self.blocks.get(index)
            {
                let both = block.merge(next);
                let has_turned = block.turn_square() > turn_rad * turn_rad;
                if has_turned || block.is_hole() != next.is_hole() || both.weight > most {
                    break;
                }
                block = both;
                index += 1;
            }
            self.put(to, Some(block));
            to += 1;
        }
        let to = self.copy(end, len, to);
        self.blocks.truncate(to);
        to < len
    }

    /// Begins to make room.
    pub fn compact(&mut self) {
        self.begin(Sweep::Rest, 0);
    }

    fn begin(&mut self, sweep: Sweep, from: usize) {
        self.compaction = Some(Compaction { sweep, from, to: 0, before: Mean::none() });
    }

    /// Begins to remove the blocks before `index`.
    pub fn drop_before(&mut self, index: usize) {
        self.begin(Sweep::Drop, index.min(self.len()));
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
        let Some(Compaction { mut sweep, from, to, before }) = self.compaction else { return };
        if from >= self.len() {
            self.end_sweep(sweep, from, to, marks);
            return;
        }
        marks.move_to(from, to);
        let end = marks.next_after(from).min(from + GROUP).min(self.len());
        let group = Mean::of(self.blocks.get(from..end).unwrap_or(&[]));
        let to = match sweep {
            Sweep::Drop => self.copy(from, end, to),
            Sweep::Rest if end + NEWEST_GROUPS * GROUP > self.len() => self.copy(from, end, to),
            Sweep::Rest => {
                let next = self.blocks.get(end..(end + GROUP).min(self.len())).unwrap_or(&[]);
                let (next, variance) = (Mean::of(next), noise_rad_s * noise_rad_s);
                let is_level =
                    group.is_level_with(&before, variance) && group.is_level_with(&next, variance);
                match self.rest_of(from, end, noise_rad_s).filter(|_| is_level) {
                    Some(all) => self.sweep_rest(&all, (from, end, to), marks, start, noise_rad_s),
                    None => self.copy(from, end, to),
                }
            }
            Sweep::Pairs | Sweep::AllButNewest => {
                let blocks = self.blocks.get(from..end).unwrap_or(&[]);
                let most = self.usual * T::lit(MOST_WEIGHT);
                let loss = T::lit(LOSS);
                let is_kept = limits.keep_information(blocks, loss, most, noise_rad_s, axes);
                if is_kept && limits.keep_momentum(blocks, most, N) {
                    sweep = Sweep::Pairs;
                    self.sweep_pairs(from, end, to, start, limits, axes)
                } else {
                    sweep = Sweep::AllButNewest;
                    self.copy(from, end, to)
                }
            }
        };
        self.compaction = Some(Compaction { sweep, from: end, to, before: group });
    }

    /// Ends a sweep, and begins that for pairs where the one for rest did not suffice.
    fn end_sweep(&mut self, sweep: Sweep, from: usize, to: usize, marks: &mut Marks) {
        marks.move_to(from, to);
        self.blocks.truncate(to);
        self.compaction = None;
        let is_of_pairs = matches!(sweep, Sweep::Pairs | Sweep::AllButNewest);
        self.is_incompressible = is_of_pairs && to + N / 16 > N - N / RESERVE_SHARE;
        if self.is_incompressible || sweep == Sweep::AllButNewest {
            // Longer blocks hide motion or drive.
            self.shorten();
        }
        if sweep == Sweep::Rest && self.len() > N * FULL_NUM / FULL_DEN {
            self.usual += self.usual;
            self.begin(Sweep::Pairs, 0);
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

    /// Merges a group whose rates agree, from block `from` to `end`, unless it turns or is driven; returns the next
    /// place.
    fn sweep_rest(
        &mut self,
        all: &Block<T, W>,
        (from, end, to): (usize, usize, usize),
        marks: &Marks,
        start: &mut Stretch<T, W>,
        noise_rad_s: T,
    ) -> usize {
        let is_leading = to == 0 && marks.split == [0; 2] && !start.has_torque;
        if is_leading && self.is_still(from, end, &start.wheels_n_m_s, start) {
            start.absorb(all, noise_rad_s);
            return to;
        }
        let half = self.blocks.get(from..(from + end) / 2).unwrap_or(&[]);
        let of_half = mean_wheels(half);
        let has_torque = all.impulse_n_m_s != Vec3::zeros();
        let turns = all.turn_square() > T::lit(REST_TURN * REST_TURN);
        if has_torque || turns || !self.is_still(from, end, &of_half, start) {
            return self.copy(from, end, to);
        }
        self.put(to, Some(*all));
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

    /// The blocks as one, if their rates agree with its mean: chi-square of all blocks, at its expectation and four
    /// sigmas.
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
        (chi_square <= most * variance).then_some(all)
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
        let most = self.usual * T::lit(MOST_WEIGHT);
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
                let is_mixed = block.is_hole() != next.is_hole();
                let is_long = both.is_hole() && both.duration_s > most * limits.period_s;
                let is_apart = is_mixed || is_long || both.weight > most;
                if is_apart || !limits.permit(&block, &both, &wheels, axes) {
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
    /// Angular frequency of a nutation at most, rad/s.
    pub nutation_rad_s: T,
    /// Mean interval between samples, s: a pair of holes is no longer than one of other blocks.
    pub period_s: T,
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

impl<T: Real> PairLimits<T> {
    /// True for a group that may be merged in pairs, up to a weight: see the module.
    #[inline(never)]
    fn keep_information<const W: usize>(
        &self,
        group: &[Block<T, W>],
        loss: T,
        most: T,
        noise_rad_s: T,
        axes: &Mat<T, 3, W>,
    ) -> bool {
        let (mut rate, mut drive) = (Spread::new(), Spread::new());
        let mut impulse = Vec3::zeros();
        let mut longest_s = T::zero();
        for block in group {
            let mean_impulse = impulse + block.impulse_n_m_s * T::lit(0.5);
            if !block.is_hole() {
                rate.add(&block.rate_rad_s, block.weight, most);
                drive.add(&(mean_impulse - block.drive_n_m_s(axes)), block.weight, most);
            }
            impulse += block.impulse_n_m_s;
            longest_s = longest_s.max(block.duration_s);
        }
        let nutation = self.nutation_rad_s * (longest_s + longest_s);
        let is_of_body = nutation > self.turn_rad || drive.is_lost(loss, T::zero());
        !(is_of_body && rate.is_lost(loss, noise_rad_s * noise_rad_s))
    }

    /// True for a group whose pairs, of weights up to `most`, carry the momentum across as their blocks do, in a storage of
    /// `blocks`: see the module.
    #[inline(never)]
    fn keep_momentum<const W: usize>(&self, group: &[Block<T, W>], most: T, blocks: usize) -> bool {
        let (mut drift, mut pairs, mut weight) = (Vec3::zeros(), 0, T::zero());
        for pair in group.chunks_exact(2) {
            let [a, b] = pair else { continue };
            let both = a.merge(b);
            if both.weight > most || a.is_hole() != b.is_hole() {
                continue;
            }
            let x = a.duration_s / both.duration_s;
            let of_pair = both.impulse_n_m_s * (x * T::lit(0.5))
                + both.beyond_ramp_n_m_s * (x * (T::lit(3.0) - x - x));
            let missed = a.impulse_n_m_s * T::lit(0.5) + a.beyond_ramp_n_m_s - of_pair;
            drift += (a.rate_rad_s - b.rate_rad_s).cross(&missed) * a.duration_s;
            (pairs, weight) = (pairs + 1, weight.max(both.weight));
        }
        let of_window = T::count(blocks as u32 / 2);
        // The noise is that of a body with all of the trace as its moment: three times the mean moment.
        let noise = self.noise_n_m_s * T::lit(1.0 / 3.0);
        let most = noise * T::lit(DRIFT) / (of_window * (of_window * weight).sqrt());
        pairs == 0 || largest_component(&drift) <= most * T::count(pairs)
    }
}

/// Weighted squares of values about their mean, and what pairs of them lose.
struct Spread<T: Real> {
    blocks: u32,
    pairs: u32,
    weight: T,
    mean: Vec3<T>,
    square: Vec3<T>,
    lost: Vec3<T>,
    last: Vec3<T>,
    last_weight: T,
}

impl<T: Real> Spread<T> {
    fn new() -> Self {
        let (zero, none) = (T::zero(), Vec3::zeros());
        Self {
            blocks: 0,
            pairs: 0,
            weight: zero,
            mean: none,
            square: none,
            lost: none,
            last: none,
            last_weight: zero,
        }
    }

    fn add(&mut self, value: &Vec3<T>, weight: T, most: T) {
        let pair = self.last_weight + weight;
        if self.blocks & 1 == 1 && pair <= most {
            let apart = value - self.last;
            let of_pair = self.last_weight * weight / pair;
            self.lost += apart.component_mul(&apart) * of_pair;
            self.pairs += 1;
        }
        (self.last, self.last_weight) = (*value, weight);
        let sum = self.weight + weight;
        let apart = value - self.mean;
        self.square += apart.component_mul(&apart) * (self.weight * weight / sum);
        self.mean += apart * (weight / sum);
        self.weight = sum;
        self.blocks += 1;
    }

    /// True where an axis loses more than this share, beyond what noise of this variance a sample loses: a chi-square,
    /// at its expectation and two sigmas.
    fn is_lost(&self, loss: T, variance: T) -> bool {
        let (blocks, pairs) = (T::count(self.blocks.max(2)), T::count(self.pairs));
        let share = loss + T::lit(3.0) / (blocks * blocks - T::one());
        let by_noise = (pairs + (pairs + pairs).sqrt() * T::lit(2.0)) * variance;
        (0..3).any(|i| self.lost[i] > self.square[i] * share + by_noise)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: PairLimits<f64> =
        PairLimits { turn_rad: 0.6, noise_n_m_s: 3e-4, nutation_rad_s: 0.0, period_s: 0.1 };
    const NOISE_RAD_S: f64 = 1e-4;
    /// Amplitudes of rate, rad/s, and of wheel momentum, N m s: a body of 1 kg m².
    const SWING: f64 = 0.01;

    /// Thirty-two blocks of a sample become eight of four, those after them stay, and so does what turns far.
    #[test]
    fn short_blocks_at_the_start_are_joined() {
        let block = |weight: f64, rate: f64| Block {
            weight,
            duration_s: 0.1 * weight,
            rate_rad_s: Vec3::new(rate, 0.0, 0.0),
            ..Block::<f64, 0>::empty()
        };
        let mut storage = Storage::<f64, 0, 128>::new();
        storage.clear(4.0);
        (0..32).for_each(|k| storage.push(&block(1.0, f64::from(k) * 0.01)));
        (0..5).for_each(|_| storage.push(&block(4.0, 0.7)));
        assert!(storage.join_short(10.0));
        assert!(!storage.join_short(10.0));
        let found: std::vec::Vec<(f64, f64)> =
            storage.blocks.iter().map(|b| (b.weight, b.rate_rad_s.x)).collect();
        assert_eq!(found.len(), 13);
        for (k, (weight, rate)) in found.iter().enumerate() {
            let mean = if k < 8 { 0.01 * (4.0 * k as f64 + 1.5) } else { 0.7 };
            assert!(*weight == 4.0 && (rate - mean).abs() < 1e-12, "{k}: {weight} {rate}");
        }
        storage.clear(4.0);
        (0..32).for_each(|_| storage.push(&block(1.0, 5.0)));
        assert!(storage.join_short(0.6));
        assert_eq!(storage.len(), 16);
    }

    /// Blocks of a second and of ten samples: rate and wheel of sines by their angular frequencies, and noise of the
    /// wheel that alternates.
    fn group(rate: f64, wheel: f64, wheel_noise: f64) -> [Block<f64, 1>; GROUP] {
        let mean = |w: f64, k: usize| {
            let (from, to) = (w * k as f64, w * (k + 1) as f64);
            if w > 0.0 { SWING * (from.cos() - to.cos()) / w } else { 0.0 }
        };
        core::array::from_fn(|k| Block {
            weight: 10.0,
            duration_s: 1.0,
            rate_rad_s: Vec3::new(mean(rate, k), 0.0, 0.0),
            wheels_n_m_s: Momenta::<f64, 1>::from_element(
                mean(wheel, k) + if k & 1 == 0 { wheel_noise } else { -wheel_noise },
            ),
            ..Block::empty()
        })
    }

    fn keeps(group: &[Block<f64, 1>], nutation_rad_s: f64) -> bool {
        let limits = PairLimits { nutation_rad_s, ..LIMITS };
        limits.keep_information(
            group,
            LOSS,
            20.2,
            NOISE_RAD_S,
            &Mat::<f64, 3, 1>::new(1.0, 0.0, 0.0),
        )
    }

    /// Normal noise about a slow swing, parts of which are rest: the blocks that are not merged show the slopes of the
    /// swing, within five standard errors. Judged by their own trend, the groups that are left exaggerate them.
    #[test]
    fn merging_of_rest_does_not_select_noise() {
        let mut state = 1u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let course = |t: f64| 20.0 * (t / 60.0).sin();
        let axes = Mat::<f64, 3, 0>::zeros();
        let (mut product, mut square, mut merged) = (0.0, 0.0, 0);
        for _ in 0..100 {
            let mut storage = Storage::<f64, 0, 1024>::new();
            for k in 0..512 {
                let x = course(f64::from(k) + 0.5) + normal();
                let rate_rad_s = Vec3::new(x, normal(), normal()) * 1e-4;
                storage.push(&Block { weight: 1.0, duration_s: 1.0, rate_rad_s, ..Block::empty() });
            }
            let mut start = Stretch::new(Momenta::<f64, 0>::zeros());
            start.has_torque = true;
            let mut marks = Marks { front: 0, split: [0; 2] };
            storage.compact();
            while storage.is_compacting() {
                storage.sweep(&mut marks, &mut start, 1e-4, &LIMITS, &axes);
            }
            let mut t = 0.0;
            for block in &storage.blocks {
                let middle = t + 0.5 * block.duration_s;
                t += block.duration_s;
                if block.weight == 1.0 {
                    let of_line = course(middle) - course(16.0 * (middle / 16.0).floor() + 8.0);
                    product += of_line * (block.rate_rad_s.x * 1e4 - course(middle));
                    square += of_line * of_line;
                } else {
                    merged += 1;
                }
            }
        }
        let error = product / square.sqrt();
        assert!(merged > 200 && error.abs() < 5.0, "{merged} {error}");
    }

    /// Between blocks of 0.1 and 0.5 rad/s: a straight line over the three seconds of the hole.
    #[test]
    fn a_hole_has_the_rates_of_a_straight_line() {
        let block = |weight: f64, rate: f64| Block::<f64, 1> {
            weight,
            duration_s: 1.0,
            rate_rad_s: Vec3::new(rate, 0.0, 0.0),
            ..Block::empty()
        };
        let mut storage = Storage::<f64, 1, 64>::new();
        for (weight, rate) in [(10.0, 0.1), (0.0, 0.1), (0.0, 0.1), (0.0, 0.1), (10.0, 0.7)] {
            storage.push(&block(weight, rate));
        }
        storage.fill_holes(0, 5, 0.1);
        let rates = storage.blocks.iter().map(|b| b.rate_rad_s.x);
        for (rate, expected) in rates.zip([0.1, 0.2, 0.4, 0.6, 0.7]) {
            assert!((rate - expected).abs() < 1e-12, "{rate} {expected}");
        }
    }

    /// The rate of a merger is that of the block with readings; pairs of a sweep are alike.
    #[test]
    fn a_hole_has_no_influence_on_a_mean_rate() {
        let blocks = group(0.0, 0.0, 0.0);
        let hole = Block { weight: 0.0, rate_rad_s: Vec3::repeat(0.12), ..blocks[0] };
        let read = Block { rate_rad_s: Vec3::repeat(0.1), ..blocks[0] };
        for both in [hole.merge(&read), read.merge(&hole)] {
            assert_eq!(
                (both.rate_rad_s, both.weight, both.duration_s),
                (read.rate_rad_s, 10.0, 2.0)
            );
        }
        let mut storage = Storage::<f64, 1, 64>::new();
        storage.usual = 20.0;
        storage.blocks.extend([read, read, hole, hole, read, read]);
        let (start, axes) = (Stretch::new(Momenta::<f64, 1>::zeros()), Mat::<f64, 3, 1>::zeros());
        let len = storage.sweep_pairs(0, 6, 0, &start, &LIMITS, &axes);
        let weights: std::vec::Vec<f64> = storage.blocks.iter().map(|b| b.weight).collect();
        assert_eq!(weights[..len], [20.0, 0.0, 20.0]);
    }

    /// `sin²(w/2)` for blocks of a second: 0.05 at a period of 14 s.
    #[test]
    fn pairs_keep_the_information_of_slow_swings_alone() {
        for (period_s, is_kept) in
            [(200.0, true), (40.0, true), (20.0, true), (10.0, false), (4.3, false)]
        {
            let w = core::f64::consts::TAU / period_s;
            assert_eq!(keeps(&group(w, w, 0.0), 0.0), is_kept, "{period_s} s");
        }
    }

    /// A flexible part moves the body and no wheel; nutation does so too, but not faster than the momentum permits.
    #[test]
    fn swings_without_a_drive_count_where_the_body_may_nutate() {
        let w = core::f64::consts::TAU / 5.0;
        assert!(keeps(&group(w, 0.0, 0.0), 0.0));
        assert!(!keeps(&group(w, 0.0, 0.0), 1.0));
    }

    #[test]
    fn noise_of_tachometers_is_no_swing() {
        assert!(keeps(&group(0.0, 0.0, SWING), 0.0));
        let rest_of_steady_motion = group(0.0, 0.0, 1e-3 * SWING)
            .map(|block| Block { rate_rad_s: Vec3::new(0.05, 0.0, 0.0), ..block });
        assert!(keeps(&rest_of_steady_motion, 0.0));
    }

    /// A torque about two axes in quadrature, of 1 kg m² and 0.5 kg m²: pairs drift by a share of the fifth power of their
    /// length. About one axis they do not.
    #[test]
    fn pairs_under_a_torque_keep_the_momentum() {
        let of_torque = |period_s: f64, second: f64| -> [Block<f64, 0>; GROUP] {
            let w = core::f64::consts::TAU / period_s;
            // Momentum a sin(w t), a cos(w t), and its mean over a block.
            let at = |t: f64| Vec3::new((w * t).sin(), second * (w * t).cos(), 0.0) * SWING;
            let mean = |t: f64| {
                let (from, to) = (w * t, w * (t + 1.0));
                let x = (from.cos() - to.cos()) / w;
                Vec3::new(x, second * (to.sin() - from.sin()) / w, 0.0) * SWING
            };
            core::array::from_fn(|k| {
                let t = k as f64;
                let impulse = at(t + 1.0) - at(t);
                let momentum = mean(t);
                Block {
                    weight: 10.0,
                    duration_s: 1.0,
                    rate_rad_s: momentum.component_mul(&Vec3::new(1.0, 2.0, 1.0)),
                    impulse_n_m_s: impulse,
                    beyond_ramp_n_m_s: momentum - at(t) - impulse * 0.5,
                    ..Block::empty()
                }
            })
        };
        assert!(LIMITS.keep_momentum(&of_torque(60.0, 1.0), 20.2, 512));
        assert!(!LIMITS.keep_momentum(&of_torque(15.0, 1.0), 20.2, 512));
        assert!(LIMITS.keep_momentum(&of_torque(15.0, 0.0), 20.2, 512));
    }
}
