//! UD factors of a covariance: `P = U D Uᵀ`, U unit upper triangular, D diagonal. \[Bierman1977\]
//!
//! A factorised covariance stays symmetric, and its variances stay positive under rounding, which
//! makes single precision sufficient. No square root is taken.
//!
//! # Operations
//!
//! | operation | effect on P | products | source |
//! |---|---|---|---|
//! | [`Ud::observe`] | `P − K (h P)`, `h = eᵢᵀ` | about `N² + 5 N` | \[Bierman1977\] section V.3 |
//! | [`Ud::observe_along`] | `P − K (h P)`, any h | about `1.5 N²` | the same |
//! | [`Ud::add_product`] | `P + q a aᵀ` | about `2 N²` | \[Agee1972\], \[Bierman1977\] section III.5 |
//! | [`Ud::inflate`] | `P + q eᵢ eᵢᵀ` | about `N²` | \[Agee1972\], \[Bierman1977\] section III.5 |
//! | [`Ud::transform_first`] | `Φ P Φᵀ` | about 150 | \[Bierman1977\] section VI.4, \[Thornton1976\] |
//! | [`Ud::times`] | `P b`, without forming P | `N²` | |
//!
//! # Meaning of the factors
//!
//! `x = U e` with uncorrelated e of variances `dᵢ`. Element `dᵢ` is the variance of component i
//! given the components after it, and `u_ik` the regression of component i on the innovation of
//! component k. The order of the components therefore matters: those that are transformed at every
//! step come first, so that the factors of the others keep their values.
//!
//! # Numerical properties
//!
//! * Symmetry holds by construction: P is not stored.
//! * A variance `pᵢᵢ = dᵢ + Σ u_ik² d_k` is a sum of terms that are not negative. It loses no
//!   digits to cancellation, unlike the difference in `P − K h P`.
//! * The condition number of `U √D` is the square root of that of P: single precision with
//!   factors resembles double precision with P.

use super::{Entries, Mat, Vec3, scalar::Real, unroll};

/// UD factors of the N×N covariance of N components, each in its own unit.
///
/// Both factors share one matrix: D on the diagonal, U above it, zeros below.
///
/// ```
/// use fsw_core::math::ud::Ud;
///
/// // Two components of variance 4 and 1; the first is measured with noise variance 1.
/// let mut p = Ud::diagonal([4.0f32, 1.0]);
/// let gain = p.observe(0, 1.0);
/// assert!((gain[0] - 0.8).abs() < 1e-6); // 4 / (4 + 1)
/// assert!((p.variance(0) - 0.8).abs() < 1e-6); // 4 · 1 / (4 + 1)
/// assert_eq!(p.variance(1), 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ud<T: Real, const N: usize> {
    pub(crate) packed: Mat<T, N, N>,
}

impl<T: Real, const N: usize> Ud<T, N> {
    /// Factors of uncorrelated components with these variances (unit², not negative): U is the
    /// identity.
    pub fn diagonal(variances: [T; N]) -> Self {
        let mut packed = Mat::<T, N, N>::zeros();
        for i in 0..N {
            *packed.at_mut(i, i) = variances[i];
        }
        Self { packed }
    }

    /// Element `u_ik` of U above the diagonal, `row < column`: unit of the row over unit of the
    /// column.
    #[inline(always)] // in its caller the indices have bounds, and no check is left
    pub fn u(&self, row: usize, column: usize) -> T {
        self.packed.at(row, column)
    }

    /// Element `dᵢ` of D, unit²: the variance of component i given the components after it.
    #[inline(always)] // as in `u`
    pub fn d(&self, index: usize) -> T {
        self.packed.at(index, index)
    }

    /// Sets `u_ik`, `row < column`.
    ///
    /// The covariance of two components that are the last ones is `u_ik d_k`.
    #[inline]
    pub fn set_u(&mut self, row: usize, column: usize, value: T) {
        *self.packed.at_mut(row, column) = value;
    }

    /// Sets `dᵢ`, which must not be negative.
    #[inline]
    pub fn set_d(&mut self, index: usize, value: T) {
        *self.packed.at_mut(index, index) = value;
    }

    /// Covariance `P = U D Uᵀ`, N×N: `p_ij = Σ_{k ≥ j} u_ik d_k u_jk` for `i ≤ j`, unit of i times
    /// unit of j.
    ///
    /// ```
    /// use fsw_core::math::ud::Ud;
    ///
    /// let mut p = Ud::diagonal([3.0f64, 2.0]);
    /// p.set_u(0, 1, 0.5);
    /// let p = p.covariance();
    /// assert_eq!(p[(0, 0)], 3.5); // 3 + 0.5² · 2
    /// assert_eq!((p[(0, 1)], p[(1, 0)], p[(1, 1)]), (1.0, 1.0, 2.0));
    /// ```
    pub fn covariance(&self) -> Mat<T, N, N> {
        self.covariance_of_last()
    }

    /// Covariance of the last M components, without those before them.
    pub fn covariance_of_last<const M: usize>(&self) -> Mat<T, M, M> {
        let first = N.saturating_sub(M);
        let mut p = Mat::<T, M, M>::zeros();
        for i in 0..M {
            for j in i..M {
                let mut sum = T::zero();
                for k in j..M {
                    let ui = if k == i { T::one() } else { self.u(first + i, first + k) };
                    let uj = if k == j { T::one() } else { self.u(first + j, first + k) };
                    sum += ui * uj * self.d(first + k);
                }
                *p.at_mut(i, j) = sum;
                *p.at_mut(j, i) = sum;
            }
        }
        p
    }

    /// Variance of one component, `pᵢᵢ = dᵢ + Σ_{k > i} u_ik² d_k`, unit².
    #[inline]
    pub fn variance(&self, component: usize) -> T {
        let mut sum = self.d(component);
        for k in component + 1..N {
            let u = self.u(component, k);
            sum += u * u * self.d(k);
        }
        sum
    }

    /// Product `P b = U (D (Uᵀ b))`, without forming P.
    ///
    /// ```
    /// use fsw_core::math::ud::Ud;
    ///
    /// let mut p = Ud::diagonal([3.0f64, 2.0]);
    /// p.set_u(0, 1, 0.5);
    /// assert_eq!(p.times(&[1.0, 0.0]), [3.5, 1.0]); // first column of P
    /// ```
    pub fn times(&self, b: &[T; N]) -> [T; N] {
        // D Uᵀ b in place from the last element down, then U from the first up: each element is
        // read before it is overwritten.
        let mut x = *b;
        for k in (0..N).rev() {
            for i in 0..k {
                x[k] += self.u(i, k) * x[i];
            }
            x[k] *= self.d(k);
        }
        for k in 1..N {
            for i in 0..k {
                x[i] += self.u(i, k) * x[k];
            }
        }
        x
    }

    /// Multiplies the covariance by `share` (not negative): only D changes.
    pub fn scale(&mut self, share: T) {
        for i in 0..N {
            *self.packed.at_mut(i, i) *= share;
        }
    }

    /// True where all factors are finite and no element of D is negative.
    ///
    /// A filter tests this after each update and resets itself where it fails.
    pub fn is_valid(&self) -> bool {
        // The sum is finite only where all terms are: cheaper than a test of each.
        let mut sum = T::zero();
        for column in 0..N {
            for row in 0..column + 1 {
                sum += self.packed.at(row, column);
            }
        }
        sum.is_finite() && (0..N).all(|i| self.d(i) >= T::zero())
    }

    /// True where every variance D and the magnitude of every factor U is below its bound.
    pub(crate) fn is_below(&self, variance: T, factor: T) -> bool {
        (0..N).all(|column| {
            self.d(column) < variance
                && (0..column).all(|row| self.packed.at(row, column).abs() < factor)
        })
    }

    /// Measurement update with one component, `z = xᵢ + v`, `v` white of variance `r` =
    /// `noise_variance` (unit², positive). Returns the Kalman gain K for the innovation
    /// `ν = z − xᵢ`.
    ///
    /// With `f = Uᵀ h`, `h = eᵢ`, and `α₋₁ = r`, for `j = 0 … N−1`:
    ///
    /// `αⱼ = αⱼ₋₁ + fⱼ² dⱼ`, `dⱼ⁺ = dⱼ αⱼ₋₁ / αⱼ`, `λⱼ = −fⱼ / αⱼ₋₁`,
    ///
    /// `uⱼ⁺ = uⱼ + λⱼ K̄ⱼ`, `K̄ⱼ₊₁ = K̄ⱼ + dⱼ fⱼ uⱼ`, `K = K̄_N / α_{N−1}`.
    ///
    /// `α_{N−1} = hᵀ P h + r` is the innovation variance S. Each `dⱼ` is multiplied by a ratio
    /// between 0 and 1 and stays positive. \[Bierman1977\] section V.3; elements of f before
    /// component i vanish and are left out.
    ///
    /// Three components of a vector measurement with uncorrelated noise are processed one after the
    /// other.
    ///
    /// ```
    /// use fsw_core::math::ud::Ud;
    ///
    /// // The second component is measured; the first one follows by its correlation.
    /// let mut p = Ud::diagonal([1.0f64, 4.0]);
    /// p.set_u(0, 1, 0.5); // covariance 0.5 · 4 = 2
    /// let gain = p.observe(1, 4.0);
    /// assert_eq!(gain, [0.25, 0.5]); // [2, 4] / (4 + 4)
    /// assert_eq!(p.covariance()[(0, 0)], 1.5); // 2 − 2² / 8
    /// ```
    #[inline(never)]
    #[allow(clippy::absurd_extreme_comparisons, clippy::reversed_empty_ranges, reason = "unrolled")]
    pub fn observe(&mut self, component: usize, noise_variance: T) -> [T; N] {
        let mut gain = [T::zero(); N];
        let mut alpha = noise_variance;
        unroll!(N, J => {
            if J >= component {
                let f = if J == component { T::one() } else { self.u(component, J) };
                let v = self.d(J) * f;
                let alpha_before = alpha;
                alpha += f * v;
                let shrink = alpha_before / alpha;
                let lambda = -f / alpha_before;
                self.set_d(J, self.d(J) * shrink);
                gain[J] = v;
                for i in 0..J {
                    let u = self.u(i, J);
                    self.set_u(i, J, u + gain[i] * lambda);
                    gain[i] += u * v;
                }
            }
        });
        let scale = T::one() / alpha;
        gain.map(|k| k * scale)
    }

    /// Measurement update with a combination of the components, `z = hᵀ x + v`, `v` white of variance `r` =
    /// `noise_variance` (not negative). Returns the Kalman gain, and the innovation's variance `hᵀ P h + r`.
    ///
    /// The recursion of [`observe`](Self::observe), for any h. Without noise and variance along h the gain is zero.
    ///
    /// ```
    /// use fsw_core::math::ud::Ud;
    ///
    /// // The sum of two components is measured.
    /// let mut p = Ud::diagonal([3.0f64, 1.0]);
    /// assert_eq!(p.observe_along(&[1.0, 1.0], 4.0), ([0.375, 0.125], 8.0));
    /// assert_eq!(p.covariance()[(0, 1)], -0.375); // −3 · 1 / 8
    /// ```
    #[inline(never)]
    pub fn observe_along(&mut self, h: &[T; N], noise_variance: T) -> ([T; N], T) {
        let mut gain = [T::zero(); N];
        let mut alpha = noise_variance;
        for j in 0..N {
            let mut f = h[j];
            for i in 0..j {
                f += self.u(i, j) * h[i];
            }
            let v = self.d(j) * f;
            let before = alpha;
            alpha += f * v;
            // Zero: neither noise nor variance in the components so far, and nothing to divide by.
            let lambda = if before > T::zero() { -f / before } else { T::zero() };
            let share = if alpha > T::zero() { before / alpha } else { T::one() };
            self.set_d(j, self.d(j) * share);
            gain[j] = v;
            for i in 0..j {
                let u = self.u(i, j);
                self.set_u(i, j, u + gain[i] * lambda);
                gain[i] += u * v;
            }
        }
        let scale = if alpha > T::zero() { T::one() / alpha } else { T::zero() };
        (gain.map(|k| k * scale), alpha)
    }

    /// Process noise on one component: `P + q eᵢ eᵢᵀ`, `q` = `variance` (unit²; zero or less
    /// changes nothing).
    ///
    /// With `a = eᵢ` and `c = q`, for `j = N−1 … 0`:
    ///
    /// `dⱼ⁺ = dⱼ + c aⱼ²`, `a ← a − aⱼ uⱼ`, `uⱼ⁺ = uⱼ + a (c aⱼ / dⱼ⁺)`, `c ← c dⱼ / dⱼ⁺`.
    ///
    /// Rank-one update of \[Agee1972\], \[Bierman1977\] section III.5. Columns after component i
    /// keep their values and are skipped.
    ///
    /// ```
    /// use fsw_core::math::ud::Ud;
    ///
    /// let mut p = Ud::diagonal([1.0f32, 1.0]);
    /// p.inflate(1, 0.25);
    /// assert_eq!((p.variance(0), p.variance(1)), (1.0, 1.25));
    /// ```
    #[inline(never)]
    pub fn inflate(&mut self, component: usize, variance: T) {
        if variance <= T::zero() {
            return;
        }
        let unit = core::array::from_fn(|i| if i == component { T::one() } else { T::zero() });
        self.add_along(unit, variance, component);
    }

    /// Variance along a vector: `P + q a aᵀ`, `q` = `variance` (zero or less changes nothing), the product in
    /// unit². The recursion of [`inflate`](Self::inflate) for any a.
    ///
    /// ```
    /// use fsw_core::math::ud::Ud;
    ///
    /// let mut p = Ud::diagonal([1.0f32, 1.0]);
    /// p.add_product([1.0, 0.5], 4.0);
    /// assert_eq!((p.variance(0), p.variance(1)), (5.0, 2.0));
    /// ```
    #[inline(never)]
    pub fn add_product(&mut self, a: [T; N], variance: T) {
        if variance > T::zero() {
            self.add_along(a, variance, N);
        }
    }

    /// Adds `c a aᵀ`, with a zero after component `last`.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "unrolled, with constants of the caller")]
    fn add_along(&mut self, mut a: [T; N], mut c: T, last: usize) {
        unroll!(N, I => {
            let j = N - 1 - I;
            if j <= last {
                let along = c * a[j];
                let before = self.d(j);
                let after = before + along * a[j];
                // Neither variance nor noise in this direction: its factors keep their values.
                let (inverse_after, kept) = if after > T::zero() {
                    let inverse_after = T::one() / after;
                    (inverse_after, before * inverse_after)
                } else {
                    (T::zero(), T::one())
                };
                self.set_d(j, after);
                let v = along * inverse_after;
                for i in 0..j {
                    let u = self.u(i, j);
                    a[i] -= a[j] * u;
                    self.set_u(i, j, u + a[i] * v);
                }
                c *= kept;
            }
        });
    }
}

impl<T: Real> Ud<T, 9> {
    /// Time update `P ← Φ P Φᵀ`, `Φ = [[A, B], [0, 1]]`: the first three components become
    /// `A x₁ + B x₂`.
    ///
    /// In the same blocks `Φ U = [[A U₁₁, A U₁₂ + B U₂₂], [0, U₂₂]]`. The factors of the other six
    /// keep their values, and only the 3×3 block `A U₁₁` has to be made triangular again.
    ///
    /// `a` is 3×3, `b` 3×6 in the unit of the first block over that of the second.
    #[inline]
    pub fn transform_first(&mut self, a: &Mat<T, 3, 3>, b: &Mat<T, 3, 6>) {
        for column in 3..9 {
            let mut new = Vec3::zeros();
            for i in 0..3 {
                let mut sum = b.at(i, column - 3);
                for k in 3..column {
                    sum += b.at(i, k - 3) * self.u(k, column);
                }
                for k in 0..3 {
                    sum += a.at(i, k) * self.u(k, column);
                }
                new[i] = sum;
            }
            for i in 0..3 {
                self.set_u(i, column, new[i]);
            }
        }
        let (u01, u02, u12) = (self.u(0, 1), self.u(0, 2), self.u(1, 2));
        let row = |i: usize| {
            let (x, y, z) = (a.at(i, 0), a.at(i, 1), a.at(i, 2));
            Vec3::new(x, x * u01 + y, x * u02 + y * u12 + z)
        };
        self.retriangularise([row(0), row(1), row(2)]);
    }

    /// Weighted Gram-Schmidt from the last row up: U₁₁⁺ and D₁⁺ with `U₁₁⁺ D₁⁺ U₁₁⁺ᵀ = W D₁ Wᵀ`.
    ///
    /// `dⱼ⁺ = wⱼ D₁ wⱼᵀ`, `u_ij = wᵢ D₁ wⱼᵀ / dⱼ⁺`, `wᵢ ← wᵢ − u_ij wⱼ`, with `wⱼ` the rows of
    /// `W = A U₁₁`. \[Bierman1977\] section VI.4, \[Thornton1976\]
    #[inline]
    fn retriangularise(&mut self, mut w: [Vec3<T>; 3]) {
        let d = Vec3::new(self.d(0), self.d(1), self.d(2));
        for j in (0..3).rev() {
            let weighted = w[j].component_mul(&d);
            let d_new = w[j].dot(&weighted);
            self.set_d(j, d_new);
            for i in 0..j {
                let u = if d_new > T::zero() { w[i].dot(&weighted) / d_new } else { T::zero() };
                self.set_u(i, j, u);
                let along = w[j] * u;
                w[i] -= along;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Random factors and the covariance that they form.
    fn random<const N: usize>(x: &[f64]) -> (Ud<f64, N>, Mat<f64, N, N>) {
        let u = Mat::<f64, N, N>::from_fn(|i, k| match k {
            _ if k < i => 0.0,
            _ if k == i => 1.0,
            _ => x[(7 * i + 11 * k) % x.len()],
        });
        let mut ud = Ud::diagonal(core::array::from_fn(|i| 1.5 + x[i]));
        let mut d = Mat::<f64, N, N>::zeros();
        for k in 0..N {
            d[(k, k)] = ud.d(k);
            for i in 0..k {
                ud.set_u(i, k, u[(i, k)]);
            }
        }
        (ud, u * d * u.transpose())
    }

    proptest! {
        /// Product of the factors, variances and matrix-vector product against dense algebra.
        #[test]
        fn factors_reassemble_the_covariance(x in prop::array::uniform25(-1.0..1.0f64)) {
            let (ud, p) = random::<5>(&x);
            prop_assert!((ud.covariance() - p).abs().max() < 1e-12);
            prop_assert!((0..5).all(|i| (ud.variance(i) - p[(i, i)]).abs() < 1e-12));
            let b = [x[5], x[6], x[7], x[8], x[9]];
            let expected = p * Mat::<f64, 5, 1>::from(b);
            prop_assert!((Mat::from(ud.times(&b)) - expected).abs().max() < 1e-12);
        }

        /// Gain and covariance against `K = P h / (hᵀ P h + r)`, `P − K hᵀ P`.
        #[test]
        fn an_observation_is_the_kalman_update(
            x in prop::array::uniform25(-1.0..1.0f64), i in 0..5usize, r in 0.01..1.0f64,
        ) {
            let (mut ud, p) = random::<5>(&x);
            let gain = ud.observe(i, r);
            let s = p[(i, i)] + r;
            let k = p.column(i) / s;
            for n in 0..5 {
                prop_assert!((gain[n] - k[n]).abs() < 1e-10);
            }
            let joseph = p - k * p.row(i);
            prop_assert!((ud.covariance() - joseph).abs().max() < 1e-11);
        }

        /// Covariance against `P + q eᵢ eᵢᵀ`.
        #[test]
        fn inflating_adds_variance_to_one_component(
            x in prop::array::uniform25(-1.0..1.0f64), i in 0..5usize, q in 0.0..1.0f64,
        ) {
            let (mut ud, mut p) = random::<5>(&x);
            ud.inflate(i, q);
            p[(i, i)] += q;
            prop_assert!((ud.covariance() - p).abs().max() < 1e-11);
        }

        /// Covariance against `P + q a aᵀ`.
        #[test]
        fn a_product_is_added(
            x in prop::array::uniform25(-1.0..1.0f64), a in prop::array::uniform5(-1.0..1.0f64),
            q in 0.0..1.0f64,
        ) {
            let (mut ud, p) = random::<5>(&x);
            ud.add_product(a, q);
            let a = Mat::<f64, 5, 1>::from(a);
            prop_assert!((ud.covariance() - (p + a * a.transpose() * q)).abs().max() < 1e-11);
        }

        /// Covariance against the dense product `Φ P Φᵀ`, relative to its largest element.
        #[test]
        fn the_transformation_is_the_dense_one(
            x in prop::array::uniform32(-1.0..1.0f64), y in prop::array::uniform27(-1.0..1.0f64),
        ) {
            let a = Mat::<f64, 3, 3>::from_row_slice(&y[..9]);
            let b = Mat::<f64, 3, 6>::from_row_slice(&y[9..]);
            let (mut ud, p) = random::<9>(&x);
            let mut phi = Mat::<f64, 9, 9>::identity();
            phi.fixed_view_mut::<3, 3>(0, 0).copy_from(&a);
            phi.fixed_view_mut::<3, 6>(0, 3).copy_from(&b);
            let dense = phi * p * phi.transpose();
            ud.transform_first(&a, &b);
            prop_assert!((ud.covariance() - dense).abs().max() < 1e-11 * dense.abs().max());
        }
    }

    /// An observation of another component leaves a known one known.
    #[test]
    fn zero_variance_stays_zero() {
        let mut ud = Ud::diagonal([1.0f32, 1.0, 0.0]);
        ud.observe(0, 0.1);
        assert_eq!(ud.variance(2), 0.0);
        assert!(ud.is_valid());
    }
}
