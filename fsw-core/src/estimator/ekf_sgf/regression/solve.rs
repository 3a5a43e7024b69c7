//! Solution of the sums, and the covariance of its error.
//!
//! Input: the factor R of `HᵀH = RᵀR` with rows in units of their sigma, and the prior `j₀ ± S`
//! (kg m²). Output: elements (kg m²) and covariance (kg² m⁴).
//!
//! The bias by noise in the regressor: with accelerations `ω̇ + v` the rows are `H + V`, and least
//! squares solves `(HᵀH + N) ĵ = HᵀH j`, `N = E[VᵀV]`, so `ĵ − j = −(HᵀH + N)⁻¹ N j`. The measured
//! `HᵀH` contains N already. j is unknown; its second moment is that of the prior, `S² + j₀ j₀ᵀ`.

use super::unobserved::ElementPrior;
use super::{Elements, Regression, Solution};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Entries, Mat, Vec3, scalar::Real};
use crate::prior::Prior;
use crate::tensor::{Inertia, regressor_noise_share};

/// Rows before the mean square of their residuals is used as the noise level: its relative scatter
/// is then below √(2/60) = 0.18.
const RESIDUALS_COUNT: u32 = 60;

impl<T: Real> Regression<T> {
    /// The elements and the covariance of their error, the prior `j₀ ± S` included.
    ///
    /// The covariance is the sum of
    ///
    /// * `s² (HᵀH)⁻¹`, the noise of the equation's balance: `s²` the mean squared residual in
    ///   sigmas, at least 1;
    /// * `A (S² + j₀ j₀ᵀ) Aᵀ`, the same noise in the regressor, which biases the solution towards
    ///   zero by `A j`, `A = (HᵀH)⁻¹ N`; `N = n σ² diag(1 1 1 2 2 2)` is the noise's expected share
    ///   of `HᵀH` ([`regressor_noise_share`]), and `S² + j₀ j₀ᵀ` the second moment of j;
    /// * `m mᵀ`, `m = (HᵀH)⁻¹ Hᵀ b`: the effect of the known imbalance b, the lag of the rate;
    /// * with three moments, the effect of the products' own sigma.
    ///
    /// A direction with little more information than the prior is set to the prior. A spin about
    /// one axis `a` thus determines the three elements of `J a`, for any rank that noise gives
    /// `HᵀH`.
    ///
    /// Left out: the correlation between instants that share a window (up to a factor of two: the
    /// covariance is too large for motions slow beside the window, too small for those as fast as
    /// it); noise of the rate in `ω^× G(ω)`; errors of torque and wheels.
    pub fn solve(&self, elements: Elements, nominal: &Prior<T>) -> Solution<T> {
        let mut information = self.information;
        for i in 0..6 {
            let mut row = [T::zero(); 6];
            let weight = T::one() / nominal.sigma_kg_m2[i];
            row[i] = weight;
            information.add(row, weight * nominal.inertia_kg_m2[i]);
        }
        match elements {
            Elements::All => {
                let prior =
                    ElementPrior { value: nominal.inertia_kg_m2, sigma: nominal.sigma_kg_m2 };
                let (j, covariance) = self.solve_factor(&information, &prior, &Mat::zeros());
                Solution { inertia: Inertia::new(j), covariance_kg2_m4: covariance }
            }
            Elements::Moments => self.solve_moments(&information, nominal),
        }
    }

    /// The three moments m with the products p at their nominal values, from the first three rows
    /// of the factor: `R₁₁ m = d₁ − R₁₂ p`.
    ///
    /// An error `δp` moves the moments by `−R₁₁⁻¹ R₁₂ δp`, which joins the covariance. The
    /// correlation of moments and products that follows from it is left out.
    #[inline(never)]
    fn solve_moments(
        &self,
        information: &SquareRootInformation<T, 6>,
        nominal: &Prior<T>,
    ) -> Solution<T> {
        let (value, sigma) = (&nominal.inertia_kg_m2, &nominal.sigma_kg_m2);
        let mut moments = SquareRootInformation::<T, 3>::default();
        // R₁₁ᵀ R₁₂, one row a product.
        let mut by_products = [[T::zero(); 3]; 3];
        for (row, d) in information.equations().iter().take(3) {
            let mut y = *d;
            for p in 0..3 {
                y -= row[3 + p] * value[3 + p];
                for m in 0..3 {
                    by_products[p][m] += row[m] * row[3 + p];
                }
            }
            moments.add([row[0], row[1], row[2]], y);
        }
        let mut by_product_sigma = Mat::<T, 3, 3>::zeros();
        for p in 0..3 {
            let moved = moments.solve_normal(&by_products[p]).unwrap_or([T::MAX; 3]);
            let moved = Vec3::from(moved) * sigma[3 + p];
            by_product_sigma += moved * moved.transpose();
        }
        let prior = ElementPrior {
            value: [value[0], value[1], value[2]],
            sigma: [sigma[0], sigma[1], sigma[2]],
        };
        let (m, covariance) = self.solve_factor(&moments, &prior, &by_product_sigma);
        Solution {
            inertia: Inertia::new([m[0], m[1], m[2], value[3], value[4], value[5]]),
            covariance_kg2_m4: with_products(&covariance, sigma),
        }
    }

    /// Solution of one factor, with `unmodelled` (kg² m⁴) added to its covariance, and unobserved
    /// directions set to the prior. Where the factor is singular or a number overflows, the prior.
    #[inline(never)]
    fn solve_factor<const N: usize>(
        &self,
        information: &SquareRootInformation<T, N>,
        prior: &ElementPrior<T, N>,
        unmodelled: &Mat<T, N, N>,
    ) -> ([T; N], Mat<T, N, N>) {
        let mut covariance = Mat::<T, N, N>::zeros();
        let (Some(x), true) =
            (information.solve(), information.covariance_of_last(&mut covariance))
        else {
            return (prior.value, prior.covariance());
        };
        covariance *= self.residual_variance(N);
        covariance += unmodelled;
        match self.add_bias(information, prior, &mut covariance) {
            Some(()) => prior.in_unobserved_directions(&x, &covariance),
            None => (prior.value, prior.covariance()),
        }
    }

    /// Adds `A (S² + j₀ j₀ᵀ) Aᵀ`, `A = (HᵀH)⁻¹ N`, and `m mᵀ`, `m = (HᵀH)⁻¹ Hᵀ b`, all in kg² m⁴.
    /// `None` where the factor is singular.
    #[inline(never)]
    fn add_bias<const N: usize>(
        &self,
        information: &SquareRootInformation<T, N>,
        prior: &ElementPrior<T, N>,
        covariance: &mut Mat<T, N, N>,
    ) -> Option<()> {
        // In rows of unit sigma, noise of one sigma in the acceleration is 1 / moment.
        let noise = self.instants / (self.moment_kg_m2 * self.moment_kg_m2);
        let mut pulled = [T::zero(); N];
        for k in 0..N {
            let mut b = [T::zero(); N];
            b[k] = noise * regressor_noise_share(k);
            let column = information.solve_normal(&b)?;
            for i in 0..N {
                pulled[i] += column[i] * prior.value[k];
            }
            add_square(covariance, &column.map(|c| c * prior.sigma[k]));
        }
        let imbalance = core::array::from_fn(|k| self.imbalance.get(k).map_or(T::zero(), |b| *b));
        let moved = information.solve_normal(&imbalance)?;
        add_square(covariance, &pulled);
        add_square(covariance, &moved);
        Some(())
    }

    /// `s² = Σ r² / (3 n − N)`, sigmas squared, at least 1; 1 while there are few rows.
    fn residual_variance(&self, unknowns: usize) -> T {
        let rows = self.instants * T::lit(3.0);
        if rows < T::count(RESIDUALS_COUNT) {
            return T::one();
        }
        (self.residual_square / (rows - T::count(unknowns as u32))).max(T::one())
    }
}

/// Covariance of six elements from that of the moments, kg² m⁴: the products keep their prior sigma
/// (kg m²), uncorrelated.
fn with_products<T: Real>(moments: &Mat<T, 3, 3>, sigma: &[T; 6]) -> Mat<T, 6, 6> {
    let mut full = Mat::<T, 6, 6>::zeros();
    for i in 0..3 {
        for k in 0..3 {
            *full.at_mut(i, k) = moments.at(i, k);
        }
        *full.at_mut(3 + i, 3 + i) = sigma[3 + i] * sigma[3 + i];
    }
    full
}

/// Adds `v vᵀ`.
fn add_square<T: Real, const N: usize>(covariance: &mut Mat<T, N, N>, v: &[T; N]) {
    for i in 0..N {
        for k in 0..N {
            *covariance.at_mut(i, k) += v[i] * v[k];
        }
    }
}
