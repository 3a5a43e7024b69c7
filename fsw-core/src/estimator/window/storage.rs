//! The window's blocks in fixed storage, and their merging when it is full.

use super::block::Block;
use super::packed::{Packed, Packer, Scale};
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
    blocks: [Packed; N],
    len: usize,
    scale: Scale<T>,
    /// Carry on what rounding takes: along the end, and along the pairs that are merged.
    appending: Packer<T>,
    pairing: Packer<T>,
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
            blocks: [Packed::default(); N],
            len: 0,
            scale: Scale { drive_n_m_s: Vec3::zeros(), duration_s: T::one() },
            appending: Packer::default(),
            pairing: Packer::default(),
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
        self.appending = Packer::default();
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
        self.merging = None;
    }

    /// Forgets all blocks but the newest.
    pub fn keep_newest(&mut self, usual_samples: u32) {
        let newest = self.len.checked_sub(1).and_then(|last| self.block(last));
        self.clear();
        if let Some(block) = newest {
            self.store(&block, usual_samples);
        }
    }

    /// Block `index` as it is stored.
    fn block(&self, index: usize) -> Option<Block<T>> {
        self.block_in(index, &self.scale)
    }

    fn block_in(&self, index: usize, scale: &Scale<T>) -> Option<Block<T>> {
        Some(self.blocks.get(..self.len)?.get(index)?.block(scale))
    }

    fn store(&mut self, block: &Block<T>, usual_samples: u32) -> bool {
        if self.len == 0 {
            let share = T::count(usual_samples) / T::count(block.samples.max(1));
            let (drive_n_m_s, duration_s) = (block.drive_n_m_s, block.duration_s * share);
            self.scale = Scale { drive_n_m_s, duration_s };
        }
        let Some(free) = self.blocks.get_mut(self.len) else { return false };
        *free = self.appending.pack(block, &self.scale);
        self.len += 1;
        true
    }

    /// Block `index` is to be crossed, but its rate isn't to be believed.
    pub fn distrust(&mut self, index: usize) {
        if let Some(block) = self.blocks.get_mut(..self.len).and_then(|all| all.get_mut(index)) {
            *block = block.without_samples();
        }
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

    /// Appends a block, of which a usual one has so many samples; false if there is no room.
    pub fn push(&mut self, block: Block<T>, usual_samples: u32, noise_rad_s: T) -> bool {
        if !self.store(&block, usual_samples) {
            return false;
        }
        let scale = self.scale;
        self.note_motion(self.len - 1, &scale, noise_rad_s);
        true
    }

    /// Notes how far the block at `index` turns and bends, whose two predecessors are in place.
    fn note_motion(&mut self, index: usize, scale: &Scale<T>, noise_rad_s: T) {
        let at = |back: usize| index.checked_sub(back).and_then(|i| self.block_in(i, scale));
        let (Some(c), b, a) = (at(0), at(1), at(2)) else { return };
        let turn = c.rate_rad_s * c.duration_s;
        let turn_square = turn.dot(&turn);
        self.turn_square = self.turn_square.max(turn_square);
        let (Some(a), Some(b)) = (a, b) else { return };
        if [&a, &b, &c].iter().any(|block| block.samples == 0) {
            return;
        }
        let bend = a.rate_rad_s - b.rate_rad_s * T::lit(2.0) + c.rate_rad_s;
        let noise_square = noise_rad_s * noise_rad_s / T::count(c.samples);
        let over_noise = bend.dot(&bend) / noise_square - T::lit(BEND_BY_NOISE);
        self.bend_squares += turn_square * over_noise;
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
        Some([self.block(at)?, self.block(at + 1)?])
    }

    /// Begins to merge blocks two by two.
    pub fn begin_merging(&mut self) {
        self.merging = Some((0, self.len / 2));
        self.pairing = Packer::default();
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
    }

    /// Merges some pairs: one slice of work. True when all are done.
    pub fn merge_some(&mut self, noise_rad_s: T) -> bool {
        let Some((done, pairs)) = self.merging else { return true };
        // Twice as long: so is their unit.
        let two = T::lit(2.0);
        let longer = Scale { duration_s: self.scale.duration_s * two, ..self.scale };
        let end = pairs.min(done + PAIRS_PER_STEP);
        for pair in done..end {
            let (Some(first), Some(second)) = (self.block(2 * pair), self.block(2 * pair + 1))
            else {
                break;
            };
            self.put(pair, &first.merge(&second), &longer);
            self.note_motion(pair, &longer, noise_rad_s);
        }
        if end < pairs {
            self.merging = Some((end, pairs));
            return false;
        }
        // Those that came meanwhile, or had no partner, follow.
        for from in 2 * pairs..self.len {
            if let Some(block) = self.block(from) {
                self.put(from - pairs, &block, &longer);
            }
        }
        self.len -= pairs;
        self.scale = longer;
        self.merging = None;
        true
    }

    fn put(&mut self, index: usize, block: &Block<T>, scale: &Scale<T>) {
        if let Some(place) = self.blocks.get_mut(index) {
            *place = self.pairing.pack(block, scale);
        }
    }

    /// Block `index` in units of an inertia, whose inverse is `per`, with what its neighbours tell
    /// of its inside.
    pub fn span(&self, index: usize, per: T) -> Option<Span<T>> {
        let at = |offset: usize| (index + offset).checked_sub(2).and_then(|i| self.block(i));
        let [first, before, here, after, last] = [at(0), at(1), at(2), at(3), at(4)];
        Some(span([first, before], &here?, [after, last], per))
    }
}

/// A block between two neighbours on either side, where it has them, in units of an inertia, whose
/// inverse is `per`.
pub fn span<T: Real>(
    before: [Option<Block<T>>; 2],
    here: &Block<T>,
    after: [Option<Block<T>>; 2],
    per: T,
) -> Span<T> {
    let ([second_before, before], [after, second_after]) = (before, after);
    let beyond_here = beyond_ramp(before.as_ref(), here, after.as_ref());
    let mean = wheel_momentum(here, &beyond_here);
    let half_way = |other: &Block<T>, beyond: &Vec3<T>| {
        let share = here.duration_s / (other.duration_s + here.duration_s);
        wheel_momentum(other, beyond) * share + mean * (T::one() - share)
    };
    // Half-way between the means of two blocks, and beyond the ends as before them.
    let start = before.map(|b| half_way(&b, &beyond_ramp(second_before.as_ref(), &b, Some(here))));
    let end = after.map(|b| half_way(&b, &beyond_ramp(Some(here), &b, second_after.as_ref())));
    let mirror = |known: Vec3<T>| mean + mean - known;
    let (start, end) = match (start, end) {
        (Some(start), Some(end)) => (start, end),
        (Some(start), None) => (start, mirror(start)),
        (None, Some(end)) => (mirror(end), end),
        (None, None) => (mean, mean),
    };
    // n samples in a row miss 1/n² of what the mean over time makes of the curvature.
    let n = T::count(here.samples.max(1));
    let over_time = mean + (start + end - mean - mean) * (T::lit(1.0 / 12.0) / (n * n));
    // The parabola that has this mean and these ends.
    let middle = over_time * T::lit(1.5) - (start + end) * T::lit(0.25);
    let block = Block {
        drive_n_m_s: here.drive_n_m_s * per,
        impulse_n_m_s: here.impulse_n_m_s * per,
        ..*here
    };
    Span {
        block,
        wheels_at_start: start * per,
        wheels_in_the_middle: middle * per,
        wheels_at_end: end * per,
        beyond_ramp: beyond_here * per,
    }
}

/// Mean wheel momentum of a block over its samples: the drive and the external torque's share,
/// `beyond_ramp` over time.
fn wheel_momentum<T: Real>(block: &Block<T>, beyond_ramp: &Vec3<T>) -> Vec3<T> {
    let n = T::count(block.samples.max(1));
    block.drive_n_m_s + beyond_ramp * (T::one() + T::lit(0.5) / (n * n))
}

/// What the external torque's impulse is beyond a ramp, mean over time: `−τ̇ Δ² / 12` for a torque
/// that changes steadily, with τ̇ from the block before to the one after.
fn beyond_ramp<T: Real>(
    before: Option<&Block<T>>,
    here: &Block<T>,
    after: Option<&Block<T>>,
) -> Vec3<T> {
    let torque = |b: &Block<T>| b.impulse_n_m_s / b.duration_s;
    let inner = if before.is_some() && after.is_some() { here.duration_s } else { T::zero() };
    let (before, after) = (before.unwrap_or(here), after.unwrap_or(here));
    let apart = (before.duration_s + after.duration_s) * T::lit(0.5) + inner;
    let change = (torque(after) - torque(before)) / apart;
    -change * (here.duration_s * here.duration_s * T::lit(1.0 / 12.0))
}
