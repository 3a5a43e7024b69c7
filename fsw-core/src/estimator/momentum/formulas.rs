//! The paper's four formulas, each a linear function of `B = Σ ω Qᵀ` for given `M = Σ ω ωᵀ`.
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
    /// problems, one for each row of the tensor. Of the two entries of a product the paper averages
    /// none here; these are the ones that Table 2 prints, xy, yz and zx.
    Batch,
    /// Each entry by itself, as if the body turned about one axis only, Eqs. (10), (14).
    Conventional,
    /// The moments so; the products with the moments taken off, and the second product of each
    /// row with the first taken off too, in the order of Eq. (15), as the text after it says of
    /// (15a) and (15b). With it, over 200 s at 10 Hz, two products of Table 2 come out, xz 0.054 for 0.0589 and yz 0.000
    /// for 0.0062 kg m², and the third doesn't, xy 0.069 for −0.0019; none of the 720 orders of
    /// the six entries comes close to all three.
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

    /// `M⁻¹ B`, Eq. (3), without the entries xz, yx and zy.
    fn batch(&self, b: &RightHandSide<T>) -> Entries<T> {
        if !self.has_pivots {
            return [[None; 3]; 3];
        }
        core::array::from_fn(|row| {
            let direct = self.forward(&b.direct.column(row).into());
            let x = self.backward(&(b.factored.column(row) + direct));
            let is_printed = |column: usize| column == row || column == (row + 1) % 3;
            core::array::from_fn(|i| is_printed(i).then_some(x[i]))
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The sums of a stored history, in f64 and by nothing but their definition.
    struct Dense {
        m: Mat<f64, 3, 3>,
        b: Mat<f64, 3, 3>,
    }

    impl Dense {
        /// `(HᵀH)⁻¹ Hᵀ z` with H of Eq. (4): nine unknowns, not three times three.
        fn batch(history: &[(Vec3<f64>, Vec3<f64>)]) -> Option<Mat<f64, 9, 1>> {
            let (mut normal, mut right) = (Mat::<f64, 9, 9>::zeros(), Mat::<f64, 9, 1>::zeros());
            for (m, q) in history {
                let mut h = Mat::<f64, 3, 9>::zeros();
                for row in 0..3 {
                    for column in 0..3 {
                        h[(row, 3 * row + column)] = m[column];
                    }
                }
                normal += h.transpose() * h;
                right += h.transpose() * q;
            }
            normal.try_inverse().map(|inverse| inverse * right)
        }

        /// Eq. (14).
        fn moment(&self, i: usize) -> f64 {
            self.b[(i, i)] / self.m[(i, i)]
        }

        /// Eq. (15), with another product of the row taken off too.
        fn product(&self, i: usize, k: usize, other: (usize, f64)) -> f64 {
            let taken_off = self.moment(i) * self.m[(k, i)] + other.1 * self.m[(k, other.0)];
            (self.b[(k, i)] - taken_off) / self.m[(k, k)]
        }
    }

    proptest! {
        #[test]
        fn agrees_with_the_equations_on_a_stored_history(
            rows in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 12),
        ) {
            let history: std::vec::Vec<_> = (rows.iter())
                .map(|r| (Vec3::new(r[0], r[1], r[2]), Vec3::new(r[3], r[4], r[5])))
                .collect();
            let (mut sums, mut d) =
                (Sums::default(), Dense { m: Mat::zeros(), b: Mat::zeros() });
            for (m, q) in &history {
                prop_assert!(sums.add(m, q));
                d.m += m * m.transpose();
                d.b += m * q.transpose();
            }
            prop_assume!(d.m.symmetric_eigenvalues().min() > 0.1);

            let formulas = Formulas::new(&sums, 1e-9);
            let b = RightHandSide { factored: sums.right_hand_side(), direct: Mat::zeros() };
            // The same B, but all of it as it is.
            let direct = RightHandSide { factored: Mat::zeros(), direct: d.b };
            let check = |method, expected: [f64; 6]| {
                for b in [&b, &direct] {
                    let found = formulas.elements(method, b).map(Option::unwrap);
                    for i in 0..6 {
                        assert!((found[i] - expected[i]).abs() < 1e-11, "{method:?}");
                    }
                }
            };
            let mean = |a: f64, b: f64| 0.5 * (a + b);
            let x = Dense::batch(&history).unwrap();
            let (xy, yz, zx) = (x[1], x[5], x[6]);
            check(Method::Batch, [x[0], x[4], x[8], xy, zx, yz]);

            let [xx, yy, zz] = [0, 1, 2].map(|i| d.moment(i));
            let ratio = |i: usize, k: usize| d.b[(k, i)] / d.m[(k, k)];
            let pair = |i, k| mean(ratio(i, k), ratio(k, i));
            check(Method::Conventional, [xx, yy, zz, pair(0, 1), pair(0, 2), pair(1, 2)]);

            let alone = |i: usize, k: usize| d.product(i, k, (0, 0.0));
            let pair = |i, k| mean(alone(i, k), alone(k, i));
            check(Method::Suggested, [xx, yy, zz, pair(0, 1), pair(0, 2), pair(1, 2)]);

            let (xy, yx, zx) = (alone(0, 1), alone(1, 0), alone(2, 0));
            let xz = d.product(0, 2, (1, xy));
            let yz = d.product(1, 2, (0, yx));
            let zy = d.product(2, 1, (0, zx));
            check(Method::PreEstimate, [xx, yy, zz, mean(xy, yx), mean(xz, zx), mean(yz, zy)]);
        }
    }

    #[test]
    fn an_axis_that_never_turned_divides_by_nothing() {
        let mut sums = Sums::<f32>::default();
        for k in 0..20 {
            let x = 0.01 * k as f32;
            sums.add(&Vec3::new(x, 0.0, 0.0), &Vec3::new(1.5 * x, 0.1 * x, -0.2 * x));
        }
        let formulas = Formulas::new(&sums, 1e-6);
        let b = RightHandSide { factored: sums.right_hand_side(), direct: Mat::zeros() };
        assert_eq!(formulas.elements(Method::Batch, &b), [None; 6]);
        let [xx, yy, zz, xy, xz, yz] = formulas.elements(Method::Conventional, &b);
        assert!((xx.unwrap() - 1.5).abs() < 1e-6);
        assert!((xy.unwrap() - 0.1).abs() < 1e-6 && (xz.unwrap() + 0.2).abs() < 1e-6);
        assert_eq!((yy, zz, yz), (None, None, None));
    }
}
