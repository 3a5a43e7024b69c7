//! Consistency with a bias that walks, with a torque that varies as the body turns, and with an inertia that walks.

use super::*;
use crate::Inertia;
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::math::Mat;
use std::vec::Vec;

const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
const NOISE_RAD_S: f64 = 1e-4;
const PERIOD_S: f64 = 0.1;
const SAMPLES: u64 = 600;
const FLIGHTS: u64 = 24;
/// Mean NEES over its six degrees of freedom within four sampling errors, `1 ± 4 √(2 / (6 · 24))`.
const CONSISTENT: core::ops::Range<f64> = 0.53..1.47;

/// Normal numbers of unit variance: sums of twelve uniform ones.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1);
    let mut uniform = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Tumbling flight with a bias walk in (rad/s)/√s and, unknown to the estimator, a torque of a field.
fn fly(seed: u64, walk: f64, field_n_m: f64) -> Vec<Sample<f32, 0>> {
    let mut normal = normal(seed);
    let phases = [0; 6].map(|_| normal());
    // Amplitudes of unit variance, cosine and sine of an angle that grows by the body's rate of 0.05 rad/s.
    let of_field = |t: f64| {
        let (sin, cos) = (0.05 * t).sin_cos();
        Vec3::from_fn(|i, _| field_n_m * (phases[i] * cos + phases[i + 3] * sin))
    };
    let flight = TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels: WheelArray::new([], []).unwrap(),
        period_us: 100_000,
        samples: SAMPLES,
    };
    let mut samples = flight.fly(|_| [], |t| tumbling_torque_n_m(t) + of_field(t));
    let mut bias = Vec3::zeros();
    for (k, sample) in samples.iter_mut().enumerate() {
        let t = k as f64 * PERIOD_S;
        let noise = Vec3::from_fn(|_, _| NOISE_RAD_S * normal());
        bias += Vec3::from_fn(|_, _| walk * PERIOD_S.sqrt() * normal());
        sample.rate_rad_s += (noise + bias).map(|x| x as f32);
        sample.torque_n_m = tumbling_torque_n_m(t).map(|x| x as f32);
    }
    samples
}

fn estimate(config: Config<f32, 0>, samples: &[Sample<f32, 0>]) -> Estimate<f32> {
    let wheels = WheelArray::new([], []).unwrap();
    let mut window = Window::<f32, 0, 512, 15>::new(config, wheels).unwrap();
    for sample in samples {
        window.step(sample);
    }
    window.finish();
    window.estimate()
}

fn config() -> Config<f32, 0> {
    let noise = NOISE_RAD_S as f32;
    Config {
        is_torque_smooth: true,
        gyro_bias_rad_s: Some(1e-3),
        disturbance_torque_n_m: Some(1e-3),
        ..Config::new(noise)
    }
}

/// Mean NEES over its degrees of freedom, and share of flights that are not white.
fn campaign(config: Config<f32, 0>, walk: f64, field_n_m: f64) -> (f64, f64) {
    campaign_of(config, |seed| (fly(seed, walk, field_n_m), INERTIA))
}

/// The same of flights with their true inertia at the end.
fn campaign_of(
    config: Config<f32, 0>,
    flight: impl Fn(u64) -> (Vec<Sample<f32, 0>>, [f64; 6]),
) -> (f64, f64) {
    let (mut sum, mut flagged) = (0.0, 0.0);
    for seed in 0..FLIGHTS {
        let (samples, truth) = flight(seed);
        let estimate = estimate(config, &samples);
        let error = Mat::<f64, 6, 1>::from_fn(|i, _| {
            f64::from(estimate.inertia.elements_kg_m2()[i]) - truth[i]
        });
        let covariance = estimate.covariance_kg2_m4.map(f64::from);
        sum += (error.transpose() * covariance.try_inverse().unwrap() * error)[0] / 6.0;
        flagged += f64::from(estimate.residuals_white == Some(false));
    }
    (sum / FLIGHTS as f64, flagged / FLIGHTS as f64)
}

/// Walk over the flight of two to three times the noise.
const WALK: f64 = 3e-5;

#[test]
fn a_stated_walk_of_the_bias_is_consistent_and_white() {
    let stated = Config { bias_walk_rad_s_sqrt_s: WALK as f32, ..config() };
    let (nees, flagged) = campaign(stated, WALK, 0.0);
    assert!(CONSISTENT.contains(&nees) && flagged < 0.1, "{nees} {flagged}");
}

#[test]
fn a_walk_of_the_bias_that_is_not_stated_is_not_white() {
    let (nees, flagged) = campaign(config(), WALK, 0.0);
    assert!(flagged > 0.95, "{nees} {flagged}");
}

/// Torque of a field: a fraction of a per cent of the known one.
const FIELD_N_M: f64 = 1e-4;

/// A walk is rougher than a cosine, and the covariance larger than the errors: by up to two in sigma.
const COVERED: f64 = 0.25;

#[test]
fn a_stated_torque_of_fields_is_covered_and_white() {
    let stated = Config { varying_torque_n_m: FIELD_N_M as f32, ..config() };
    let (nees, flagged) = campaign(stated, 0.0, FIELD_N_M);
    assert!((COVERED..CONSISTENT.end).contains(&nees) && flagged < 0.1, "{nees} {flagged}");
    // In 300 flights 1.15 and 0.48.
    let (unstated, _) = campaign(config(), 0.0, FIELD_N_M);
    assert!(unstated > 1.8 * nees, "{unstated} {nees}");
}

/// 2 % of a moment over the flight, kg m²/√s.
const INERTIA_WALK: f64 = 3e-3;
/// Samples between two steps of it.
const STEADY: u64 = 5;

/// Tumbling flight with a random walk of each element, and the inertia at its end. The momentum is continuous.
fn fly_walking(seed: u64) -> (Vec<Sample<f32, 0>>, [f64; 6]) {
    let mut normal = normal(seed);
    let step = INERTIA_WALK * (STEADY as f64 * PERIOD_S).sqrt();
    let (mut inertia, mut rate) = (INERTIA, Vec3::new(0.01, -0.02, 0.03));
    let mut samples: Vec<Sample<f32, 0>> = Vec::new();
    for part in 0..SAMPLES / STEADY {
        let start_us = part * STEADY * 100_000;
        let of_part = TestFlight {
            inertia_kg_m2: inertia,
            initial_rate_rad_s: rate,
            wheels: WheelArray::new([], []).unwrap(),
            period_us: 100_000,
            samples: STEADY + 1,
        };
        let mut flown = of_part.fly(|_| [], |t| tumbling_torque_n_m(t + start_us as f64 * 1e-6));
        let end = flown.pop().unwrap();
        samples.extend(flown.into_iter().map(|sample| {
            let noise = Vec3::from_fn(|_, _| (NOISE_RAD_S * normal()) as f32);
            let time_us = sample.time_us + start_us;
            Sample { time_us, rate_rad_s: sample.rate_rad_s + noise, ..sample }
        }));
        if part + 1 < SAMPLES / STEADY {
            let matrix = |elements| Inertia::new(elements).matrix_kg_m2();
            let momentum = matrix(inertia) * end.rate_rad_s.map(f64::from);
            inertia = inertia.map(|element| element + step * normal());
            rate = matrix(inertia).try_inverse().unwrap() * momentum;
        }
    }
    (samples, inertia)
}

#[test]
fn a_stated_walk_of_the_inertia_is_consistent_and_white() {
    let stated = Config { inertia_walk_kg_m2_sqrt_s: INERTIA_WALK as f32, ..config() };
    let (nees, flagged) = campaign_of(stated, fly_walking);
    assert!(CONSISTENT.contains(&nees) && flagged < 0.1, "{nees} {flagged}");
    let (_, flagged) = campaign_of(config(), fly_walking);
    assert!(flagged > 0.95, "{flagged}");
}
