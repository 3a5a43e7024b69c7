//! From a pass to a solution: its data, with what is held of the unknowns beside them.
//!
//! A pass collects what the window's data say and nothing else. To solve it, rows are added to a
//! copy of its factor, in a room of its own, one a slice:
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

use super::past::Past;
use super::unknowns::{BIAS, DRAG, Point, TORQUE, has_bias, has_drag, has_torque, inertia_of};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, scalar::Real};

/// An element whose sigma is above this many typical inertias is vague.
pub const VAGUE: f64 = 0.15;
/// How loosely a vague inertia is held to a sphere, one sigma of each element in typical inertias:
/// ten times this is far from any of them, a third is no tensor that moves wildly.
const SPHERE_SIGMA: f64 = 0.3;
/// Held at zero, an unknown is as good as known: so many times what the data know of it, squared.
const HARD: f64 = 1.0e6;

/// The weight that holds an unknown at zero, of which a column of this square is known.
pub fn hard<T: Real>(column_square: T) -> T {
    if column_square > T::zero() { column_square * T::lit(HARD) } else { T::one() }
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
pub struct Held<'a, T: Real> {
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
    pub past: Option<&'a Past<T>>,
}

/// A solution in the making.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solving<T: Real> {
    row: usize,
    /// Sums of squares that rows left, rad²/s².
    torque_square: T,
    drag_square: T,
    past_square: T,
}

crate::persist!(
    [T: Real] Solving<T> { row, torque_square, drag_square, past_square } if |this| this.row <= END + 1
);

/// Rows of each kind begin here, three or six of each.
const OF_BIAS: usize = 3;
const OF_DRAG: usize = 6;
const PAST: usize = 9;
const SPHERE: usize = 15;
const END: usize = 21;

/// A solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// How far the inertia moves in the step to it, squared, rad²/s²: in units of the noise, so many
    /// sigmas.
    pub inertia_step_square: T,
    /// Where it leads.
    pub point: Point<T>,
    /// For unit noise, variances of the torque and of the bias, and covariance of the inertia. Nothing
    /// but data, the past, and what any body keeps to holds it.
    pub torque_variances: [T; 3],
    /// See `torque_variances`.
    pub bias_variances: [T; 3],
}

impl<T: Real> Solving<T> {
    /// Before any row.
    pub fn new() -> Self {
        let o = T::zero();
        Self { row: 0, torque_square: o, drag_square: o, past_square: o }
    }

    /// Adds one row to a factor about `point`: one slice of work. True once all are in.
    pub fn take_row<const U: usize>(
        &mut self,
        room: &mut SquareRootInformation<T, U>,
        point: &Point<T>,
        held: &Held<'_, T>,
    ) -> bool {
        self.skip::<U>(held.past.is_some());
        match self.row {
            0..OF_BIAS => {
                let axis = self.row;
                let left = hold(room, TORQUE + axis, point.torque[axis], &held.torque, held);
                if held.torque == Hold::AtZero {
                    self.torque_square += left;
                }
            }
            OF_BIAS..OF_DRAG => {
                let axis = self.row - OF_BIAS;
                hold(room, BIAS + axis, point.bias[axis], &held.bias, held);
            }
            OF_DRAG..PAST => {
                let axis = self.row - OF_DRAG;
                let left = hold(room, DRAG + axis, point.drag[axis], &held.drag, held);
                if held.drag == Hold::AtZero {
                    self.drag_square += left;
                }
            }
            PAST..SPHERE => {
                if let Some(past) = held.past {
                    self.past_square += add_past(room, self.row - PAST, point, past, held);
                }
            }
            SPHERE if !is_vague(room, held.noise_rad_s) => self.row = END,
            SPHERE..END => {
                let element = self.row - SPHERE;
                add_sphere(room, &point.inertia, element, held.noise_rad_s / T::lit(SPHERE_SIGMA));
            }
            _ => {}
        }
        self.row += 1;
        self.skip::<U>(held.past.is_some());
        self.row >= END
    }

    /// Passes over rows of what isn't among the unknowns, or isn't known.
    fn skip<const U: usize>(&mut self, has_past: bool) {
        if self.row < OF_BIAS && !has_torque(U) {
            self.row = OF_BIAS;
        }
        if (OF_BIAS..OF_DRAG).contains(&self.row) && !has_bias(U) {
            self.row = OF_DRAG;
        }
        if (OF_DRAG..PAST).contains(&self.row) && !has_drag(U) {
            self.row = PAST;
        }
        if (PAST..SPHERE).contains(&self.row) && !has_past {
            self.row = SPHERE;
        }
    }

    /// Whether the next row is of the sphere, or none is left.
    pub fn has_all_but_the_sphere<const U: usize>(&mut self, has_past: bool) -> bool {
        self.skip::<U>(has_past);
        self.row >= SPHERE
    }

    /// Adds rows until the past is in.
    pub fn take_all_but_the_sphere<const U: usize>(
        &mut self,
        room: &mut SquareRootInformation<T, U>,
        point: &Point<T>,
        held: &Held<'_, T>,
    ) {
        while !self.has_all_but_the_sphere::<U>(held.past.is_some()) {
            self.take_row(room, point, held);
        }
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
}

/// A row of one unknown by itself.
fn only<T: Real, const U: usize>(column: usize) -> [T; U] {
    core::array::from_fn(|i| if i == column { T::one() } else { T::zero() })
}

/// Adds a row that holds one unknown. Returns the square of what it left.
fn hold<T: Real, const U: usize>(
    room: &mut SquareRootInformation<T, U>,
    column: usize,
    value: T,
    hold: &Hold<T>,
    held: &Held<'_, T>,
) -> T {
    let weight = match hold {
        Hold::AtZero => hard(room.column_square(column)),
        Hold::Within(sigma) => {
            let weight = held.noise_rad_s / *sigma;
            weight * weight
        }
    };
    let row = only(column);
    room.add_weighted(&row, -value, weight).square()
}

/// Adds a row of the past. Returns the square of what it left.
fn add_past<T: Real, const U: usize>(
    room: &mut SquareRootInformation<T, U>,
    index: usize,
    point: &Point<T>,
    past: &Past<T>,
    held: &Held<'_, T>,
) -> T {
    let (of_past, right, weight) = past.information.equation(index);
    // From unit variance to that of the gyro, from kg m² to typical inertias.
    let per = T::one() / held.typical_kg_m2;
    let unit = held.noise_rad_s * held.typical_kg_m2;
    let mut row = [T::zero(); U];
    let mut y = right * per;
    for c in index..6 {
        row[inertia_of(U) + c] = of_past[c];
        y -= of_past[c] * (point.inertia[c] - past.inertia_kg_m2[c] * per);
    }
    room.add_weighted(&row, y, weight * (unit * unit)).square()
}

/// What is known of the inertia once rows are in up to the past.
pub fn known<T: Real, const U: usize>(
    room: &SquareRootInformation<T, U>,
    point: &Point<T>,
    held: &Held<'_, T>,
) -> Past<T> {
    let unit = T::one() / (held.noise_rad_s * held.typical_kg_m2);
    let mut information = room.last::<6>();
    information.rescale(held.typical_kg_m2, unit * unit);
    Past { inertia_kg_m2: point.inertia.map(|x| x * held.typical_kg_m2), information }
}

/// The solution once rows are in up to the past, and what it is worth: the covariance of the six elements
/// for unit noise goes where it is wanted. Where the inertia is vague the sphere steers it, but isn't counted
/// as knowledge: its elements are then as uncertain as they can be. Uses up its room.
pub fn finish<T: Real, const U: usize>(
    room: &mut SquareRootInformation<T, U>,
    point: &Point<T>,
    held: &Held<'_, T>,
    covariance: &mut Mat<T, 6, 6>,
) -> Option<Solution<T>> {
    let is_vague = is_vague(room, held.noise_rad_s);
    let (step, inertia_step_square) = steered(room, point, held, is_vague)?;
    if is_vague {
        add_whole_sphere(room, &point.inertia, held.noise_rad_s);
    }
    let (torque_variances, bias_variances) = variances_of_torque_and_bias(room)?;
    let point = point.plus(&step);
    room.covariance_of_last(covariance).then_some(Solution {
        inertia_step_square,
        point,
        torque_variances,
        bias_variances,
    })
}

/// The step, and how far the inertia moves in it, squared.
#[inline(never)]
fn steered<T: Real, const U: usize>(
    room: &SquareRootInformation<T, U>,
    point: &Point<T>,
    held: &Held<'_, T>,
    is_vague: bool,
) -> Option<([T; U], T)> {
    if !is_vague {
        return Some((room.solve()?, room.last::<6>().size_square()));
    }
    let mut all = *room;
    for element in 0..6 {
        let weight = held.noise_rad_s / T::lit(SPHERE_SIGMA);
        add_sphere(&mut all, &point.inertia, element, weight);
    }
    Some((all.solve()?, all.last::<6>().size_square()))
}

#[inline(never)]
fn variances_of_torque_and_bias<T: Real, const U: usize>(
    room: &SquareRootInformation<T, U>,
) -> Option<([T; 3], [T; 3])> {
    let none = [T::zero(); 3];
    if !has_torque(U) {
        return Some((none, none));
    }
    let all = room.variances()?;
    let three = |at: usize| core::array::from_fn(|i| all[at + i]);
    Some((three(TORQUE), if has_bias(U) { three(BIAS) } else { none }))
}

/// Variances of the six elements for unit noise: of a factor's last six rows, which don't depend on
/// the unknowns before them.
#[inline(never)]
pub fn inertia_variances<T: Real, const U: usize>(
    information: &SquareRootInformation<T, U>,
) -> Option<[T; 6]> {
    information.last::<6>().variances()
}

/// Whether any element's sigma is large, in typical inertias.
fn is_vague<T: Real, const U: usize>(
    information: &SquareRootInformation<T, U>,
    noise_rad_s: T,
) -> bool {
    let most = T::lit(VAGUE) / noise_rad_s;
    let are_small = |variances: [T; 6]| variances.iter().all(|v| *v < most * most);
    !inertia_variances(information).is_some_and(are_small)
}

/// Adds that an element is that of a sphere of the typical size.
fn add_sphere<T: Real, const U: usize>(
    information: &mut SquareRootInformation<T, U>,
    point: &[T; 6],
    element: usize,
    weight: T,
) {
    let centre = if element < 3 { T::one() } else { T::zero() };
    let row = only(inertia_of(U) + element);
    let element = point.get(element).copied().unwrap_or(centre);
    information.add_weighted(&row, centre - element, weight * weight);
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
pub fn solve_past<T: Real>(
    past: &Past<T>,
    typical_kg_m2: T,
    covariance: &mut Mat<T, 6, 6>,
) -> Option<[T; 6]> {
    let per = T::one() / typical_kg_m2;
    let mut information = past.information;
    information.rescale(per, typical_kg_m2 * typical_kg_m2);
    let point = past.inertia_kg_m2.map(|x| x * per);
    let step = if is_vague(&information, T::one()) {
        let mut steered = information;
        for element in 0..6 {
            add_sphere(&mut steered, &point, element, T::lit(1.0 / SPHERE_SIGMA));
        }
        add_whole_sphere(&mut information, &point, T::one());
        steered.solve()?
    } else {
        information.solve()?
    };
    let inertia = core::array::from_fn(|i| point[i] + step[i]);
    information.covariance_of_last(covariance).then_some(inertia)
}
