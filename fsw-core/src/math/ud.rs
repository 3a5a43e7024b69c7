//! UD factors of a covariance: `P = U D Uᵀ`, U unit upper triangular, D diagonal.
//!
//! A covariance kept so can't lose symmetry, nor its positive diagonal to rounding, which is
//! why it flies in single precision. No square root is needed. \[Bierman1977\]

use super::{Mat, Vec3, scalar::Real, unroll};

/// The factors in one matrix: D on the diagonal, U above it, nothing below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ud<T: Real, const N: usize> {
    pub(crate) packed: Mat<T, N, N>,
}

impl<T: Real, const N: usize> Ud<T, N> {
    /// Uncorrelated components of these variances (not negative).
    pub fn diagonal(variances: [T; N]) -> Self {
        let mut packed = Mat::zeros();
        for i in 0..N {
            packed[(i, i)] = variances[i];
        }
        Self { packed }
    }

    /// The unit upper triangular factor's element above the diagonal, `row < column`.
    #[inline]
    pub fn u(&self, row: usize, column: usize) -> T {
        self.packed[(row, column)]
    }

    /// The diagonal factor's element.
    #[inline]
    pub fn d(&self, index: usize) -> T {
        self.packed[(index, index)]
    }

    /// Sets an element of U, `row < column`.
    #[inline]
    pub fn set_u(&mut self, row: usize, column: usize, value: T) {
        self.packed[(row, column)] = value;
    }

    /// Sets an element of D.
    #[inline]
    pub fn set_d(&mut self, index: usize, value: T) {
        self.packed[(index, index)] = value;
    }

    /// The covariance, N×N.
    pub fn covariance(&self) -> Mat<T, N, N> {
        let mut p = Mat::zeros();
        for i in 0..N {
            for j in i..N {
                let mut sum = T::zero();
                for k in j..N {
                    let ui = if k == i { T::one() } else { self.u(i, k) };
                    let uj = if k == j { T::one() } else { self.u(j, k) };
                    sum += ui * uj * self.d(k);
                }
                p[(i, j)] = sum;
                p[(j, i)] = sum;
            }
        }
        p
    }

    /// Variance of one component.
    #[inline]
    pub fn variance(&self, component: usize) -> T {
        let mut sum = self.d(component);
        for k in component + 1..N {
            let u = self.u(component, k);
            sum += u * u * self.d(k);
        }
        sum
    }

    /// `P b`.
    pub fn times(&self, b: &[T; N]) -> [T; N] {
        // D Uᵀ b from the last on, each before an element of b that it takes is overwritten; then U.
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

    /// Multiplies the covariance by `share` (not negative).
    pub fn scale(&mut self, share: T) {
        for i in 0..N {
            self.packed[(i, i)] *= share;
        }
    }

    /// Every factor is finite and no variance negative.
    pub fn is_valid(&self) -> bool {
        // One infinity or NaN spoils the sum, which costs less than to ask each of them.
        let mut sum = T::zero();
        for column in 0..N {
            for row in 0..column + 1 {
                sum += self.packed[(row, column)];
            }
        }
        sum.is_finite() && (0..N).all(|i| self.d(i) >= T::zero())
    }

    /// Updates the factors with a scalar measurement of one component, `z = x[component] + v`,
    /// `v` of variance `noise_variance` (positive), and returns the Kalman gain for its
    /// innovation.
    ///
    /// \[Bierman1977\] section V.3, with the zeros of such a measurement left out: elements of
    /// `f = Uᵀ h` before `component` vanish.
    // One copy for every component: the columns are unrolled, and those before it passed over.
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

    /// Adds `variance` (not negative) to one component: a random walk.
    ///
    /// The rank-one update of Agee and Turner, \[Bierman1977\] section III.5.
    #[inline(never)]
    pub fn inflate(&mut self, component: usize, variance: T) {
        if variance <= T::zero() {
            return;
        }
        let mut a: [T; N] =
            core::array::from_fn(|i| if i == component { T::one() } else { T::zero() });
        let mut c = variance;
        // From the last column on, although those after `component` stay as they are.
        unroll!(N, I => {
            let j = N - 1 - I;
            if j <= component {
                let along = c * a[j];
                let before = self.d(j);
                let after = before + along * a[j];
                // Where nothing is uncertain, and nothing is added, all stays as it is.
                let (per_after, kept) = if after > T::zero() {
                    let per_after = T::one() / after;
                    (per_after, before * per_after)
                } else {
                    (T::zero(), T::one())
                };
                self.set_d(j, after);
                let v = along * per_after;
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
    /// `P ← Φ P Φᵀ` with `Φ = [[A, B], [0, 1]]`: the first three components become `A x₁ + B x₂`.
    ///
    /// In the same blocks `Φ U = [[A U₁₁, A U₁₂ + B U₂₂], [0, U₂₂]]`: the factors of the other six
    /// stay as they are, and only the 3×3 block `A U₁₁` has to be made triangular again.
    #[inline]
    pub fn transform_first(&mut self, a: &Mat<T, 3, 3>, b: &Mat<T, 3, 6>) {
        for column in 3..9 {
            let mut new = Vec3::zeros();
            for i in 0..3 {
                let mut sum = b[(i, column - 3)];
                for k in 3..column {
                    sum += b[(i, k - 3)] * self.u(k, column);
                }
                for k in 0..3 {
                    sum += a[(i, k)] * self.u(k, column);
                }
                new[i] = sum;
            }
            for i in 0..3 {
                self.set_u(i, column, new[i]);
            }
        }
        let (u01, u02, u12) = (self.u(0, 1), self.u(0, 2), self.u(1, 2));
        let row = |i: usize| {
            let (x, y, z) = (a[(i, 0)], a[(i, 1)], a[(i, 2)]);
            Vec3::new(x, x * u01 + y, x * u02 + y * u12 + z)
        };
        self.retriangularise([row(0), row(1), row(2)]);
    }

    /// Weighted Gram-Schmidt from the last row up: U₁₁, D₁ such that
    /// `U₁₁ D₁' U₁₁ᵀ = W D₁ Wᵀ`. \[Bierman1977\] section VI.4, \[Thornton1976\]
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

    /// Factors, and their covariance.
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
        #[test]
        fn factors_reassemble_the_covariance(x in prop::array::uniform25(-1.0..1.0f64)) {
            let (ud, p) = random::<5>(&x);
            prop_assert!((ud.covariance() - p).abs().max() < 1e-12);
            prop_assert!((0..5).all(|i| (ud.variance(i) - p[(i, i)]).abs() < 1e-12));
            let b = [x[5], x[6], x[7], x[8], x[9]];
            let expected = p * Mat::<f64, 5, 1>::from(b);
            prop_assert!((Mat::from(ud.times(&b)) - expected).abs().max() < 1e-12);
        }

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

        #[test]
        fn inflating_adds_variance_to_one_component(
            x in prop::array::uniform25(-1.0..1.0f64), i in 0..5usize, q in 0.0..1.0f64,
        ) {
            let (mut ud, mut p) = random::<5>(&x);
            ud.inflate(i, q);
            p[(i, i)] += q;
            prop_assert!((ud.covariance() - p).abs().max() < 1e-11);
        }

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

    #[test]
    fn a_known_direction_stays_known() {
        let mut ud = Ud::diagonal([1.0f32, 1.0, 0.0]);
        ud.observe(0, 0.1);
        assert_eq!(ud.variance(2), 0.0);
        assert!(ud.is_valid());
    }
}
