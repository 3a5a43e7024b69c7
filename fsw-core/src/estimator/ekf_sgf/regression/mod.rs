//! Inertia from rates, accelerations and torques of the same instants, by linear least squares:
//! \[Kim2013\] (recursive, three moments), \[Kim2016\] Eqs. (3) to (6) (batch, six elements).
//!
//! `[G(ω̇) + ω^× G(ω)] j = τ − ḣ_w − ω × h_w`
//!
//! gives three rows `H j = y` an instant (N m). Input: [`Instant`]s. Output: a [`Solution`].
//!
//! Both papers' estimators are the same sums solved at different times, so both are accumulated as
//! one square-root information factor R of `HᵀH = RᵀR`: no stored history, and no normal matrix,
//! which in single precision would lose weakly excited directions. Recursive least squares in
//! the covariance form of \[Kim2013\] has the same solution (tested). With the moments first among
//! the elements, fixing the products needs no sums of its own.
//!
//! Departures from the papers: rows are weighted by the noise of their own acceleration; the prior
//! (`P₀` of \[Kim2013\]) joins when solving, so that it neither fades under a forgetting factor nor
//! lets the covariance of a direction without data wind up. \[Kim2016\] has no prior: the one here
//! shifts a direction by `(σ_data / σ_prior)²` of the distance between the two.

mod solve;
#[cfg(test)]
mod tests;
mod unobserved;

use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::prior::Prior;
use crate::tensor::{Inertia, gyroscopic_regressor, regressor};

/// Largest sum of absolute values of weighted rows (sigmas). No flight data comes near it; beyond,
/// the squares overflow single precision.
const LARGEST_IN_SIGMAS: f64 = 1.0e15;

/// Unknowns of the regression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Elements {
    /// The three moments, with the products at their nominal values: \[Kim2013\].
    Moments,
    /// All six elements: \[Kim2016\].
    All,
}

crate::persist!([] enum Elements { 0 => Moments, 1 => All });

/// Terms of the equation at one instant, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<T: Real> {
    /// Body rate ω, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Its derivative ω̇, rad/s².
    pub acceleration_rad_s2: Vec3<T>,
    /// Torque on the body, `τ − ḣ_w − ω × h_w`, N m.
    pub torque_n_m: Vec3<T>,
    /// One sigma of the noise in each axis of the acceleration, rad/s², above zero.
    pub acceleration_sigma_rad_s2: T,
    /// Known error of the equation from another cause than that noise, N m: the lag of the filtered
    /// rate. It is not corrected; its effect joins the covariance.
    pub imbalance_n_m: Vec3<T>,
}

crate::persist!([T: Real] Instant<T> {
    rate_rad_s, acceleration_rad_s2, torque_n_m, acceleration_sigma_rad_s2, imbalance_n_m
});

/// Sums over instants, rows in units of their own sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regression<T: Real> {
    /// R and `R⁻ᵀ Hᵀ y`.
    information: SquareRootInformation<T, 6>,
    /// Typical nominal moment, `√(tr(J₀²) / 3)`: acceleration noise times this is the noise of a
    /// row.
    moment_kg_m2: T,
    /// Instants, weighted by the forgetting: not a whole number.
    instants: T,
    /// `Σ r²` of the recursive residuals, in sigmas squared.
    residual_square: T,
    /// `Hᵀ b`, b the imbalance.
    imbalance: [T; 6],
}

crate::persist!([T: Real] Regression<T> {
    information, moment_kg_m2, instants, residual_square, imbalance
});

/// Solution of the regression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// Inertia, kg m², nominal in unobserved directions.
    pub inertia: Inertia<T>,
    /// Covariance of the six elements, kg² m⁴. [`Regression::solve`] lists its terms.
    pub covariance_kg2_m4: Mat<T, 6, 6>,
}

impl<T: Real> Regression<T> {
    /// Empty sums. `nominal` sets the typical moment.
    pub fn new(nominal: &Prior<T>) -> Self {
        let j = Inertia::new(nominal.inertia_kg_m2).matrix_kg_m2();
        Self {
            information: SquareRootInformation::default(),
            moment_kg_m2: (j.dot(&j) * T::lit(1.0 / 3.0)).sqrt(),
            instants: T::zero(),
            residual_square: T::zero(),
            imbalance: [T::zero(); 6],
        }
    }

    /// Multiplies the weight of all instants before the next by `forgetting`, above 0 up to 1:
    /// `HᵀH ← λ HᵀH`. 1 keeps all, \[Kim2013\].
    pub fn forget(&mut self, forgetting: T) {
        if forgetting == T::one() {
            return;
        }
        self.information.forget(forgetting);
        self.instants *= forgetting;
        self.residual_square *= forgetting;
        self.imbalance = self.imbalance.map(|x| x * forgetting);
    }

    /// Adds one instant: rows `H = G(ω̇) + ω^× G(ω)` and right-hand sides `y` of
    /// \[Kim2016\] Eqs. (3) to (5), divided by `σ_row = σ_ω̇ · moment` (N m).
    ///
    /// `false`, without effect, where a number is not finite or so large that its square overflows.
    pub fn add(&mut self, instant: &Instant<T>) -> bool {
        let weight = T::one() / (instant.acceleration_sigma_rad_s2 * self.moment_kg_m2);
        let h = (regressor(&instant.acceleration_rad_s2)
            + gyroscopic_regressor(&instant.rate_rad_s))
            * weight;
        let y = instant.torque_n_m * weight;
        let imbalance = instant.imbalance_n_m * weight;
        let is_in_range = sum_of_sizes(&h) + sum_of_sizes(&y) + sum_of_sizes(&imbalance)
            < T::lit(LARGEST_IN_SIGMAS);
        if !is_in_range {
            return false;
        }
        for r in 0..3 {
            let row = core::array::from_fn(|c| h[(r, c)]);
            let residual = self.information.add_weighted(&row, y[r], T::one());
            self.residual_square += residual.square();
            for c in 0..6 {
                self.imbalance[c] += h[(r, c)] * imbalance[r];
            }
        }
        self.instants += T::one();
        true
    }
}

/// `Σ |mᵢₖ|`; NaN where an element is NaN.
fn sum_of_sizes<T: Real, const R: usize, const C: usize>(m: &Mat<T, R, C>) -> T {
    let mut sum = T::zero();
    for r in 0..R {
        for c in 0..C {
            sum += m[(r, c)].abs();
        }
    }
    sum
}
