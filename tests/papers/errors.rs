//! Estimation errors of a built-in scenario over seeds, and their statistics.

use host_sim::estimation::{EstimatorName, Precision, Setup, estimate_log, set_up};
use host_sim::input::scenario::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::Flight;

const SEEDS: std::ops::Range<u64> = 0..40;
/// Difference of two times that counts as the same sample, s. The sampling interval is 0.1 s.
const SAME_TIME_S: f64 = 1e-9;

/// A built-in scenario and its true motion.
pub fn flight(name: &str) -> (Scenario, Flight) {
    let scenario = Scenario::load(name).unwrap();
    let flight = Flight::simulate(&scenario).unwrap();
    (scenario, flight)
}

/// Relative errors of the six elements, per cent, at the times `at_s`, for each seed.
pub fn errors_percent(name: &str, estimator: EstimatorName, at_s: &[f64]) -> Vec<Vec<[f64; 6]>> {
    let (scenario, flight) = flight(name);
    let craft = scenario.craft();
    let truth = scenario.spacecraft.inertia_kg_m2;
    let errors_of_seed = |seed| {
        let estimator = set_up(&Setup {
            estimator,
            precision: Precision::F32,
            craft: &craft,
            gyro_noise_rad_s: Some(scenario.gyro.noise_rad_s),
            sample_period_s: 1.0 / scenario.gyro.rate_hz,
            refuse_spikes: true,
        })
        .unwrap();
        let mut errors = Vec::new();
        estimate_log(&log_of(&scenario, &flight, seed), estimator, |row, _, estimator| {
            if at_s.iter().any(|at| (row.time_us as f64 * 1e-6 - at).abs() < SAME_TIME_S) {
                let found = estimator.estimate().inertia.elements_kg_m2();
                errors.push(std::array::from_fn(|i| 100.0 * (found[i] / truth[i] - 1.0)));
            }
        });
        errors
    };
    SEEDS.map(errors_of_seed).collect()
}

/// Mean.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), x| (count + 1.0, sum + x));
    sum / count
}

/// Root mean square.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|x| x * x)).sqrt()
}
