//! UD factors of a covariance: `P = U D Uᵀ`, U unit upper triangular, D diagonal.
//!
//! A covariance kept so can't lose symmetry, nor its positive diagonal to rounding, which is
//! why it flies in single precision. No square root is needed. \[Bierman1977\]

use super::{Mat, scalar::Real};

/// The factors in one matrix: D on the diagonal, U above it, nothing below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ud<T: Real, const N: usize> {
    packed: Mat<T, N, N>,
}

/// No factor is as large; the variances of those that aren't are still numbers in single precision.
const LARGEST_KEPT: f64 = 1.0e12;

crate::persist!(
    [T: Real, const N: usize] Ud<T, N> { packed }
    if |ud| ud.is_valid() && ud.packed.iter().all(|x| x.abs() < T::lit(LARGEST_KEPT))
);

impl<T: Real, const N: usize> Ud<T, N> {
    /// Factors of the covariance `S Sᵀ`, by modified Gram-Schmidt from the last row up.
    ///
    /// The covariance itself is never formed: squaring would lose in single precision what is
    /// known of one component given the others. \[Bierman1977\] section VI.4
    pub fn of_factor(s: &Mat<T, N, N>) -> Self {
        let mut rows = *s;
        let mut packed = Mat::zeros();
        for j in (0..N).rev() {
            let mut d = T::zero();
            for k in 0..N {
                d += rows[(j, k)] * rows[(j, k)];
            }
            packed[(j, j)] = d;
            for i in 0..j {
                let mut along = T::zero();
                for k in 0..N {
                    along += rows[(i, k)] * rows[(j, k)];
                }
                let u = if d > T::zero() { along / d } else { T::zero() };
                packed[(i, j)] = u;
                for k in 0..N {
                    let step = u * rows[(j, k)];
                    rows[(i, k)] -= step;
                }
            }
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

    /// Every factor is finite and no variance negative.
    pub fn is_valid(&self) -> bool {
        self.packed.iter().all(|x| x.is_finite()) && (0..N).all(|i| self.d(i) >= T::zero())
    }

    /// Updates the factors with a scalar measurement of one component, `z = x[component] + v`,
    /// `v` of variance `noise_variance` (positive), and returns the Kalman gain for its
    /// innovation.
    ///
    /// \[Bierman1977\] section V.3, with the zeros of such a measurement left out: elements of
    /// `f = Uᵀ h` before `component` vanish.
    #[inline]
    pub fn observe(&mut self, component: usize, noise_variance: T) -> [T; N] {
        let mut gain = [T::zero(); N];
        let mut alpha = noise_variance;
        for j in component..N {
            let f = if j == component { T::one() } else { self.u(component, j) };
            let v = self.d(j) * f;
            let alpha_before = alpha;
            alpha += f * v;
            let shrink = alpha_before / alpha;
            let lambda = -f / alpha_before;
            self.set_d(j, self.d(j) * shrink);
            gain[j] = v;
            for i in 0..j {
                let u = self.u(i, j);
                self.set_u(i, j, u + gain[i] * lambda);
                gain[i] += u * v;
            }
        }
        let scale = T::one() / alpha;
        gain.map(|k| k * scale)
    }

    /// Adds `variance` (not negative) to one component: a random walk.
    ///
    /// The rank-one update of Agee and Turner, \[Bierman1977\] section III.5.
    #[inline]
    pub fn inflate(&mut self, component: usize, variance: T) {
        if variance <= T::zero() {
            return;
        }
        let mut a = [T::zero(); N];
        a[component] = T::one();
        let mut c = variance;
        for j in (0..=component).rev() {
            let aj = a[j];
            let d = self.d(j);
            let d_new = d + c * aj * aj;
            self.set_d(j, d_new);
            if d_new <= T::zero() {
                continue;
            }
            let v = c * aj / d_new;
            for i in 0..j {
                let u = self.u(i, j);
                a[i] -= aj * u;
                self.set_u(i, j, u + a[i] * v);
            }
            c *= d / d_new;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A factor and its covariance, well enough conditioned for the tolerances below.
    fn random(x: &[f64; 25]) -> (Ud<f64, 5>, Mat<f64, 5, 5>) {
        let s = Mat::<f64, 5, 5>::from_row_slice(x) + Mat::identity() * 3.0;
        (Ud::of_factor(&s), s * s.transpose())
    }

    proptest! {
        #[test]
        fn factors_reassemble_the_covariance(x in prop::array::uniform25(-1.0..1.0f64)) {
            let (ud, p) = random(&x);
            prop_assert!((ud.covariance() - p).abs().max() < 1e-12);
            prop_assert!((0..5).all(|i| (ud.variance(i) - p[(i, i)]).abs() < 1e-12));
        }

        #[test]
        fn an_observation_is_the_kalman_update(
            x in prop::array::uniform25(-1.0..1.0f64), i in 0..5usize, r in 0.01..1.0f64,
        ) {
            let (mut ud, p) = random(&x);
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
            let (mut ud, mut p) = random(&x);
            ud.inflate(i, q);
            p[(i, i)] += q;
            prop_assert!((ud.covariance() - p).abs().max() < 1e-11);
        }
    }

    #[test]
    fn a_known_direction_stays_known() {
        let mut s = Mat::<f32, 3, 3>::identity();
        s[(2, 2)] = 0.0;
        let mut ud = Ud::of_factor(&s);
        ud.observe(0, 0.1);
        assert_eq!(ud.variance(2), 0.0);
        assert!(ud.is_valid());
    }
}
