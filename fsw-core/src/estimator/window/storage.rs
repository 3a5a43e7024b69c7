//! The window's blocks in fixed storage, and their merging when it is full.

use super::block::Block;
use super::trajectory::Span;
use crate::math::{Vec3, scalar::Real};

/// Storage is merged while this many blocks are still free, since merging takes a few steps.
const RESERVE: usize = 16;
/// Pairs merged per step.
const PAIRS_PER_STEP: usize = 16;

/// Turn times bend that merged blocks may have, in sigmas of a block's noise: a tenth of it is an
/// error of the rate.
const BEND_SIGMA: f64 = 3.0;
/// Noise bends the rate, too: each axis by √6 of a block's sigma. The square of that, of three axes.
const BEND_BY_NOISE: f64 = 18.0;

/// Up to N blocks.
#[derive(Clone, Debug)]
pub struct Storage<T: Real, const N: usize> {
    blocks: [Block<T>; N],
    len: usize,
    /// Largest `|ω| Δ` of any block, squared, rad².
    turn_square: T,
    /// Sum over the blocks of the square of its product with the bend of the rate from block to
    /// block, `ω₋ − 2 ω + ω₊`, over a block's noise, rad²; less what noise is expected to add.
    bend_squares: T,
    /// While merging: pairs done, and how many there are.
    merging: Option<(usize, usize)>,
}

impl<T: Real, const N: usize> Default for Storage<T, N> {
    fn default() -> Self {
        Self {
            blocks: [Block::empty(); N],
            len: 0,
            turn_square: T::zero(),
            bend_squares: T::zero(),
            merging: None,
        }
    }
}

impl<T: Real, const N: usize> Storage<T, N> {
    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.len = 0;
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
        self.merging = None;
    }

    /// Forgets all blocks but the newest.
    pub fn keep_newest(&mut self) {
        if self.len > 0 {
            self.blocks[0] = self.blocks[self.len - 1];
            self.len = 1;
        }
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
        self.merging = None;
    }

    /// Blocks stored. While merging, none can be read.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether blocks are being merged.
    pub fn is_merging(&self) -> bool {
        self.merging.is_some()
    }

    /// Whether it is time to merge.
    pub fn is_nearly_full(&self) -> bool {
        self.len + RESERVE >= N
    }

    /// Appends a block; false if there is no room.
    pub fn push(&mut self, block: Block<T>, noise_rad_s: T) -> bool {
        let Some(free) = self.blocks.get_mut(self.len) else { return false };
        *free = block;
        self.len += 1;
        self.note_motion(self.len - 1, noise_rad_s);
        true
    }

    /// Notes how far the block at `index` turns and bends, whose two predecessors are in place.
    fn note_motion(&mut self, index: usize, noise_rad_s: T) {
        let Some(block) = self.blocks.get(index) else { return };
        let turn = block.rate_rad_s * block.duration_s;
        self.turn_square = self.turn_square.max(turn.dot(&turn));
        let Some([a, b, c]) = index
            .checked_sub(2)
            .and_then(|first| self.blocks.get(first..=index))
            .and_then(|three| three.first_chunk::<3>())
        else {
            return;
        };
        let bend = a.rate_rad_s - b.rate_rad_s * T::lit(2.0) + c.rate_rad_s;
        let noise_square = noise_rad_s * noise_rad_s / T::count(c.samples);
        let over_noise = bend.dot(&bend) / noise_square - T::lit(BEND_BY_NOISE);
        self.bend_squares += turn.dot(&turn) * over_noise;
    }

    /// Whether blocks of twice the length would still turn by less than `turn_rad`, and what drives
    /// them wouldn't bend inside them by more than the gyro's noise tells.
    ///
    /// Inside a block the drive is a parabola; what it misses turns with the body into an error of
    /// the rate of about a tenth of turn times bend. Twice the length turns twice as far and bends
    /// four times as much, over noise that is √2 times smaller.
    pub fn can_merge(&self, turn_rad: T) -> bool {
        self.turn_square * T::lit(4.0) < turn_rad * turn_rad
            && self.bend_squares * T::lit(128.0)
                < T::lit(BEND_SIGMA * BEND_SIGMA) * T::count(self.len as u32)
    }

    /// The newest two blocks, the newest last.
    pub fn newest(&self) -> Option<[Block<T>; 2]> {
        let at = self.len.checked_sub(2)?;
        Some([self.blocks[at], self.blocks[at + 1]])
    }

    /// Begins to merge blocks two by two.
    pub fn begin_merging(&mut self) {
        self.merging = Some((0, self.len / 2));
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
    }

    /// Merges some pairs: one slice of work. True when all are done.
    pub fn merge_some(&mut self, noise_rad_s: T) -> bool {
        let Some((done, pairs)) = self.merging else { return true };
        let end = pairs.min(done + PAIRS_PER_STEP);
        for pair in done..end {
            self.blocks[pair] = self.blocks[2 * pair].merge(&self.blocks[2 * pair + 1]);
            self.note_motion(pair, noise_rad_s);
        }
        if end < pairs {
            self.merging = Some((end, pairs));
            return false;
        }
        self.blocks.copy_within(2 * pairs..self.len, pairs);
        self.len -= pairs;
        self.merging = None;
        true
    }

    /// Block `index` in units of an inertia, whose inverse is `per`, with what its neighbours tell
    /// of its inside.
    pub fn span(&self, index: usize, per: T) -> Option<Span<T>> {
        if index >= self.len {
            return None;
        }
        let here = &self.blocks[index];
        let half_way = |a: usize, b: usize| {
            let share =
                self.blocks[b].duration_s / (self.blocks[a].duration_s + self.blocks[b].duration_s);
            self.wheel_momentum(a) * share + self.wheel_momentum(b) * (T::one() - share)
        };
        let mean = self.wheel_momentum(index);
        // Half-way between the means of two blocks, and beyond the ends as before them.
        let start = (index > 0).then(|| half_way(index - 1, index));
        let end = (index + 1 < self.len).then(|| half_way(index, index + 1));
        let mirror = |known: Vec3<T>| mean + mean - known;
        let (start, end) = match (start, end) {
            (Some(start), Some(end)) => (start, end),
            (Some(start), None) => (start, mirror(start)),
            (None, Some(end)) => (mirror(end), end),
            (None, None) => (mean, mean),
        };
        // n samples in a row miss 1/n² of what the mean over time makes of the curvature.
        let n = T::count(here.samples);
        let over_time = mean + (start + end - mean - mean) * (T::lit(1.0 / 12.0) / (n * n));
        // The parabola that has this mean and these ends.
        let middle = over_time * T::lit(1.5) - (start + end) * T::lit(0.25);
        let block = Block {
            drive_n_m_s: here.drive_n_m_s * per,
            impulse_n_m_s: here.impulse_n_m_s * per,
            ..*here
        };
        Some(Span {
            block,
            wheels_at_start: start * per,
            wheels_in_the_middle: middle * per,
            wheels_at_end: end * per,
            beyond_ramp: self.beyond_ramp(index) * per,
        })
    }

    /// Mean wheel momentum of a block over its samples: the drive and the external torque's share.
    fn wheel_momentum(&self, index: usize) -> Vec3<T> {
        let n = T::count(self.blocks[index].samples);
        let over_samples = T::one() + T::lit(0.5) / (n * n);
        self.blocks[index].drive_n_m_s + self.beyond_ramp(index) * over_samples
    }

    /// What the external torque's impulse is beyond a ramp, mean over time: `−τ̇ Δ² / 12` for a
    /// torque that changes steadily, with τ̇ from the block before to the one after.
    fn beyond_ramp(&self, index: usize) -> Vec3<T> {
        let here = &self.blocks[index];
        let before = &self.blocks[index.saturating_sub(1)];
        let after = &self.blocks[(index + 1).min(self.len - 1)];
        let torque = |b: &Block<T>| b.impulse_n_m_s / b.duration_s;
        let inner = if index > 0 && index + 1 < self.len { here.duration_s } else { T::zero() };
        let apart = (before.duration_s + after.duration_s) * T::lit(0.5) + inner;
        let change = (torque(after) - torque(before)) / apart;
        -change * (here.duration_s * here.duration_s * T::lit(1.0 / 12.0))
    }
}
