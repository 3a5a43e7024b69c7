//! One Gauss-Newton pass over the blocks of a window, in slices.
//!
//! About a point θ it follows the trajectory from block to block, and puts
//! each block's residual `z̄ − ω̄` with its sensitivities S̄ into a square-root information factor,
//! weighted by the block's number of samples. Once it has come to the newest block it stays
//! there: each further block is one more step of it. Solved, it gives a better point, for the
//! next pass.

use super::known::{INERTIA, Known, Point, UNKNOWNS};
use super::trajectory::{Span, Trajectory};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real};

/// One pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass<T: Real> {
    point: Point<T>,
    trajectory: Trajectory<T>,
    next: usize,
    information: SquareRootInformation<T, UNKNOWNS>,
    /// Sum of the squares that no θ explains, rad²/s² of one sample; of so many rows, of which so
    /// many went into what was unknown.
    unexplained: T,
    rows: u32,
    fitted: u32,
    waiting: Waiting<T>,
}

/// Rows that are still to be taken in, and how many of them are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Waiting<T: Real> {
    Nothing,
    Known(Known<T>, usize),
    Block(BlockRows<T>, usize),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct BlockRows<T: Real> {
    sensitivity: [Vec3<T>; UNKNOWNS],
    residual: Vec3<T>,
    /// √n.
    weight: T,
}

impl<T: Real> Pass<T> {
    /// A pass about `point` that begins with the first block; `None` where that inertia has no
    /// inverse.
    pub fn new(point: Point<T>, known: Option<&Known<T>>) -> Option<Self> {
        Some(Self {
            point,
            trajectory: Trajectory::new(&point)?,
            next: 0,
            information: SquareRootInformation::default(),
            unexplained: T::zero(),
            rows: 0,
            fitted: UNKNOWNS as u32 - known.map_or(0, Known::rank),
            waiting: known.map_or(Waiting::Nothing, |known| Waiting::Known(*known, 0)),
        })
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

    /// Takes in one of the rows that wait: one slice of work.
    pub fn take_row(&mut self) {
        match self.waiting {
            Waiting::Nothing => {}
            Waiting::Known(known, done) => {
                let (row, from) = (known.rows[done], self.point.minus(&known.point));
                let mut y = known.right[done];
                for c in 0..UNKNOWNS {
                    y -= row[c] * from[c];
                }
                self.information.add(row, y);
                let is_last = done + 1 == UNKNOWNS;
                self.waiting =
                    if is_last { Waiting::Nothing } else { Waiting::Known(known, done + 1) };
            }
            Waiting::Block(block, axis) => {
                let row = block.sensitivity.map(|column| column[axis] * block.weight);
                let left = self.information.add(row, block.residual[axis] * block.weight);
                self.unexplained += left * left;
                self.rows = self.rows.saturating_add(1);
                self.waiting =
                    if axis == 2 { Waiting::Nothing } else { Waiting::Block(block, axis + 1) };
            }
        }
    }

    /// Integrates across the next block and leaves its rows waiting: one slice of work.
    pub fn advance(&mut self, span: &Span<T>) {
        let prediction = self.trajectory.advance(span);
        self.next += 1;
        let block = BlockRows {
            sensitivity: prediction.sensitivity,
            residual: span.block.rate_rad_s - prediction.rate_rad_s,
            weight: T::count(span.block.samples).sqrt(),
        };
        self.waiting = Waiting::Block(block, 0);
    }

    /// The solution: a better point.
    pub fn solve(&self) -> Option<Point<T>> {
        Some(self.point.plus(&self.information.solve()?))
    }

    /// How far the solution is from this pass's own point, squared, rad²/s²: in units of the
    /// noise, by so many sigmas linearising anew could move it at most.
    pub fn step_square(&self) -> T {
        self.information.equations().iter().fold(T::zero(), |sum, (_, y)| sum + *y * *y)
    }

    /// Sum of the squares that no θ explains, rad²/s² of one sample, and its degrees of freedom.
    pub fn unexplained(&self) -> (T, u32) {
        (self.unexplained, self.rows.saturating_sub(self.fitted))
    }

    /// Covariance of the six elements for unit noise.
    pub fn inertia_covariance(&self) -> Option<Mat<T, 6, 6>> {
        let factor = self.information.covariance_factor()?;
        let rows = factor.fixed_rows::<6>(INERTIA);
        Some(rows * rows.transpose())
    }

    /// What this pass knows of momentum and inertia at the start of the next block, about the
    /// solution.
    pub fn known_at_next(&self) -> Option<Known<T>> {
        let step = self.information.solve()?;
        let (momentum, lost) = self.trajectory.moved(&step);
        let inertia = self.point.plus(&step).inertia;
        // What rounding the point leaves of the solution: it may be many of its sigmas.
        let rest: [T; UNKNOWNS] = core::array::from_fn(|i| match i {
            0..INERTIA => lost[i],
            _ => step[i] - (inertia[i - INERTIA] - self.point.inertia[i - INERTIA]),
        });
        let mut known = Known {
            point: Point { momentum, inertia },
            rows: [[T::zero(); UNKNOWNS]; UNKNOWNS],
            right: [T::zero(); UNKNOWNS],
        };
        for (i, (row, _)) in self.information.equations().iter().enumerate() {
            let row = self.trajectory.row_at_end(row)?;
            for c in 0..UNKNOWNS {
                known.right[i] += row[c] * rest[c];
            }
            known.rows[i] = row;
        }
        Some(known)
    }
}
