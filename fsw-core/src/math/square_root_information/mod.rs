//! Least squares by a triangular square-root information factor.
//!
//! Input: equations `a · x = y + v` with unknowns x, `v` of variance `1/w`, one at a time. Output:
//! the solution that minimises `Σ w (a · x − y)²`, its covariance, and the recursive residuals.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | N | number of unknowns | – |
//! | `a`, `y` | row and right-hand side of one equation | any, consistent |
//! | `w` | weight of an equation, inverse of its variance | 1/unit of y² |
//! | `R` | factor of the information, upper triangular, `RᵀR = Σ w a aᵀ` | 1/unit of the unknown |
//! | `d` | right-hand side, `R x = d` | – |
//! | `D^(−½) d` | right-hand side as stored | unit of the unknown |
//! | `e` | recursive residual | unit of y |
//!
//! # Method
//!
//! Givens rotations fold each equation into R and d. The normal matrix `RᵀR`, formed in single
//! precision, would square the condition number; R does not. A rotation of the augmented rows
//! `[√d u | √d ȳ]` and `[√w a | √w y]` zeroes the leading element of the second one and keeps the
//! sum of squares, so that after N rotations
//!
//! `Σ w (a · x − y)² = |R x − d|² + Σ w e²`.
//!
//! The last sum does not depend on x: it is the sum of squared residuals at the solution.
//!
//! Stored as `R = √D U`, D diagonal and U unit upper triangular: an equation then takes one
//! division per unknown, no square root, and two products per element (\[Gentleman1973\], Algorithm
//! AS 75).
//!
//! # Range
//!
//! | pivot `dᵢ + w x²` | treatment | `f32`, unit weight |
//! |---|---|---|
//! | inverse not finite | element without information: no rotation | below 5e-20, no other equation |
//! | infinite or NaN | rest of the equation left out | above 1e19 |
//!
//! # Work
//!
//! | operation | products |
//! |---|---|
//! | [`add_weighted`](SquareRootInformation::add_weighted) | about `N² + 6 N` |
//! | [`add_each`](SquareRootInformation::add_each) | the same for each equation |
//! | [`solve`](SquareRootInformation::solve) | `N² / 2` |
//! | [`covariance`](SquareRootInformation::covariance) | about `N³ / 3` |
//!
//! # Relation to a Kalman filter
//!
//! R is the inverse of a square root of the covariance, `P = R⁻¹ R⁻ᵀ`, and `U⁻¹`, `D⁻¹` are the
//! factors of [`Ud`](super::ud::Ud). No information at all is `R = 0`, which a covariance cannot express.

mod solution;

use super::{UNROLLED, scalar::Real, unroll};

/// Equations `R x = d` for N unknowns. The default holds no information.
///
/// ```
/// use fsw_core::math::square_root_information::SquareRootInformation;
///
/// // A line y = x₀ + x₁ t through three points.
/// let mut line = SquareRootInformation::<f64, 2>::default();
/// for (t, y) in [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)] {
///     line.add([1.0, t], y);
/// }
/// let [intercept, slope] = line.solve().unwrap();
/// assert!((intercept - 1.0).abs() < 1e-14 && (slope - 2.0).abs() < 1e-14);
/// // Variance of the slope for unit variance of each y: 1 / Σ (t − 1)².
/// assert!((line.covariance().unwrap()[(1, 1)] - 0.5).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareRootInformation<T: Real, const N: usize> {
    /// U above the diagonal, D on it, zeros below.
    pub(crate) factor: [[T; N]; N],
    /// Right-hand side `D^(−½) d`, in the units of the unknowns.
    pub(crate) right_hand_side: [T; N],
}

/// Recursive residual of one equation: the part of y that no solution explains, with its weight.
///
/// For a model that is right, recursive residuals are white and have unit variance after scaling by
/// the square root of the weight. \[Brown1975\]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecursiveResidual<T: Real> {
    pub(crate) value: T,
    pub(crate) weight: T,
}

impl<T: Real> RecursiveResidual<T> {
    /// Residual of unit variance, `e √w`. Squares of these add up to the sum of squared residuals.
    pub fn residual(&self) -> T {
        self.value * self.weight.sqrt()
    }

    /// Square of the residual, `w e²`.
    pub fn square(&self) -> T {
        self.value * self.value * self.weight
    }

    /// Residual of no equation: zero, of weight zero.
    pub fn nothing() -> Self {
        Self { value: T::zero(), weight: T::zero() }
    }
}

impl<T: Real, const N: usize> Default for SquareRootInformation<T, N> {
    #[inline(never)] // its temporary copy is not on the stack of the caller
    fn default() -> Self {
        Self { factor: [[T::zero(); N]; N], right_hand_side: [T::zero(); N] }
    }
}

impl<T: Real, const N: usize> SquareRootInformation<T, N> {
    /// One equation for each unknown, `xᵢ = valueᵢ`, of variance `1 / weightᵢ`: an uncorrelated
    /// prior.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// // Prior 2 ± 0.5, measurement 3 ± 0.5: mean 2.5, variance 0.125.
    /// let mut fused = SquareRootInformation::of_each([2.0f64], [4.0]);
    /// fused.add_weighted(&[1.0], 3.0, 4.0);
    /// assert_eq!(fused.solve(), Some([2.5]));
    /// assert_eq!(fused.variances(), Some([0.125]));
    /// ```
    pub fn of_each(values: [T; N], weights: [T; N]) -> Self {
        let mut this = Self { right_hand_side: values, ..Self::default() };
        for i in 0..N {
            this.factor[i][i] = weights[i];
        }
        this
    }

    /// Adds one equation `row · x = y` of unit variance. Returns its recursive residual, of unit
    /// variance.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut mean = SquareRootInformation::<f64, 1>::default();
    /// assert_eq!(mean.add([1.0], 4.0), 0.0); // the first equation is satisfied exactly
    /// let residual = mean.add([1.0], 6.0);
    /// assert!((residual * residual - 2.0).abs() < 1e-14); // (4 − 5)² + (6 − 5)²
    /// ```
    pub fn add(&mut self, row: [T; N], y: T) -> T {
        self.add_weighted(&row, y, T::one()).residual()
    }

    /// Adds one equation of variance `1 / weight`. Returns its recursive residual.
    ///
    /// Rotation with row i of U, `x = aᵢ`: `dᵢ⁺ = dᵢ + w x²`, `s = w x / dᵢ⁺`, `w ← w dᵢ / dᵢ⁺`,
    /// `a ← a − x uᵢ`, `uᵢ⁺ = uᵢ + s a`. \[Gentleman1973\]
    #[inline(never)]
    pub fn add_weighted(&mut self, row: &[T; N], mut y: T, mut weight: T) -> RecursiveResidual<T> {
        if N > UNROLLED {
            return self.fold(row, y, weight);
        }
        let mut rest = *row;
        unroll!(N, I => {
            let x = rest[I];
            let above = &mut self.factor[I];
            let weighted = weight * x;
            let pivot = above[I] + weighted * x;
            let is_in_range = pivot < T::MAX;
            if !is_in_range {
                return RecursiveResidual::nothing();
            }
            let one_over = T::one() / pivot;
            if x != T::zero() && one_over < T::MAX {
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
        RecursiveResidual { value: y, weight }
    }

    /// Adds R equations of one variance, `1 / weight`: as [`add_weighted`](Self::add_weighted) one after another, bit for
    /// bit. Calls `visit` with the index and the recursive residual of each.
    ///
    /// The rotations of an equation wait for one division after another. In one sweep over the unknowns those of the other
    /// equations proceed meanwhile. A Cortex-M has no such parallelism, and registers for one equation.
    #[inline(always)]
    pub fn add_each<const R: usize>(
        &mut self,
        rows: &[[T; N]; R],
        y: &[T; R],
        weight: T,
        mut visit: impl FnMut(usize, RecursiveResidual<T>),
    ) {
        if cfg!(target_arch = "arm") || N > UNROLLED {
            for (r, (row, y)) in rows.iter().zip(y).enumerate() {
                visit(r, self.add_weighted(row, *y, weight));
            }
            return;
        }
        for (r, left) in self.sweep(rows, y, weight).into_iter().enumerate() {
            visit(r, left);
        }
    }

    /// Rotations of R equations in one sweep over the unknowns.
    #[inline(never)]
    fn sweep<const R: usize>(
        &mut self,
        rows: &[[T; N]; R],
        y: &[T; R],
        weight: T,
    ) -> [RecursiveResidual<T>; R] {
        let mut rest = *rows;
        let mut left = y.map(|value| RecursiveResidual { value, weight });
        unroll!(N, I => {
            self.rotate_each::<I, R>(&mut rest, &mut left);
        });
        left
    }

    /// Rotations of R equations with row I of U, one after another.
    #[inline(always)]
    fn rotate_each<const I: usize, const R: usize>(
        &mut self,
        rest: &mut [[T; N]; R],
        left: &mut [RecursiveResidual<T>; R],
    ) {
        let (above, of_above) = (&mut self.factor[I], &mut self.right_hand_side[I]);
        let (mut by, mut is_each) = ([None; R], true);
        let mut diagonal = above[I];
        for ((rest, left), by) in rest.iter_mut().zip(left.iter_mut()).zip(&mut by) {
            let x = rest[I];
            let weighted = left.weight * x;
            let pivot = diagonal + weighted * x;
            let is_in_range = pivot < T::MAX;
            let one_over = T::one() / pivot;
            if is_in_range && x != T::zero() && one_over < T::MAX {
                *by = Some((x, weighted * one_over));
                left.weight *= diagonal * one_over;
                diagonal = pivot;
            } else {
                is_each = false;
                if !is_in_range {
                    (*rest, *left) = ([T::zero(); N], RecursiveResidual::nothing());
                }
            }
        }
        above[I] = diagonal;
        if is_each {
            let by = by.map(|by| by.unwrap_or((T::zero(), T::zero())));
            for k in I + 1..N {
                for (rest, (x, share)) in rest.iter_mut().zip(&by) {
                    rest[k] -= *x * above[k];
                    above[k] += *share * rest[k];
                }
            }
            for (left, (x, share)) in left.iter_mut().zip(&by) {
                left.value -= *x * *of_above;
                *of_above += *share * left.value;
            }
            return;
        }
        for ((rest, left), by) in rest.iter_mut().zip(left).zip(by) {
            let Some((x, share)) = by else { continue };
            for k in I + 1..N {
                rest[k] -= x * above[k];
                above[k] += share * rest[k];
            }
            left.value -= x * *of_above;
            *of_above += share * left.value;
        }
    }

    /// As [`add_weighted`](Self::add_weighted), bit for bit, in a loop that all N share: a tenth of the
    /// code, for equations that are few.
    pub fn fold(&mut self, row: &[T; N], y: T, weight: T) -> RecursiveResidual<T> {
        let mut rest = *row;
        fold(self.factor.as_flattened_mut(), &mut self.right_hand_side, &mut rest, y, weight)
    }

    /// Recursive residual that [`add_weighted`](Self::add_weighted) would return; the factor is
    /// unchanged.
    ///
    /// A test of an equation before it is used: its [`square`](RecursiveResidual::square) is
    /// chi-square of one degree of freedom.
    #[inline(never)]
    pub fn would_leave(&self, row: &[T; N], mut y: T, mut weight: T) -> RecursiveResidual<T> {
        let mut rest = *row;
        for i in 0..N {
            let (x, above) = (rest[i], &self.factor[i]);
            let pivot = above[i] + weight * x * x;
            let is_in_range = pivot < T::MAX;
            if !is_in_range {
                return RecursiveResidual::nothing();
            }
            let one_over = T::one() / pivot;
            if x != T::zero() && one_over < T::MAX {
                weight *= above[i] * one_over;
                for k in i + 1..N {
                    rest[k] -= x * above[k];
                }
                y -= x * self.right_hand_side[i];
            }
        }
        RecursiveResidual { value: y, weight }
    }

    /// Moves the origin of the unknowns by `step`: the equations for `x' = x − step`,
    /// `R x' = d − R step`.
    ///
    /// Unknowns without information keep their right-hand side.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut about = SquareRootInformation::of_each([2.0f64, 5.0], [1.0, 1.0]);
    /// about.shift(&[1.5, 5.0]);
    /// assert_eq!(about.solve(), Some([0.5, 0.0]));
    /// ```
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

    /// Changes units: every unknown and right-hand side times `scale`, every weight times `weight`.
    pub fn rescale(&mut self, scale: T, weight: T) {
        for i in 0..N {
            self.right_hand_side[i] *= scale;
            self.factor[i][i] *= weight;
        }
    }

    /// Replaces the equations by those of another factor from unknown `index` on; the unknowns
    /// before it are left without information.
    pub fn take_over(&mut self, other: &Self, index: usize) {
        *self = Self::default();
        for i in index..N {
            self.factor[i] = other.factor[i];
            self.right_hand_side[i] = other.right_hand_side[i];
        }
    }

    /// Eliminates the unknowns before `index`: those from it on keep their marginal information, and the others are
    /// pinned to zero by an equation of unit weight.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut sum = SquareRootInformation::<f64, 2>::default();
    /// sum.add([1.0, 1.0], 3.0);
    /// sum.add([1.0, -1.0], 1.0);
    /// sum.eliminate(1);
    /// assert_eq!(sum.solve(), Some([0.0, 1.0]));
    /// assert_eq!(sum.variances(), Some([1.0, 0.5]));
    /// ```
    #[inline(never)]
    pub fn eliminate(&mut self, index: usize) {
        let rows = self.factor.iter_mut().zip(&mut self.right_hand_side).enumerate();
        for (i, (row, y)) in rows.take(index) {
            *row = unit_row(i);
            *y = T::zero();
        }
    }

    /// Number of unknowns that the equations determine: positive elements of D.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut sum = SquareRootInformation::<f32, 2>::default();
    /// sum.add([1.0, 1.0], 3.0);
    /// assert_eq!((sum.rank(), sum.solve()), (1, None));
    /// sum.add([1.0, -1.0], 1.0);
    /// assert_eq!((sum.rank(), sum.solve()), (2, Some([2.0, 1.0])));
    /// ```
    pub fn rank(&self) -> u32 {
        (0..N).filter(|i| self.factor[*i][*i] > T::zero()).count() as u32
    }

    /// Process noise: unknown `index` changes by c, of zero mean and of this variance (unit²,
    /// positive).
    ///
    /// With c as a further unknown, `R (x − c) = d` and `c = 0` of weight `1 / variance`. Rotations
    /// from the last affected equation up eliminate c; the equations keep their triangle.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut known = SquareRootInformation::of_each([2.0f64], [1.0]); // variance 1
    /// known.walk(0, 1.0);
    /// assert_eq!(known.solve(), Some([2.0]));
    /// assert_eq!(known.variances(), Some([2.0]));
    /// ```
    pub fn walk(&mut self, index: usize, variance: T) {
        let mut along = [T::zero(); N];
        let index = index.min(N.saturating_sub(1));
        along[index] = T::one();
        self.walk_along(&along, index, variance);
    }

    /// The same of several unknowns at once, which change by c times a direction: `along`, zero beyond unknown `last`.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut known = SquareRootInformation::of_each([2.0f64, 3.0], [1.0, 1.0]);
    /// known.walk_along(&[0.5, 1.0], 1, 4.0);
    /// let covariance = known.covariance().unwrap();
    /// assert_eq!((covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]), (2.0, 2.0, 5.0));
    /// ```
    ///
    /// A variance outside the range of numbers, or with an inverse outside it, changes nothing.
    #[inline(never)]
    pub fn walk_along(&mut self, along: &[T; N], last: usize, variance: T) {
        let mut weight = T::one() / variance;
        if !(variance < T::MAX && weight < T::MAX) {
            return;
        }
        let (mut of_change, mut y) = ([T::zero(); N], T::zero());
        let last = last.min(N.saturating_sub(1));
        for i in (0..last + 1).rev() {
            let above = &mut self.factor[i];
            let mut x = -along[i];
            for k in i + 1..last + 1 {
                x -= above[k] * along[k];
            }
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

    /// Fading memory: multiplies the weight of each equation by `share` (0 to 1). The solution is
    /// unchanged, its covariance grows by `1 / share`.
    pub fn forget(&mut self, share: T) {
        for i in 0..N {
            self.factor[i][i] *= share;
        }
    }

    /// Factor as N equations of unit variance, `row · x = y`: the rows of R, zeros before the
    /// diagonal.
    ///
    /// The equations replace all those that were added, for instance as a prior of another problem.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut known = SquareRootInformation::of_each([2.0f64], [4.0]);
    /// assert_eq!(known.equations(), [([2.0], 4.0)]); // 2 x = 4 ± 1 is x = 2 ± 0.5
    /// ```
    pub fn equations(&self) -> [([T; N], T); N] {
        core::array::from_fn(|i| {
            let (row, y, weight) = self.equation(i);
            let size = weight.sqrt();
            (row.map(|u| u * size), y * size)
        })
    }

    /// Row `index` of U with its right-hand side and its weight: `(u, D^(−½) d, dᵢ)`.
    ///
    /// An index beyond the last row returns the last row.
    pub fn equation(&self, index: usize) -> ([T; N], T, T) {
        let index = index.min(N.saturating_sub(1));
        let mut row = self.factor[index];
        row[index] = T::one();
        (row, self.right_hand_side[index], self.factor[index][index])
    }

    /// Marginal equations of the last M unknowns, the others free.
    ///
    /// In a triangular factor these are the last M rows: the unknowns of interest are placed last.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut line = SquareRootInformation::<f64, 2>::default();
    /// for (t, y) in [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)] {
    ///     line.add([1.0, t], y);
    /// }
    /// let slope = line.last::<1>();
    /// assert!((slope.solve().unwrap()[0] - 2.0).abs() < 1e-14);
    /// ```
    pub fn last<const M: usize>(&self) -> SquareRootInformation<T, M> {
        let first = N.saturating_sub(M);
        SquareRootInformation {
            factor: core::array::from_fn(|i| {
                core::array::from_fn(|k| self.factor[first + i][first + k])
            }),
            right_hand_side: core::array::from_fn(|i| self.right_hand_side[first + i]),
        }
    }

    /// Information on one unknown with all others known: squared length of a column of R,
    /// `Σ_{i ≤ c} dᵢ u_ic²`, 1/unit². Zero for a column beyond the last.
    ///
    /// It is the diagonal element of `RᵀR`. The information with the others unknown is smaller, the
    /// inverse of an element of [`variances`](Self::variances).
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut sum = SquareRootInformation::<f64, 2>::default();
    /// sum.add([1.0, 1.0], 0.0);
    /// sum.add([1.0, -1.0], 0.0);
    /// assert_eq!([sum.column_square(0), sum.column_square(1)], [2.0, 2.0]);
    /// ```
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

    /// Squared length `|d|² = Σ dᵢ yᵢ²`: squared distance of the solution from zero, in sigmas.
    pub fn size_square(&self) -> T {
        (0..N).fold(T::zero(), |sum, i| {
            let y = self.right_hand_side[i];
            sum + self.factor[i][i] * y * y
        })
    }
}

/// Folds an equation, `rest · x = y`, into the rows of a factor and its right-hand side.
#[inline(never)]
fn fold<T: Real>(
    mut factor: &mut [T],
    right_hand_side: &mut [T],
    mut rest: &mut [T],
    mut y: T,
    mut weight: T,
) -> RecursiveResidual<T> {
    let columns = right_hand_side.len();
    for of_row in right_hand_side {
        let Some((row, below)) = core::mem::take(&mut factor).split_at_mut_checked(columns) else {
            break;
        };
        factor = below;
        let right = columns.saturating_sub(rest.len());
        let Some((x, others)) = core::mem::take(&mut rest).split_first_mut() else { break };
        rest = others;
        let Some((diagonal, above)) = row.get_mut(right..).and_then(<[T]>::split_first_mut) else {
            break;
        };
        let (x, weighted) = (*x, weight * *x);
        let pivot = *diagonal + weighted * x;
        let is_in_range = pivot < T::MAX;
        if !is_in_range {
            return RecursiveResidual::nothing();
        }
        let one_over = T::one() / pivot;
        if x != T::zero() && one_over < T::MAX {
            let share = weighted * one_over;
            weight *= *diagonal * one_over;
            *diagonal = pivot;
            for (rest, above) in rest.iter_mut().zip(above) {
                *rest -= x * *above;
                *above += share * *rest;
            }
            y -= x * *of_row;
            *of_row += share * y;
        }
    }
    RecursiveResidual { value: y, weight }
}

/// Row of one unknown alone; of none for an index beyond the last one.
pub fn unit_row<T: Real, const N: usize>(index: usize) -> [T; N] {
    core::array::from_fn(|i| if i == index { T::one() } else { T::zero() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat;
    use proptest::prelude::*;

    /// Variances without an inverse within the range of numbers, and without a value there.
    #[test]
    fn a_walk_outside_the_range_of_numbers_changes_nothing() {
        let mut known = SquareRootInformation::of_each([2.0f32, 3.0], [4.0, 1.0]);
        let before = known.equations();
        for variance in [0.0, 1e-40, f32::INFINITY, f32::NAN] {
            known.walk_along(&[0.5, 1.0], 1, variance);
            assert_eq!(known.equations(), before, "{variance}");
        }
    }

    proptest! {
        /// Solution, sum of squared residuals and covariance against the normal equations in double
        /// precision. Bound: 1e-9 of the largest element of the covariance, which itself is below
        /// 1e4.
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

    /// The last two of three unknowns, by themselves and among all.
    #[test]
    fn marginal_equations_keep_solution_and_variance() {
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

    /// `of_each` against two added equations, bit for bit.
    #[test]
    fn one_equation_per_unknown_equals_their_sum() {
        let mut added = SquareRootInformation::<f64, 2>::default();
        added.add_weighted(&[1.0, 0.0], 3.0, 2.0);
        added.add_weighted(&[0.0, 1.0], 5.0, 7.0);
        assert_eq!(SquareRootInformation::of_each([3.0, 5.0], [2.0, 7.0]), added);
    }

    /// The inverse of (1e-20)² overflows in single precision.
    #[test]
    fn a_pivot_without_a_finite_inverse_is_no_information() {
        let mut s = SquareRootInformation::<f32, 2>::default();
        for tiny in [1e-20, 3e-20, -1e-38] {
            s.add([tiny, 1.0], 1.0);
        }
        assert_eq!((s.rank(), s.solve_with_last::<1>(&[1.0])), (1, None));
        s.add([1e30, 1.0], 1.0);
        s.add([1.0, 1.0], 3.0);
        let [x, y] = s.solve().unwrap();
        assert!((x - 2.0).abs() < 1e-5 && (y - 1.0).abs() < 1e-5, "{x} {y}");
    }

    proptest! {
        /// Rows of magnitudes from 1e-38 to 1e38, elements within a decade of each other: the factor
        /// stays finite, and ordinary equations are solved afterwards.
        #[test]
        fn any_magnitude_leaves_a_finite_factor(
            rows in prop::collection::vec(
                (-38.0..38.0f32, prop::array::uniform4(-10.0..10.0f32)), 1..20),
        ) {
            let mut s = SquareRootInformation::<f32, 3>::default();
            for (exponent, [a, b, c, y]) in rows {
                let size = 10f32.powf(exponent);
                s.add([a * size, b * size, c * size], y * size);
                prop_assert!(s.factor.iter().flatten().all(|x| x.is_finite()), "{s:?}");
                prop_assert!(s.right_hand_side.iter().all(|x| x.is_finite()), "{s:?}");
            }
            if let Some(x) = s.solve() {
                prop_assert!(x.iter().all(|x| x.is_finite()));
            }
            if let Some(variances) = s.variances() {
                prop_assert!(variances.iter().all(|x| x.is_finite() && *x >= 0.0));
            }
        }

        /// The loop gives the bits of the unrolled rotations.
        #[test]
        fn loop_and_unrolled_rotations_agree(
            rows in prop::collection::vec(prop::array::uniform5(-2.0..2.0f32), 1..20),
        ) {
            let (mut unrolled, mut looped) = (SquareRootInformation::<f32, 3>::default(), SquareRootInformation::default());
            for [a, b, c, y, w] in rows {
                let row = [a, if b < 0.0 { 0.0 } else { b }, c];
                let left = unrolled.add_weighted(&row, y, w.abs());
                prop_assert_eq!(left, looped.fold(&row, y, w.abs()));
                prop_assert_eq!(unrolled, looped);
            }
        }

        /// Three equations in one sweep give the bits of one after another: zeros, and pivots out of range, among them.
        #[test]
        fn equations_of_a_sweep_are_added_in_turn(
            rows in prop::collection::vec(prop::array::uniform16(-2.0..2.0f32), 1..20),
        ) {
            let (mut swept, mut in_turn) = (SquareRootInformation::<f32, 4>::default(), SquareRootInformation::default());
            for of_rows in rows {
                let size = |k: usize| match (of_rows[15], k) {
                    (s, 1) if s > 1.9 => 1e30,
                    (s, 2) if s < -1.9 => 1e-30,
                    _ => 1.0,
                };
                let element = |k: usize| if of_rows[k] < -1.0 { 0.0 } else { of_rows[k] * size(k / 4) };
                let rows: [[f32; 4]; 3] = core::array::from_fn(|r| core::array::from_fn(|c| element(4 * r + c)));
                let (y, weight) = ([of_rows[12], of_rows[13], of_rows[14]], of_rows[15].abs());
                let mut left = [RecursiveResidual::nothing(); 3];
                swept.add_each(&rows, &y, weight, |r, of_row| left[r] = of_row);
                for (left, (row, y)) in left.into_iter().zip(rows.iter().zip(y)) {
                    prop_assert_eq!(left, in_turn.add_weighted(row, y, weight));
                }
                prop_assert_eq!(swept, in_turn);
            }
        }

        /// Every element of another magnitude: a solution is finite, or none.
        #[test]
        fn a_solution_is_finite_or_none(
            rows in prop::collection::vec(prop::array::uniform4(-38.0..38.0f32), 1..20),
        ) {
            let mut s = SquareRootInformation::<f32, 3>::default();
            for row in rows {
                let [a, b, c, y] = row.map(|exponent| 10f32.powf(exponent));
                s.add([a, b, c], y);
                let is_finite = |x: [f32; 3]| x.iter().all(|x| x.is_finite());
                prop_assert!(s.solve().is_none_or(is_finite));
                prop_assert!(s.variances().is_none_or(is_finite));
            }
        }
    }

    /// One equation for two unknowns.
    #[test]
    fn an_unobserved_direction_has_no_solution() {
        let mut s = SquareRootInformation::<f32, 2>::default();
        s.add([1.0, 0.0], 2.0);
        assert_eq!(s.solve(), None);
        assert_eq!(s.covariance_factor(), None);
        assert_eq!(s.covariance_ud(), None);
    }
}
