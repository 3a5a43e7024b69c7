//! Unobserved directions: the prior in place of a solution that noise alone decides.
//!
//! Input: a solution x of N elements (kg m²) with its covariance C (kg² m⁴), and the prior
//! `x₀ ± σ`. Output: the same with the prior's value and variance in each unobserved direction.
//!
//! Directions are judged in units of the prior's sigmas, so that bodies of any size are judged
//! alike. The division by two sigmas is done one after the other, since the product of two small
//! sigmas may underflow in single precision.

use crate::math::{Entries, Mat, eigen::symmetric_eigen, scalar::Real};

/// Posterior over prior sigma above which a direction is unobserved. Noise in the regressor alone
/// makes it 0.9 to 1.1 there, rather than large: noise looks like motion.
const UNOBSERVED: f64 = 0.75;

/// Prior of N elements, kg m², uncorrelated.
pub(super) struct ElementPrior<T: Real, const N: usize> {
    /// `x₀`.
    pub value: [T; N],
    /// One sigma of each, above zero.
    pub sigma: [T; N],
}

impl<T: Real, const N: usize> ElementPrior<T, N> {
    /// `diag(σᵢ²)`, kg² m⁴.
    pub(super) fn covariance(&self) -> Mat<T, N, N> {
        let mut c = Mat::<T, N, N>::zeros();
        for i in 0..N {
            *c.at_mut(i, i) = self.sigma[i] * self.sigma[i];
        }
        c
    }

    /// The solution `x` (kg m²) with its covariance C (kg² m⁴), and the prior in each unobserved
    /// direction.
    ///
    /// With `S = diag(σᵢ)` the scaled covariance is `S⁻¹ C S⁻¹ = V D Vᵀ`; a direction is a column v
    /// of V. Where `√d < 0.75` it keeps value `vᵀ S⁻¹ (x − x₀)` and variance d, elsewhere it takes
    /// those of the prior, 0 and 1:
    ///
    /// `x ← x₀ + Σ S v vᵀ S⁻¹ (x − x₀)` over the observed, `C ← Σ d S v vᵀ S` over all directions.
    ///
    /// The prior alone, where a number is not finite.
    #[inline(never)]
    pub(super) fn in_unobserved_directions(
        &self,
        x: &[T; N],
        covariance: &Mat<T, N, N>,
    ) -> ([T; N], Mat<T, N, N>) {
        let mut scaled = Mat::<T, N, N>::zeros();
        for i in 0..N {
            for k in 0..N {
                *scaled.at_mut(i, k) = covariance.at(i, k) / self.sigma[i] / self.sigma[k];
            }
        }
        if !scaled.iter().chain(x.iter()).all(|v| v.is_finite()) {
            return (self.value, self.covariance());
        }
        let (variance, direction) = symmetric_eigen(&scaled);
        let (mut value, mut combined) = (self.value, Mat::<T, N, N>::zeros());
        for d in 0..N {
            let is_observed = variance[d] < T::lit(UNOBSERVED * UNOBSERVED);
            let mut along = T::zero();
            for i in 0..N {
                along += direction.at(i, d) * (x[i] - self.value[i]) / self.sigma[i];
            }
            let variance = if is_observed { variance[d].max(T::zero()) } else { T::one() };
            for i in 0..N {
                let axis = direction.at(i, d) * self.sigma[i];
                if is_observed {
                    value[i] += axis * along;
                }
                for k in 0..N {
                    *combined.at_mut(i, k) +=
                        variance * axis * (direction.at(k, d) * self.sigma[k]);
                }
            }
        }
        (value, combined)
    }
}
