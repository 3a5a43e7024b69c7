//! Statistics of the nine-state filter on the STSAT-3 spin-up, against the Cramér-Rao bound.
//!
//! 100 flights each, seeds 0 to 99. One sigma of the RMS over 100 flights is 7 %, of the mean NEES of
//! six degrees of freedom 6 %, for a consistent filter.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

use fsw_core::Prior;
use fsw_core::estimator::joint_ekf::{AsPublished, Config, Form, JointEkf, StructuredUd};
use fsw_core::{Estimate, Estimator, Real, Sample, WheelArray};
use host_sim::campaign::{Reference, Score, Verdict, reduce};
use host_sim::input::log::LogRow;
use host_sim::input::scenario::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::Flight;

const SEEDS: std::ops::Range<u64> = 0..100;

/// Prior of the reference figures, kg m². The sigmas are about half the initial errors: the source
/// of the figures does not give them.
const PRIOR: Prior<f64> = Prior {
    inertia_kg_m2: [25.0, 25.0, 25.0, 2.0, 2.0, 2.0],
    sigma_kg_m2: [7.0, 7.0, 7.0, 1.5, 1.5, 1.5],
};

/// Statistics of 100 flights.
#[derive(Debug)]
struct Statistics {
    rms_over_bound: [f64; 6],
    bias_over_bound: [f64; 6],
    nees_per_dof: f64,
    /// Runs in `nees_per_dof`: those with a positive definite covariance.
    nees_runs: usize,
    /// Runs that did not converge, by an error above 20 bounds or by their status. They are left out of
    /// the other statistics.
    failures: usize,
}

/// Scenario and true motion of the spin-up.
struct SpinUp {
    scenario: Scenario,
    flight: Flight,
}

impl SpinUp {
    fn new() -> Self {
        let scenario = Scenario::load("stsat3-spin-up").unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        Self { scenario, flight }
    }

    fn config<T: Real>(&self, prior: Option<Prior<f64>>) -> Config<T> {
        Config {
            prior: prior.map(|p| Prior {
                inertia_kg_m2: p.inertia_kg_m2.map(T::lit),
                sigma_kg_m2: p.sigma_kg_m2.map(T::lit),
            }),
            ..Config::new(T::lit(self.scenario.gyro.noise_rad_s))
        }
    }

    /// Statistics over all seeds, printed under `name`.
    fn statistics<T: Real, F: Form<T>>(&self, name: &str, config: Config<T>) -> Statistics {
        let reference = Reference {
            truth_kg_m2: self.scenario.spacecraft.inertia_kg_m2,
            bound_kg_m2: self.flight.bound.sigma_kg_m2,
            joint_bound_kg_m2: [None; 6],
        };
        let scores: Vec<Score> = SEEDS
            .map(|seed| log_of(&self.scenario, &self.flight, seed))
            .map(|log| reference.score(&fly::<T, F>(&log, config)))
            .collect();
        let converged = |score: &&Score| score.verdict == Verdict::Converged;
        let reduced = reduce(scores.iter().filter(converged));
        let statistics = Statistics {
            rms_over_bound: reduced.rmse_over_bound.map(|rms| rms.unwrap()),
            bias_over_bound: reduced.bias_over_bound.map(|bias| bias.unwrap()),
            nees_per_dof: reduced.nees_per_dof.unwrap(),
            nees_runs: reduced.nees_runs,
            failures: scores.len() - reduced.runs,
        };
        println!("{name}: {statistics:.2?}");
        statistics
    }
}

fn fly<T: Real, F: Form<T>>(log: &[LogRow], config: Config<T>) -> Estimate<T> {
    let wheels = WheelArray::<T, 0>::new([], []).unwrap();
    let mut filter = JointEkf::<T, F, 0>::new(config, wheels).unwrap();
    for row in log {
        filter.step(&Sample {
            time_us: row.time_us,
            rate_rad_s: row.rate_rad_s.map(T::lit),
            wheel_speed_rad_s: [],
            torque_n_m: row.torque_n_m.map(T::lit),
            attitude: None,
        });
    }
    filter.estimate()
}

/// Requirements on the flight filter in either precision, for no prior, or one that contains the
/// truth within its sigma.
fn check_flight_filter(s: &Statistics) {
    /// Lower limit three sigma below the bound, upper limit of the filter's loss against the bound.
    const RMS_OVER_BOUND: std::ops::Range<f64> = 0.8..1.6;
    /// Five sigma of the mean over 100 flights, bounds.
    const BIAS_OVER_BOUND: f64 = 0.5;
    /// More than six sigma of the mean NEES over 100 flights to either side.
    const NEES_PER_DOF: std::ops::Range<f64> = 0.6..1.5;
    assert_eq!(s.failures, 0, "{s:?}");
    assert!(s.rms_over_bound.iter().all(|rms| RMS_OVER_BOUND.contains(rms)), "{s:?}");
    assert!(s.bias_over_bound.iter().all(|bias| bias.abs() < BIAS_OVER_BOUND), "{s:?}");
    assert!(NEES_PER_DOF.contains(&s.nees_per_dof), "{s:?}");
    assert_eq!(s.nees_runs, SEEDS.count(), "{s:?}");
}

#[test]
fn flight_filter_is_consistent_without_prior_in_single_precision() {
    let spin_up = SpinUp::new();
    check_flight_filter(
        &spin_up.statistics::<f32, StructuredUd<f32>>("f32, no prior", spin_up.config(None)),
    );
}

#[test]
fn flight_filter_is_consistent_without_prior_in_double_precision() {
    let spin_up = SpinUp::new();
    check_flight_filter(
        &spin_up.statistics::<f64, StructuredUd<f64>>("f64, no prior", spin_up.config(None)),
    );
}

#[test]
fn flight_filter_is_consistent_with_a_vague_prior() {
    let spin_up = SpinUp::new();
    let sigma_kg_m2 = [30.0, 30.0, 30.0, 10.0, 10.0, 10.0];
    let config = spin_up.config(Some(Prior { sigma_kg_m2, ..PRIOR }));
    check_flight_filter(&spin_up.statistics::<f32, StructuredUd<f32>>("f32, vague prior", config));
}

/// The extended filter without alignment, linearised about its prior from the first sample on.
fn unaligned(name: &str, rate_walk_rad_s_sqrt_s: f64) -> Statistics {
    let spin_up = SpinUp::new();
    let config = spin_up.config::<f64>(Some(PRIOR));
    let config = Config { align_above: f64::MAX, rate_walk_rad_s_sqrt_s, ..config };
    spin_up.statistics::<f64, StructuredUd<f64>>(name, config)
}

fn largest_bias(s: &Statistics) -> f64 {
    s.bias_over_bound.iter().fold(0.0, |largest, b| b.abs().max(largest))
}

/// Checks the RMS errors against documented ones, which are those of 60 to 200 runs.
fn check_rms(s: &Statistics, documented: [f64; 6]) {
    /// Three sigma of the ratio of two such RMS errors.
    const RATIO: std::ops::Range<f64> = 0.75..1.25;
    for i in 0..6 {
        let ratio = s.rms_over_bound[i] / documented[i];
        assert!(RATIO.contains(&ratio), "element {i}: {s:?}");
    }
}

#[test]
fn unaligned_filter_without_process_noise_is_biased_and_overconfident() {
    let s = unaligned("unaligned, no process noise", 0.0);
    check_rms(&s, [1.06, 1.05, 1.05, 1.82, 1.27, 2.15]);
    assert_eq!(s.failures, 0, "{s:?}");
    // Documented: bias up to 1.7 bounds, NEES 6 to 8 per degree of freedom.
    assert!((1.4..2.1).contains(&largest_bias(&s)), "{s:?}");
    assert!((5.0..12.0).contains(&s.nees_per_dof), "{s:?}");
}

#[test]
fn small_process_noise_makes_the_unaligned_filter_less_overconfident() {
    let s = unaligned("unaligned, a little process noise", 3.0e-7);
    // Documented: bias up to 1.6 bounds, NEES 2.6, one run in a hundred diverges.
    assert!(s.failures <= 3, "{s:?}");
    assert!((1.2..1.9).contains(&largest_bias(&s)), "{s:?}");
    assert!((1.8..4.0).contains(&s.nees_per_dof), "{s:?}");
}

#[test]
fn larger_process_noise_makes_the_unaligned_filter_underconfident() {
    let s = unaligned("unaligned, more process noise", 1.0e-6);
    check_rms(&s, [1.4, 1.5, 1.4, 1.4, 1.1, 1.5]);
    assert_eq!(s.failures, 0, "{s:?}");
    // Documented: bias up to 1.2 bounds, NEES 0.5.
    assert!(largest_bias(&s) < 1.2, "{s:?}");
    assert!((0.35..0.75).contains(&s.nees_per_dof), "{s:?}");
}

#[test]
fn printed_form_loses_its_covariance_in_single_precision() {
    let spin_up = SpinUp::new();
    let noise = spin_up.scenario.gyro.noise_rad_s;
    let double = Config::bellar_2019(noise);
    let double = spin_up.statistics::<f64, AsPublished<f64>>("as printed, f64", double);
    let single = Config::bellar_2019(noise as f32);
    let single = spin_up.statistics::<f32, AsPublished<f32>>("as printed, f32", single);
    assert!(double.failures <= 3, "{double:?}");
    // (1 − K H) P loses definiteness in f32. The UD form, which flies, does not.
    assert!(single.failures >= 10, "{single:?}");
}
