//! The window's blocks in fixed storage. When it is full they are merged two by two, or those that a
//! pass has left behind are dropped: either way storage is rebuilt, a block a slice.

use super::block::Block;
use super::packed::{Packed, Packer, Scale};
use crate::math::{Vec3, scalar::Real};
use crate::persist::{Archive, Persist, mix, name};
use heapless::Vec;

/// Storage is rebuilt while this share of it, and at least so many blocks, is still free: meanwhile
/// more come, at most as many as steps pass, and a step rebuilds three. A last pass before that takes a
/// quarter of the time that its blocks took.
const RESERVE_SHARE: usize = 4;
const LEAST_RESERVE: usize = 16;
/// What is handed on is rebuilt while at least so many are free.
const LAST_BLOCKS: usize = 8;

/// Turn times bend that merged blocks may have, in sigmas of a block's noise: a tenth of it is an
/// error of the rate.
const BEND_SIGMA: f64 = 3.0;
/// Noise bends the rate, too: each axis by √6 of a block's sigma. The square of that, of three axes.
const BEND_BY_NOISE: f64 = 18.0;

/// No storage is larger.
const MOST_BLOCKS: usize = 1 << 16;

/// Up to N blocks.
#[derive(Clone, Debug)]
pub struct Storage<T: Real, const N: usize> {
    /// Their places hold nothing until they are needed, so that a window can be built where it stays,
    /// without a second one on the stack.
    blocks: Vec<Packed, N>,
    scale: Scale<T>,
    /// Carry on what rounding takes: along the end, and along what is rebuilt.
    appending: Packer<T>,
    rebuilding: Packer<T>,
    /// Largest `|ω| Δ` of any block, squared, rad².
    turn_square: T,
    /// Sum over the blocks of the square of its product with the bend of the rate from block to
    /// block, `ω₋ − 2 ω + ω₊`, over a block's noise, rad²; less what noise is expected to add.
    bend_squares: T,
    rebuild: Option<Rebuild<T>>,
}

impl<T: Real, const N: usize> Persist for Storage<T, N> {
    fn layout() -> u32 {
        let blocks = mix(const { mix(name("Storage"), name("packed")) }, <[Packed; N]>::layout());
        let packers = mix(Scale::<T>::layout(), <[Packer<T>; 2]>::layout());
        mix(mix(blocks, packers), mix(T::layout(), Option::<Rebuild<T>>::layout()))
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Self { blocks, scale, appending, rebuilding, turn_square, bend_squares, rebuild } =
            self;
        let mut len = blocks.len();
        len.persist(archive);
        if blocks.resize_default(len).is_err() {
            return archive.refuse("Storage");
        }
        for block in blocks {
            block.persist(archive);
        }
        scale.persist(archive);
        appending.persist(archive);
        rebuilding.persist(archive);
        turn_square.persist(archive);
        bend_squares.persist(archive);
        rebuild.persist(archive);
    }
}

/// What is left to be rebuilt: blocks from `from` on become blocks from `to` on, in another scale, and
/// those before `in_pairs` two by two.
#[derive(Clone, Copy, Debug)]
struct Rebuild<T: Real> {
    from: usize,
    to: usize,
    in_pairs: usize,
    scale: Scale<T>,
}

crate::persist!(
    [T: Real] Rebuild<T> { from, to, in_pairs, scale }
    if |this| this.to <= this.from && this.from <= MOST_BLOCKS && this.in_pairs <= MOST_BLOCKS
);

/// What rebuilding has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rebuilt {
    /// There is more to do.
    NotYet,
    /// All blocks are merged two by two.
    Merged,
    /// Blocks that weren't needed any more are gone.
    Dropped,
}

impl<T: Real, const N: usize> Default for Storage<T, N> {
    #[inline(always)]
    fn default() -> Self {
        Self {
            blocks: Vec::new(),
            scale: Scale { drive_n_m_s: Vec3::zeros(), duration_s: T::one() },
            appending: Packer::default(),
            rebuilding: Packer::default(),
            turn_square: T::zero(),
            bend_squares: T::zero(),
            rebuild: None,
        }
    }
}

impl<T: Real, const N: usize> Storage<T, N> {
    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.appending = Packer::default();
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
        self.rebuild = None;
    }

    /// Block `index`.
    pub fn block(&self, index: usize) -> Option<Block<T>> {
        Some(self.packed(index)?.block(&self.scale))
    }

    /// Block `index` with the two before it and the one after it, as far as there are.
    pub fn around(&self, index: usize) -> [Option<Block<T>>; 4] {
        [0, 1, 2, 3].map(|i| (index + i).checked_sub(2).and_then(|i| self.block(i)))
    }

    /// Samples of block `index`; zero if its rate isn't to be believed.
    pub fn samples(&self, index: usize) -> u32 {
        self.packed(index).map_or(0, Packed::samples)
    }

    fn packed(&self, index: usize) -> Option<&Packed> {
        self.blocks.get(index)
    }

    /// Block `index` is to be crossed, but its rate isn't to be believed.
    pub fn distrust(&mut self, index: usize) {
        if let Some(block) = self.blocks.get_mut(index) {
            *block = block.without_samples();
        }
    }

    /// Blocks stored.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Whether a block turns by so much.
    pub fn turn_by(&self, turn_rad: T) -> bool {
        self.turn_square > turn_rad * turn_rad
    }

    /// Whether it is being rebuilt. Until that is done none of its blocks can be read.
    pub fn is_rebuilt(&self) -> bool {
        self.rebuild.is_some()
    }

    /// Whether all but the last few places are taken.
    pub fn is_full(&self) -> bool {
        self.len() + LAST_BLOCKS >= N
    }

    /// Whether it is time to make room.
    pub fn is_nearly_full(&self) -> bool {
        self.len() + (N / RESERVE_SHARE).max(LEAST_RESERVE) >= N
    }

    /// Appends a block, of which a usual one has so many samples; false if there is no
    /// room, or if it is far longer than that.
    pub fn push(&mut self, block: &Block<T>, usual_samples: u32, noise_rad_s: T) -> bool {
        if self.blocks.is_empty() {
            let share = T::count(usual_samples) / T::count(block.samples.max(1));
            let (drive_n_m_s, duration_s) = (block.drive_n_m_s, block.duration_s * share);
            self.scale = Scale { drive_n_m_s, duration_s };
        }
        if self.blocks.is_full() || !Packed::fits(block, &self.scale) {
            return false;
        }
        let packed = self.appending.pack(block, &self.scale);
        // There is room.
        let _ = self.blocks.push(packed);
        // One that is still to be rebuilt is noted then.
        if self.rebuild.is_none() {
            self.note_motion(self.len() - 1, block, noise_rad_s);
        }
        true
    }

    /// Notes how far the block at `index` turns and bends, whose two predecessors are in place.
    fn note_motion(&mut self, index: usize, c: &Block<T>, noise_rad_s: T) {
        let turn = c.rate_rad_s * c.duration_s;
        let turn_square = turn.dot(&turn);
        self.turn_square = self.turn_square.max(turn_square);
        let at = |back: usize| index.checked_sub(back).and_then(|i| self.blocks.get(i));
        let (Some(a), Some(b)) = (at(2), at(1)) else { return };
        if a.samples() == 0 || b.samples() == 0 || c.samples == 0 {
            return;
        }
        let bend = a.rate_rad_s() - b.rate_rad_s::<T>() * T::lit(2.0) + c.rate_rad_s;
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
                < T::lit(BEND_SIGMA * BEND_SIGMA) * T::count(self.len() as u32)
    }

    /// Begins to merge blocks two by two. Those that come meanwhile, or have no partner, follow.
    pub fn begin_merging(&mut self) {
        // Twice as long: so is their unit.
        let duration_s = self.scale.duration_s * T::lit(2.0);
        self.begin(0, self.len() & !1, Scale { duration_s, ..self.scale });
    }

    /// Begins to drop the blocks before `first`.
    pub fn begin_dropping(&mut self, first: usize) {
        let drive_n_m_s = self.block(first).map_or(self.scale.drive_n_m_s, |b| b.drive_n_m_s);
        self.begin(first, 0, Scale { drive_n_m_s, ..self.scale });
    }

    fn begin(&mut self, from: usize, in_pairs: usize, scale: Scale<T>) {
        self.rebuild = Some(Rebuild { from, to: 0, in_pairs, scale });
        self.rebuilding = Packer::default();
        self.turn_square = T::zero();
        self.bend_squares = T::zero();
    }

    /// Rebuilds one block: one slice of work.
    pub fn rebuild_one(&mut self, noise_rad_s: T) -> Rebuilt {
        let Some(Rebuild { from, to, in_pairs, scale }) = self.rebuild else {
            return Rebuilt::NotYet;
        };
        let Some(mut block) = self.block(from) else {
            self.blocks.truncate(to);
            self.scale = scale;
            self.rebuild = None;
            return if in_pairs > 0 { Rebuilt::Merged } else { Rebuilt::Dropped };
        };
        let mut taken = 1;
        if from < in_pairs
            && let Some(second) = self.block(from + 1)
        {
            block = block.merge(&second);
            taken = 2;
        }
        if let Some(place) = self.blocks.get_mut(to) {
            *place = self.rebuilding.pack(&block, &scale);
        }
        self.note_motion(to, &block, noise_rad_s);
        self.rebuild = Some(Rebuild { from: from + taken, to: to + 1, in_pairs, scale });
        Rebuilt::NotYet
    }
}
