//! One Gauss-Newton pass over the blocks of a window, in slices.
//!
//! About a point θ it follows the trajectory from block to block, and puts each block's residual
//! `z̄ − ω̄ − b` with its sensitivities S̄ into a square-root information factor, weighted by the
//! block's number of samples. Once it has come to the newest block it stays there: each further
//! block is one more step of it. Solved, it gives a better point, for the next pass.
//!
//! What is left of a row once it has gone into the factor is its recursive residual: for a model
//! that is right these are white, each with the variance of a gyro sample (Brown, Durbin and Evans,
//! J. R. Stat. Soc. B 37, 1975).

use super::approach::Approach;
use super::block::Block;
use super::storage::Storage;
use super::trajectory::{Crossing, Trajectory};
use super::unknowns::{Known, Point};
use crate::math::square_root_information::{RecursiveResidual as Left, SquareRootInformation};
use crate::math::{Vec3, scalar::Real};

/// One pass over U unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass<T: Real, const U: usize> {
    point: Point<T>,
    trajectory: Trajectory<T, U>,
    next: usize,
    stage: Stage,
    approach: Approach<T>,
    crossing: Crossing<T, U>,
    /// Residual of the block whose rows are taken in, rad/s.
    residual: Vec3<T>,
    information: SquareRootInformation<T, U>,
    residuals: Residuals<T>,
}

crate::persist!([T: Real, const U: usize] Pass<T, U> {
    point, trajectory, next, stage, approach, crossing, residual, information, residuals
});

/// The slice of work that comes next in a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// To look at the blocks around the next one.
    Look,
    /// To go on to the next one.
    GoOn,
    /// To carry the momentum across it, a step.
    MoveOn,
    /// To carry the sensitivities after it.
    Differentiate,
    /// To take in its row of this axis.
    Row(usize),
}

crate::persist!([] enum Stage {
    0 => Look, 1 => GoOn, 2 => MoveOn, 3 => Differentiate, 4 => Row(axis: usize)
}
    if |this| !matches!(this, Self::Row(3..)));

/// Sums over the recursive residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals<T: Real> {
    /// Of their squares, rad²/s².
    pub squares: T,
    /// Of their products with the same axis's one block before, rad²/s².
    pub products: T,
    /// How many there are, and how many of the rows went into what was unknown.
    pub rows: u32,
    pub fitted: u32,
    last: [Left<T>; 3],
}

crate::persist!(
    [T: Real] Residuals<T> { squares, products, rows, fitted, last }
    if |this| this.squares >= T::zero()
);

/// What became of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Taken<T> {
    /// A row went in, and left a recursive residual of this square, rad²/s².
    In(T),
    /// The row would have left more than was allowed: it stayed out.
    Refused,
    /// It told nothing of the data.
    Silent,
}

impl<T: Real> Residuals<T> {
    fn new(fitted: u32) -> Self {
        let o = T::zero();
        Self { squares: o, products: o, rows: 0, fitted, last: [Left::nothing(); 3] }
    }

    fn add(&mut self, axis: usize, left: &Left<T>) {
        self.squares += left.square();
        if let Some(last) = self.last.get_mut(axis) {
            self.products += left.product(last);
            *last = *left;
        }
        self.rows = self.rows.saturating_add(1);
    }

    /// Degrees of freedom.
    pub fn degrees(&self) -> u32 {
        self.rows.saturating_sub(self.fitted)
    }

    /// Mean square, rad²/s²; zero without degrees of freedom.
    pub fn mean_square(&self) -> T {
        match self.degrees() {
            0 => T::zero(),
            degrees => self.squares / T::count(degrees),
        }
    }
}

impl<T: Real, const U: usize> Pass<T, U> {
    /// None begun.
    pub fn none() -> Self {
        Self {
            point: Point::new(Vec3::zeros(), [T::zero(); 6]),
            trajectory: Trajectory::nowhere(),
            next: 0,
            stage: Stage::Look,
            approach: Approach::nothing(),
            crossing: Crossing::none(),
            residual: Vec3::zeros(),
            information: SquareRootInformation::default(),
            residuals: Residuals::new(0),
        }
    }

    /// Begins a pass about `point` with the first block, and with what was known before it. False
    /// where that inertia has no inverse.
    pub fn begin(&mut self, point: &Point<T>, known: Option<&Known<T, U>>) -> bool {
        if !self.trajectory.start(point) {
            return false;
        }
        self.point = *point;
        self.next = 0;
        self.stage = Stage::Look;
        match known {
            Some(known) => {
                self.information = known.information;
                self.information.shift(&point.minus(&known.point));
            }
            None => self.information = SquareRootInformation::default(),
        }
        self.residuals = Residuals::new(U as u32 - self.information.rank());
        true
    }

    /// θ.
    pub fn point(&self) -> &Point<T> {
        &self.point
    }

    /// What all rows so far say of a step from θ.
    pub fn information(&self) -> &SquareRootInformation<T, U> {
        &self.information
    }

    /// The same, of a pass that isn't under way: room for a solution.
    pub fn room(&mut self) -> &mut SquareRootInformation<T, U> {
        &mut self.information
    }

    /// See [`Residuals`].
    pub fn residuals(&self) -> &Residuals<T> {
        &self.residuals
    }

    /// The block that comes next.
    pub fn next(&self) -> usize {
        self.next
    }

    /// Whether the newest of the stored blocks has been looked at.
    pub fn has_looked_at_all<const N: usize>(&self, blocks: &Storage<T, N>) -> bool {
        let ahead = match self.stage {
            Stage::Look => 0,
            Stage::GoOn | Stage::Row(_) => 2,
            Stage::MoveOn | Stage::Differentiate => 3,
        };
        self.next + ahead == blocks.len()
    }

    /// See [`Trajectory::growth_square`].
    pub fn growth_square(&self) -> T {
        self.trajectory.growth_square()
    }

    /// What comes next: `None` while the next block waits for the two after it, which tell of its
    /// inside.
    pub fn stage<const N: usize>(&self, blocks: &Storage<T, N>) -> Option<Stage> {
        let waits = self.next + 2 >= blocks.len();
        (self.is_busy() || !waits).then_some(self.stage)
    }

    /// Whether the pass is inside a block.
    pub fn is_busy(&self) -> bool {
        matches!(self.stage, Stage::MoveOn | Stage::Differentiate | Stage::Row(_))
    }

    /// Whatever comes next.
    pub fn current(&self) -> Stage {
        self.stage
    }

    /// Blocks were merged two by two.
    pub fn halve(&mut self) {
        self.next /= 2;
        self.stage = Stage::Look;
    }

    /// One slice of work on stored blocks, in units of an inertia whose inverse is `per`. A block's row
    /// that would leave more than `most` (rad/s) stays out, and so do those of its other axes.
    pub fn work<const N: usize>(&mut self, blocks: &Storage<T, N>, per: T, most: T) -> Taken<T> {
        match self.stage {
            Stage::Look => self.look(blocks),
            Stage::GoOn => self.go_on_to_stored(blocks, per),
            Stage::MoveOn | Stage::Differentiate | Stage::Row(_) => self.inside(most),
        }
    }

    // What unpacks blocks has a frame of its own, so that it isn't under that of a step across one.
    #[inline(never)]
    fn look<const N: usize>(&mut self, blocks: &Storage<T, N>) -> Taken<T> {
        self.approach.begin(blocks.around(self.next));
        self.stage = Stage::GoOn;
        Taken::Silent
    }

    #[inline(never)]
    fn go_on_to_stored<const N: usize>(&mut self, blocks: &Storage<T, N>, per: T) -> Taken<T> {
        self.approach.set_samples(blocks.samples(self.next));
        self.go_on(blocks.block(self.next + 2), per);
        Taken::Silent
    }

    /// The same on what lies ahead when no more comes, followed by a block that isn't stored.
    /// `None` at the end.
    pub fn work_to_the_end(
        &mut self,
        last: &mut Option<Block<T>>,
        per: T,
        most: T,
    ) -> Option<Taken<T>> {
        match self.stage {
            Stage::Look => None,
            Stage::GoOn if self.approach.is_at_the_end() => None,
            Stage::GoOn => {
                self.go_on(last.take(), per);
                Some(Taken::Silent)
            }
            Stage::MoveOn | Stage::Differentiate | Stage::Row(_) => Some(self.inside(most)),
        }
    }

    fn go_on(&mut self, second_after: Option<Block<T>>, per: T) {
        if let Some(span) = self.approach.go_on(second_after, per) {
            self.trajectory.enter(&mut self.crossing, &span, &self.point);
            self.residual = span.block.rate_rad_s;
            self.stage = Stage::MoveOn;
        }
    }

    fn inside(&mut self, most: T) -> Taken<T> {
        match self.stage {
            Stage::Row(axis) => return self.take_row(axis, most),
            Stage::Differentiate => self.differentiate(),
            _ => {
                self.trajectory.move_on(&mut self.crossing, &self.point);
                self.stage = Stage::Differentiate;
            }
        }
        Taken::Silent
    }

    fn differentiate(&mut self) {
        self.trajectory.differentiate(&mut self.crossing, &self.point);
        if !self.crossing.is_done() {
            self.stage = Stage::MoveOn;
            return;
        }
        self.next += 1;
        self.stage = if self.crossing.samples() > 0 {
            self.residual -= self.trajectory.mean_rate_rad_s(&self.crossing, &self.point);
            Stage::Row(0)
        } else {
            Stage::GoOn
        };
    }

    fn take_row(&mut self, axis: usize, most: T) -> Taken<T> {
        let axis = axis.min(2); // it always is, which the compiler can't see
        let row = self.trajectory.mean_sensitivity(&self.crossing, axis);
        let weight = T::count(self.crossing.samples());
        let y = self.residual[axis];
        if most < T::MAX && self.information.would_leave(&row, y, weight).square() > most * most {
            self.stage = Stage::GoOn;
            return Taken::Refused;
        }
        let left = self.information.add_weighted(&row, y, weight);
        self.residuals.add(axis, &left);
        self.stage = if axis < 2 { Stage::Row(axis + 1) } else { Stage::GoOn };
        Taken::In(left.square())
    }

    /// What the point a step from θ comes to at the start of the next block, and of the step what
    /// rounding that point leaves, which may be many of its sigmas.
    pub fn carried(&self, step: &[T; U]) -> (Point<T>, [T; U]) {
        let (momentum, lost) = self.trajectory.moved(step);
        let point = Point { momentum, ..self.point.plus(step) };
        let rounded: [T; U] = point.minus(&self.point);
        let rest = core::array::from_fn(|i| if i < 3 { lost[i] } else { step[i] - rounded[i] });
        (point, rest)
    }

    /// Equation `index` of the factor, on the step and then on what [`carried`](Self::carried)
    /// leaves of it, with its weight.
    pub fn carried_equation(
        &self,
        index: usize,
        step: &[T; U],
        rest: &[T; U],
    ) -> Option<([T; U], T, T)> {
        let (row, mut left, weight) = self.information.equation(index);
        for c in 0..U {
            left -= row[c] * step[c];
        }
        let row = if index < 3 { self.trajectory.row_at_end(&row)? } else { row };
        for c in 0..U {
            left += row[c] * rest[c];
        }
        Some((row, left, weight))
    }
}
