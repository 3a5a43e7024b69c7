//! Solution of `R x = d`, and its covariance.
//!
//! `x = U⁻¹ D^(−½) d`, `P = U⁻¹ D⁻¹ U⁻ᵀ`, by back substitution. A result that is not finite is reported as
//! `None`; it follows from an unknown without information, `dᵢ = 0`.
//!
//! Covariances assume that an equation of weight 1 has unit variance. Otherwise they are to be
//! multiplied by the variance of such an equation, for instance by the mean squared residual.

use super::SquareRootInformation;
use crate::math::{Entries, Mat, identity, scalar::Real, ud::Ud};

impl<T: Real, const N: usize> SquareRootInformation<T, N> {
    /// Least-squares solution `x = U⁻¹ D^(−½) d`.
    ///
    /// `None` while an element of D is zero, and where the solution is not finite.
    #[inline(never)]
    pub fn solve(&self) -> Option<[T; N]> {
        let is_known = (0..N).all(|i| self.factor[i][i] > T::zero());
        let x = self.back_substitute(self.right_hand_side);
        (is_known && x.iter().all(|x| x.is_finite())).then_some(x)
    }

    /// Least-squares solution for given values of the last M unknowns.
    ///
    /// `None` while one of the other elements of D is zero, and where the solution is not finite.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let mut sum = SquareRootInformation::<f64, 2>::default();
    /// sum.add([1.0, 1.0], 3.0);
    /// assert_eq!(sum.solve_with_last(&[0.5]), Some([2.5, 0.5]));
    /// ```
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

    /// Solution of the normal equations, `(RᵀR)⁻¹ b`: the change of the solution due to a term b on
    /// their right-hand side. `None` where it is not finite.
    ///
    /// Applications: corrections for noise in the regressors, sensitivities to a parameter.
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

    /// Factor `R⁻¹` of the solution's covariance for unit variance of each equation, `P = R⁻¹ R⁻ᵀ`.
    /// `None` while an element of D is zero.
    pub fn covariance_factor(&self) -> Option<Mat<T, N, N>> {
        let mut root = Mat::zeros();
        self.covariance_factor_of_last(&mut root).then_some(root)
    }

    /// The factor for the last M unknowns, upper triangular, written to `root`. False where it is not finite.
    ///
    /// A covariance of functions of the unknowns, `(J R⁻¹)(J R⁻¹)ᵀ`, has no negative eigenvalue beyond rounding,
    /// where `J P Jᵀ` may have one if the functions cancel what is uncertain.
    #[inline(never)]
    pub fn covariance_factor_of_last<const M: usize>(&self, root: &mut Mat<T, M, M>) -> bool {
        let first = N.saturating_sub(M);
        *root = self.inverse_of_last();
        for k in 0..M {
            let sigma = T::one() / self.factor[first + k][first + k].sqrt();
            if !sigma.is_finite() {
                return false;
            }
            for i in 0..k + 1 {
                *root.at_mut(i, k) *= sigma;
            }
        }
        root.iter().all(|x| x.is_finite())
    }

    /// UD factors `U⁻¹`, `D⁻¹` of the solution's covariance, if an equation of weight 1 has unit
    /// variance. `None` while an element of D is zero.
    ///
    /// A batch solution initialises a Kalman filter this way, without forming a covariance.
    ///
    /// ```
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let known = SquareRootInformation::of_each([2.0f64, 3.0], [4.0, 0.5]);
    /// let covariance = known.covariance_ud().unwrap();
    /// assert_eq!([covariance.variance(0), covariance.variance(1)], [0.25, 2.0]);
    /// ```
    pub fn covariance_ud(&self) -> Option<Ud<T, N>> {
        let inverse = self.inverse();
        let mut covariance = Ud::diagonal(core::array::from_fn(|i| T::one() / self.factor[i][i]));
        for k in 1..N {
            for i in 0..k {
                covariance.set_u(i, k, inverse.at(i, k));
            }
        }
        covariance.is_valid().then_some(covariance)
    }

    /// Covariance of the solution, `P = U⁻¹ D⁻¹ U⁻ᵀ`, if an equation of weight 1 has unit variance.
    pub fn covariance(&self) -> Option<Mat<T, N, N>> {
        let mut covariance = Mat::zeros();
        self.covariance_of_last(&mut covariance).then_some(covariance)
    }

    /// Covariance of the last M unknowns, written to `covariance`. False where it is not finite.
    ///
    /// `U⁻¹` is upper triangular, and its lower right block is the inverse of the same block of U:
    /// the unknowns before the last M have no influence.
    ///
    /// ```
    /// use fsw_core::math::Mat;
    /// use fsw_core::math::square_root_information::SquareRootInformation;
    ///
    /// let known = SquareRootInformation::of_each([1.0f64, 2.0, 3.0], [1.0, 4.0, 2.0]);
    /// let mut covariance = Mat::<f64, 2, 2>::zeros();
    /// assert!(known.covariance_of_last(&mut covariance));
    /// assert_eq!(covariance, Mat::<f64, 2, 2>::new(0.25, 0.0, 0.0, 0.5));
    /// ```
    #[inline(never)]
    pub fn covariance_of_last<const M: usize>(&self, covariance: &mut Mat<T, M, M>) -> bool {
        let first = N.saturating_sub(M);
        let inverse = self.inverse_of_last::<M>();
        covariance.fill(T::zero());
        for k in 0..M {
            let variance = T::one() / self.factor[first + k][first + k];
            for i in 0..k + 1 {
                let scaled = inverse.at(i, k) * variance;
                for c in i..k + 1 {
                    *covariance.at_mut(i, c) += scaled * inverse.at(c, k);
                    *covariance.at_mut(c, i) = covariance.at(i, c);
                }
            }
        }
        covariance.iter().all(|x| x.is_finite())
    }

    /// Diagonal of [`covariance`](Self::covariance), unit². `None` where it is not finite, in
    /// particular while an element of D is zero.
    #[inline(never)]
    pub fn variances(&self) -> Option<[T; N]> {
        // One column of the inverse at a time: no N×N matrix on the stack.
        let (mut variances, mut column) = ([T::zero(); N], [T::zero(); N]);
        for k in 0..N {
            let variance = T::one() / self.factor[k][k];
            column[k] = T::one();
            for i in (0..k).rev() {
                let mut sum = T::zero();
                for l in i + 1..k + 1 {
                    sum -= self.factor[i][l] * column[l];
                }
                column[i] = sum;
            }
            for i in 0..k + 1 {
                variances[i] += column[i] * column[i] * variance;
            }
        }
        variances.iter().all(|x| x.is_finite()).then_some(variances)
    }

    /// Inverse `U⁻¹`.
    fn inverse(&self) -> Mat<T, N, N> {
        self.inverse_of_last()
    }

    /// Inverse of the lower right M×M block of U.
    #[inline(never)] // one copy for covariance and factor
    fn inverse_of_last<const M: usize>(&self) -> Mat<T, M, M> {
        let first = N.saturating_sub(M);
        let mut inverse = identity::<T, M>();
        for column in 1..M {
            for i in (0..column).rev() {
                let above = &self.factor[first + i];
                let mut sum = T::zero();
                for k in i + 1..column + 1 {
                    sum -= above[first + k] * inverse.at(k, column);
                }
                *inverse.at_mut(i, column) = sum;
            }
        }
        inverse
    }

    /// Back substitution, `U⁻¹ b`.
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
