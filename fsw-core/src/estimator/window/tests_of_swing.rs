//! Motion that swings faster than storage of that many blocks lasts: blocks are merged as far as they keep its information.

use super::*;
use crate::estimate::Status;
use crate::estimator::test_flight::TestFlight;
use std::vec::Vec;

const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
const NOISE_RAD_S: f64 = 1e-4;
/// Samples at 10 Hz that 512 blocks hold without a merger, and 64 blocks with one of 64 to 1.
const SAMPLES: u64 = 1700;

fn wheels<T: Real>() -> WheelArray<T, 3> {
    WheelArray::new([Vec3::x(), Vec3::y(), Vec3::z()], [T::lit(1e-3); 3]).unwrap()
}

/// Body at rest, with wheels that swing about its axes, s and rad/s, and noise.
fn fly(periods_s: [f64; 3], amplitude_rad_s: f64) -> Vec<Sample<f32, 3>> {
    let flight = TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::zeros(),
        wheels: wheels(),
        period_us: 100_000,
        samples: SAMPLES,
    };
    let speed = |t: f64, period: f64| amplitude_rad_s * (core::f64::consts::TAU * t / period).sin();
    let mut samples = flight.fly(|t| periods_s.map(|period| speed(t, period)), |_| Vec3::zeros());
    let mut state = 1u64;
    let mut uniform = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    for sample in &mut samples {
        sample.rate_rad_s += Vec3::from_fn(|_, _| (12f64.sqrt() * NOISE_RAD_S * uniform()) as f32);
    }
    samples
}

fn estimate<const N: usize>(samples: &[Sample<f32, 3>]) -> Estimate<f32> {
    let config = Config { slices_per_step: 16, ..Config::new(NOISE_RAD_S as f32) };
    let mut window = Window::<f32, 3, N, 12>::new(config, wheels()).unwrap();
    for sample in samples {
        window.step(sample);
    }
    window.finish();
    window.estimate()
}

/// Largest sigma over that with all blocks in storage.
fn largest_loss(periods_s: [f64; 3]) -> f32 {
    let samples = fly(periods_s, 20.0);
    let (found, all) = (estimate::<64>(&samples), estimate::<512>(&samples));
    assert_eq!((found.status, found.residuals_white), (Status::Converged, Some(true)));
    let (sigma, of_all) = (found.sigma_kg_m2(), all.sigma_kg_m2());
    for i in 0..6 {
        let error = f64::from(found.inertia.elements_kg_m2()[i]) - INERTIA[i];
        assert!(error.abs() < 4.0 * f64::from(sigma[i]), "element {i}: {error} {}", sigma[i]);
    }
    (0..6).map(|i| sigma[i] / of_all[i]).fold(0.0, f32::max)
}

/// Mergers lose 3.5 % of sigma at most, and some windows in a row their momenta and the tested torque.
const LOSS: f32 = 1.15;

#[test]
fn mergers_keep_the_information_of_fast_swings() {
    let loss = largest_loss([3.0, 4.0, 5.0]);
    assert!(loss < LOSS, "{loss}");
}

#[test]
fn mergers_keep_the_information_of_swings_of_different_periods() {
    let loss = largest_loss([3.0, 5.0, 12.0]);
    assert!(loss < LOSS, "{loss}");
}

/// New blocks are as long as the slow swing before permits.
#[test]
fn blocks_become_shorter_where_the_motion_becomes_faster() {
    let config = Config { slices_per_step: 16, ..Config::new(NOISE_RAD_S as f32) };
    let mut window = Window::<f32, 3, 64, 12>::new(config, wheels()).unwrap();
    let (slow, fast) = (fly([90.0, 110.0, 70.0], 20.0), fly([12.0, 10.0, 15.0], 20.0));
    for sample in &slow {
        window.step(sample);
    }
    let before = window.blocks.usual();
    let offset = slow.last().unwrap().time_us + 100_000;
    let mut shortest = before;
    for sample in &fast {
        window.step(&Sample { time_us: sample.time_us + offset, ..*sample });
        shortest = shortest.min(window.blocks.usual());
    }
    assert!(before >= 32.0 && shortest <= 8.0, "{before} {shortest}");
}
