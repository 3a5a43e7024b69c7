//! Information that a window hands on to the one that continues it.
//!
//! A window that ends in mid-motion, since storage is full or rounding or a random walk limits it, ends at a
//! known momentum. Its information on momentum, shape and scale, transformed to the end, begins the
//! next window as rows of its factor. Torque and bias are eliminated: they are found anew.

use super::belief::{Past, WALKED, last_six};
use super::pass::Pass;
use super::unknowns::{FIRST_GROUP, Point, shape_of};
use crate::math::scalar::Real;
use crate::math::square_root_information::SquareRootInformation;

/// Momentum, shape, scale.
const KEPT: usize = 9;

/// Information on momentum, shape and scale at the start of a window.
#[derive(Clone, Copy, Debug)]
pub struct Carried<T: Real> {
    /// Point of reference, and the unit of its scale, 1/(kg m²).
    pub point: Point<T>,
    pub unit_per_kg_m2: T,
    /// `R δ = d` for a step δ from it, in units of a sample's variance.
    information: SquareRootInformation<T, KEPT>,
}

crate::persist!([T: Real] Carried<T> { point, unit_per_kg_m2, information }
    if |this| this.unit_per_kg_m2 > T::zero());

impl<T: Real> Carried<T> {
    /// Information of a pass at the end of its last block. `factor` is that of the pass with the beliefs on
    /// further groups. `None` where rounding prevents the transformation.
    #[inline(never)]
    pub fn from_pass<const U: usize>(
        pass: &Pass<T, U>,
        factor: &SquareRootInformation<T, U>,
    ) -> Option<Self> {
        let mut at_end = SquareRootInformation::<T, U>::default();
        // Constraints on further groups first: their large weights then leave the other rows exact.
        let groups = FIRST_GROUP..shape_of(U);
        for i in groups.chain(0..FIRST_GROUP).chain(shape_of(U)..U) {
            let mut row = factor.factor[i];
            let weight = row[i];
            row[i] = T::one();
            for before in row.iter_mut().take(i) {
                *before = T::zero();
            }
            let row = groups_first(&pass.trajectory.row_at_end(&row)?);
            at_end.add_weighted(&row, factor.right_hand_side[i], weight);
        }
        let mut information = SquareRootInformation::default();
        let first = U - KEPT;
        for i in 0..KEPT {
            for k in i..KEPT {
                information.factor[i][k] = at_end.factor[first + i][first + k];
            }
            information.right_hand_side[i] = at_end.right_hand_side[first + i];
        }
        let is_finite = information.factor.iter().flatten().all(|x| x.is_finite());
        let mut point = pass.point;
        point.momentum = pass.trajectory.momentum();
        is_finite.then_some(Self { point, unit_per_kg_m2: pass.unit_per_kg_m2, information })
    }

    /// The information on shape and scale, joined with that of earlier windows, for a sample's noise, rad/s.
    pub fn to_past(&self, noise_rad_s: T, earlier: Option<&Past<T>>) -> Past<T> {
        let mut six = last_six(&self.information);
        six.rescale(T::one(), T::one() / (noise_rad_s * noise_rad_s));
        Past::joined(six, &self.point, self.unit_per_kg_m2, earlier)
    }

    /// Forgets by a random walk of each element, one sigma, kg m², for a sample's noise, rad/s.
    pub fn walk(&mut self, sigma_kg_m2: T, noise_rad_s: T) {
        let share = sigma_kg_m2 * self.unit_per_kg_m2 * self.point.scale / noise_rad_s;
        let variance = share * share;
        if variance > T::zero() {
            for (k, times) in WALKED.into_iter().enumerate() {
                self.information.walk(FIRST_GROUP + k, variance * T::count(times));
            }
        }
    }

    /// Row `index` about a point, its right-hand side and weight.
    pub fn row<const U: usize>(&self, index: usize, point: &Point<T>, unit: T) -> ([T; U], T, T) {
        let factor = &self.information.factor[index];
        let (mut row, mut y) = ([T::zero(); U], self.information.right_hand_side[index]);
        let ratio = unit / self.unit_per_kg_m2;
        for k in index..KEPT {
            let u = if k == index { T::one() } else { factor[k] };
            let (column, away, by) = match k {
                0..FIRST_GROUP => (k, point.momentum[k] - self.point.momentum[k], T::one()),
                8 => (U - 1, point.scale * ratio - self.point.scale, ratio),
                _ => {
                    let q = k - FIRST_GROUP;
                    (shape_of(U) + q, point.shape[q] - self.point.shape[q], T::one())
                }
            };
            row[column] = u * by;
            y -= u * away;
        }
        (row, y, factor[index])
    }
}

/// A row with its further groups before the momentum.
fn groups_first<T: Real, const U: usize>(row: &[T; U]) -> [T; U] {
    let groups = U - KEPT;
    core::array::from_fn(|i| {
        if i < groups {
            row[FIRST_GROUP + i]
        } else if i < groups + FIRST_GROUP {
            row[i - groups]
        } else {
            row[i]
        }
    })
}
