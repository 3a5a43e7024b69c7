//! Eigenvalues of small symmetric matrices by cyclic Jacobi rotations, \[Golub2013\] section 8.5.
//!
//! `A = V Λ Vᵀ`, V orthogonal, Λ diagonal.
//!
//! Each rotation in the plane (p, q) zeroes `a_pq`, which reduces the sum of squares of the
//! off-diagonal elements by `2 a_pq²`. Sweeps over all planes converge quadratically. A fixed
//! number of sweeps bounds the work, and the result needs no test for convergence; the routine of
//! nalgebra iterates without a stated bound and may panic.
//!
//! | N | rotations | use |
//! |---|---|---|
//! | 3 | 24 | principal moments and axes |
//! | 6 | 120 | observed directions of the inertia |
//!
//! Accuracy: eigenvalues to a few ε of the largest one.

use super::{Entries, Mat, column, identity, scalar::Real};

/// Sweeps over all off-diagonal elements. A 6×6 matrix is diagonal to double precision after about
/// six; two are margin.
const SWEEPS: usize = 8;

/// Eigenvalues in no particular order, and the matrix V of unit eigenvectors in its columns.
///
/// `symmetric` is N×N; only its upper triangle is read. The result is not finite where an element
/// is not.
///
/// ```
/// use fsw_core::math::{Mat, eigen::symmetric_eigen};
///
/// let a = Mat::<f64, 2, 2>::new(2.0, 1.0, 1.0, 2.0);
/// let (mut values, v) = symmetric_eigen(&a);
/// values.sort_by(f64::total_cmp);
/// assert!((values[0] - 1.0).abs() < 1e-15 && (values[1] - 3.0).abs() < 1e-15);
/// assert!((v * v.transpose() - Mat::identity()).abs().max() < 1e-15);
/// ```
pub fn symmetric_eigen<T: Real, const N: usize>(
    symmetric: &Mat<T, N, N>,
) -> ([T; N], Mat<T, N, N>) {
    let mut a = Mat::<T, N, N>::zeros();
    for k in 0..N {
        for i in 0..k + 1 {
            *a.at_mut(i, k) = symmetric.at(i, k);
            *a.at_mut(k, i) = symmetric.at(i, k);
        }
    }
    let mut v = identity::<T, N>();
    for _ in 0..SWEEPS {
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut a, &mut v, p, q);
            }
        }
    }
    let mut values = [T::zero(); N];
    for i in 0..N {
        values[i] = a.at(i, i);
    }
    (values, v)
}

/// Zeroes `a_pq` by a rotation in the plane (p, q), and applies the rotation to `v`.
///
/// `t = tan φ` is the smaller root of `t² + 2 θ t − 1 = 0` with `θ = (a_qq − a_pp) / 2 a_pq`;
/// `c = 1 / √(1 + t²)`, `s = t c`. \[Golub2013\] algorithm 8.5.1.
///
/// The smaller root keeps `|φ| ≤ 45°`, which makes the sweeps converge. Diagonal elements change by
/// `∓ t a_pq`, without cancellation.
fn rotate<T: Real, const N: usize>(a: &mut Mat<T, N, N>, v: &mut Mat<T, N, N>, p: usize, q: usize) {
    // Never true. Without it the compiler leaves a check of each index where it does not inline the function.
    if p >= N || q >= N {
        return;
    }
    let apq = a.at(p, q);
    if apq == T::zero() {
        return;
    }
    let theta = (a.at(q, q) - a.at(p, p)) / (apq + apq);
    let root = (theta * theta + T::one()).sqrt();
    let t = if theta < T::zero() { -T::one() } else { T::one() } / (theta.abs() + root);
    let c = T::one() / (t * t + T::one()).sqrt();
    let s = t * c;
    *a.at_mut(p, p) -= t * apq;
    *a.at_mut(q, q) += t * apq;
    *a.at_mut(p, q) = T::zero();
    *a.at_mut(q, p) = T::zero();
    for k in 0..N {
        if k != p && k != q {
            let (akp, akq) = (a.at(k, p), a.at(k, q));
            *a.at_mut(k, p) = c * akp - s * akq;
            *a.at_mut(k, q) = s * akp + c * akq;
            *a.at_mut(p, k) = a.at(k, p);
            *a.at_mut(q, k) = a.at(k, q);
        }
        let (vkp, vkq) = (v.at(k, p), v.at(k, q));
        *v.at_mut(k, p) = c * vkp - s * vkq;
        *v.at_mut(k, q) = s * vkp + c * vkq;
    }
}

/// Singular values of a square matrix in no particular order, and the matrix V whose columns are its
/// right singular vectors: `A = W diag(values) Vᵀ`.
///
/// One-sided Jacobi rotations \[Golub2013\] section 8.6.3: each makes two columns of A V orthogonal.
/// A small value keeps its relative accuracy, which the eigenvalues of `AᵀA` lose to the square of the
/// largest.
///
/// ```
/// use fsw_core::math::{Mat, eigen::singular_values};
///
/// let (mut values, _) = singular_values(&Mat::<f32, 2, 2>::new(1.0, 1.0, 0.0, 1e-5));
/// values.sort_by(f32::total_cmp);
/// assert!((values[0] * values[1] - 1e-5).abs() < 1e-11); // the determinant
/// ```
#[inline(never)]
pub fn singular_values<T: Real, const N: usize>(a: &Mat<T, N, N>) -> ([T; N], Mat<T, N, N>) {
    let (mut b, mut v) = (*a, identity::<T, N>());
    for _ in 0..SWEEPS {
        for p in 0..N {
            for q in p + 1..N {
                make_orthogonal(&mut b, &mut v, p, q);
            }
        }
    }
    let mut values = [T::zero(); N];
    for (k, value) in values.iter_mut().enumerate() {
        let column = column(&b, k);
        *value = column.dot(&column).sqrt();
    }
    (values, v)
}

/// Rotates columns p and q of b and v so that those of b are orthogonal.
fn make_orthogonal<T: Real, const N: usize>(
    b: &mut Mat<T, N, N>,
    v: &mut Mat<T, N, N>,
    p: usize,
    q: usize,
) {
    let (p, q) = (p.min(N.saturating_sub(1)), q.min(N.saturating_sub(1)));
    let (x, y) = (column(b, p), column(b, q));
    let (xx, yy, xy) = (x.dot(&x), y.dot(&y), x.dot(&y));
    if xy == T::zero() {
        return;
    }
    let theta = (yy - xx) / (xy + xy);
    let root = (theta * theta + T::one()).sqrt();
    let t = if theta < T::zero() { -T::one() } else { T::one() } / (theta.abs() + root);
    let c = T::one() / (t * t + T::one()).sqrt();
    let s = t * c;
    for matrix in [b, v] {
        for i in 0..N {
            let (at_p, at_q) = (matrix.at(i, p), matrix.at(i, q));
            *matrix.at_mut(i, p) = c * at_p - s * at_q;
            *matrix.at_mut(i, q) = s * at_p + c * at_q;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Product `V Λ Vᵀ` and orthogonality of V, to 1e-13 for elements up to 1.
        #[test]
        fn eigenvectors_and_eigenvalues_reassemble_the_matrix(x in prop::array::uniform21(-1.0..1.0f64)) {
            let mut m = Mat::<f64, 6, 6>::zeros();
            let mut k = 0;
            for i in 0..6 {
                for j in i..6 {
                    m[(i, j)] = x[k];
                    m[(j, i)] = x[k];
                    k += 1;
                }
            }
            let (d, v) = symmetric_eigen(&m);
            let again = v * Mat::<f64, 6, 6>::from_diagonal(&d.into()) * v.transpose();
            prop_assert!((again - m).abs().max() < 1e-13);
            prop_assert!((v * v.transpose() - Mat::identity()).abs().max() < 1e-13);
        }
    }

    /// A multiple of the identity needs no rotation.
    #[test]
    fn repeated_eigenvalues_are_exact() {
        let (d, _) = symmetric_eigen(&(Mat::<f32, 3, 3>::identity() * 2.0));
        assert_eq!(d, [2.0; 3]);
    }
}
