//! Rank test of observability, \[Bellar2019\] Eq. (23).

use nalgebra::{DMatrix, Matrix3, Matrix3x6, SMatrix, Vector3};

/// \[Bellar2019\] Table 2: time constants `τ` of moments and products, s.
pub const TIME_CONSTANT_S: [f64; 6] = [1e6, 1e6, 1e6, 1e5, 1e5, 1e5];

/// Rank of `OB = [H; H F; …; H F⁸]`, `H = [1 0]`, with `F` the Jacobian of the nine states at this
/// rate under this torque, \[Bellar2019\] Eqs. (7), (23):
///
/// `F = [[A, B], [0, D]]`, `A = J⁻¹ ([J ω]^× − ω^× J)`, `B = −J⁻¹ [G(ω̇) + ω^× G(ω)]`,
/// `D = −diag(1/τ)`.
///
/// Symbols: `J` inertia, kg m²; `ω` rate, rad/s; `ω̇ = J⁻¹ (torque − ω × J ω)`; `τ` time constants,
/// s. Rank 0 if `J` is singular. A singular value counts if it exceeds 27 ε of the largest; the
/// matrix is not scaled.
///
/// The rank at a frozen instant does not measure the observability of a motion over time: `B` has
/// three rows, and any rank above 6 is due to the unequal time constants of moments and products.
pub fn rank_of_observability_matrix(
    inertia_kg_m2: &[f64; 6],
    time_constant_s: &[f64; 6],
    rate_rad_s: &Vector3<f64>,
    torque_n_m: &Vector3<f64>,
) -> usize {
    let [xx, yy, zz, xy, xz, yz] = *inertia_kg_m2;
    let j = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let Some(inverse) = j.try_inverse() else { return 0 };
    let w = rate_rad_s;
    let acceleration = inverse * (torque_n_m - w.cross(&(j * w)));
    let turn = w.cross_matrix();
    let mut f = SMatrix::<f64, 9, 9>::zeros();
    f.fixed_view_mut::<3, 3>(0, 0).copy_from(&(inverse * ((j * w).cross_matrix() - turn * j)));
    f.fixed_view_mut::<3, 6>(0, 3)
        .copy_from(&(-inverse * (regressor(&acceleration) + turn * regressor(w))));
    for k in 0..6 {
        f[(3 + k, 3 + k)] = -1.0 / time_constant_s[k];
    }
    let mut rows = DMatrix::zeros(27, 9);
    let mut power = SMatrix::<f64, 3, 9>::identity();
    for block in 0..9 {
        rows.view_mut((3 * block, 0), (3, 9)).copy_from(&power);
        power *= f;
    }
    let singular = rows.singular_values();
    let least = singular.max() * 27.0 * f64::EPSILON;
    singular.iter().filter(|value| **value > least).count()
}

/// `G(v)` with `J v = G(v) j`, for `j = [jxx jyy jzz jxy jxz jyz]`.
pub(super) fn regressor(v: &Vector3<f64>) -> Matrix3x6<f64> {
    let o = 0.0;
    Matrix3x6::new(
        v.x, o, o, v.y, v.z, o, //
        o, v.y, o, v.x, o, v.z, //
        o, o, v.z, o, v.x, v.y,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const INERTIA_KG_M2: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];

    fn rank(time_constant_s: [f64; 6], rate: Vector3<f64>, torque: Vector3<f64>) -> usize {
        rank_of_observability_matrix(&INERTIA_KG_M2, &time_constant_s, &rate, &torque)
    }

    #[test]
    fn rank_is_that_of_the_rate_at_rest_without_torque() {
        assert_eq!(rank(TIME_CONSTANT_S, Vector3::zeros(), Vector3::zeros()), 3);
    }

    /// The rows of the inertia's block are `Aᵏ B D^m`. With `D` a multiple of the identity they lie
    /// in the row space of `B`, which has three dimensions.
    #[test]
    fn full_rank_is_due_to_unequal_time_constants_alone() {
        let torque = Vector3::new(1e-3, 1e-3, -2e-3);
        for rate in [Vector3::zeros(), Vector3::new(0.03, -0.02, 0.05)] {
            assert_eq!(rank([1e6; 6], rate, torque), 6);
            assert_eq!(rank(TIME_CONSTANT_S, rate, torque), 9);
        }
    }
}
