//! Least squares through a triangular square-root information factor.
//!
//! Rows `a · x = y` go in one at a time by Givens rotations, so only the factor R (upper triangular,
//! `RᵀR = Σ w a aᵀ`) and `R x = d` are kept. Forming `RᵀR` itself in single precision would square the
//! condition number; R doesn't.
//!
//! R is kept as `√D U`, D diagonal and U of unit diagonal: rotated so, a row takes one division an
//! unknown and no square root (Gentleman, J. Inst. Maths Applics 12, 1973; his Algorithm AS 75), and an
//! element two products.

use super::{Mat, scalar::Real, ud::Ud, unroll};

/// `R x = d` for N unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareRootInformation<T: Real, const N: usize> {
    /// U above the diagonal, D on it, zeros below.
    pub(crate) factor: [[T; N]; N],
    /// `D^(-1/2) d`.
    pub(crate) right_hand_side: [T; N],
}

/// What no solution can explain of a row, and the weight that is left of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left<T: Real> {
    pub(crate) value: T,
    pub(crate) weight: T,
}

impl<T: Real> Left<T> {
    /// Of unit variance: squares of these add up to the sum of squared residuals.
    pub fn residual(&self) -> T {
        self.value * self.weight.sqrt()
    }

    /// Its square.
    pub fn square(&self) -> T {
        self.value * self.value * self.weight
    }

    /// Its product with another row's, without a square root: the harmonic mean of their weights stands
    /// for the geometric one, of which it is never more.
    pub fn product(&self, other: &Self) -> T {
        let sum = self.weight + other.weight;
        if sum > T::zero() {
            let two = T::lit(2.0);
            self.value * other.value * (two * self.weight * (other.weight / sum))
        } else {
            T::zero()
        }
    }

    /// Of no row.
    pub fn nothing() -> Self {
        Self { value: T::zero(), weight: T::zero() }
    }
}

impl<T: Real, const N: usize> Default for SquareRootInformation<T, N> {
    fn default() -> Self {
        Self { factor: [[T::zero(); N]; N], right_hand_side: [T::zero(); N] }
    }
}

impl<T: Real, const N: usize> SquareRootInformation<T, N> {
    /// One equation of its own for each unknown, `xᵢ = valueᵢ`, of variance `1 / weightᵢ`.
    pub fn of_each(values: [T; N], weights: [T; N]) -> Self {
        let mut this = Self { right_hand_side: values, ..Self::default() };
        for i in 0..N {
            this.factor[i][i] = weights[i];
        }
        this
    }

    /// Takes in one equation `row · x = y`, of unit variance. Returns what no solution can
    /// explain of it: the sum of its squares is the sum of the squared residuals.
    pub fn add(&mut self, row: [T; N], y: T) -> T {
        self.add_weighted(&row, y, T::one()).residual()
    }

    /// Takes in one equation of variance `1 / weight`.
    #[inline(never)]
    pub fn add_weighted(&mut self, row: &[T; N], mut y: T, mut weight: T) -> Left<T> {
        let mut rest = *row;
        unroll!(N, I => {
            let x = rest[I];
            let above = &mut self.factor[I];
            let weighted = weight * x;
            let pivot = above[I] + weighted * x;
            if x != T::zero() && pivot != T::zero() {
                let one_over = T::one() / pivot;
                let share = weighted * one_over;
                weight *= above[I] * one_over;
                above[I] = pivot;
                for k in I + 1..N {
                    rest[k] -= x * above[k];
                    above[k] += share * rest[k];
                }
                y -= x * self.right_hand_side[I];
                self.right_hand_side[I] += share * y;
            }
        });
        Left { value: y, weight }
    }

    /// What [`add_weighted`](Self::add_weighted) would leave of a row.
    #[inline(never)]
    pub fn would_leave(&self, row: &[T; N], mut y: T, mut weight: T) -> Left<T> {
        let mut rest = *row;
        unroll!(N, I => {
            let x = rest[I];
            let above = &self.factor[I];
            let pivot = above[I] + weight * x * x;
            if x != T::zero() && pivot != T::zero() {
                weight *= above[I] / pivot;
                for k in I + 1..N {
                    rest[k] -= x * above[k];
                }
                y -= x * self.right_hand_side[I];
            }
        });
        Left { value: y, weight }
    }

    /// About another point, a step from the one that it was about: `R (x − step) = d'`.
    pub fn shift(&mut self, step: &[T; N]) {
        for i in 0..N {
            if self.factor[i][i] == T::zero() {
                continue;
            }
            let mut y = self.right_hand_side[i] - step[i];
            for k in i + 1..N {
                y -= self.factor[i][k] * step[k];
            }
            self.right_hand_side[i] = y;
        }
    }

    /// In other units: every unknown's number, and so every right-hand side, times `scale`; all weights
    /// times `weight`.
    pub fn rescale(&mut self, scale: T, weight: T) {
        for i in 0..N {
            self.right_hand_side[i] *= scale;
            self.factor[i][i] *= weight;
        }
    }

    /// Replaces what is known of unknown `index` and those after it by equations of another factor.
    pub fn take_over(&mut self, other: &Self, index: usize) {
        *self = Self::default();
        for i in index..N {
            self.factor[i] = other.factor[i];
            self.right_hand_side[i] = other.right_hand_side[i];
        }
    }

    /// How many unknowns the equations determine.
    pub fn rank(&self) -> u32 {
        (0..N).filter(|i| self.factor[*i][*i] > T::zero()).count() as u32
    }

    /// Unknown `index` has changed by an amount of zero mean and this variance, and what is known of
    /// it fades.
    ///
    /// With the change c as a further unknown: `R (x − c) = d` and `c = 0` with its weight. Rotated into
    /// the latter from the last equation up, those keep their triangle, and c leaves them.
    pub fn walk(&mut self, index: usize, variance: T) {
        let mut weight = T::one() / variance;
        let (mut of_change, mut y) = ([T::zero(); N], T::zero());
        let index = index.min(N.saturating_sub(1));
        for i in (0..index + 1).rev() {
            let above = &mut self.factor[i];
            let x = if i == index { -T::one() } else { -above[index] };
            let d = above[i];
            let pivot = weight + d * x * x;
            let share = d * x / pivot;
            above[i] = d * (weight / pivot);
            weight = pivot;
            of_change[i] = share;
            for k in i + 1..N {
                above[k] -= x * of_change[k];
                of_change[k] += share * above[k];
            }
            self.right_hand_side[i] -= x * y;
            y += share * self.right_hand_side[i];
        }
    }

    /// Multiplies the weight of each equation so far by `share`.
    pub fn forget(&mut self, share: T) {
        for i in 0..N {
            self.factor[i][i] *= share;
        }
    }

    /// The factor as N equations of unit variance, row by row: `row · x = y`, zeros before the
    /// diagonal.
    pub fn equations(&self) -> [([T; N], T); N] {
        core::array::from_fn(|i| {
            let (row, y, weight) = self.equation(i);
            let size = weight.sqrt();
            (row.map(|u| u * size), y * size)
        })
    }

    /// Equation `index`, one on the diagonal, and its weight. Beyond the last one it is the last.
    pub fn equation(&self, index: usize) -> ([T; N], T, T) {
        let index = index.min(N.saturating_sub(1));
        let mut row = self.factor[index];
        row[index] = T::one();
        (row, self.right_hand_side[index], self.factor[index][index])
    }

    /// The last M unknowns by themselves, the others left free.
    pub fn last<const M: usize>(&self) -> SquareRootInformation<T, M> {
        let first = N.saturating_sub(M);
        SquareRootInformation {
            factor: core::array::from_fn(|i| {
                core::array::from_fn(|k| self.factor[first + i][first + k])
            }),
            right_hand_side: core::array::from_fn(|i| self.right_hand_side[first + i]),
        }
    }

    /// Square of the length of a column of the factor: what is known of that unknown were all others
    /// known.
    pub fn column_square(&self, column: usize) -> T {
        let mut sum = T::zero();
        if let Some(diagonal) = self.factor.get(column).and_then(|row| row.get(column)) {
            sum = *diagonal;
        }
        for i in 0..N {
            if let (true, Some(u)) = (i < column, self.factor[i].get(column)) {
                sum += self.factor[i][i] * *u * *u;
            }
        }
        sum
    }

    /// How far the solution is from zero, squared, in units of what is known of it: `|d|²`.
    pub fn size_square(&self) -> T {
        (0..N).fold(T::zero(), |sum, i| {
            let y = self.right_hand_side[i];
            sum + self.factor[i][i] * y * y
        })
    }

    /// The least-squares solution, or `None` while a diagonal element of the factor is zero.
    #[inline(never)]
    pub fn solve(&self) -> Option<[T; N]> {
        let is_known = (0..N).all(|i| self.factor[i][i] > T::zero());
        let x = self.back_substitute(self.right_hand_side);
        (is_known && x.iter().all(|x| x.is_finite())).then_some(x)
    }

    /// The least-squares solution where the last M unknowns have these values.
    pub fn solve_with_last<const M: usize>(&self, last: &[T; M]) -> Option<[T; N]> {
        let first = N.saturating_sub(M);
        let mut x = self.right_hand_side;
        x[first..].copy_from_slice(last);
        for i in (0..first).rev() {
            for k in i + 1..N {
                let step = self.factor[i][k] * x[k];
                x[i] -= step;
            }
        }
        let is_known = (0..N).all(|i| i >= first || self.factor[i][i] > T::zero());
        (is_known && x.iter().all(|x| x.is_finite())).then_some(x)
    }

    /// `(RᵀR)⁻¹ b`: what a term `b` on the right of the normal equations adds to the solution.
    pub fn solve_normal(&self, b: &[T; N]) -> Option<[T; N]> {
        let mut x = *b;
        for i in 0..N {
            for k in i + 1..N {
                let step = self.factor[i][k] * x[i];
                x[k] -= step;
            }
        }
        for i in 0..N {
            x[i] /= self.factor[i][i];
        }
        let x = self.back_substitute(x);
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// `R⁻¹`, a factor of the covariance of the solution if every row has unit variance:
    /// `(RᵀR)⁻¹ = R⁻¹ R⁻ᵀ`.
    pub fn covariance_factor(&self) -> Option<Mat<T, N, N>> {
        let mut inverse = self.inverse();
        for k in 0..N {
            let sigma = T::one() / self.factor[k][k].sqrt();
            if !sigma.is_finite() {
                return None;
            }
            for i in 0..k + 1 {
                inverse[(i, k)] *= sigma;
            }
        }
        inverse.iter().all(|x| x.is_finite()).then_some(inverse)
    }

    /// Covariance of the solution, if a row of weight 1 has unit variance, by its UD factors, which
    /// are `U⁻¹` and `D⁻¹`; `None` while a diagonal element of the factor is zero.
    pub fn covariance_ud(&self) -> Option<Ud<T, N>> {
        let inverse = self.inverse();
        let mut covariance = Ud::diagonal(core::array::from_fn(|i| T::one() / self.factor[i][i]));
        for k in 1..N {
            for i in 0..k {
                covariance.set_u(i, k, inverse[(i, k)]);
            }
        }
        covariance.is_valid().then_some(covariance)
    }

    /// Covariance of the solution if a row of weight 1 has unit variance.
    pub fn covariance(&self) -> Option<Mat<T, N, N>> {
        let mut covariance = Mat::zeros();
        self.covariance_of_last(&mut covariance).then_some(covariance)
    }

    /// The same of the last M unknowns by themselves, to where it is wanted; false where it isn't finite.
    /// It doesn't depend on the unknowns before them.
    #[inline(never)]
    pub fn covariance_of_last<const M: usize>(&self, covariance: &mut Mat<T, M, M>) -> bool {
        let first = N.saturating_sub(M);
        let inverse = self.inverse_of_last::<M>();
        covariance.fill(T::zero());
        for k in 0..M {
            let variance = T::one() / self.factor[first + k][first + k];
            for i in 0..k + 1 {
                let scaled = inverse[(i, k)] * variance;
                for c in i..k + 1 {
                    covariance[(i, c)] += scaled * inverse[(c, k)];
                    covariance[(c, i)] = covariance[(i, c)];
                }
            }
        }
        covariance.iter().all(|x| x.is_finite())
    }

    /// The diagonal of [`covariance`](Self::covariance).
    #[inline(never)]
    pub fn variances(&self) -> Option<[T; N]> {
        let inverse = self.inverse();
        let mut variances = [T::zero(); N];
        for k in 0..N {
            let variance = T::one() / self.factor[k][k];
            for i in 0..k + 1 {
                variances[i] += inverse[(i, k)] * inverse[(i, k)] * variance;
            }
        }
        variances.iter().all(|x| x.is_finite()).then_some(variances)
    }

    /// `U⁻¹`.
    fn inverse(&self) -> Mat<T, N, N> {
        self.inverse_of_last()
    }

    /// `U⁻¹` of the last M unknowns by themselves.
    fn inverse_of_last<const M: usize>(&self) -> Mat<T, M, M> {
        let first = N.saturating_sub(M);
        let mut inverse = Mat::<T, M, M>::identity();
        for column in 1..M {
            for i in (0..column).rev() {
                let above = &self.factor[first + i];
                let mut sum = T::zero();
                for k in i + 1..column + 1 {
                    sum -= above[first + k] * inverse[(k, column)];
                }
                inverse[(i, column)] = sum;
            }
        }
        inverse
    }

    /// `U⁻¹ b`.
    fn back_substitute(&self, b: [T; N]) -> [T; N] {
        let mut x = b;
        for i in (0..N).rev() {
            for k in i + 1..N {
                let step = self.factor[i][k] * x[k];
                x[i] -= step;
            }
        }
        x
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
            let ud = s.covariance_ud().unwrap().covariance();
            prop_assert!((ud - inverse).abs().max() < 1e-9 * scale);
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
    fn an_equation_for_each_is_as_if_added() {
        let mut added = SquareRootInformation::<f64, 2>::default();
        added.add_weighted(&[1.0, 0.0], 3.0, 2.0);
        added.add_weighted(&[0.0, 1.0], 5.0, 7.0);
        assert_eq!(SquareRootInformation::of_each([3.0, 5.0], [2.0, 7.0]), added);
    }

    #[test]
    fn an_unseen_direction_has_no_solution() {
        let mut s = SquareRootInformation::<f32, 2>::default();
        s.add([1.0, 0.0], 2.0);
        assert_eq!(s.solve(), None);
        assert_eq!(s.covariance_factor(), None);
        assert_eq!(s.covariance_ud(), None);
    }
}
