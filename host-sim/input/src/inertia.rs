//! The inertia tensor as files list it: six elements about the centre of mass, kg m².

use nalgebra::{Matrix3, SMatrix};

/// The six elements of an inertia tensor in the order of files and reports.
///
/// An off-diagonal element is the tensor entry itself: −∫xy dm for `jxy`.
pub const ELEMENT_NAMES: [&str; 6] = ["jxx", "jyy", "jzz", "jxy", "jxz", "jyz"];

/// Tolerance of the triangle inequality, relative to the sum of the two smaller principal moments.
///
/// A flat body lies on that limit exactly, and its file is rounded to some digits.
const TRIANGLE_TOLERANCE: f64 = 1e-6;

/// The tensor of the six elements `jxx jyy jzz jxy jxz jyz`.
pub fn tensor(elements_kg_m2: &[f64; 6]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = *elements_kg_m2;
    SMatrix::from_row_slice(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
}

/// Principal moments: the eigenvalues of a symmetric tensor, ascending, kg m².
pub fn principal_moments(tensor: &Matrix3<f64>) -> [f64; 3] {
    let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    moments
}

/// Criterion of a rigid body for its principal moments, ascending: all positive, the largest at most
/// the sum of the other two.
pub fn is_physical(moments: &[f64; 3]) -> bool {
    let [smallest, middle, largest] = moments;
    *smallest > 0.0 && *largest <= (smallest + middle) * (1.0 + TRIANGLE_TOLERANCE)
}
