//! What the chains of \[Kim2013\] and \[Kim2016\] make of their papers' own flights, beside what was
//! published. Seeds are fixed, and the figures printed: `cargo test -p tests --test ekf_sgf -- --nocapture`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use fsw_core::Prior;
use fsw_core::estimator::ekf_sgf::rate_ekf;
use fsw_core::estimator::ekf_sgf::{Config, EkfSgf};
use fsw_core::math::savgol::Fit;
use fsw_core::{Estimator, Sample, Vec3, WheelArray};
use host_sim::estimation::{EstimatorName, Precision, Setup, estimate_log, set_up};
use host_sim::input::scenario::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::{Flight, Instant};

const SEEDS: std::ops::Range<u64> = 0..40;

fn flight(name: &str) -> (Scenario, Flight) {
    let scenario = Scenario::load(name).unwrap();
    let flight = Flight::simulate(&scenario).unwrap();
    (scenario, flight)
}

/// Relative errors of the six elements, per cent, at each of these times: flight by flight.
fn errors_percent(name: &str, estimator: EstimatorName, at_s: &[f64]) -> Vec<Vec<[f64; 6]>> {
    let (scenario, flight) = flight(name);
    let craft = scenario.craft();
    let truth = scenario.spacecraft.inertia_kg_m2;
    let one = |seed| {
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
            if at_s.iter().any(|at| (row.time_us as f64 * 1e-6 - at).abs() < 1e-9) {
                let found = estimator.estimate().inertia.elements_kg_m2();
                errors.push(std::array::from_fn(|i| 100.0 * (found[i] / truth[i] - 1.0)));
            }
        });
        errors
    };
    SEEDS.map(one).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), x| (count + 1.0, sum + x));
    sum / count
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|x| x * x)).sqrt()
}

#[test]
fn kim_2013_errors_are_at_most_the_published_ones_and_end_near_them() {
    const AT_S: [f64; 6] = [100.0, 200.0, 300.0, 400.0, 500.0, 600.0];
    // Mean size of the error over 10,000 runs, per cent.
    const PUBLISHED: [[f64; 3]; 6] = [
        [10.50, 11.57, 8.30],
        [5.05, 6.64, 6.43],
        [4.78, 5.56, 5.43],
        [5.84, 5.16, 5.32],
        [5.60, 4.63, 4.76],
        [2.84, 2.89, 2.84],
    ];
    let flights = errors_percent("kim-2013", EstimatorName::EkfSgfRls, &AT_S);
    for (k, published) in PUBLISHED.iter().enumerate() {
        let size = |i: usize| mean(flights.iter().map(|errors| errors[k][i].abs()));
        let spread = |i: usize| {
            let middle = mean(flights.iter().map(|errors| errors[k][i]));
            rms(flights.iter().map(|errors| errors[k][i] - middle))
        };
        let (sizes, spreads) = ([0, 1, 2].map(size), [0, 1, 2].map(spread));
        println!("{:3.0} s: {sizes:.2?} %, sd {spreads:.2?}; published {published:.2?}", AT_S[k]);
        // Never worse than published, and at the end no more than a percentage point away.
        assert!((0..3).all(|i| sizes[i] < published[i] + 0.1), "{sizes:?}");
        if k == 5 {
            assert!((0..3).all(|i| (sizes[i] - published[i]).abs() < 1.0), "{sizes:?}");
        }
    }
}

#[test]
fn kim_2016_estimates_are_distributed_about_the_published_ones() {
    const TRUE_KG_M2: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
    const PUBLISHED_KG_M2: [f64; 6] = [14.1823, 17.2876, 20.2859, 0.0864, 0.1350, 0.6009];
    let flights = errors_percent("kim-2016", EstimatorName::EkfSgfLls, &[600.0]);
    for i in 0..6 {
        let errors: Vec<f64> = flights.iter().map(|errors| errors[0][i]).collect();
        let middle = mean(errors.iter().copied());
        let spread = rms(errors.iter().map(|error| error - middle));
        let published = 100.0 * (PUBLISHED_KG_M2[i] / TRUE_KG_M2[i] - 1.0);
        let below = errors.iter().filter(|error| **error < published).count();
        println!(
            "{i}: {middle:.3} %, sd {spread:.3}; published {published:.3}, above {below} of {}",
            errors.len()
        );
        assert!((published - middle).abs() < 3.0 * spread, "element {i}");
    }
}

/// RMS errors of the backward difference and of the fit, deg/s², with the process noise that \[Kim2016\]
/// lost in printing chosen so that the backward difference errs as in its Table 5.
fn acceleration_errors_deg_s2(order: usize) -> [f64; 2] {
    let (scenario, flight) = flight("kim-2016");
    let noise_rad_s = scenario.gyro.noise_rad_s;
    // A filter of constant gain K leaves `2 K² / (2 − K) (σ / Δt)²` in the backward difference, and has
    // that gain with a process noise of `K² / (1 − K) σ²` a sample.
    let gain = 0.0764_f64;
    let prior = scenario.prior.as_ref().unwrap();
    let nominal = Prior { inertia_kg_m2: prior.inertia_kg_m2, sigma_kg_m2: prior.sigma_kg_m2 };
    let config = Config {
        rate_ekf: rate_ekf::Config {
            rate_walk_rad_s_sqrt_s: noise_rad_s
                * gain
                * (scenario.gyro.rate_hz / (1.0 - gain)).sqrt(),
            acceleration_doubt: 0.0,
            ..rate_ekf::Config::new(noise_rad_s)
        },
        fit: Fit::centred(6, order, 1),
        ..Config::kim_2016(noise_rad_s, nominal)
    };
    let wheels = WheelArray::<f64, 0>::new([], []).unwrap();
    let mut chain = EkfSgf::<f64, 0>::new(config, wheels).unwrap();
    let j = fsw_core::Inertia::new(scenario.spacecraft.inertia_kg_m2);
    let (matrix, inverse) = (j.matrix_kg_m2(), j.inverse().unwrap());
    let truth = |instant: &Instant| {
        let rate = instant.rate_rad_s;
        inverse * (instant.torque_n_m - rate.cross(&(matrix * rate)))
    };
    let (mut backward, mut fitted) = (Vec::<f64>::new(), Vec::<f64>::new());
    let mut last: Option<Vec3<f64>> = None;
    for (k, row) in log_of(&scenario, &flight, 0).iter().enumerate() {
        chain.step(&Sample {
            time_us: row.time_us,
            rate_rad_s: row.rate_rad_s,
            wheel_speed_rad_s: [],
            torque_n_m: row.torque_n_m,
            attitude: None,
        });
        let rate: Vec3<f64> = chain.rate_rad_s();
        // From 10 s on: the filter has settled, as in the formula.
        if let (Some(last), Some(instant), true) = (last, chain.last_instant(), k >= 100) {
            let of = |index: usize| truth(&flight.instants[index]);
            backward.extend(((rate - last) * scenario.gyro.rate_hz - of(k)).iter().copied());
            let middle = (of(k - 3) + of(k - 2)) * 0.5;
            fitted.extend((instant.acceleration_rad_s2 - middle).iter().copied());
        }
        last = Some(rate);
    }
    [backward, fitted].map(|errors| rms(errors.into_iter()).to_degrees())
}

#[test]
fn kim_2016_table_5_is_that_of_a_true_quartic() {
    // Published: 0.0081 and 0.0058 deg/s², 28.3 to 29.1 % less.
    let [backward, fitted] = acceleration_errors_deg_s2(4);
    let improvement = 100.0 * (1.0 - fitted / backward);
    println!("quartic: {backward:.4} to {fitted:.4} deg/s², {improvement:.1} % less");
    assert!((backward - 0.0081).abs() < 0.0001 && (fitted - 0.0057).abs() < 0.0002);
    assert!((27.0..32.0).contains(&improvement));

    // The weights printed in its Table 2 and Eq. (10) are a parabola's, and do better than that.
    let [backward, fitted] = acceleration_errors_deg_s2(2);
    let improvement = 100.0 * (1.0 - fitted / backward);
    println!("as printed: {backward:.4} to {fitted:.4} deg/s², {improvement:.1} % less");
    assert!((54.0..60.0).contains(&improvement));
}
