//! Elements of a method, and the second moment of their error: gyro noise, its bias through the
//! regressor, and the terms that the method neglects.
//!
//! With `Q = J (ω − v)` for gyro noise v (rad/s), a method that is linear in `B = Σ ω Qᵀ` (see
//! [`formulas`](super::formulas)) for given `M = Σ ω ωᵀ` yields, of a true tensor J,
//!
//! `ĵ = f(M J − Σ ω vᵀ J)`, `E[Σ ω vᵀ] = n σ² 1`
//!
//! Systematic error: `f((M − n σ² 1) J) − j`, the bias towards zero and everything that the method
//! neglects, for any motion. It is linear in the unknown j, so its second moment follows from the
//! prior `j₀ ± S`. Random error: the rest of `Σ ω vᵀ J`, whose rows have the covariance
//! `σ² |J|² M`, through the same formula.
//!
//! Ours: the paper gives no covariance.

use super::formulas::{Formulas, Method, RightHandSide};
use super::sums::Sums;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, scalar::Real};
use crate::prior::Prior;
use crate::tensor::{Inertia, regressor, regressor_noise_share};

/// Error model of the formulas, for given sums and gyro noise.
pub(super) struct ErrorModel<T: Real> {
    sums: Sums<T>,
    formulas: Formulas<T>,
    /// `j₀ ± S`.
    prior: Prior<T>,
    /// `n σ²`, rad²/s².
    noise_square: T,
    /// One sigma of a row of `J ω = Q`: typical moment times the larger of stated and measured
    /// noise.
    row_sigma_n_m_s: T,
}

impl<T: Real> ErrorModel<T> {
    /// For gyro noise of `noise_rad_s`, one sigma per sample. Without a prior, that of a body of
    /// the size along the motion; while the motion is too weak for a size, the prior of an unknown
    /// body.
    pub(super) fn new(sums: &Sums<T>, noise_rad_s: T, prior: Option<&Prior<T>>) -> Self {
        let size = sums.size_kg_m2(noise_rad_s);
        let prior = match (prior, size) {
            (Some(prior), _) => *prior,
            (None, Some(size)) => Prior::of_size(size),
            (None, None) => Prior::unknown(),
        };
        let j = Inertia::new(prior.inertia_kg_m2).matrix_kg_m2();
        let moment = (j.dot(&j) * T::lit(1.0 / 3.0)).sqrt().max(size.unwrap_or(T::zero()));
        let noise = sums.residual_rms_rad_s().max(noise_rad_s);
        Self {
            sums: *sums,
            formulas: Formulas::new(sums, noise_rad_s),
            prior,
            noise_square: sums.noise_square(noise_rad_s),
            row_sigma_n_m_s: moment * noise,
        }
    }

    /// The prior in use.
    pub(super) fn prior(&self) -> &Prior<T> {
        &self.prior
    }

    /// The method's elements, kg m², and the second moment of their error, kg² m⁴:
    ///
    /// `Σ e eᵀ` over `e = f((M − n σ² 1) J) − j` for `j = j₀` and for `j = Sₖ` along each element
    /// k, and over `e = f(σ_row Rᵀ Eₖᵣ)` for each of the nine unit matrices `E`, R the factor of
    /// `M = RᵀR`.
    ///
    /// An element without a solution, and all of them where a number overflows, are the prior's.
    pub(super) fn solve(&self, method: Method) -> ([T; 6], Mat<T, 6, 6>) {
        let Prior { inertia_kg_m2: value, sigma_kg_m2: sigma } = &self.prior;
        let solve = |b: &RightHandSide<T>| self.formulas.elements(method, b);
        let measured =
            RightHandSide { factored: self.sums.right_hand_side(), direct: Mat::zeros() };
        let found = solve(&measured);
        let elements: [T; 6] = core::array::from_fn(|i| found[i].unwrap_or(value[i]));

        let mut second_moment = Mat::<T, 6, 6>::zeros();
        let mut add = |error: [T; 6]| {
            let error = Mat::<T, 6, 1>::from(error);
            second_moment += error * error.transpose();
        };
        let expected = solve(&self.expected_right_hand_side(value));
        add(core::array::from_fn(|i| expected[i].map_or(T::zero(), |x| x - value[i])));
        for k in 0..6 {
            let unit: [T; 6] = core::array::from_fn(|i| if i == k { sigma[k] } else { T::zero() });
            let expected = solve(&self.expected_right_hand_side(&unit));
            add(core::array::from_fn(|i| expected[i].unwrap_or(T::zero()) - unit[i]));
        }
        for (row, k) in (0..9).map(|i| (i / 3, i % 3)) {
            let mut noise = RightHandSide { factored: Mat::zeros(), direct: Mat::zeros() };
            noise.factored[(k, row)] = self.row_sigma_n_m_s;
            add(solve(&noise).map(|x| x.unwrap_or(T::zero())));
        }
        let is_finite = elements.iter().chain(second_moment.iter()).all(|x| x.is_finite());
        if is_finite { (elements, second_moment) } else { (*value, self.prior_covariance()) }
    }

    /// `(M − n σ² 1) J`: expectation of B for the tensor of these elements (kg m²).
    fn expected_right_hand_side(&self, elements: &[T; 6]) -> RightHandSide<T> {
        let j = Inertia::new(*elements).matrix_kg_m2();
        RightHandSide { factored: self.sums.factor() * j, direct: -(j * self.noise_square) }
    }

    /// `S²`, kg² m⁴.
    fn prior_covariance(&self) -> Mat<T, 6, 6> {
        Mat::from_diagonal(&self.prior.sigma_kg_m2.map(|s| s * s).into())
    }

    /// Covariance, kg² m⁴, of least squares for the six elements with the prior: the directions
    /// that the data observes, whichever method is selected.
    ///
    /// `σ_row² (HᵀH)⁻¹ + A (S² + j₀ j₀ᵀ) Aᵀ`, `A = (HᵀH)⁻¹ N`, `N = n σ² diag(1 1 1 2 2 2)`
    ///
    /// `HᵀH = Σ Gᵀ(ω) G(ω)` is a sum over M, and so over the rows of its factor. As for
    /// [`regression`](crate::estimator::ekf_sgf::regression), noise in ω biases the solution by A:
    /// a direction whose excitation does not stand out of the noise keeps its prior uncertainty.
    /// The prior's covariance, where the factor is singular or a number overflows.
    pub(super) fn least_squares_covariance(&self) -> Mat<T, 6, 6> {
        let information = self.least_squares_information();
        let covariance = information.covariance_factor().and_then(|factor| {
            let factor = factor * self.row_sigma_n_m_s;
            self.with_bias(&information, factor * factor.transpose())
        });
        match covariance {
            Some(covariance) if covariance.iter().all(|x| x.is_finite()) => covariance,
            _ => self.prior_covariance(),
        }
    }

    /// Rows `G(ω)` of the motion, and one a row of the prior in units of a motion row's sigma.
    fn least_squares_information(&self) -> SquareRootInformation<T, 6> {
        let mut information = SquareRootInformation::<T, 6>::default();
        for rate in self.sums.factor().row_iter() {
            let h = regressor(&rate.transpose());
            for row in h.row_iter() {
                information.add(core::array::from_fn(|c| row[c]), T::zero());
            }
        }
        for i in 0..6 {
            let mut row = [T::zero(); 6];
            row[i] = self.row_sigma_n_m_s / self.prior.sigma_kg_m2[i];
            information.add(row, T::zero());
        }
        information
    }

    /// `covariance + A (S² + j₀ j₀ᵀ) Aᵀ`, or `None` where the factor is singular.
    fn with_bias(
        &self,
        information: &SquareRootInformation<T, 6>,
        mut covariance: Mat<T, 6, 6>,
    ) -> Option<Mat<T, 6, 6>> {
        let Prior { inertia_kg_m2: value, sigma_kg_m2: sigma } = &self.prior;
        let mut pulled = Mat::<T, 6, 1>::zeros();
        for k in 0..6 {
            let mut b = [T::zero(); 6];
            b[k] = self.noise_square * regressor_noise_share(k);
            let column = Mat::<T, 6, 1>::from(information.solve_normal(&b)?);
            pulled += column * value[k];
            let spread = column * sigma[k];
            covariance += spread * spread.transpose();
        }
        covariance += pulled * pulled.transpose();
        Some(covariance)
    }
}
