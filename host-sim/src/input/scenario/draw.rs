//! The scenario of one run of a campaign, drawn from the run's seed alone: `run --seed` repeats it.

use flight_input::craft::InitialEstimate;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::definition::Scenario;
use super::dispersion::InitialSpread;
use super::random_draw;

/// Offset into the random sequence of a seed, beyond the part that the gyro noise of the same seed
/// uses.
const BEYOND_THE_GYRO: u128 = 1 << 64;

impl Scenario {
    /// The scenario with true spacecraft number `index` of its [`Dispersion`](super::Dispersion).
    pub fn of_truth(&self, index: usize) -> Self {
        let mut scenario = self.clone();
        if let Some(factor) = self.dispersion.inertia_factors.get(index) {
            let scale = |elements: &mut [f64; 6]| *elements = elements.map(|j| j * factor);
            scale(&mut scenario.spacecraft.inertia_kg_m2);
            scenario.changes.sudden.iter_mut().for_each(|change| scale(&mut change.inertia_kg_m2));
        }
        scenario
    }

    /// The scenario of the run with this seed.
    pub fn of_seed(&self, seed: u64) -> Self {
        if let Some(random) = &self.dispersion.spacecraft {
            return Self {
                solve_for: self.solve_for,
                disturbance_torque_n_m: self.disturbance_torque_n_m,
                ..random_draw::scenario(random, &self.name, seed)
            }
            .with_drawn_hardware(seed);
        }
        let mut scenario = self.of_truth(self.dispersion.truth_of(seed));
        let spread = &self.dispersion.initial_estimate;
        scenario.initial_estimate = spread.as_ref().map(|spread| initial_estimate(spread, seed));
        scenario.with_drawn_hardware(seed)
    }
}

fn initial_estimate(spread: &InitialSpread, seed: u64) -> InitialEstimate {
    let mut random = Pcg64::seed_from_u64(seed);
    random.advance(BEYOND_THE_GYRO);
    let mut within = |half_width: f64| half_width * (2.0 * random.random::<f64>() - 1.0);
    let rate_rad_s = std::array::from_fn(|_| within(spread.rate_rad_s));
    let inertia_kg_m2 = std::array::from_fn(|i| {
        within(if i < 3 { spread.moments_kg_m2 } else { spread.products_kg_m2 })
    });
    InitialEstimate {
        rate_rad_s: rate_rad_s.into(),
        rate_sigma_rad_s: spread.rate_sigma_rad_s,
        inertia_kg_m2,
        sigma_kg_m2: spread.sigma_kg_m2,
    }
}
