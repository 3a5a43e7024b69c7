//! The paper's four formulas, each a linear function of `B = Σ m Qᵀ` for given `M = Σ m mᵀ`.
//!
//! That they are linear is what makes their covariance simple: what any error of B does to the
//! elements is the same formula applied to that error.

use super::sums::Sums;
use crate::math::{Mat, Vec3, scalar::Real};

/// Which formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// Least squares for all nine entries at once, Eqs. (2) to (4), which separates into three
    /// problems, one for each row of the tensor.
    Batch,
    /// Each entry by itself, as if the body turned about one axis only, Eqs. (10), (14).
    Conventional,
    /// The moments so; the products with the moments taken off, and the second product of each
    /// row with the first taken off too, in the order of Eq. (15): the text after it, and the
    /// column of that name in Table 2.
    PreEstimate,
    /// The moments so; the products with the moments taken off, Eq. (15).
    Suggested,
}

/// Where the six elements stand in the tensor.
const PLACES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// `B = Rᵀ factored + direct`, N m s rad/s.
///
/// The first part never goes through the normal equations, which single precision couldn't
/// afford. Column r belongs to row r of the tensor.
pub(super) struct RightHandSide<T: Real> {
    /// In terms of the factor R.
    pub factored: Mat<T, 3, 3>,
    /// As it is.
    pub direct: Mat<T, 3, 3>,
}

/// Each entry of the tensor, or none where the formula divides by nothing.
type Entries<T> = [[Option<T>; 3]; 3];

/// The formulas for given sums.
pub(super) struct Formulas<T: Real> {
    factor: Mat<T, 3, 3>,
    squares: Mat<T, 3, 3>,
    /// Which diagonal elements of M, and which pivots of R, can be divided by.
    has_square: [bool; 3],
    has_pivots: bool,
}

impl<T: Real> Formulas<T> {
    pub(super) fn new(sums: &Sums<T>, noise_rad_s: T) -> Self {
        let factor = sums.factor();
        let squares = factor.transpose() * factor;
        let is_excited = |square: T| sums.is_excited(square, noise_rad_s);
        Self {
            has_square: core::array::from_fn(|i| is_excited(squares[(i, i)])),
            has_pivots: (0..3).all(|i| is_excited(factor[(i, i)] * factor[(i, i)])),
            factor,
            squares,
        }
    }

    /// The six elements; a product is the mean of its two entries, Eq. (16), or the one there is.
    pub(super) fn elements(&self, method: Method, b: &RightHandSide<T>) -> [Option<T>; 6] {
        let entries = match method {
            Method::Batch => self.batch(b),
            _ => self.one_by_one(method, b),
        };
        PLACES.map(|(i, j)| match (entries[i][j], entries[j][i]) {
            (Some(x), Some(y)) => Some((x + y) * T::lit(0.5)),
            (one, other) => one.or(other),
        })
    }

    /// `M⁻¹ B`, Eq. (3).
    fn batch(&self, b: &RightHandSide<T>) -> Entries<T> {
        if !self.has_pivots {
            return [[None; 3]; 3];
        }
        core::array::from_fn(|row| {
            let direct = self.forward(&b.direct.column(row).into());
            let x = self.backward(&(b.factored.column(row) + direct));
            core::array::from_fn(|i| Some(x[i]))
        })
    }

    /// `R⁻ᵀ b`.
    fn forward(&self, b: &Vec3<T>) -> Vec3<T> {
        let mut x = *b;
        for i in 0..3 {
            for k in 0..i {
                let step = self.factor[(k, i)] * x[k];
                x[i] -= step;
            }
            x[i] /= self.factor[(i, i)];
        }
        x
    }

    /// `R⁻¹ b`.
    fn backward(&self, b: &Vec3<T>) -> Vec3<T> {
        let mut x = *b;
        for i in (0..3).rev() {
            for k in i + 1..3 {
                let step = self.factor[(i, k)] * x[k];
                x[i] -= step;
            }
            x[i] /= self.factor[(i, i)];
        }
        x
    }

    /// Eqs. (10), (14), (15): row i, column k is `M_kk⁻¹ (B_ki − Σ known entries of the row × M)`.
    fn one_by_one(&self, method: Method, b: &RightHandSide<T>) -> Entries<T> {
        let sums = self.factor.transpose() * b.factored + b.direct;
        core::array::from_fn(|row| {
            let entry = |column: usize, taken_off: &[(usize, Option<T>)]| {
                if !self.has_square[column] {
                    return None;
                }
                let mut rest = sums[(column, row)];
                for (known, value) in taken_off {
                    rest -= value.unwrap_or(T::zero()) * self.squares[(column, *known)];
                }
                Some(rest / self.squares[(column, column)])
            };
            // The row's own moment, and the two others in the order of Eq. (15).
            let (first, second) = [(1, 2), (0, 2), (0, 1)][row];
            let moment = entry(row, &[]);
            let (one, other) = match method {
                Method::Batch | Method::Conventional => (entry(first, &[]), entry(second, &[])),
                Method::Suggested => {
                    (entry(first, &[(row, moment)]), entry(second, &[(row, moment)]))
                }
                Method::PreEstimate => {
                    let one = entry(first, &[(row, moment)]);
                    (one, entry(second, &[(row, moment), (first, one)]))
                }
            };
            let mut entries = [None; 3];
            (entries[row], entries[first], entries[second]) = (moment, one, other);
            entries
        })
    }
}
