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

use super::trajectory::{Span, Trajectory};
use super::unknowns::{Point, Rows};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Vec3, scalar::Real};

/// One pass over U unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass<T: Real, const U: usize> {
    point: Point<T>,
    trajectory: Trajectory<T, U>,
    next: usize,
    information: SquareRootInformation<T, U>,
    residuals: Residuals<T>,
    waiting: Waiting<T, U>,
}

/// Rows that are still to be taken in, and how many of them are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Waiting<T: Real, const U: usize> {
    Nothing,
    Carried(usize),
    Block(BlockRows<T, U>, usize),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct BlockRows<T: Real, const U: usize> {
    sensitivity: [Vec3<T>; U],
    residual: Vec3<T>,
    /// √n.
    weight: T,
}

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
    last: Vec3<T>,
}

/// What became of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Taken<T> {
    /// It went in, and left this recursive residual, rad/s.
    In(T),
    /// It would have left more than was allowed: it stayed out.
    Refused,
    /// It told nothing of the data.
    Silent,
}

impl<T: Real> Residuals<T> {
    fn new(fitted: u32) -> Self {
        let o = T::zero();
        Self { squares: o, products: o, rows: 0, fitted, last: Vec3::zeros() }
    }

    fn add(&mut self, axis: usize, left: T) {
        self.squares += left * left;
        self.products += left * self.last[axis];
        self.last[axis] = left;
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
    /// A pass about `point` that begins with the first block, and with what was carried to there;
    /// `None` where that inertia has no inverse.
    pub fn new(point: Point<T>, carried: Option<&Rows<T, U>>) -> Option<Self> {
        Some(Self {
            point,
            trajectory: Trajectory::new(&point)?,
            next: 0,
            information: SquareRootInformation::default(),
            residuals: Residuals::new(U as u32 - carried.map_or(0, Rows::rank)),
            waiting: carried.map_or(Waiting::Nothing, |_| Waiting::Carried(0)),
        })
    }

    /// θ.
    pub fn point(&self) -> &Point<T> {
        &self.point
    }

    /// What all rows so far say of a step from θ.
    pub fn information(&self) -> &SquareRootInformation<T, U> {
        &self.information
    }

    /// See [`Residuals`].
    pub fn residuals(&self) -> &Residuals<T> {
        &self.residuals
    }

    /// The block that comes next.
    pub fn next(&self) -> usize {
        self.next
    }

    /// See [`Trajectory::growth_square`].
    pub fn growth_square(&self) -> T {
        self.trajectory.growth_square()
    }

    /// Whether rows wait to be taken in.
    pub fn is_busy(&self) -> bool {
        self.waiting != Waiting::Nothing
    }

    /// Blocks were merged two by two.
    pub fn halve(&mut self) {
        self.next /= 2;
    }

    /// Takes in one of the rows that wait: one slice of work. A block's row that would leave more
    /// than `most` (rad/s) stays out, and so do those of its other axes that wait.
    pub fn take_row(&mut self, carried: Option<&Rows<T, U>>, most: T) -> Taken<T> {
        match self.waiting {
            Waiting::Nothing => Taken::Silent,
            Waiting::Carried(done) => {
                let is_last = done + 1 >= U;
                self.waiting = if is_last { Waiting::Nothing } else { Waiting::Carried(done + 1) };
                if let Some(carried) = carried {
                    let (row, y) = carried.about(&self.point, done);
                    self.information.add(row, y);
                }
                Taken::Silent
            }
            Waiting::Block(block, axis) => {
                let row = block.sensitivity.map(|column| column[axis] * block.weight);
                let before = self.information;
                let left = self.information.add(row, block.residual[axis] * block.weight);
                if left.abs() > most {
                    self.information = before;
                    self.waiting = Waiting::Nothing;
                    return Taken::Refused;
                }
                self.residuals.add(axis, left);
                self.waiting =
                    if axis == 2 { Waiting::Nothing } else { Waiting::Block(block, axis + 1) };
                Taken::In(left)
            }
        }
    }

    /// Takes in all rows that wait, as [`take_row`](Self::take_row) does.
    pub fn take_all_rows(&mut self, carried: Option<&Rows<T, U>>, most: T) {
        for _ in 0..U {
            self.take_row(carried, most);
        }
    }

    /// Integrates across the next block and leaves its rows waiting: one slice of work.
    pub fn advance(&mut self, span: &Span<T>) {
        let prediction = self.trajectory.advance(span);
        self.next += 1;
        if span.block.samples == 0 {
            return;
        }
        let block = BlockRows {
            sensitivity: prediction.sensitivity,
            residual: span.block.rate_rad_s - prediction.rate_rad_s,
            weight: T::count(span.block.samples).sqrt(),
        };
        self.waiting = Waiting::Block(block, 0);
    }

    /// What this pass knows at the start of the next block, about the point a step from θ: all
    /// that the next window has to begin with.
    pub fn carry(&self, step: &[T; U]) -> Option<Rows<T, U>> {
        let (momentum, lost) = self.trajectory.moved(step);
        let point = Point { momentum, ..self.point.plus(step) };
        // What rounding the point leaves of the solution: it may be many of its sigmas.
        let rounded: [T; U] = point.minus(&self.point);
        let rest: [T; U] =
            core::array::from_fn(|i| if i < 3 { lost[i] } else { step[i] - rounded[i] });
        let mut carried = Rows { point, rows: [[T::zero(); U]; U], right: [T::zero(); U] };
        for (i, (row, y)) in self.information.equations().iter().enumerate() {
            // About the step, of what the factor itself says: zero for its own solution.
            let mut left = *y;
            for c in 0..U {
                left -= row[c] * step[c];
            }
            let row = self.trajectory.row_at_end(row)?;
            for c in 0..U {
                left += row[c] * rest[c];
            }
            carried.right[i] = left;
            carried.rows[i] = row;
        }
        Some(carried)
    }
}
