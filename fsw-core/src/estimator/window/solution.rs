//! From a pass to a solution: its data, with what is held of the unknowns beside them.
//!
//! A pass collects what the window's data say and nothing else. To solve it, rows are added to a
//! copy of its factor, one a slice:
//!
//! 1. torque, bias and drag: zero, or within a range;
//! 2. the past of the inertia, where there is one;
//! 3. where the inertia is still vague, a sphere of the typical size, loosely: an inertia that no
//!    data hold may come close to a singular one, which magnifies motion so that noise looks like
//!    information.
//!
//! What rows of 1. and 2. leave is how much the data contradict them: with white noise of variance
//! σ², the sum of their squares over σ² is chi-square with as many degrees of freedom as rows. For a
//! torque held at zero that is Lagrange's multiplier test for a constant torque, which uses just the
//! part of it that no change of inertia imitates; for drag, whether the torque changes with the motion;
//! for the past, the test for a change.

use super::pass::Pass;
use super::past::Past;
use super::unknowns::{BIAS, DRAG, Point, TORQUE, has_bias, has_drag, has_torque, inertia_of};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, scalar::Real};

/// An element whose sigma is above this many typical inertias is vague.
pub const VAGUE: f64 = 0.15;
/// How loosely a vague inertia is held to a sphere, one sigma of each element in typical inertias:
/// ten times this is far from any of them, a third is no tensor that moves wildly.
const SPHERE_SIGMA: f64 = 0.3;
/// Held at zero, an unknown is as good as known: so many times what the data know of it.
const HARD: f64 = 1.0e3;

/// The weight that holds an unknown at zero, of which a column of this size is known.
pub fn hard<T: Real>(column_size: T) -> T {
    if column_size > T::zero() { column_size * T::lit(HARD) } else { T::one() }
}

/// How a torque or a bias is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold<T> {
    /// At zero.
    AtZero,
    /// Within one sigma, in the unknown's units.
    Within(T),
}

/// What is held of the unknowns beside a window's own data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<T: Real> {
    /// One sigma of a gyro sample, rad/s.
    pub noise_rad_s: T,
    /// Unit of inertia, kg m².
    pub typical_kg_m2: T,
    /// rad/s².
    pub torque: Hold<T>,
    /// rad/s.
    pub bias: Hold<T>,
    /// 1/s.
    pub drag: Hold<T>,
    /// The inertia before this window.
    pub past: Option<Past<T>>,
}

/// A solution in the making.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solving<T: Real, const U: usize> {
    information: SquareRootInformation<T, U>,
    point: Point<T>,
    row: usize,
    /// Sums of squares that rows left, rad²/s².
    torque_square: T,
    drag_square: T,
    past_square: T,
}

/// Rows of each kind begin here, three or six of each.
const OF_BIAS: usize = 3;
const OF_DRAG: usize = 6;
const PAST: usize = 9;
const SPHERE: usize = 15;
const END: usize = 21;

/// A solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real, const U: usize> {
    /// The step from the pass's point.
    pub step: [T; U],
    /// How far the inertia moves in it, squared, rad²/s²: in units of the noise, so many sigmas.
    pub inertia_step_square: T,
    /// Where it leads.
    pub point: Point<T>,
    /// Covariance for unit noise, rows and columns of the torque, of the bias and of the inertia.
    pub torque_covariance: Mat<T, 3, 3>,
    /// See `torque_covariance`.
    pub bias_covariance: Mat<T, 3, 3>,
    /// See `torque_covariance`. Nothing but data, the past, and what any body keeps to holds it.
    pub inertia_covariance: Mat<T, 6, 6>,
}

impl<T: Real, const U: usize> Solving<T, U> {
    /// Begins with a pass that has no rows waiting.
    pub fn new(pass: &Pass<T, U>) -> Self {
        Self {
            information: *pass.information(),
            point: *pass.point(),
            row: 0,
            torque_square: T::zero(),
            drag_square: T::zero(),
            past_square: T::zero(),
        }
    }

    /// Adds one row: one slice of work. True once all are in.
    pub fn take_row(&mut self, held: &Held<T>) -> bool {
        match self.row {
            0..OF_BIAS if has_torque(U) => {
                let axis = self.row;
                let left = self.hold(TORQUE + axis, self.point.torque[axis], &held.torque, held);
                if held.torque == Hold::AtZero {
                    self.torque_square += left * left;
                }
            }
            OF_BIAS..OF_DRAG if has_bias(U) => {
                let axis = self.row - OF_BIAS;
                self.hold(BIAS + axis, self.point.bias[axis], &held.bias, held);
            }
            OF_DRAG..PAST if has_drag(U) => {
                let axis = self.row - OF_DRAG;
                let left = self.hold(DRAG + axis, self.point.drag[axis], &held.drag, held);
                if held.drag == Hold::AtZero {
                    self.drag_square += left * left;
                }
            }
            PAST..SPHERE => {
                if let Some(past) = &held.past {
                    self.add_past(past, held);
                }
            }
            SPHERE if !is_vague(&self.information, held.noise_rad_s) => self.row = END,
            SPHERE..END => {
                let element = self.row - SPHERE;
                let weight = held.noise_rad_s / T::lit(SPHERE_SIGMA);
                add_sphere(&mut self.information, &self.point.inertia, element, weight);
            }
            _ => {}
        }
        self.row += 1;
        self.row >= END
    }

    /// Adds rows until the past is in.
    pub fn take_all_but_the_sphere(&mut self, held: &Held<T>) {
        while self.row < SPHERE {
            self.take_row(held);
        }
    }

    fn hold(&mut self, column: usize, value: T, hold: &Hold<T>, held: &Held<T>) -> T {
        let weight = match hold {
            Hold::AtZero => hard(self.information.column_size(column)),
            Hold::Within(sigma) => held.noise_rad_s / *sigma,
        };
        let mut row = [T::zero(); U];
        row[column] = weight;
        self.information.add(row, -weight * value)
    }

    fn add_past(&mut self, past: &Past<T>, held: &Held<T>) {
        let index = self.row - PAST;
        // From unit variance to that of the gyro, from kg m² to typical inertias.
        let weight = held.noise_rad_s * held.typical_kg_m2;
        let mut row = [T::zero(); U];
        let mut y = past.right[index] * held.noise_rad_s;
        for c in 0..6 {
            let r = past.rows[index][c] * weight;
            row[inertia_of(U) + c] = r;
            y -= r * (self.point.inertia[c] - past.inertia_kg_m2[c] / held.typical_kg_m2);
        }
        let left = self.information.add(row, y);
        self.past_square += left * left;
    }

    /// The step to a better point, once all rows are in.
    pub fn step(&self) -> Option<[T; U]> {
        self.information.solve()
    }

    /// How far that is from the pass's own point, squared, rad²/s²: in units of the noise, by so many
    /// sigmas linearising anew could move it at most.
    pub fn step_square(&self) -> T {
        size_square(&self.information)
    }

    /// Sum of squares by which the data contradict a torque of zero, rad²/s², of three degrees of
    /// freedom.
    pub fn torque_square(&self) -> T {
        self.torque_square
    }

    /// The same for a drag of zero.
    pub fn drag_square(&self) -> T {
        self.drag_square
    }

    /// The same for the past, of six degrees of freedom.
    pub fn past_square(&self) -> T {
        self.past_square
    }

    /// What is known of the inertia without the sphere: data, and the past if it is in.
    pub fn known(&self, held: &Held<T>) -> Past<T> {
        let (noise, typical) = (held.noise_rad_s, held.typical_kg_m2);
        let equations = self.information.equations();
        let first = inertia_of(U);
        Past {
            inertia_kg_m2: self.point.inertia.map(|x| x * typical),
            rows: core::array::from_fn(|i| {
                core::array::from_fn(|c| equations[first + i].0[first + c] / (noise * typical))
            }),
            right: core::array::from_fn(|i| equations[first + i].1 / noise),
        }
    }

    /// The solution, and what it is worth. Where the inertia is vague the sphere steers it, but isn't
    /// counted as knowledge: its elements are then as uncertain as they can be.
    pub fn finish(&self, held: &Held<T>) -> Option<Solution<T, U>> {
        let mut loose = *self;
        loose.take_all_but_the_sphere(held);
        let mut all = loose;
        while !all.take_row(held) {}
        if is_vague(&loose.information, held.noise_rad_s) {
            add_whole_sphere(&mut loose.information, &self.point.inertia, held.noise_rad_s);
        }
        let step = all.information.solve()?;
        let factor = loose.information.covariance_factor()?;
        let block = |at: usize| {
            let rows = Mat::<T, 3, U>::from_fn(|i, c| factor[(at + i, c)]);
            rows * rows.transpose()
        };
        let none = Mat::<T, 3, 3>::zeros();
        Some(Solution {
            step,
            inertia_step_square: size_square(&all.information.last::<6>()),
            point: self.point.plus(&step),
            torque_covariance: if has_torque(U) { block(TORQUE) } else { none },
            bias_covariance: if has_bias(U) { block(BIAS) } else { none },
            inertia_covariance: inertia_covariance(&loose.information)?,
        })
    }
}

/// Covariance of the six elements for unit noise: of a factor's last six rows, which don't depend on
/// the unknowns before them.
pub fn inertia_covariance<T: Real, const U: usize>(
    information: &SquareRootInformation<T, U>,
) -> Option<Mat<T, 6, 6>> {
    let factor = information.last::<6>().covariance_factor()?;
    Some(factor * factor.transpose())
}

/// How far a factor's solution is from its point, squared, rad²/s².
pub fn size_square<T: Real, const U: usize>(information: &SquareRootInformation<T, U>) -> T {
    information.equations().iter().fold(T::zero(), |sum, (_, y)| sum + *y * *y)
}

/// Whether any element's sigma is large, in typical inertias.
fn is_vague<T: Real, const U: usize>(
    information: &SquareRootInformation<T, U>,
    noise_rad_s: T,
) -> bool {
    let most = T::lit(VAGUE) / noise_rad_s;
    let small = |covariance: Mat<T, 6, 6>| (0..6).all(|i| covariance[(i, i)] < most * most);
    !inertia_covariance(information).is_some_and(small)
}

/// Adds that an element is that of a sphere of the typical size.
fn add_sphere<T: Real, const U: usize>(
    information: &mut SquareRootInformation<T, U>,
    point: &[T; 6],
    element: usize,
    weight: T,
) {
    let centre = if element < 3 { T::one() } else { T::zero() };
    let mut row = [T::zero(); U];
    row[inertia_of(U) + element] = weight;
    information.add(row, weight * (centre - point[element]));
}

/// Adds no more than what any body of the typical size keeps to.
fn add_whole_sphere<T: Real, const U: usize>(
    information: &mut SquareRootInformation<T, U>,
    point: &[T; 6],
    noise_rad_s: T,
) {
    for element in 0..6 {
        let sigma = if element < 3 { T::one() } else { T::lit(0.5) };
        add_sphere(information, point, element, noise_rad_s / sigma);
    }
}

/// The past by itself: six elements and their covariance, in typical inertias, with the sphere where
/// it is vague.
pub fn solve_past<T: Real>(past: &Past<T>, typical_kg_m2: T) -> Option<([T; 6], Mat<T, 6, 6>)> {
    let mut information = SquareRootInformation::<T, 6>::default();
    for i in 0..6 {
        information.add(past.rows[i].map(|x| x * typical_kg_m2), past.right[i]);
    }
    let point = past.inertia_kg_m2.map(|x| x / typical_kg_m2);
    let mut loose = information;
    if is_vague(&information, T::one()) {
        add_whole_sphere(&mut loose, &point, T::one());
        for element in 0..6 {
            add_sphere(&mut information, &point, element, T::lit(1.0 / SPHERE_SIGMA));
        }
    }
    let step = information.solve()?;
    let inertia = core::array::from_fn(|i| point[i] + step[i]);
    Some((inertia, inertia_covariance(&loose)?))
}
