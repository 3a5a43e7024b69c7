//! What the elements are worth: noise, what noise in the regressor does, what a method neglects.
//!
//! With `Q = J (ω − v)` for gyro noise v, a method that is linear in B (see
//! [`formulas`](super::formulas)) and given `M = Σ ω ωᵀ` finds, of a true tensor J,
//!
//! `ĵ = f(M J − Σ ω vᵀ J)`, `E[Σ ω vᵀ] = n σ² 1`.
//!
//! So `f((M − n σ² 1) J) − j` is its systematic error: the pull of noise towards zero and all that
//! it neglects, for whatever M the motion made. It is linear in the unknown j, and its second
//! moment follows from what is believed of j beforehand, `j₀ ± S`. The rest of `Σ ω vᵀ J` has rows
//! of covariance `σ² |J|² M` and goes through the same formula.

use super::formulas::{Formulas, Method, RightHandSide};
use super::sums::Sums;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, scalar::Real};
use crate::prior::Prior;
use crate::tensor::{Inertia, regressor};

/// `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)` for white v of σ on each axis.
const NOISE_SHARE: [f64; 6] = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0];

/// What can be said of the elements for given sums and gyro noise.
pub(super) struct Worth<T: Real> {
    sums: Sums<T>,
    formulas: Formulas<T>,
    believed: Prior<T>,
    /// `n σ²`, rad²/s².
    noise_square: T,
    /// One sigma of a row of `J ω = Q`, N m s.
    row_sigma_n_m_s: T,
}

impl<T: Real> Worth<T> {
    pub(super) fn new(sums: &Sums<T>, noise_rad_s: T, prior: Option<&Prior<T>>) -> Self {
        let size = sums.size_kg_m2(noise_rad_s);
        let believed = match (prior, size) {
            (Some(prior), _) => *prior,
            (None, Some(size)) => Prior::of_size(size),
            (None, None) => Prior::unknown(),
        };
        let j = Inertia::new(believed.inertia_kg_m2).matrix_kg_m2();
        let moment = (j.dot(&j) * T::lit(1.0 / 3.0)).sqrt().max(size.unwrap_or(T::zero()));
        let noise = sums.residual_rms_rad_s().max(noise_rad_s);
        Self {
            sums: *sums,
            formulas: Formulas::new(sums, noise_rad_s),
            believed,
            noise_square: sums.noise_square(noise_rad_s),
            row_sigma_n_m_s: moment * noise,
        }
    }

    /// What is believed beforehand, or of a body of this size.
    pub(super) fn believed(&self) -> &Prior<T> {
        &self.believed
    }

    /// The method's elements, kg m², and the second moment of their error, kg² m⁴.
    pub(super) fn of(&self, method: Method) -> ([T; 6], Mat<T, 6, 6>) {
        let Prior { inertia_kg_m2: value, sigma_kg_m2: sigma } = &self.believed;
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
        let expected = solve(&self.expected_of(value));
        add(core::array::from_fn(|i| expected[i].map_or(T::zero(), |x| x - value[i])));
        for k in 0..6 {
            let unit: [T; 6] = core::array::from_fn(|i| if i == k { sigma[k] } else { T::zero() });
            let expected = solve(&self.expected_of(&unit));
            add(core::array::from_fn(|i| expected[i].unwrap_or(T::zero()) - unit[i]));
        }
        for (row, k) in (0..9).map(|i| (i / 3, i % 3)) {
            let mut noise = RightHandSide { factored: Mat::zeros(), direct: Mat::zeros() };
            noise.factored[(k, row)] = self.row_sigma_n_m_s;
            add(solve(&noise).map(|x| x.unwrap_or(T::zero())));
        }
        let is_finite = elements.iter().chain(second_moment.iter()).all(|x| x.is_finite());
        if is_finite { (elements, second_moment) } else { (*value, self.believed_covariance()) }
    }

    /// `(M − n σ² 1) J`: what B is expected to be for the tensor of these elements.
    fn expected_of(&self, elements: &[T; 6]) -> RightHandSide<T> {
        let j = Inertia::new(*elements).matrix_kg_m2();
        RightHandSide { factored: self.sums.factor() * j, direct: -(j * self.noise_square) }
    }

    fn believed_covariance(&self) -> Mat<T, 6, 6> {
        Mat::from_diagonal(&self.believed.sigma_kg_m2.map(|s| s * s).into())
    }

    /// Covariance, kg² m⁴, of least squares for the six elements, with what is believed: what the
    /// data could show, whichever method is asked for.
    ///
    /// `Σ Gᵀ(ω) G(ω)` is a sum over `M = Σ ω ωᵀ`, and so over the rows of its factor. As for
    /// [`regression`](crate::estimator::ekf_sgf::regression), noise in ω pulls the solution by
    /// `A = (HᵀH)⁻¹ N`, N its expected share, and adds `A (S² + j₀ j₀ᵀ) Aᵀ`: a direction whose
    /// excitation doesn't stand out of the noise is as uncertain as it was.
    pub(super) fn covariance_of_the_best(&self) -> Mat<T, 6, 6> {
        let Prior { inertia_kg_m2: value, sigma_kg_m2: sigma } = &self.believed;
        let mut information = SquareRootInformation::<T, 6>::default();
        for rate in self.sums.factor().row_iter() {
            let h = regressor(&rate.transpose());
            for row in h.row_iter() {
                information.add(core::array::from_fn(|c| row[c]), T::zero());
            }
        }
        for i in 0..6 {
            let mut row = [T::zero(); 6];
            row[i] = self.row_sigma_n_m_s / sigma[i];
            information.add(row, T::zero());
        }
        let Some(factor) = information.covariance_factor() else {
            return self.believed_covariance();
        };
        let factor = factor * self.row_sigma_n_m_s;
        let mut covariance = factor * factor.transpose();
        let mut pulled = Mat::<T, 6, 1>::zeros();
        for k in 0..6 {
            let mut b = [T::zero(); 6];
            b[k] = self.noise_square * T::lit(NOISE_SHARE[k]);
            let Some(column) = information.solve_normal(&b) else {
                return self.believed_covariance();
            };
            let column = Mat::<T, 6, 1>::from(column);
            pulled += column * value[k];
            let spread = column * sigma[k];
            covariance += spread * spread.transpose();
        }
        covariance += pulled * pulled.transpose();
        if covariance.iter().all(|x| x.is_finite()) {
            covariance
        } else {
            self.believed_covariance()
        }
    }
}
