//! One pass of Gauss-Newton over the blocks: prediction, sensitivities, residuals into a factor.
//!
//! Each block adds three rows `S̄ δθ = z̄ − z̄(θ₀)` of variance `σ² / n`, with n its samples. The factor is in
//! units of one sample's variance, so that a change of σ needs no further pass.
//!
//! # Robust weights
//!
//! With `u² = n |r|² / s²` of a block's three residuals, or of its innovations where the bias walks (module `drift`), and s the typical residual, a block has the weight
//! `min(1, K² / u²)`: an influence bounded by K. s is σ, or the median of the last pass where that is
//! larger: far from the solution all residuals are large, and none of them is an outlier.
//!
//! # Watch for a change
//!
//! The squared recursive residuals of a block over their variance have a mean of 3 as long as one tensor
//! and one motion explain all blocks. Their cumulative sum `c ← max(0, c + min(u², 16) − 3 − 1)` stays low
//! then. Noise alone lifts it above h once in `exp(θ h)` blocks, with θ = 0.24 the root of
//! `E exp(θ (min(u², 16) − 4)) = 1` for chi-square of three degrees of freedom: with h = 75 once in 7·10⁷. The
//! block at which it began to rise estimates the instant of the change.

use super::drift::{Drift, turn_against_field};
use crate::blocks::span::Span;
use crate::blocks::stretch::Rest;
use crate::dynamics::wheels::Momenta;
use crate::math::square_root_information::{RecursiveResidual, SquareRootInformation};
use crate::math::{Entries, Mat, Vec3, norm, scalar::Real};
use crate::monitor::curvature::Curvature;
use crate::monitor::whiteness::Whiteness;
use crate::trajectory::Trajectory;
use crate::trajectory::unknowns::{FIRST_GROUP, Group, Groups, Point, groups_of, shape_of};

/// K: u² of three normal residuals exceeds its square by chance once in 900 blocks (chi-square).
const ROBUST: f64 = 4.0;
/// Median of chi-square with three degrees of freedom.
const MEDIAN_CHI_SQUARE: f64 = 2.366;
/// Octaves of u² in the histogram, and the first one: 2⁻⁴ to 2²⁴.
const OCTAVES: usize = 28;
const FIRST_OCTAVE: i32 = -4;
/// Share of blocks at reduced weight above which the model is wrong rather than the blocks, and number
/// that chance alone may add.
const LOW_SHARE: f64 = 0.05;
const LOW_BY_CHANCE: f64 = 3.0;

/// Expected square of a block, and the drift of Page's test.
const EXPECTED: f64 = 4.0;
/// Largest contribution of a block: an outlier is not a change.
const MOST: f64 = 16.0;
/// h.
const CONTRADICTED: f64 = 75.0;
/// Sum above which the newest residuals are not called white: by chance at `exp(−0.24 · 40)`, one instant in
/// 15,000. Four blocks beyond [`MOST`] exceed it.
const ALARMED: f64 = 40.0;
/// Levels of groups: up to 256 blocks, which is half of a storage of 512.
const LEVELS: usize = 5;
/// Blocks over which residuals are tested for correlation: a period of a mode at the usual eight blocks or fewer.
pub const LAGS: usize = 6;
/// Range of the seed over that of an unknown.
const SEED: f64 = 100.0;

/// Statistics of the residuals of a pass. Squares are in rad²/s² of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals<T: Real> {
    /// Number of blocks, of rows.
    pub blocks: u32,
    pub rows: u32,
    /// Sum of squared recursive residuals at their weights.
    pub squares: T,
    /// Sums of products with those of the block before, of the one before that, …
    products: [T; LAGS],
    /// Robust cost `Σ min(u², K²) s²`.
    pub cost: T,
    /// Blocks at reduced weight; the present run of them, and the longest one.
    pub low: u32,
    run: Run,
    pub longest: Run,
    /// Cumulative sum of Page's test, the block at which it began to rise, and whether it has exceeded
    /// its limit.
    sum: T,
    pub rise: usize,
    pub is_contradicted: bool,
    last: [[RecursiveResidual<T>; 3]; LAGS],
    histogram: [u16; OCTAVES],
    /// Groups of recursive residuals, over the unit of the histogram.
    pub whiteness: Whiteness<T, LEVELS>,
    /// Residuals at the solution along the curvature of the rate.
    pub curvature: Curvature<T>,
}

crate::persist!([T: Real] Residuals<T> {
    blocks, rows, squares, products, cost, low, run, longest, sum, rise, is_contradicted, last, histogram,
    whiteness, curvature
} if |this| this.squares >= T::zero());

/// Run of blocks at reduced weight, with gaps of up to three blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// First block, and the one after the last.
    pub from: usize,
    pub after: usize,
    /// Number of blocks at reduced weight.
    pub count: u32,
}

crate::persist!([] Run { from, after, count });

/// Blocks of full weight that end a run.
const RUN_GAP: usize = 4;

impl Run {
    fn none() -> Self {
        Self { from: 0, after: 0, count: 0 }
    }

    /// The run with one more block.
    fn with(self, block: usize) -> Self {
        if self.count > 0 && block < self.after.saturating_add(RUN_GAP) {
            Self { after: block + 1, count: self.count.saturating_add(1), ..self }
        } else {
            Self { from: block, after: block + 1, count: 1 }
        }
    }
}

impl<T: Real> Residuals<T> {
    /// No residuals.
    pub fn none() -> Self {
        Self {
            blocks: 0,
            rows: 0,
            squares: T::zero(),
            products: [T::zero(); LAGS],
            cost: T::zero(),
            low: 0,
            run: Run::none(),
            longest: Run::none(),
            sum: T::zero(),
            rise: 0,
            is_contradicted: false,
            last: [[RecursiveResidual::nothing(); 3]; LAGS],
            histogram: [0; OCTAVES],
            whiteness: Whiteness::default(),
            curvature: Curvature::none(),
        }
    }

    /// Degrees of freedom of the sum of squares for U unknowns.
    pub fn degrees(&self, unknowns: u32) -> u32 {
        self.rows.saturating_sub(unknowns)
    }

    /// Residual of a sample as the median of the blocks has it, one axis, rad/s, for the unit in which
    /// the histogram was filled.
    #[inline(never)]
    pub fn typical(&self, unit_rad_s: T) -> T {
        let half = self.blocks / 2;
        let (mut below, mut octave) = (0, 0);
        while octave + 1 < OCTAVES && below + u32::from(self.histogram[octave]) <= half {
            below += u32::from(self.histogram[octave]);
            octave += 1;
        }
        let inside = T::count(half.saturating_sub(below)) + T::lit(0.5);
        let share = inside / T::count(u32::from(self.histogram[octave]).max(1));
        let mut bottom = T::lit(0.0625);
        for _ in 0..octave {
            bottom += bottom;
        }
        let u_square = bottom * (T::one() + share.min(T::one()));
        (u_square / T::lit(MEDIAN_CHI_SQUARE)).sqrt() * unit_rad_s
    }

    /// Correlation of residuals from block to block, −1 to 1, with a sum of products up to `explained` explained
    /// otherwise, rad²/s².
    pub fn correlation_beyond(&self, explained: T) -> T {
        let [products, ..] = self.products;
        let beyond = products - products.max(-explained).min(explained);
        if self.squares > T::zero() { beyond / self.squares } else { T::zero() }
    }

    /// Number of rows times the sum of squared correlations over [`LAGS`] blocks \[Box1970\], with sums of products up to
    /// `explained` explained otherwise, rad²/s²: chi-square of LAGS degrees of freedom if white.
    pub fn correlations_beyond(&self, explained: T) -> T {
        let sum = self.products.iter().fold(T::zero(), |sum, products| {
            let beyond = *products - products.max(-explained).min(explained);
            sum + beyond * beyond
        });
        let squares = self.squares * self.squares;
        if squares > T::zero() { sum * T::count(self.rows) / squares } else { T::zero() }
    }

    /// True where more blocks are at reduced weight than outliers explain.
    pub fn has_many_low(&self) -> bool {
        let most = T::count(self.blocks) * T::lit(LOW_SHARE) + T::lit(LOW_BY_CHANCE);
        T::count(self.low) > most
    }

    /// Takes in `n |r|²` of a block in units of the histogram; returns the block's weight.
    fn weigh(&mut self, block: usize, square: T, unit_rad_s: T, scale_rad_s: T) -> T {
        let of_unit = square / (unit_rad_s * unit_rad_s);
        let exponent = ((of_unit.to_f32().to_bits() >> 23) & 0xff) as i32 - 127;
        let octave = (exponent - FIRST_OCTAVE).clamp(0, OCTAVES as i32 - 1) as usize;
        self.histogram[octave] = self.histogram[octave].saturating_add(1);
        self.blocks = self.blocks.saturating_add(1);
        let most = scale_rad_s * scale_rad_s * T::lit(ROBUST * ROBUST);
        self.cost += square.min(most);
        if square > most {
            self.low = self.low.saturating_add(1);
            self.run = self.run.with(block);
            if self.run.count >= self.longest.count {
                self.longest = self.run;
            }
            most / square
        } else {
            T::one()
        }
    }

    /// Watches the squared residual of a block over its variance; `next` is the block after it.
    fn watch(&mut self, share: T, next: usize) {
        if self.is_contradicted {
            return;
        }
        let sum = self.sum + share.min(T::lit(MOST)) - T::lit(EXPECTED);
        if sum > T::zero() {
            self.sum = sum;
        } else {
            self.sum = T::zero();
            self.rise = next;
        }
        self.is_contradicted = self.sum > T::lit(CONTRADICTED);
    }

    /// True where the newest blocks are not explained.
    pub fn is_alarmed(&self) -> bool {
        self.sum > T::lit(ALARMED)
    }

    fn add(&mut self, axis: usize, left: RecursiveResidual<T>) {
        self.squares += left.square();
        let mut newer = left;
        for (products, last) in self.products.iter_mut().zip(&mut self.last) {
            if let Some(last) = last.get_mut(axis) {
                *products += left.product(last);
                core::mem::swap(last, &mut newer);
            }
        }
        self.rows = self.rows.saturating_add(1);
    }
}

/// Pass over a stretch of blocks about one point.
#[derive(Clone, Copy, Debug)]
pub struct Pass<T: Real, const W: usize, const U: usize, const M: usize> {
    /// Point of linearisation.
    pub point: Point<T, U>,
    /// Step from the point to the solution as far as it is known, where it is below the rounding of the
    /// point: residuals are judged there.
    pub offset: [T; U],
    pub trajectory: Trajectory<T, W, U, M>,
    /// Information of the blocks on a step from the point.
    pub factor: SquareRootInformation<T, U>,
    pub residuals: Residuals<T>,
    /// Block that comes next.
    pub next: usize,
    /// κᵤ, unit of the inverse trace, 1/(kg m²).
    pub unit_per_kg_m2: T,
    /// Unit of the histogram and scale of the robust weights, one axis of a sample, rad/s.
    pub unit_rad_s: T,
    pub scale_rad_s: T,
    /// One sigma of a sample for the watch, rad/s.
    pub watch_rad_s: T,
    /// Newton decrement with which the descent ended, σ²: distance to the minimum that rounding leaves.
    pub decrement: T,
    /// Walk of the bias, in units of `unit_rad_s` squared.
    pub drift: Drift<T>,
    /// Walk of the torque over the trace, in units of `unit_rad_s` squared: variance for each radian of turn, 1/s². Zero
    /// for a constant torque.
    pub torque_per_rad: T,
    /// Mean square of a residual that errors of the considered hardware explain, one sigma, rad²/s².
    pub explained: T,
    /// True where the modes are held without inertia.
    pub holds_modes: bool,
}

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] Pass<T, W, U, M> {
    point, offset, trajectory, factor, residuals, next, unit_per_kg_m2, unit_rad_s, scale_rad_s,
    watch_rad_s, decrement, drift, torque_per_rad, explained, holds_modes
} if |this| [this.unit_rad_s, this.scale_rad_s, this.watch_rad_s].iter().all(|x| *x > T::zero()));

impl<T: Real, const W: usize, const U: usize, const M: usize> Pass<T, W, U, M> {
    /// Pass that has not begun.
    pub fn blank() -> Self {
        Self {
            point: Point::sphere(Vec3::zeros()),
            offset: [T::zero(); U],
            trajectory: Trajectory::blank(),
            factor: SquareRootInformation::default(),
            residuals: Residuals::none(),
            next: 0,
            unit_per_kg_m2: T::one(),
            unit_rad_s: T::one(),
            scale_rad_s: T::one(),
            watch_rad_s: T::one(),
            decrement: T::zero(),
            drift: Drift::none(),
            torque_per_rad: T::zero(),
            explained: T::zero(),
            holds_modes: M > 0,
        }
    }

    /// Begins at a point and at block `from`. `rest` measures the rate there, for wheel momentum `wheels`
    /// times the unit. False where the point's tensor has no inverse.
    #[inline(never)]
    pub fn begin(
        &mut self,
        point: &Point<T, U>,
        groups: &Groups<T>,
        axes: &Mat<T, 3, W>,
        from: usize,
        rest: &Rest<T, W>,
        wheels: &Momenta<T, W>,
    ) -> bool {
        self.point = *point;
        self.offset = [T::zero(); U];
        self.seed(groups);
        self.residuals = Residuals { rise: from, ..Residuals::none() };
        self.next = from;
        if !self.trajectory.start(point, groups, axes, wheels) {
            return false;
        }
        if rest.weight > T::zero() {
            let model = &self.trajectory.model;
            let rate = model.rate_rad_s(&point.momentum(), wheels);
            let apart = rest.rate_rad_s - model.reading_rad_s(&point.momentum(), wheels);
            for axis in 0..3 {
                let row = self.trajectory.reading_at_start(&rate, wheels, axis);
                self.factor.fold(&row, apart[axis], rest.weight);
            }
            if groups_of(U) > 0
                && let Some(variance) = self.drift.after_rest()
            {
                self.walk_bias(variance);
            }
        }
        true
    }

    /// The bias of each axis changes by a step of this variance, σ² of a sample.
    #[inline(never)]
    fn walk_bias(&mut self, variance: T) {
        let Some(first) = self.trajectory.model.offset_of(Group::Bias) else { return };
        for column in first..first + 3 {
            self.factor.walk(column, variance);
        }
    }

    /// Seeds the factor with next to no information, at the point itself.
    ///
    /// Without it the first rows, which are those of a body at rest, would find pivots that consist of
    /// rounding, and right-hand sides of that size inverse. A range of [`SEED`] times what is possible
    /// lies far above rounding and far below any data.
    fn seed(&mut self, groups: &Groups<T>) {
        let noise = self.unit_rad_s;
        let rate = norm(&self.point.momentum()) + noise * T::lit(SEED);
        self.factor = SquareRootInformation::default();
        for (column, row) in self.factor.factor.iter_mut().enumerate() {
            let range = if column < FIRST_GROUP {
                rate
            } else if column < shape_of(U) {
                match groups.sigma(column) {
                    Some(sigma) => sigma,
                    None => rate.max(T::one()),
                }
            } else {
                T::one()
            };
            let share = noise / (range * T::lit(SEED));
            row[column] = share * share;
        }
    }

    /// The torque of each axis changes by a step over a turn, from now on.
    ///
    /// With the torque d' after the step w, and the momentum m' at the start of the window that leads to the present one
    /// under d', `d = d' − w` and `m₀ = m' + S w` ([`start_for_torque`](Trajectory::start_for_torque)).
    #[inline(never)]
    fn walk_torque(&mut self, turn_rad: T) {
        let Some((first, start)) = self.trajectory.start_for_torque() else { return };
        let variance = self.torque_per_rad * turn_rad;
        for (axis, start) in start.iter().enumerate() {
            let mut along = [T::zero(); U];
            for (of_momentum, s) in along.iter_mut().zip(start.as_slice()) {
                *of_momentum = -*s;
            }
            if let Some(of_torque) = along.get_mut(first + axis) {
                *of_torque = T::one();
            }
            self.factor.walk_along(&along, first + axis, variance);
        }
    }

    /// Square of a block's innovations by the factor, over its variance of a sample, rad²/s².
    #[inline(never)]
    fn square_by_factor(&self, rows: &[[T; U]; 3], apart: &Vec3<T>, n: T) -> T {
        let axes = rows.iter().zip(apart.as_slice());
        axes.fold(T::zero(), |sum, (row, apart)| {
            sum + self.factor.would_leave(row, *apart, n).square()
        })
    }

    /// Residuals at the solution for those at the point, rad/s.
    #[inline(always)]
    fn at_solution(&self, rows: &[[T; U]; 3], apart: &Vec3<T>) -> Vec3<T> {
        Vec3::from_fn(|axis, _| {
            let explained = rows[axis].iter().zip(&self.offset);
            explained.fold(apart.at(axis, 0), |left, (s, step)| left - *s * *step)
        })
    }

    /// Adds the rows of a block to the factor. Returns their recursive residuals in units of `unit_rad_s`.
    #[inline(always)]
    fn fold(&mut self, rows: &[[T; U]; 3], apart: &Vec3<T>, weight: T) -> Vec3<T> {
        let (mut value, one_over) = (Vec3::zeros(), T::one() / self.unit_rad_s);
        for (axis, row) in rows.iter().enumerate() {
            let left = self.factor.add_weighted(row, apart.at(axis, 0), weight);
            self.residuals.add(axis, left);
            *value.at_mut(axis, 0) = left.residual() * one_over;
        }
        value
    }

    /// Takes in the next block.
    #[inline(never)]
    pub fn take(&mut self, span: &Span<T, W>) {
        let is_torque_walking = groups_of(U) > 0 && self.torque_per_rad > T::zero();
        if is_torque_walking {
            let turn = span.block.turn_square().sqrt();
            self.walk_torque(turn_against_field(turn, span.block.duration_s));
        }
        let crossing = self.trajectory.cross(span);
        let mean_rate_rad_s = self.trajectory.mean_rate_rad_s(&crossing);
        let apart = span.block.rate_rad_s - mean_rate_rad_s;
        let rows: [[T; U]; 3] =
            core::array::from_fn(|axis| self.trajectory.mean_sensitivity(&crossing, axis));
        let judged = self.at_solution(&rows, &apart);
        let n = span.block.weight;
        if groups_of(U) > 0
            && let Some(variance) = self.drift.advance(span.block.duration_s)
        {
            self.walk_bias(variance);
        }
        let (judged, of_innovation) = self.drift.innovation(&judged, n);
        let square = if is_torque_walking {
            self.square_by_factor(&rows, &apart, n)
        } else {
            judged.dot(&judged) * of_innovation
        };
        let robust = self.residuals.weigh(self.next, square, self.unit_rad_s, self.scale_rad_s);
        self.drift.update(&judged, of_innovation * robust);
        let weight = n * robust;
        let before = self.residuals.squares;
        let value = self.fold(&rows, &apart, weight);
        self.residuals.whiteness.add_value(&value);
        // At the solution, where the torque does not walk: a fit that follows the blocks takes up a part of a slow error.
        let of_fit = if is_torque_walking {
            value
        } else {
            judged * ((of_innovation * robust).sqrt() / self.unit_rad_s)
        };
        self.residuals.curvature.add(&mean_rate_rad_s, span.block.duration_s, &of_fit);
        self.next += 1;
        let square = (self.residuals.squares - before).max(T::zero());
        self.residuals.watch(square / (self.watch_rad_s * self.watch_rad_s), self.next);
    }

    /// False where a number of the pass is not finite.
    pub fn is_finite(&self) -> bool {
        self.residuals.squares.is_finite() && self.residuals.cost.is_finite()
    }
}
