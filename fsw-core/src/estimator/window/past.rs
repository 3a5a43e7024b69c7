//! What is known of the inertia from before a window: a prior, or earlier windows.
//!
//! Kept as information of unit variance, and walked forward in time by the random walk that a slow
//! change (fuel) is taken for.

use crate::math::scalar::Real;
use crate::math::square_root_information::SquareRootInformation;
use crate::prior::Prior;

/// Information on the six elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past<T: Real> {
    /// j₀, kg m².
    pub inertia_kg_m2: [T; 6],
    /// `R (j − j₀) = d`, R in 1/(kg m²).
    pub information: SquareRootInformation<T, 6>,
}

crate::persist!([T: Real] Past<T> { inertia_kg_m2, information });

impl<T: Real> Past<T> {
    /// Of a prior.
    pub fn from_prior(prior: &Prior<T>) -> Self {
        let mut information = SquareRootInformation::default();
        for i in 0..6 {
            let mut row = [T::zero(); 6];
            row[i] = T::one() / prior.sigma_kg_m2[i];
            information.add(row, T::zero());
        }
        Self { inertia_kg_m2: prior.inertia_kg_m2, information }
    }

    /// After a random walk of one sigma (kg m²) of each element.
    pub fn walk(&mut self, sigma_kg_m2: T) {
        if sigma_kg_m2 > T::zero() {
            for i in 0..6 {
                self.information.walk(i, sigma_kg_m2 * sigma_kg_m2);
            }
        }
    }

    /// The elements by this alone, kg m²; `None` where a direction is unknown.
    pub fn inertia(&self) -> Option<[T; 6]> {
        let step = self.information.solve()?;
        Some(core::array::from_fn(|i| self.inertia_kg_m2[i] + step[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat;

    const PRIOR: Prior<f64> = Prior {
        inertia_kg_m2: [2.0, 3.0, 4.0, 0.1, -0.1, 0.2],
        sigma_kg_m2: [0.1, 0.2, 0.3, 0.01, 0.02, 0.03],
    };

    fn solve(past: &Past<f64>) -> ([f64; 6], Mat<f64, 6, 6>) {
        (past.inertia().unwrap(), past.information.covariance().unwrap())
    }

    #[test]
    fn a_prior_is_what_it_says() {
        let (inertia, covariance) = solve(&Past::from_prior(&PRIOR));
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
            let row = core::array::from_fn(|k| 3.0 * ((7 * i + k) as f64).sin());
            past.information.add(row, 0.5 - i as f64);
        }
        let (before, covariance) = solve(&past);
        past.walk(0.05);
        let (after, walked) = solve(&past);
        let expected = covariance + Mat::<f64, 6, 6>::identity() * (0.05 * 0.05);
        assert!((walked - expected).abs().max() < 1e-12);
        for i in 0..6 {
            assert!((before[i] - after[i]).abs() < 1e-12);
        }
    }
}
