//! Algebra without flight knowledge.
//!
//! | module | content | source |
//! |---|---|---|
//! | [`scalar`] | the scalar trait | |
//! | [`ud`] | covariance as `U D Uᵀ`, scalar updates | \[Bierman1977\] |
//! | [`square_root_information`] | least squares by Givens rotations | \[Gentleman1973\] |
//! | [`eigen`] | eigenvalues of symmetric matrices | \[Golub2013\] |
//! | [`savgol`] | Savitzky-Golay smoothing and differentiation | \[Savitzky1964\] |
//!
//! Matrices have fixed sizes and live on the stack. No function panics, and each has a bounded
//! amount of work that depends on the sizes alone.

pub mod eigen;
pub(crate) mod range;
pub mod savgol;
pub mod scalar;
pub mod square_root_information;
pub mod ud;

/// Column vector of three, in body axes unless its name says otherwise.
pub type Vec3<T> = nalgebra::SVector<T, 3>;
/// Matrix of R rows and C columns, stored by columns.
pub type Mat<T, const R: usize, const C: usize> = nalgebra::SMatrix<T, R, C>;

use scalar::Real;

// Unrolls a loop over up to 18 unknowns.
//
// The index is a constant in each copy of the body, so that rows stay in registers: half the
// instructions of a loop. The caller loops where there are more.
macro_rules! unroll {
    ($n:ident, $i:ident => $body:block) => {
        unroll!(@ $n, $i, $body, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17)
    };
    (@ $n:ident, $i:ident, $body:block, $($index:literal)+) => {
        $(if $index < $n {
            const $i: usize = $index;
            $body
        })+
    };
}
use unroll;
/// Number of unknowns up to which loops are unrolled.
const UNROLLED: usize = 18;

/// Entries of a matrix by row and column, inlined at each level of optimisation.
///
/// nalgebra's `[]` is a call where code is compiled for size. Its check of the range then remains in the
/// image, with a panic; inlined, it is proved away wherever the indices are those of a loop.
pub(crate) trait Entries<T> {
    /// Entry of a row and a column.
    fn at(&self, row: usize, column: usize) -> T;

    /// As [`at`](Self::at), mutable.
    fn at_mut(&mut self, row: usize, column: usize) -> &mut T;
}

impl<T: Real, const R: usize, const C: usize> Entries<T> for Mat<T, R, C> {
    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> T {
        self.data.0[column][row]
    }

    #[inline(always)]
    fn at_mut(&mut self, row: usize, column: usize) -> &mut T {
        &mut self.data.0[column][row]
    }
}

/// Identity, inlined at each level of optimisation: nalgebra's takes two more copies on the stack where
/// code is compiled for size.
#[inline(always)]
pub(crate) fn identity<T: Real, const N: usize>() -> Mat<T, N, N> {
    let mut m = Mat::from_array_storage(nalgebra::ArrayStorage([[T::zero(); N]; N]));
    for i in 0..N {
        *m.at_mut(i, i) = T::one();
    }
    m
}

/// Product `M v` of a 3×3 matrix. Not inlined where flash is scarce: one function for all, a hundred bytes less for each use.
/// (With an operating system, inlined products make a flight a tenth to a fifth shorter.)
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn rotated<T: Real>(m: &Mat<T, 3, 3>, v: &Vec3<T>) -> Vec3<T> {
    m * v
}

/// Product of two 3×3 matrices. Not inlined, as [`rotated`].
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn times<T: Real>(a: &Mat<T, 3, 3>, b: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    a * b
}

/// Column `index` of a matrix; zeros beyond the last column.
///
/// Replaces nalgebra's `column`, which panics on an index out of range.
pub fn column<T: Real, const R: usize, const C: usize>(
    matrix: &Mat<T, R, C>,
    index: usize,
) -> nalgebra::SVector<T, R> {
    let column = matrix.data.0.get(index).copied().unwrap_or([T::zero(); R]);
    nalgebra::SVector::from(column)
}

/// Matrix of these columns. Unlike nalgebra's it takes none as well.
pub fn of_columns<T: Real, const R: usize, const C: usize>(
    columns: [nalgebra::SVector<T, R>; C],
) -> Mat<T, R, C> {
    Mat::from_array_storage(nalgebra::ArrayStorage(columns.map(|column| column.into())))
}

/// Component `axis` of a vector; zero beyond the third.
///
/// Replaces nalgebra's index, which panics where the compiler does not know it.
pub fn component<T: Real>(v: &Vec3<T>, axis: usize) -> T {
    v.as_slice().get(axis).copied().unwrap_or(T::zero())
}

/// Euclidean length, `|v| = √(v · v)`, in the unit of `v`.
///
/// The square must be representable: lengths between 1e-19 and 1e19 in `f32`.
pub fn norm<T: Real>(v: &Vec3<T>) -> T {
    v.dot(v).sqrt()
}

/// Largest absolute component, `|v|∞`, in the unit of `v`.
pub fn largest_component<T: Real>(v: &Vec3<T>) -> T {
    v.iter().fold(T::zero(), |most, x| most.max(x.abs()))
}

/// Matrix of the cross product, `a^× b = a × b`.
///
/// `a^× = [0 −a_z a_y; a_z 0 −a_x; −a_y a_x 0]`, antisymmetric.
///
/// ```
/// use fsw_core::{Vec3, math::skew};
///
/// let (a, b) = (Vec3::new(1.0f32, -2.0, 3.0), Vec3::new(0.5, 4.0, -1.0));
/// assert_eq!(skew(&a) * b, a.cross(&b));
/// ```
pub fn skew<T: Real>(a: &Vec3<T>) -> Mat<T, 3, 3> {
    let o = T::zero();
    Mat::<T, 3, 3>::new(o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o)
}

/// Inverse of a symmetric 3×3 matrix by its adjugate, `M⁻¹ = adj(M) / det(M)`.
///
/// Only the upper triangle is read. Twelve products for the cofactors and one division: cheaper
/// than a factorisation, and without a panic. `None` where the determinant is zero or not finite.
///
/// ```
/// use fsw_core::math::{Mat, inverse_symmetric};
///
/// let m = Mat::<f64, 3, 3>::new(2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 4.0);
/// let identity = m * inverse_symmetric(&m).unwrap();
/// assert!((identity - Mat::identity()).abs().max() < 1e-15);
/// assert!(inverse_symmetric(&Mat::<f64, 3, 3>::zeros()).is_none());
/// ```
pub fn inverse_symmetric<T: Real>(m: &Mat<T, 3, 3>) -> Option<Mat<T, 3, 3>> {
    let (xx, xy, xz) = (m[(0, 0)], m[(0, 1)], m[(0, 2)]);
    let (yy, yz, zz) = (m[(1, 1)], m[(1, 2)], m[(2, 2)]);
    let (cxx, cxy, cxz) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let determinant = xx * cxx + xy * cxy + xz * cxz;
    let scale = T::one() / determinant;
    if !scale.is_finite() || !determinant.is_finite() {
        return None;
    }
    let (cyy, cyz, czz) = (xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy);
    Some(Mat::<T, 3, 3>::new(cxx, cxy, cxz, cxy, cyy, cyz, cxz, cyz, czz) * scale)
}

/// `xᵀ S⁻¹ x` by a Cholesky factorisation in place; `None` where S is not positive definite. Of S the lower
/// triangle counts.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn quadratic_over<T: Real>(s: &mut Mat<T, 6, 6>, mut x: [T; 6]) -> Option<T> {
    let mut sum = T::zero();
    for k in 0..6 {
        let pivot = s.at(k, k);
        if !(pivot > T::zero() && pivot.is_finite()) {
            return None;
        }
        let inverse = T::one() / pivot;
        sum += x[k] * x[k] * inverse;
        for i in k + 1..6 {
            let share = s.at(i, k) * inverse;
            x[i] -= share * x[k];
            for j in k + 1..=i {
                let change = share * s.at(j, k);
                *s.at_mut(i, j) -= change;
            }
        }
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Product with the inverse against the identity.
    #[test]
    fn inverse_symmetric_inverts() {
        let m =
            Mat::<f64, 3, 3>::new(14.2, 0.0867, 0.1357, 0.0867, 17.3, 0.6016, 0.1357, 0.6016, 20.3);
        let e = m * inverse_symmetric(&m).unwrap() - Mat::identity();
        assert!(e.abs().max() < 1e-15);
    }

    /// Zero matrix and NaN.
    #[test]
    fn a_singular_matrix_has_no_inverse() {
        assert_eq!(inverse_symmetric(&Mat::<f32, 3, 3>::zeros()), None);
        assert_eq!(inverse_symmetric(&Mat::<f32, 3, 3>::repeat(f32::NAN)), None);
    }

    /// `a^× b = a × b`, bit for bit.
    #[test]
    fn skew_is_the_cross_product() {
        let (a, b) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(0.5, 4.0, -1.0));
        assert_eq!(skew(&a) * b, a.cross(&b));
    }
}
