//! Least squares through a triangular square-root information factor.
//!
//! Rows `a · x = y` of equal weight go in one at a time by Givens rotations, so only the factor
//! R (upper triangular, `RᵀR = Σ a aᵀ`) and `R x = d` are kept. Forming `RᵀR` itself in single
//! precision would square the condition number; R doesn't.

use super::{Mat, scalar::Real};

/// `R x = d` for N unknowns, and the number of rows it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareRootInformation<T: Real, const N: usize> {
    factor: Mat<T, N, N>,
    right_hand_side: [T; N],
}

crate::persist!([T: Real, const N: usize] SquareRootInformation<T, N> {
    factor, right_hand_side
});

impl<T: Real, const N: usize> Default for SquareRootInformation<T, N> {
    fn default() -> Self {
        Self { factor: Mat::zeros(), right_hand_side: [T::zero(); N] }
    }
}

impl<T: Real, const N: usize> SquareRootInformation<T, N> {
    /// Takes in one equation `row · x = y`, of unit variance. Returns what no solution can
    /// explain of it: the sum of its squares is the sum of the squared residuals.
    pub fn add(&mut self, mut row: [T; N], mut y: T) -> T {
        for i in 0..N {
            let b = row[i];
            if b == T::zero() {
                continue;
            }
            let a = self.factor[(i, i)];
            let h = (a * a + b * b).sqrt();
            let (c, s) = (a / h, b / h);
            for k in i..N {
                let (r, x) = (self.factor[(i, k)], row[k]);
                self.factor[(i, k)] = c * r + s * x;
                row[k] = c * x - s * r;
            }
            let d = self.right_hand_side[i];
            self.right_hand_side[i] = c * d + s * y;
            y = c * y - s * d;
        }
        y
    }

    /// Multiplies each equation so far, and so the square root of its weight, by `share`.
    pub fn forget(&mut self, share: T) {
        self.factor *= share;
        for d in &mut self.right_hand_side {
            *d *= share;
        }
    }

    /// The factor as N equations, row by row: `row · x = y`, zeros before the diagonal.
    pub fn equations(&self) -> [([T; N], T); N] {
        core::array::from_fn(|i| {
            (core::array::from_fn(|k| self.factor[(i, k)]), self.right_hand_side[i])
        })
    }

    /// The last M unknowns by themselves, the others left free.
    pub fn last<const M: usize>(&self) -> SquareRootInformation<T, M> {
        let first = N.saturating_sub(M);
        SquareRootInformation {
            factor: Mat::from_fn(|i, k| self.factor[(first + i, first + k)]),
            right_hand_side: core::array::from_fn(|i| self.right_hand_side[first + i]),
        }
    }

    /// Sum of the absolute values in a column of the factor: of the size of what is known of that
    /// unknown were all others known.
    pub fn column_size(&self, column: usize) -> T {
        (0..=column).fold(T::zero(), |sum, i| sum + self.factor[(i, column)].abs())
    }

    /// The least-squares solution, or `None` while a diagonal element of the factor is zero.
    pub fn solve(&self) -> Option<[T; N]> {
        self.back_substitute(&self.right_hand_side)
    }

    /// `(RᵀR)⁻¹ b`: what a term `b` on the right of the normal equations adds to the solution.
    pub fn solve_normal(&self, b: &[T; N]) -> Option<[T; N]> {
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                let step = self.factor[(k, i)] * x[k];
                x[i] -= step;
            }
            x[i] = self.divide_by_pivot(x[i], i)?;
        }
        self.back_substitute(&x)
    }

    /// `R⁻¹`, a factor of the covariance of the solution if every row has unit variance:
    /// `(RᵀR)⁻¹ = R⁻¹ R⁻ᵀ`.
    pub fn covariance_factor(&self) -> Option<Mat<T, N, N>> {
        let mut inverse = Mat::<T, N, N>::zeros();
        for column in 0..N {
            let mut unit = [T::zero(); N];
            unit[column] = T::one();
            let x = self.back_substitute(&unit)?;
            for i in 0..N {
                inverse[(i, column)] = x[i];
            }
        }
        Some(inverse)
    }

    fn back_substitute(&self, b: &[T; N]) -> Option<[T; N]> {
        let mut x = *b;
        for i in (0..N).rev() {
            for k in i + 1..N {
                let step = self.factor[(i, k)] * x[k];
                x[i] -= step;
            }
            x[i] = self.divide_by_pivot(x[i], i)?;
        }
        Some(x)
    }

    fn divide_by_pivot(&self, value: T, i: usize) -> Option<T> {
        let quotient = value / self.factor[(i, i)];
        quotient.is_finite().then_some(quotient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_normal_equations(x in prop::array::uniform28(-1.0..1.0f64)) {
            let mut s = SquareRootInformation::<f64, 3>::default();
            let (mut n, mut b) = (Mat::<f64, 3, 3>::zeros(), Mat::<f64, 3, 1>::zeros());
            let mut unexplained = 0.0;
            for k in 0..7 {
                let row = [x[4 * k], x[4 * k + 1], x[4 * k + 2]];
                let (a, y) = (Mat::<f64, 3, 1>::from(row), x[4 * k + 3]);
                unexplained += s.add(row, y).powi(2);
                n += a * a.transpose();
                b += a * y;
            }
            let inverse = n.try_inverse().unwrap();
            let scale = inverse.abs().max();
            prop_assume!(scale < 1e4);
            let direct = inverse * b;
            let solved = s.solve().unwrap();
            let normal = s.solve_normal(&b.into()).unwrap();
            for i in 0..3 {
                prop_assert!((solved[i] - direct[i]).abs() < 1e-9 * scale);
                prop_assert!((normal[i] - direct[i]).abs() < 1e-9 * scale);
            }
            let residuals: f64 = (0..7).map(|k| {
                let row = [x[4 * k], x[4 * k + 1], x[4 * k + 2]];
                (Mat::<f64, 3, 1>::from(row).dot(&direct) - x[4 * k + 3]).powi(2)
            }).sum();
            prop_assert!((unexplained - residuals).abs() < 1e-9 * scale);
            let factor = s.covariance_factor().unwrap();
            prop_assert!((factor * factor.transpose() - inverse).abs().max() < 1e-9 * scale);
        }
    }

    #[test]
    fn the_last_unknowns_by_themselves_are_as_known_as_among_all() {
        let mut s = SquareRootInformation::<f64, 3>::default();
        for k in 0..6 {
            let x = f64::from(k);
            s.add([x.sin(), (2.0 * x).cos(), (0.7 * x).sin()], (3.0 * x).sin());
        }
        let (all, last) = (s.solve().unwrap(), s.last::<2>().solve().unwrap());
        assert!((all[1] - last[0]).abs() < 1e-12 && (all[2] - last[1]).abs() < 1e-12);
        let variance = |f: &[f64]| f.iter().map(|x| x * x).sum::<f64>();
        let all = s.covariance_factor().unwrap();
        let last = s.last::<2>().covariance_factor().unwrap();
        for i in 0..2 {
            let row = |m: &[f64]| variance(m);
            let (a, b): (std::vec::Vec<f64>, std::vec::Vec<f64>) =
                (all.row(i + 1).iter().copied().collect(), last.row(i).iter().copied().collect());
            assert!((row(&a) - row(&b)).abs() < 1e-12);
        }
    }

    #[test]
    fn an_unseen_direction_has_no_solution() {
        let mut s = SquareRootInformation::<f32, 2>::default();
        s.add([1.0, 0.0], 2.0);
        assert_eq!(s.solve(), None);
        assert_eq!(s.covariance_factor(), None);
    }
}
