//! One pass of Gauss-Newton over the blocks: prediction, sensitivities, residuals into a factor.
//!
//! Each block adds three rows `S̄ δθ = z̄ − z̄(θ₀)` of variance `σ² / n`, with n its samples. The factor is in
//! units of one sample's variance, so that a change of σ needs no further pass.
//!
//! The robust weight of a block and the watch for a change (`monitor::residuals`) are of its residuals, or of its
//! innovations where the bias walks (module `drift`).

use super::belief::{Past, WALKED};
use super::drift::{Drift, turn_against_field};
use crate::blocks::span::Span;
use crate::blocks::stretch::Rest;
use crate::dynamics::wheels::Momenta;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Entries, Mat, Vec3, norm, scalar::Real};
use crate::monitor::residuals::Residuals;
use crate::trajectory::Trajectory;
use crate::trajectory::unknowns::{FIRST_GROUP, Group, Groups, Point, groups_of, shape_of};

/// Range of the seed over that of an unknown.
const SEED: f64 = 100.0;
/// Rates, rad/s, and derivatives of readings that a motion may reach: their squares are within the range of single precision.
/// The trajectory of a point far from the solution may leave it.
const MOST: f64 = 1e15;

/// Pass over a stretch of blocks about one point.
#[derive(Clone, Copy, Debug)]
pub struct Pass<T: Real, const W: usize, const U: usize, const M: usize> {
    /// Point of linearisation.
    pub point: Point<T, U>,
    /// Step from the point to the solution as far as it is known, at the end of a descent: residuals are judged there.
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
    /// Error of a step by its curvature: decrement after a step of the front over the square of that step's own decrement,
    /// 1/σ². The largest number where it is unknown.
    pub curvature_per_sigma2: T,
    /// Walk of the bias, in units of `unit_rad_s` squared.
    pub drift: Drift<T>,
    /// Walk of the torque over the trace, in units of `unit_rad_s` squared: variance for each radian of turn, 1/s². Zero
    /// for a constant torque.
    pub torque_per_rad: T,
    /// Walk of the inertia, in units of `unit_rad_s` squared: variance of a moment over the trace for each second, s.
    /// Zero for a constant inertia.
    pub inertia_per_s: T,
    /// Time since the inertia walked, s: a half of the last block. The mean of a walk over a block has its end's covariance
    /// with half of it.
    unwalked_s: T,
    /// Mean square of a residual that errors of the considered hardware explain, one sigma, rad²/s².
    pub explained: T,
    /// True where the modes are held without inertia.
    pub holds_modes: bool,
}

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] Pass<T, W, U, M> {
    point, offset, trajectory, factor, residuals, next, unit_per_kg_m2, unit_rad_s, scale_rad_s,
    watch_rad_s, decrement, curvature_per_sigma2, drift, torque_per_rad, inertia_per_s, unwalked_s, explained, holds_modes
} if |this| [this.unit_rad_s, this.scale_rad_s, this.watch_rad_s].iter().all(|x| *x > T::zero()));

impl<T: Real, const W: usize, const U: usize, const M: usize> Pass<T, W, U, M> {
    /// Pass that has not begun.
    pub fn blank() -> Self {
        Self {
            point: Point::sphere(Vec3::zeros()),
            offset: [T::zero(); U],
            trajectory: Trajectory::blank(),
            factor: SquareRootInformation::default(),
            residuals: Residuals::from_block(0),
            next: 0,
            unit_per_kg_m2: T::one(),
            unit_rad_s: T::one(),
            scale_rad_s: T::one(),
            watch_rad_s: T::one(),
            decrement: T::zero(),
            curvature_per_sigma2: T::MAX,
            drift: Drift::none(),
            torque_per_rad: T::zero(),
            inertia_per_s: T::zero(),
            unwalked_s: T::zero(),
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
        self.unwalked_s = T::zero();
        self.seed(groups);
        self.residuals = Residuals::from_block(from);
        self.next = from;
        if !self.trajectory.start(point, groups, axes) {
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

    /// Begins with the information of earlier windows on what lasts, where the inertia walks from there.
    #[inline(never)]
    pub fn begin_with(&mut self, past: &Past<T, U>, groups: &Groups<T>) {
        let variance = self.unit_rad_s * self.unit_rad_s;
        for index in groups.first_kept::<U>()..U {
            let (row, y, weight) = past.row(index, groups, &self.point, self.unit_per_kg_m2);
            self.factor.fold(&row, y, weight * variance);
        }
    }

    /// The bias of each axis changes by a step of this variance, σ² of a sample.
    #[inline(never)]
    fn walk_bias(&mut self, variance: T) {
        let Some(first) = self.trajectory.model.offset_of(Group::Bias) else { return };
        for column in first..first + 3 {
            self.factor.walk(column, variance);
        }
    }

    /// The bias walks over the length of a block, s.
    #[inline(always)]
    fn advance_bias(&mut self, duration_s: T) {
        if groups_of(U) > 0
            && let Some(variance) = self.drift.advance(duration_s)
        {
            self.walk_bias(variance);
        }
    }

    /// Passes a block without a reading, of this length, s.
    #[inline(never)]
    fn pass_hole(&mut self, duration_s: T) {
        self.advance_bias(duration_s);
        self.next += 1;
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

    /// Torque, shape and scale change by a step over a block, from now on.
    #[inline(never)]
    fn walk(&mut self, span: &Span<T, W>, has_field: bool) {
        if groups_of(U) > 0 && self.torque_per_rad > T::zero() {
            let turn = if has_field { T::zero() } else { span.block.turn_square().sqrt() };
            let turn_rad = turn_against_field(turn, span.block.duration_s);
            if let Some(first) = self.trajectory.model.offset_of(Group::Torque) {
                self.walk_along(&[T::one(); 3], first, self.torque_per_rad * turn_rad);
            }
        }
        if self.inertia_per_s > T::zero() {
            let scale = self.point.scale();
            let mut times = WALKED.map(T::count);
            times[5] *= scale * scale;
            let half_s = span.block.duration_s * T::lit(0.5);
            let since_s = core::mem::replace(&mut self.unwalked_s, half_s);
            self.walk_along(&times, shape_of(U), self.inertia_per_s * (since_s + half_s));
        }
    }

    /// Consecutive unknowns change by steps of these variances times a common one.
    ///
    /// With the unknown θ' after the step w, and the momentum m' at the start of the window that leads to the present one
    /// under θ', `θ = θ' − w` and `m₀ = m' + S w`, with `S = (∂m/∂m₀)⁻¹ ∂m/∂θ` ([`push_of`](Trajectory::push_of)).
    #[inline(never)]
    fn walk_along(&mut self, times: &[T], first: usize, variance: T) {
        let Some(back_to_start) = self.trajectory.back_to_start() else { return };
        for (index, times) in (first..).zip(times) {
            let start = back_to_start.of(&self.trajectory.push_of(index));
            let mut along = [T::zero(); U];
            for (of_momentum, s) in along.iter_mut().zip(start.as_slice()) {
                *of_momentum = -*s;
            }
            if let Some(of_index) = along.get_mut(index) {
                *of_index = T::one();
            }
            self.factor.walk_along(&along, index, variance * *times);
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
        let [apart] = &apart.data.0;
        let Self { factor, residuals, .. } = self;
        factor.add_each(rows, apart, weight, |axis, left| {
            *value.at_mut(axis, 0) = residuals.add(axis, left) * one_over;
        });
        value
    }

    /// Takes in the next block.
    #[inline(never)]
    pub fn take(&mut self, span: &Span<T, W>) {
        if self.is_broken() {
            self.next += 1;
            return;
        }
        let has_field = self.trajectory.has_field();
        let is_walking = self.torque_per_rad > T::zero() || self.inertia_per_s > T::zero();
        if is_walking {
            self.walk(span, has_field);
        }
        let mut half_turn = Vec3::zeros();
        if has_field {
            half_turn = self.trajectory.half_turn(span);
            self.trajectory.turn_axes(&half_turn);
            self.trajectory.set_torque(&self.point);
        }
        let crossing = self.trajectory.cross(span);
        let mean_rate_rad_s = self.trajectory.mean_rate_rad_s(&crossing);
        let rows: [[T; U]; 3] =
            core::array::from_fn(|axis| self.trajectory.mean_sensitivity(&crossing, axis));
        let end_rad_s = self.trajectory.nutation_rad_s();
        let numbers = mean_rate_rad_s.iter().chain(rows.iter().flatten()).chain([&end_rad_s]);
        if !are_in_range(numbers) {
            self.break_off();
            return;
        }
        if has_field {
            let rest = self.trajectory.turn_of(&crossing) - half_turn;
            self.trajectory.turn_axes(&rest);
        }
        if span.block.is_hole() {
            self.pass_hole(span.block.duration_s);
            return;
        }
        let apart = span.block.rate_rad_s - mean_rate_rad_s;
        let judged = self.at_solution(&rows, &apart);
        let n = span.block.weight;
        self.advance_bias(span.block.duration_s);
        let (judged, of_innovation) = self.drift.innovation(&judged, n);
        let square = if is_walking {
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
        // At the solution, where nothing walks: a fit that follows the blocks takes up a part of a slow error.
        let of_fit = if is_walking {
            value
        } else {
            judged * ((of_innovation * robust).sqrt() / self.unit_rad_s)
        };
        self.residuals.curvature.add(&mean_rate_rad_s, span.block.duration_s, &of_fit);
        self.next += 1;
        let square = (self.residuals.squares - before).max(T::zero());
        self.residuals.watch(square / (self.watch_rad_s * self.watch_rad_s), self.next);
    }

    /// Notes the curvature in the first pass of a fit that begins with the front's step, of this decrement. A step below a
    /// sigma shows the change of the weights rather than the curvature, which shrinks as the information grows: the one
    /// known before is then a bound.
    pub fn note_curvature(&mut self, of_step: T) {
        let is_shown = of_step > T::one() || self.curvature_per_sigma2 >= T::MAX;
        if is_shown && of_step < T::MAX {
            self.curvature_per_sigma2 = self.decrement / (of_step * of_step);
        }
    }

    /// Ends a pass whose motion has left the range of numbers: the blocks that follow are not compared. No number of the
    /// state is then other than finite, so that a checkpoint can be written at any time.
    #[inline(never)]
    fn break_off(&mut self) {
        self.trajectory.stop();
        self.residuals.cost = T::MAX;
        self.next += 1;
    }

    fn is_broken(&self) -> bool {
        self.residuals.cost >= T::MAX
    }

    /// False where the motion has left the range of numbers.
    pub fn is_finite(&self) -> bool {
        self.residuals.squares.is_finite() && self.residuals.cost < T::MAX
    }
}

/// True for numbers below [`MOST`].
fn are_in_range<'a, T: Real>(mut numbers: impl Iterator<Item = &'a T>) -> bool {
    let most = T::lit(MOST);
    numbers.all(|x| x.abs() < most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::block::Block;
    use crate::checkpoint::{ToWords, transfer};

    /// A point that turns fast, over a block far too long for it: the numbers overflow.
    #[test]
    fn motion_out_of_range_ends_a_pass_and_leaves_finite_state() {
        let mut point = Point::<f32, 9>::sphere(Vec3::new(40.0, -70.0, 90.0));
        point.set_shape(&[0.1, -0.1, 0.05, 0.02, -0.03]);
        let mut pass = Pass::<f32, 0, 9, 0>::blank();
        let (axes, none) = (Mat::<f32, 3, 0>::zeros(), Momenta::zeros());
        assert!(pass.begin(&point, &Groups::none(), &axes, 0, &Rest::none(), &none));
        let of = |duration_s, weight| Span {
            block: Block { duration_s, weight, ..Block::empty() },
            wheels_at_start: Momenta::zeros(),
            samples: 4.0,
            before: None,
            after: None,
        };
        pass.take(&of(0.01, 4.0));
        assert!(pass.is_finite());
        for block in 1..6 {
            pass.take(&of(50.0, 4.0));
            assert_eq!(pass.next, block + 1);
            let mut words = [0; 1024];
            assert!(transfer(&mut pass, &mut ToWords::new(&mut words)).is_ok());
        }
        assert!(!pass.is_finite());
        assert!(pass.begin(&point, &Groups::none(), &axes, 0, &Rest::none(), &none));
        assert!(pass.is_finite());
    }
}
