//! What is known of the inertia from before a window: a prior, or earlier windows.
//!
//! Kept as rows of information of unit variance, `R (j − j₀) − y`, and walked forward in time by the
//! random walk that a slow change (fuel) is taken for.

use crate::estimator::Prior;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, scalar::Real};

/// Information on the six elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past<T: Real> {
    /// j₀, kg m².
    pub inertia_kg_m2: [T; 6],
    /// R, upper triangular, 1/(kg m²).
    pub rows: [[T; 6]; 6],
    /// y.
    pub right: [T; 6],
}

impl<T: Real> Past<T> {
    /// Of a prior.
    pub fn from_prior(prior: &Prior<T>) -> Self {
        let mut rows = [[T::zero(); 6]; 6];
        for i in 0..6 {
            rows[i][i] = T::one() / prior.sigma_kg_m2[i];
        }
        Self { inertia_kg_m2: prior.inertia_kg_m2, rows, right: [T::zero(); 6] }
    }

    /// After a random walk of one sigma (kg m²) of each element.
    ///
    /// With the change as a further unknown: `R (j₁ − x) = y` and `x / σ = 0`. Triangularised with
    /// j₁ last, the last rows are the information on it.
    pub fn walked(&self, sigma_kg_m2: T) -> Self {
        if sigma_kg_m2 <= T::zero() {
            return *self;
        }
        let mut both = SquareRootInformation::<T, 12>::default();
        for i in 0..6 {
            let mut still = [T::zero(); 12];
            still[i] = T::one() / sigma_kg_m2;
            both.add(still, T::zero());
            let mut row = [T::zero(); 12];
            for c in 0..6 {
                row[c] = -self.rows[i][c];
                row[6 + c] = self.rows[i][c];
            }
            both.add(row, self.right[i]);
        }
        let mut walked = *self;
        for (i, (row, y)) in both.equations().iter().skip(6).enumerate() {
            walked.rows[i] = core::array::from_fn(|c| row[6 + c]);
            walked.right[i] = *y;
        }
        walked
    }

    /// The elements by this alone, kg m², and their covariance, kg² m⁴; `None` where a direction is
    /// unknown.
    pub fn solve(&self) -> Option<([T; 6], Mat<T, 6, 6>)> {
        let mut information = SquareRootInformation::<T, 6>::default();
        for i in 0..6 {
            information.add(self.rows[i], self.right[i]);
        }
        let step = information.solve()?;
        let factor = information.covariance_factor()?;
        let inertia = core::array::from_fn(|i| self.inertia_kg_m2[i] + step[i]);
        Some((inertia, factor * factor.transpose()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: Prior<f64> = Prior {
        inertia_kg_m2: [2.0, 3.0, 4.0, 0.1, -0.1, 0.2],
        sigma_kg_m2: [0.1, 0.2, 0.3, 0.01, 0.02, 0.03],
    };

    #[test]
    fn a_prior_is_what_it_says() {
        let (inertia, covariance) = Past::from_prior(&PRIOR).solve().unwrap();
        assert_eq!(inertia, PRIOR.inertia_kg_m2);
        for i in 0..6 {
            assert!((covariance[(i, i)].sqrt() / PRIOR.sigma_kg_m2[i] - 1.0).abs() < 1e-12);
        }
    }

    /// Against the sum of covariances, with elements that are correlated and an estimate that isn't
    /// the point of reference.
    #[test]
    fn a_walk_adds_to_the_covariance_and_moves_nothing() {
        let mut past = Past::from_prior(&PRIOR);
        for i in 0..6 {
            for k in i + 1..6 {
                past.rows[i][k] = 3.0 * ((7 * i + k) as f64).sin();
            }
            past.right[i] = 0.5 - i as f64;
        }
        let (before, covariance) = past.solve().unwrap();
        let (after, walked) = past.walked(0.05).solve().unwrap();
        let expected = covariance + Mat::<f64, 6, 6>::identity() * (0.05 * 0.05);
        assert!((walked - expected).abs().max() < 1e-12);
        for i in 0..6 {
            assert!((before[i] - after[i]).abs() < 1e-12);
        }
    }
}
