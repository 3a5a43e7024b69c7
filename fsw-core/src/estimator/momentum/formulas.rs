//! The four formulas of \[Kim2010\], each a linear function of `B = Σ ω Qᵀ` for given `M = Σ ω ωᵀ`.
//!
//! Input: the sums and a right-hand side B (N m s rad/s). Output: the six elements, kg m², or none
//! where the formula divides by zero.
//!
//! | method | moment `Jᵢᵢ` | first product | second product |
//! |---|---|---|---|
//! | batch | with the row, Eq. (3) | with the row | with the row |
//! | conventional | alone, Eq. (10) | alone | alone |
//! | pre-estimate | alone, Eq. (14) | without the moment | without moment and first product |
//! | suggested | alone, Eq. (14) | without the moment, Eq. (15) | without the moment, Eq. (15) |
//!
//! Row i of the tensor obeys `Jᵢ₁ ω₁ + Jᵢ₂ ω₂ + Jᵢ₃ ω₃ = Qᵢ`, Eqs. (11), (12). The methods differ
//! in the entries of the row that they solve for together. Linearity in B gives their covariance:
//! an error of B moves the elements by the same formula applied to that error
//! ([`covariance`](super::covariance)).

use super::sums::Sums;
use crate::math::{Mat, Vec3, scalar::Real};

/// Formula of \[Kim2010\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// Least squares for all nine entries at once, Eqs. (2) to (4): `x = (HᵀH)⁻¹ Hᵀ z`.
    ///
    /// It separates into three problems, one for each row of the tensor:
    /// `[Jᵢ₁ Jᵢ₂ Jᵢ₃]ᵀ = M⁻¹ [B₁ᵢ B₂ᵢ B₃ᵢ]ᵀ`. The paper does not average the two entries of a
    /// product here; those used are the ones that Table 2 prints, xy, yz and zx.
    Batch,
    /// Each entry by itself, as if the body turned about one axis only, Eqs. (10), (14):
    /// `Jᵢₖ = Bₖᵢ / Mₖₖ`.
    ///
    /// Exact where one axis turns at a time. Otherwise a product takes a share of the moment, far
    /// larger than itself.
    Conventional,
    /// Moments as [`Conventional`](Self::Conventional); products without the moments' part, and the
    /// second product of each row also without the first one's:
    /// `Jᵢₖ = (Bₖᵢ − Jᵢᵢ Mₖᵢ − Jᵢₗ Mₖₗ) / Mₖₖ`.
    ///
    /// The order is that of Eq. (15), as the text after it describes for (15a) and (15b). Over 200
    /// s at 10 Hz two products of Table 2 are reproduced, xz 0.054 for 0.0589 and yz 0.000 for
    /// 0.0062 kg m², and the third is not, xy 0.069 for −0.0019; none of the 720 orders of the six
    /// entries comes close to all three.
    PreEstimate,
    /// Moments as [`Conventional`](Self::Conventional); products without the moments' part,
    /// Eq. (15): `Jᵢₖ = (Bₖᵢ − Jᵢᵢ Mₖᵢ) / Mₖₖ`.
    Suggested,
}

/// Row and column of each of the six elements.
const PLACES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Right-hand side `B = Rᵀ factored + direct`, N m s rad/s. Column r belongs to row r of the
/// tensor.
///
/// The first part avoids the normal equations, which would lose weakly excited axes in single
/// precision.
pub(super) struct RightHandSide<T: Real> {
    /// `R⁻ᵀ B`, N m s, R the factor of `M = RᵀR`.
    pub factored: Mat<T, 3, 3>,
    /// The rest of B, N m s rad/s.
    pub direct: Mat<T, 3, 3>,
}

/// Entries of the tensor, kg m², none where the formula divides by zero.
type Entries<T> = [[Option<T>; 3]; 3];

/// The formulas, for given sums.
pub(super) struct Formulas<T: Real> {
    /// R, rad/s.
    factor: Mat<T, 3, 3>,
    /// `M = RᵀR`, rad²/s².
    squares: Mat<T, 3, 3>,
    /// Axes whose `Mᵢᵢ` is more than noise and rounding.
    is_excited: [bool; 3],
    /// All three pivots of R are more than noise and rounding.
    has_full_rank: bool,
}

impl<T: Real> Formulas<T> {
    /// For gyro noise of `noise_rad_s`, one sigma per sample.
    pub(super) fn new(sums: &Sums<T>, noise_rad_s: T) -> Self {
        let factor = sums.factor();
        let squares = factor.transpose() * factor;
        let exceeds_noise = |square: T| sums.is_excited(square, noise_rad_s);
        Self {
            is_excited: core::array::from_fn(|i| exceeds_noise(squares[(i, i)])),
            has_full_rank: (0..3).all(|i| exceeds_noise(factor[(i, i)] * factor[(i, i)])),
            factor,
            squares,
        }
    }

    /// The six elements, kg m². A product is the mean of its two entries, Eq. (16), or the only one
    /// that the method solves for.
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

    /// `M⁻¹ B`, Eq. (3), by two triangular solves, without the entries xz, yx and zy.
    fn batch(&self, b: &RightHandSide<T>) -> Entries<T> {
        if !self.has_full_rank {
            return [[None; 3]; 3];
        }
        core::array::from_fn(|row| {
            let direct = self.forward(&b.direct.column(row).into());
            let x = self.backward(&(b.factored.column(row) + direct));
            let is_printed = |column: usize| column == row || column == (row + 1) % 3;
            core::array::from_fn(|i| is_printed(i).then_some(x[i]))
        })
    }

    /// `R⁻ᵀ b`, by forward substitution.
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

    /// `R⁻¹ b`, by back substitution.
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

    /// Eqs. (10), (14), (15). The entry in row i, column k is
    ///
    /// `Jᵢₖ = Mₖₖ⁻¹ (Bₖᵢ − Σ Jᵢₗ Mₖₗ)`
    ///
    /// over the entries l of the row that the method has estimated before: none, the moment, or the
    /// moment and the first product.
    fn one_by_one(&self, method: Method, b: &RightHandSide<T>) -> Entries<T> {
        let sums = self.factor.transpose() * b.factored + b.direct;
        core::array::from_fn(|row| {
            let entry = |column: usize, estimated: &[(usize, Option<T>)]| {
                if !self.is_excited[column] {
                    return None;
                }
                let mut rest = sums[(column, row)];
                for (known, value) in estimated {
                    rest -= value.unwrap_or(T::zero()) * self.squares[(column, *known)];
                }
                Some(rest / self.squares[(column, column)])
            };
            // The row's moment, then its products in the order of Eq. (15).
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

    /// Reference: the sums of a stored history by their definition.
    struct Dense {
        m: Mat<f64, 3, 3>,
        b: Mat<f64, 3, 3>,
    }

    impl Dense {
        fn of(history: &[(Vec3<f64>, Vec3<f64>)]) -> Self {
            let mut this = Self { m: Mat::zeros(), b: Mat::zeros() };
            for (m, q) in history {
                this.m += m * m.transpose();
                this.b += m * q.transpose();
            }
            this
        }

        /// `(HᵀH)⁻¹ Hᵀ z` with H of Eq. (4): nine unknowns at once.
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

        /// Eq. (15), without the part of another product of the row.
        fn product(&self, i: usize, k: usize, other: (usize, f64)) -> f64 {
            let known = self.moment(i) * self.m[(k, i)] + other.1 * self.m[(k, other.0)];
            (self.b[(k, i)] - known) / self.m[(k, k)]
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
            let (mut sums, d) = (Sums::default(), Dense::of(&history));
            for (m, q) in &history {
                prop_assert!(sums.add(m, q));
            }
            prop_assume!(d.m.symmetric_eigenvalues().min() > 0.1);

            let formulas = Formulas::new(&sums, 1e-9);
            let b = RightHandSide { factored: sums.right_hand_side(), direct: Mat::zeros() };
            // The same B, without the factor.
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
    fn an_axis_without_motion_has_no_entries() {
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
