//! Least squares through a triangular factor, without square roots.
//!
//! Rows `a · x = y` of weight w go in one at a time, by the rotations of Gentleman, so that only R
//! (unit upper triangular), D (diagonal) and d are kept: `Rᵀ D R = Σ w aᵀ a` and `R x = d`. That is the
//! factor of [`square_root_information`](super::square_root_information), `√D R`, at half the products
//! and with a division in place of each square root. Forming `Σ w aᵀ a` itself in single precision
//! would square the condition number; R doesn't.
//!
//! W. M. Gentleman, *Least squares computations by Givens transformations without square roots*,
//! J. Inst. Math. Appl. 12, 329-336, 1973.

use super::{Mat, scalar::Real};

/// The factor for N unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares<T: Real, const N: usize> {
    /// D on the diagonal, R above it, nothing below.
    packed: Mat<T, N, N>,
    right_hand_side: [T; N],
}

crate::persist!([T: Real, const N: usize] LeastSquares<T, N> { packed, right_hand_side });

/// `(Rᵀ D R)⁻¹ = U D⁻¹ Uᵀ`: the covariance of the solution, if every row has a variance of one over its
/// weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverse<T: Real, const N: usize> {
    /// `U = R⁻¹`, unit upper triangular; zeros below.
    pub factor: Mat<T, N, N>,
    /// The diagonal of D⁻¹.
    pub variances: [T; N],
}

impl<T: Real, const N: usize> Default for LeastSquares<T, N> {
    fn default() -> Self {
        Self { packed: Mat::zeros(), right_hand_side: [T::zero(); N] }
    }
}

impl<T: Real, const N: usize> LeastSquares<T, N> {
    /// One equation of its own for each unknown: `xᵢ = valueᵢ`.
    pub fn of_each(values: [T; N], weights: [T; N]) -> Self {
        let mut packed = Mat::zeros();
        for i in 0..N {
            packed[(i, i)] = weights[i];
        }
        Self { packed, right_hand_side: values }
    }

    /// Takes in one equation `row · x = y` of this weight (not negative). Returns the weighted square
    /// of what no solution can explain of it: their sum is that of the squared residuals.
    #[inline(never)] // straight code for each N: once in an image is enough
    pub fn add(&mut self, mut row: [T; N], mut y: T, mut weight: T) -> T {
        for i in 0..N {
            let along = weight * row[i];
            let before = self.packed[(i, i)];
            let after = before + along * row[i];
            // Where nothing is said of this unknown, or so little that its square vanishes, all
            // stays as it is.
            let (x, share, kept) = if along != T::zero() && after > T::zero() {
                let per_after = T::one() / after;
                (row[i], along * per_after, before * per_after)
            } else {
                (T::zero(), T::zero(), T::one())
            };
            self.packed[(i, i)] = after;
            weight *= kept;
            for k in i + 1..N {
                let r = self.packed[(i, k)];
                row[k] -= x * r;
                self.packed[(i, k)] = r + share * row[k];
            }
            let d = self.right_hand_side[i];
            y -= x * d;
            self.right_hand_side[i] = d + share * y;
        }
        weight * y * y
    }

    /// Multiplies the weight of each equation so far by `share`.
    pub fn forget(&mut self, share: T) {
        for i in 0..N {
            self.packed[(i, i)] *= share;
        }
    }

    /// The factor as N equations, row by row, each with its weight: `row · x = y`, zeros before the
    /// diagonal.
    pub fn equation(&self, i: usize) -> ([T; N], T, T) {
        let row = core::array::from_fn(|k| match k {
            _ if k < i => T::zero(),
            _ if k == i => T::one(),
            _ => self.packed[(i, k)],
        });
        (row, self.right_hand_side[i], self.packed[(i, i)])
    }

    /// The least-squares solution. Where nothing is said of an unknown it is what it was at first, zero.
    pub fn solve(&self) -> [T; N] {
        self.back_substitute(self.right_hand_side)
    }

    /// `R⁻¹ b`.
    fn back_substitute(&self, mut x: [T; N]) -> [T; N] {
        for i in (0..N).rev() {
            for k in i + 1..N {
                let step = self.packed[(i, k)] * x[k];
                x[i] -= step;
            }
        }
        x
    }

    /// The inverse of `Rᵀ D R`, or `None` while nothing is said of some unknown.
    pub fn inverse(&self) -> Option<Inverse<T, N>> {
        let mut factor = Mat::<T, N, N>::identity();
        for column in 1..N {
            for i in (0..column).rev() {
                let mut sum = self.packed[(i, column)];
                for k in i + 1..column {
                    sum += self.packed[(i, k)] * factor[(k, column)];
                }
                factor[(i, column)] = -sum;
            }
        }
        let variances = core::array::from_fn(|i| T::one() / self.packed[(i, i)]);
        variances.iter().all(|v| v.is_finite()).then_some(Inverse { factor, variances })
    }
}

impl<T: Real, const N: usize> Inverse<T, N> {
    /// `(Rᵀ D R)⁻¹ b`: what a term `b` on the right of the normal equations adds to the solution.
    pub fn solve_normal(&self, b: &[T; N]) -> [T; N] {
        let mut z = [T::zero(); N];
        for i in 0..N {
            let mut sum = b[i];
            for k in 0..i {
                sum += self.factor[(k, i)] * b[k];
            }
            z[i] = sum * self.variances[i];
        }
        let mut x = z;
        for i in 0..N {
            for k in i + 1..N {
                x[i] += self.factor[(i, k)] * z[k];
            }
        }
        x
    }

    /// The variance of one unknown.
    pub fn variance(&self, i: usize) -> T {
        let mut sum = self.variances[i];
        for k in i + 1..N {
            let u = self.factor[(i, k)];
            sum += u * u * self.variances[k];
        }
        sum
    }

    /// The covariance itself.
    pub fn covariance(&self) -> Mat<T, N, N> {
        let scaled = Mat::from_fn(|i, k| self.factor[(i, k)] * self.variances[k]);
        scaled * self.factor.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Seven equations of different weights, and their normal equations.
    fn example(x: &[f64; 32]) -> (LeastSquares<f64, 3>, Mat<f64, 3, 3>, Mat<f64, 3, 1>, f64) {
        let mut least_squares = LeastSquares::default();
        let (mut n, mut b, mut unexplained) = (Mat::zeros(), Mat::zeros(), 0.0);
        for k in 0..7 {
            let row = [x[4 * k], x[4 * k + 1], x[4 * k + 2]];
            let (a, y, weight) = (Mat::<f64, 3, 1>::from(row), x[4 * k + 3], 1.5 + x[k + 25]);
            unexplained += least_squares.add(row, y, weight);
            n += a * a.transpose() * weight;
            b += a * (y * weight);
        }
        (least_squares, n, b, unexplained)
    }

    proptest! {
        #[test]
        fn agrees_with_the_normal_equations(x in prop::array::uniform32(-1.0..1.0f64)) {
            let (least_squares, n, b, unexplained) = example(&x);
            prop_assume!(n.determinant() > 1e-3);
            let expected = n.try_inverse().unwrap() * b;
            let found = Mat::<f64, 3, 1>::from(least_squares.solve());
            prop_assert!((found - expected).abs().max() < 1e-9);
            let mut squares = 0.0;
            for k in 0..7 {
                let a = Mat::<f64, 3, 1>::new(x[4 * k], x[4 * k + 1], x[4 * k + 2]);
                squares += (x[4 * k + 3] - a.dot(&expected)).powi(2) * (1.5 + x[k + 25]);
            }
            prop_assert!((squares - unexplained).abs() < 1e-9);
        }

        #[test]
        fn the_inverse_is_that_of_the_information(x in prop::array::uniform32(-1.0..1.0f64)) {
            let (least_squares, n, b, _) = example(&x);
            prop_assume!(n.determinant() > 1e-3);
            let (ours, expected) = (least_squares.inverse().unwrap(), n.try_inverse().unwrap());
            prop_assert!((ours.covariance() - expected).abs().max() < 1e-8);
            for i in 0..3 {
                prop_assert!((ours.variance(i) - expected[(i, i)]).abs() < 1e-8);
            }
            let normal = Mat::<f64, 3, 1>::from(ours.solve_normal(&b.into()));
            prop_assert!((normal - expected * b).abs().max() < 1e-8);
        }

        #[test]
        fn its_equations_say_the_same(x in prop::array::uniform32(-1.0..1.0f64)) {
            let (least_squares, n, _, _) = example(&x);
            let mut again = Mat::<f64, 3, 3>::zeros();
            for i in 0..3 {
                let (row, _, weight) = least_squares.equation(i);
                let row = Mat::<f64, 3, 1>::from(row);
                again += row * row.transpose() * weight;
            }
            prop_assert!((again - n).abs().max() < 1e-12);
        }
    }

    #[test]
    fn an_equation_for_each_is_as_if_added() {
        let mut added = LeastSquares::<f64, 2>::default();
        added.add([1.0, 0.0], 3.0, 2.0);
        added.add([0.0, 1.0], 5.0, 7.0);
        assert_eq!(LeastSquares::of_each([3.0, 5.0], [2.0, 7.0]), added);
    }

    #[test]
    fn forgetting_is_less_weight() {
        let mut least_squares = LeastSquares::<f64, 1>::default();
        least_squares.add([1.0], 3.0, 2.0);
        least_squares.forget(0.25);
        least_squares.add([1.0], 9.0, 0.5);
        assert_eq!(least_squares.solve(), [6.0]);
        assert_eq!(least_squares.inverse().unwrap().variances, [1.0]);
    }

    #[test]
    fn what_is_not_said_has_no_inverse() {
        let mut least_squares = LeastSquares::<f32, 2>::default();
        assert!(least_squares.inverse().is_none());
        least_squares.add([1.0, 1.0], 1.0, 1.0);
        least_squares.add([1.0, 1.0], 2.0, 1.0);
        assert!(least_squares.inverse().is_none());
        // Neither does a square that vanishes say anything.
        assert_eq!(least_squares.add([0.0, 1e-30], 1.0, 1.0), 1.0);
        least_squares.add([0.0, 1.0], 1.0, 1.0);
        assert!(least_squares.inverse().is_some());
    }
}
