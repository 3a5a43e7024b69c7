//! Samples of the prior: for the objective, and for the proof that no limit is exceeded.
//!
//! The prior is the box of two sigma about its mean, confined to inertias of rigid bodies that carry the
//! wheels. Limits hold throughout. The motion is proportional to the inverse of the inertia, a convex
//! function, so that excursion and rate are largest on the boundary of the box: the proof flies its 64
//! vertices, each drawn towards the mean until it is physical, and random samples.

use flight_input::inertia::{is_physical, principal_moments, tensor};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::problem::{DesignError, Problem};

/// Half width of the box, sigmas.
pub const BOX_SIGMAS: f64 = 2.0;
/// Random samples of the proof besides the vertices.
const RANDOM: usize = 64;
/// Attempts to draw a physical inertia.
const ATTEMPTS: usize = 10_000;
/// Halvings of the distance from the mean to a vertex.
const HALVINGS: usize = 20;
/// Least smallest moment without wheels over that of the mean: the excursion is then at most ten times
/// that of the mean.
const LEAST_MOMENT: f64 = 0.1;

impl Problem {
    /// True if the inertia is known.
    pub(super) fn is_known(&self) -> bool {
        self.prior.sigma_kg_m2 == [0.0; 6]
    }

    /// A rigid body that carries the wheels.
    pub(super) fn is_possible(&self, inertia_kg_m2: &[f64; 6]) -> bool {
        let smallest = |elements: &[f64; 6]| {
            let rest = self.wheels.iter().fold(tensor(elements), |j, wheel| {
                j - wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2
            });
            principal_moments(&rest)[0]
        };
        is_physical(&principal_moments(&tensor(inertia_kg_m2)))
            && smallest(inertia_kg_m2) > LEAST_MOMENT * smallest(&self.prior.inertia_kg_m2)
    }

    /// This number of samples of the prior, the first the mean; one if it is known.
    pub(super) fn samples(&self, count: usize, seed: u64) -> Result<Vec<[f64; 6]>, DesignError> {
        let mean = self.prior.inertia_kg_m2;
        if !self.is_possible(&mean) {
            return Err(DesignError::PriorTooWide);
        }
        let mut samples = vec![mean];
        let count = if self.is_known() { 1 } else { count };
        let mut random = Pcg64::seed_from_u64(seed);
        for _ in 1..count {
            let drawn = (0..ATTEMPTS).map(|_| self.draw(&mut random));
            let possible = drawn.into_iter().find(|sample| self.is_possible(sample));
            samples.push(possible.ok_or(DesignError::PriorTooWide)?);
        }
        Ok(samples)
    }

    /// A normal sample of each element within the box.
    fn draw(&self, random: &mut Pcg64) -> [f64; 6] {
        let mut normal = || loop {
            // Sum of twelve uniform numbers: normal within the box.
            let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            if sum.abs() <= BOX_SIGMAS {
                break sum;
            }
        };
        let Self { prior, .. } = self;
        std::array::from_fn(|i| prior.inertia_kg_m2[i] + normal() * prior.sigma_kg_m2[i])
    }

    /// Inertias of the proof: mean, vertices of the box, random samples.
    pub(super) fn extremes(&self, seed: u64) -> Result<Vec<[f64; 6]>, DesignError> {
        // Other draws than those of the objective.
        let mut all = self.samples(1 + RANDOM, !seed)?;
        if !self.is_known() {
            all.extend((0..64).map(|corner| self.vertex(corner)));
        }
        Ok(all)
    }

    fn vertex(&self, corner: usize) -> [f64; 6] {
        let at = |share: f64| -> [f64; 6] {
            std::array::from_fn(|i| {
                let sign = if corner >> i & 1 == 0 { -1.0 } else { 1.0 };
                self.prior.inertia_kg_m2[i] + sign * share * BOX_SIGMAS * self.prior.sigma_kg_m2[i]
            })
        };
        let (mut inside, mut step) = (0.0, 1.0);
        if self.is_possible(&at(1.0)) {
            return at(1.0);
        }
        for _ in 0..HALVINGS {
            step /= 2.0;
            if self.is_possible(&at(inside + step)) {
                inside += step;
            }
        }
        at(inside)
    }
}
