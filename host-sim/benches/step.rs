//! Time of a step on a PC: the estimators over a simulated flight, and dense Kalman filters of other crates.
//!
//! ```bash
//! cargo bench -p host-sim --bench step
//! ```
//!
//! The flight is `stsat3-spin-up`. An estimator's step is all of it: checks, prediction, update, and for `window` its
//! slices of work. The filters of other crates propagate a covariance of nine states and update it with three
//! measurements; they have no dynamics and no checks.

#![allow(clippy::unwrap_used, reason = "a benchmark ends with the reason")]

use std::sync::LazyLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use fsw_core::Mat;
use host_sim::estimation::{AnyEstimator, EstimatorName, Precision, Setup, estimate_log, set_up};
use host_sim::input::Craft;
use host_sim::input::log::LogRow;
use host_sim::input::scenario::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::Flight;
use nalgebra::{Matrix3, SVector};

/// Steps of a filter in one sample of the benchmark.
const STEPS: usize = 1000;

fn main() {
    divan::main();
}

/// The flight, with the noise of seed 0.
static FLIGHT: LazyLock<(Scenario, Vec<LogRow>)> = LazyLock::new(|| {
    let scenario = Scenario::load("stsat3-spin-up").unwrap();
    let flight = Flight::simulate(&scenario).unwrap();
    let log = log_of(&scenario, &flight, 0);
    (scenario, log)
});

fn estimator(name: &str, craft: &Craft) -> Box<dyn AnyEstimator> {
    let setup = Setup {
        estimator: EstimatorName::from_name(name).unwrap(),
        precision: Precision::F32,
        craft,
        gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
        sample_period_s: 0.1,
        refuse_spikes: true,
    };
    set_up(&setup).unwrap()
}

/// Steps per second over the whole flight, the work at its end included.
#[divan::bench(args = ["window", "joint-ekf", "joint-ekf-published", "ekf-sgf-rls"], sample_count = 20)]
fn estimators(bencher: Bencher, name: &str) {
    let (scenario, log) = &*FLIGHT;
    let craft = scenario.craft();
    bencher
        .counter(ItemsCount::new(log.len()))
        .with_inputs(|| estimator(name, &craft))
        .bench_local_values(|estimator| {
            estimate_log(black_box(log), estimator, |_, _, _| ()).counts
        });
}

/// Transition, noise and first covariance of the spin-up: rates that depend on the inertia by its regressor.
fn problem() -> fsw_peers::Problem {
    let mut transition = Mat::<f32, 9, 9>::identity();
    transition.fixed_view_mut::<3, 3>(0, 3).copy_from(&(Matrix3::identity() * 1e-5));
    fsw_peers::Problem {
        transition,
        process_noise: Mat::identity() * 1e-12,
        sigma: [1e-3, 1e-3, 1e-3, 10.0, 10.0, 10.0, 2.0, 2.0, 2.0],
        measurement_noise: 1.8151e-4,
    }
}

/// Covariance of other crates, steps per second.
#[divan::bench(args = ["dense-nalgebra", "adskalman", "adskalman-joseph", "minikalman"], sample_count = 20)]
fn covariance(bencher: Bencher, name: &str) {
    let problem = problem();
    let measured = SVector::<f32, 3>::from_element(1e-4);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        fsw_peers::each(&problem, &mut |found, filter| {
            if found == name {
                (0..STEPS).for_each(|_| filter.step(black_box(&measured)));
            }
        });
    });
}
