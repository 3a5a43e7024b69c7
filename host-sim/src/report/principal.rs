//! Principal moments and axes of a tensor, with their sigma by first-order perturbation.
//!
//! With `J vᵢ = λᵢ vᵢ`, a change δJ of the tensor has the effects
//!
//! ```text
//! δλᵢ = vᵢᵀ δJ vᵢ,   δvᵢ = Σ_{k≠i} vₖ (vₖᵀ δJ vᵢ) / (λᵢ − λₖ)
//! ```
//!
//! Both are linear in the six elements; their variances follow from the covariance of the elements.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Direction error from which an axis counts as undetermined, rad: beyond it the linear propagation does not hold.
const UNDETERMINED_RAD: f64 = 0.5;

/// A principal moment and its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Principal {
    /// Moment, kg m².
    pub moment_kg_m2: f64,
    /// One sigma, kg m².
    pub sigma_kg_m2: f64,
    /// Unit vector, body axes, with its largest component positive.
    pub axis: Vector3<f64>,
    /// One sigma of the direction: root sum square of the two angles about the other axes, rad. None where the moments
    /// are too close for a direction.
    pub axis_sigma_rad: Option<f64>,
}

impl Principal {
    /// Body axis nearest to this one, 0 to 2, and the angle to it, rad.
    pub fn nearest_body_axis(&self) -> (usize, f64) {
        let nearest = self.axis.iamax();
        (nearest, self.axis[nearest].abs().min(1.0).acos())
    }

    /// Angle to another principal axis, rad.
    pub fn angle_to(&self, other: &Self) -> f64 {
        self.axis.dot(&other.axis).abs().min(1.0).acos()
    }
}

/// The three of a tensor with the covariance of its elements, kg² m⁴, ascending by moment.
pub(super) fn principal(
    tensor_kg_m2: &[[f64; 3]; 3],
    covariance_kg2_m4: &[[f64; 6]; 6],
) -> [Principal; 3] {
    let eigen = Matrix3::from(*tensor_kg_m2).symmetric_eigen();
    let covariance = Matrix6::from(*covariance_kg2_m4);
    let sigma = |by: Vector6<f64>| by.dot(&(covariance * by)).max(0.0).sqrt();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let vector = |i: usize| eigen.eigenvectors.column(order[i]).into_owned();
    let value = |i: usize| eigen.eigenvalues[order[i]];
    std::array::from_fn(|i| {
        let axis: Vector3<f64> = vector(i);
        let others = [(i + 1) % 3, (i + 2) % 3];
        let angle = |k: usize| sigma(form(&vector(k), &axis)) / (value(i) - value(k)).abs();
        let angles = angle(others[0]).hypot(angle(others[1]));
        let sign = axis[axis.iamax()].signum();
        Principal {
            moment_kg_m2: value(i),
            sigma_kg_m2: sigma(form(&axis, &axis)),
            axis: axis * sign,
            axis_sigma_rad: (angles < UNDETERMINED_RAD).then_some(angles),
        }
    })
}

/// Coefficients of `aᵀ δJ b` by the elements `xx yy zz xy xz yz` of δJ.
fn form(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector6<f64> {
    let product = |i: usize, k: usize| a[i] * b[k] + a[k] * b[i];
    Vector6::new(a.x * b.x, a.y * b.y, a.z * b.z, product(0, 1), product(0, 2), product(1, 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tensor(e: [f64; 6]) -> [[f64; 3]; 3] {
        [[e[0], e[3], e[4]], [e[3], e[1], e[5]], [e[4], e[5], e[2]]]
    }

    fn covariance(sigma: [f64; 6]) -> [[f64; 6]; 6] {
        std::array::from_fn(|i| {
            std::array::from_fn(|k| if i == k { sigma[i] * sigma[i] } else { 0.0 })
        })
    }

    #[test]
    fn diagonal_tensor_has_the_sigma_of_its_elements() {
        let sigma = [0.1, 0.2, 0.3, 0.01, 0.02, 0.04];
        let [x, y, z] = principal(&tensor([1.0, 2.0, 4.0, 0.0, 0.0, 0.0]), &covariance(sigma));
        assert_eq!([x, y, z].map(|p| p.moment_kg_m2), [1.0, 2.0, 4.0]);
        assert_eq!([x, y, z].map(|p| p.nearest_body_axis().0), [0, 1, 2]);
        for (found, expected) in [x, y, z].iter().zip(sigma) {
            assert!((found.sigma_kg_m2 - expected).abs() < 1e-12);
        }
        // jxy over the difference of 1 kg m², jxz over 3 kg m².
        let expected = 0.01_f64.hypot(0.02 / 3.0);
        assert!((x.axis_sigma_rad.unwrap() - expected).abs() < 1e-12);
    }

    #[test]
    fn sigma_agrees_with_differences() {
        const STEP: f64 = 1e-6;
        let elements = [1.0, 1.5, 2.2, 0.1, -0.2, 0.15];
        let none = covariance([0.0; 6]);
        for i in 0..6 {
            let (mut moved, mut sigma) = (elements, [0.0; 6]);
            moved[i] += STEP;
            sigma[i] = STEP;
            let before = principal(&tensor(elements), &covariance(sigma));
            let after = principal(&tensor(moved), &none);
            for (a, b) in before.iter().zip(&after) {
                assert!((a.sigma_kg_m2 - (a.moment_kg_m2 - b.moment_kg_m2).abs()).abs() < 1e-10);
                // The sine: the cosine of a small angle has no digits left.
                let angle = a.axis.cross(&b.axis).norm();
                assert!((a.axis_sigma_rad.unwrap() - angle).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn axes_of_equal_moments_are_undetermined() {
        let found = principal(&tensor([1.0, 1.0, 2.0, 0.0, 0.0, 0.0]), &covariance([0.01; 6]));
        assert_eq!(found.map(|p| p.axis_sigma_rad.is_some()), [false, false, true]);
    }
}
