//! The six elements of an inertia tensor as a matrix, and ratios in per cent.

/// Symmetric matrix of the elements `jxx jyy jzz jxy jxz jyz`, row by row.
pub fn matrix(elements: &[f64; 6]) -> [[f64; 3]; 3] {
    let [xx, yy, zz, xy, xz, yz] = *elements;
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

/// Elements `jxx jyy jzz jxy jxz jyz` of a symmetric matrix.
pub fn elements(matrix: &[[f64; 3]; 3]) -> [f64; 6] {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = *matrix;
    [xx, yy, zz, xy, xz, yz]
}

/// `part` in per cent of `whole`. None if `whole` is zero.
pub(super) fn percent(part: f64, whole: f64) -> Option<f64> {
    (whole != 0.0).then(|| 100.0 * part / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_matrix_are_inverse() {
        let six = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(elements(&matrix(&six)), six);
    }
}
