use super::*;
use crate::estimate::Status;
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::prior::Prior;
use proptest::prelude::*;
use std::vec::Vec;

const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
/// Of the test flight, which has none: rounding to single precision is far below it.
const NOISE_RAD_S: f32 = 1e-5;

fn flight(samples: u64) -> TestFlight<0> {
    TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels: WheelArray::new([], []).unwrap(),
        period_us: 100_000,
        samples,
    }
}

fn tumble(samples: u64) -> Vec<Sample<f32, 0>> {
    flight(samples).fly(|_| [], tumbling_torque_n_m)
}

fn window<const N: usize>(config: Config<f32, 0>) -> Window<f32, 0, N, 12> {
    Window::new(config, WheelArray::new([], []).unwrap()).unwrap()
}

/// For torques that are sines.
fn config<const W: usize>(noise_rad_s: f32) -> Config<f32, W> {
    Config { is_torque_smooth: true, slices_per_step: 16, ..Config::new(noise_rad_s) }
}

fn fly<const N: usize>(config: Config<f32, 0>, samples: &[Sample<f32, 0>]) -> Estimate<f32> {
    let mut window = window::<N>(config);
    for sample in samples {
        window.step(sample);
    }
    window.finish();
    window.estimate()
}

fn worst_error(estimate: &Estimate<f32>) -> f64 {
    let found = estimate.inertia.elements_kg_m2().map(f64::from);
    (0..6).map(|i| (found[i] - INERTIA[i]).abs()).fold(0.0, f64::max)
}

/// Torque known at its samples alone, 70 in a period, and rounding.
const EXACT: f64 = 1e-4;

#[test]
fn finds_the_inertia_without_a_guess() {
    let estimate = fly::<512>(config(NOISE_RAD_S), &tumble(600));
    assert!(worst_error(&estimate) < EXACT, "{estimate:?}");
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
}

/// A record of twenty samples has blocks of two; the first fit in flight joins them.
#[test]
fn a_short_record_has_shorter_blocks() {
    let mut window = window::<512>(config(NOISE_RAD_S));
    for (k, sample) in tumble(60).iter().enumerate() {
        window.step(sample);
        if k == 19 {
            let mut ended = window.clone();
            ended.finish();
            assert_eq!(ended.blocks.len(), 10);
        }
    }
    window.finish();
    assert_eq!(window.blocks.len(), 15);
}

/// Once the front's solution is the start of a fit, few passes follow; none where the front is uncertain but linear.
#[test]
fn a_fit_takes_the_passes_that_it_needs() {
    let mut window = window::<512>(Config { slices_per_step: 0, ..config(1e-2) });
    let (mut passes, mut of_fits) = (0, Vec::new());
    for sample in noisy(tumble(1200), 1e-2) {
        window.step(&sample);
        while let Some(slice) = window.next_slice() {
            match slice {
                Slice::Fit => passes = 0,
                Slice::Decision => passes += 1,
                Slice::Result => of_fits.push(passes),
                _ => {}
            }
            window.work(1);
        }
    }
    let (none, most) = (of_fits.contains(&0), of_fits.iter().skip(4).max());
    assert!(none && most <= Some(&2), "{of_fits:?}");
    let estimate = window.estimate();
    for i in 0..6 {
        let error = f64::from(estimate.inertia.elements_kg_m2()[i]) - INERTIA[i];
        assert!(error.abs() < 4.0 * f64::from(estimate.sigma_kg_m2()[i]), "{estimate:?}");
    }
}

/// Storage for 64 blocks is merged, and windows end in mid-motion: the errors stay within the sigma. In single
/// precision each window begins with a momentum of its own, which costs information.
#[test]
fn little_storage_costs_information_and_no_consistency() {
    let samples = noisy(tumble(2400), 1e-3);
    let estimate = fly::<64>(config(1e-3), &samples);
    let all = fly::<512>(config(1e-3), &samples);
    assert_eq!(estimate.status, Status::Converged);
    for i in 0..6 {
        let error = f64::from(estimate.inertia.elements_kg_m2()[i]) - INERTIA[i];
        let sigma = estimate.sigma_kg_m2()[i];
        assert!(error.abs() < 4.0 * f64::from(sigma), "element {i}: {error} {sigma}");
        let ratio = sigma / all.sigma_kg_m2()[i];
        assert!((0.9..5.0).contains(&ratio), "element {i}: {ratio}");
    }
}

/// Storage for 64 blocks that are too short to be merged: a window ends when it is full. Each begins with a
/// momentum of its own, which costs information.
#[test]
fn windows_in_a_row_are_fused() {
    let short = Config { block_turn_rad: 0.05, ..config(NOISE_RAD_S) };
    let fused = fly::<64>(short, &tumble(1800));
    let one = fly::<512>(config(NOISE_RAD_S), &tumble(200));
    assert!(worst_error(&fused) < EXACT, "{fused:?}");
    assert_eq!(fused.status, Status::Converged);
    for i in 0..6 {
        let ratio = fused.sigma_kg_m2()[i] / one.sigma_kg_m2()[i];
        assert!(ratio < 0.7, "element {i}: {ratio}");
    }
}

#[test]
fn the_inertia_survives_a_gap() {
    let samples = tumble(900);
    let mut window = window::<512>(config(NOISE_RAD_S));
    for sample in &samples[..450] {
        window.step(sample);
    }
    let before = window.estimate();
    assert_eq!(window.step(&samples[600]), Outcome::Reset(Reset::Gap));
    for sample in &samples[601..610] {
        window.step(sample);
    }
    let after_gap = window.estimate();
    for sample in &samples[610..] {
        window.step(sample);
    }
    let after = window.estimate();
    for i in 0..6 {
        assert!(
            after_gap.sigma_kg_m2()[i] < 1.01 * before.sigma_kg_m2()[i],
            "{:?} {:?}",
            after_gap.sigma_kg_m2(),
            before.sigma_kg_m2()
        );
        assert!(after.sigma_kg_m2()[i] < 0.95 * before.sigma_kg_m2()[i]);
    }
    assert!(worst_error(&after) < EXACT);
    assert_eq!(after.status, Status::Converged);
}

#[test]
fn a_change_of_the_inertia_makes_all_start_anew() {
    let mut window = window::<512>(config(NOISE_RAD_S));
    for sample in tumble(600) {
        window.step(&sample);
    }
    let heavier = TestFlight { inertia_kg_m2: [1.7, 1.2, 1.8, 0.1, -0.2, 0.05], ..flight(600) };
    let later = heavier.fly(|_| [], tumbling_torque_n_m);
    let outcomes: Vec<Outcome> = later
        .iter()
        .map(|s| window.step(&Sample { time_us: s.time_us + 600_000_000, ..*s }))
        .collect();
    assert_eq!(outcomes[0], Outcome::Reset(Reset::Gap));
    assert!(
        outcomes.contains(&Outcome::Reset(Reset::Changed)),
        "{:?} {:?}",
        outcomes.iter().map(|o| o.name()).collect::<std::collections::BTreeSet<_>>(),
        window.estimate()
    );
    let found = window.estimate();
    assert!((found.inertia.elements_kg_m2()[0] - 1.7).abs() < EXACT as f32, "{found:?}");
    assert_eq!(found.status, Status::Converged);
}

/// After 12 to 30 s a change does not yet differ from a poor fit, but no single inertia explains the residuals.
#[test]
fn a_change_in_mid_manoeuvre_makes_all_start_anew() {
    for changed_after in [120, 150, 300] {
        let before = tumble(changed_after);
        let last = before.last().unwrap();
        let heavier = TestFlight {
            inertia_kg_m2: [1.7, 1.2, 1.8, 0.1, -0.2, 0.05],
            initial_rate_rad_s: last.rate_rad_s.cast(),
            ..flight(900)
        };
        let later = heavier.fly(|_| [], tumbling_torque_n_m);
        let moved = later[1..].iter().map(|s| Sample { time_us: s.time_us + last.time_us, ..*s });
        let mut window = window::<512>(config(NOISE_RAD_S));
        let outcomes: Vec<Outcome> =
            before.iter().copied().chain(moved).map(|s| window.step(&s)).collect();
        let resets = outcomes.iter().filter(|o| **o == Outcome::Reset(Reset::Changed)).count();
        let found = window.estimate();
        assert_eq!(resets, 1, "{changed_after}: {found:?}");
        assert!((found.inertia.elements_kg_m2()[0] - 1.7).abs() < EXACT as f32, "{found:?}");
        assert_eq!(found.status, Status::Converged);
    }
}

/// Bias of ten sigmas for ten seconds in a motion that goes on: within a minute of its end the estimate is converged, and
/// the residuals are called white from then on.
#[test]
fn a_transient_fault_costs_a_minute_at_most() {
    let clean = flight(1800).fly(|_| [], tumbling_torque_n_m);
    for seed in 0..6 {
        let noise_rad_s = 1e-3;
        let mut normal = crate::estimator::test_hardware::normal(seed + 1);
        let mut window = window::<512>(config(noise_rad_s));
        for (k, sample) in clean.iter().enumerate() {
            let mut sample = *sample;
            let bias = if (800..900).contains(&k) { 10.0 } else { 0.0 };
            sample.rate_rad_s += Vec3::from_fn(|_, _| (bias + normal() as f32) * noise_rad_s);
            window.step(&sample);
            if k >= 1500 && k % 50 == 0 {
                let Estimate { status, residuals_white, .. } = window.estimate();
                assert_eq!(status, Status::Converged, "seed {seed}, sample {k}");
                assert_eq!(residuals_white, Some(true), "seed {seed}, sample {k}");
            }
        }
    }
}

#[test]
fn a_turn_about_one_axis_shows_three_elements_and_no_confident_number_else() {
    let about_z = |t: f64| Vec3::new(0.0, 0.0, 0.02 * (0.4 * t).cos());
    let body = TestFlight {
        inertia_kg_m2: [1.5, 1.2, 1.8, 0.0, 0.0, 0.0],
        initial_rate_rad_s: Vec3::zeros(),
        ..flight(900)
    };
    let estimate = fly::<512>(config(NOISE_RAD_S), &body.fly(|_| [], about_z));
    assert_eq!(estimate.observed.element, [false, false, true, false, true, true]);
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Partial, 3));
    assert!((estimate.inertia.elements_kg_m2()[2] - 1.8).abs() < 1e-3);
    for i in [0, 1, 3] {
        assert!(estimate.sigma_kg_m2()[i] > 0.5, "{estimate:?}");
    }
}

#[test]
fn without_torque_and_wheels_the_ratios_are_seen_and_the_scale_is_not() {
    let spinning = TestFlight { initial_rate_rad_s: Vec3::new(0.2, 0.3, -0.2), ..flight(900) };
    let estimate = fly::<512>(config(NOISE_RAD_S), &spinning.fly(|_| [], |_| Vec3::zeros()));
    assert!(!estimate.observed.scale, "{estimate:?}");
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Partial, 5));
    let (ratio, sigma) = estimate.over_trace();
    for i in 0..6 {
        let truth = INERTIA[i] / 4.5;
        assert!((f64::from(ratio[i]) - truth).abs() < 1e-3, "{ratio:?}");
        assert!(sigma[i] < 1e-2, "{sigma:?}");
    }
}

#[test]
fn a_prior_fills_in_what_the_motion_does_not_show() {
    let about_z = |t: f64| Vec3::new(0.0, 0.0, 0.02 * (0.4 * t).cos());
    let body = TestFlight {
        inertia_kg_m2: [1.5, 1.2, 1.8, 0.0, 0.0, 0.0],
        initial_rate_rad_s: Vec3::zeros(),
        ..flight(900)
    };
    let prior = Prior { inertia_kg_m2: [1.4, 1.3, 1.6, 0.0, 0.0, 0.0], sigma_kg_m2: [0.2; 6] };
    let config = Config { prior: Some(prior), ..config(NOISE_RAD_S) };
    let estimate = fly::<512>(config, &body.fly(|_| [], about_z));
    assert!((estimate.inertia.elements_kg_m2()[2] - 1.8).abs() < 1e-3, "{estimate:?}");
    for i in [0, 1] {
        let error = estimate.inertia.elements_kg_m2()[i] - prior.inertia_kg_m2[i];
        assert!(error.abs() < 1e-2, "{estimate:?}");
        assert!((estimate.sigma_kg_m2()[i] - 0.2).abs() < 1e-2, "{estimate:?}");
    }
}

#[test]
fn without_data_the_estimate_is_the_prior() {
    let prior = Prior {
        inertia_kg_m2: [1.4, 1.3, 1.6, 0.1, 0.0, -0.1],
        sigma_kg_m2: [0.2, 0.3, 0.4, 0.1, 0.2, 0.3],
    };
    for (stated, expected) in [(Some(prior), prior), (None, Prior::unknown())] {
        let estimate = fly::<64>(Config { prior: stated, ..config(NOISE_RAD_S) }, &[]);
        assert_eq!(estimate.inertia.elements_kg_m2(), expected.inertia_kg_m2);
        assert_eq!(estimate.sigma_kg_m2(), expected.sigma_kg_m2);
        assert_eq!((estimate.status, estimate.observed.directions), (Status::Unobservable, 0));
    }
}

/// A body at rest for a minute with a walk of 0.01 kg m² after a second: the prior has aged by a minute. The ranges of any rigid
/// body add up to 3 % of its information.
#[test]
fn a_prior_ages_by_the_walk_of_the_inertia() {
    let walk = 0.01f32;
    let prior = Prior { inertia_kg_m2: [1.4, 1.3, 1.6, 0.1, 0.0, -0.1], sigma_kg_m2: [0.05; 6] };
    let config =
        Config { prior: Some(prior), inertia_walk_kg_m2_sqrt_s: walk, ..config(NOISE_RAD_S) };
    let mut still = tumble(601);
    for sample in &mut still {
        sample.rate_rad_s = Vec3::zeros();
        sample.torque_n_m = Vec3::zeros();
    }
    let estimate = fly::<64>(config, &noisy(still, NOISE_RAD_S));
    for (sigma, stated) in estimate.sigma_kg_m2().iter().zip(prior.sigma_kg_m2) {
        let walked_s = (sigma * sigma - stated * stated) / (walk * walk);
        assert!((55.0..60.1).contains(&walked_s), "{walked_s}");
    }
}

/// 1e-3 kg m² after a second. A window ends where its first blocks no longer count; at rest the variance grows by 1e-6 kg² m⁴
/// in a second, and by up to half of that more: the coordinates of shape and scale walk, without their correlation.
#[test]
fn an_inertia_that_walks_is_known_for_less_long() {
    let walk = 1e-3f32;
    let config = Config { inertia_walk_kg_m2_sqrt_s: walk, ..config(NOISE_RAD_S) };
    let mut window = window::<512>(config);
    let samples = noisy(tumble(600), NOISE_RAD_S);
    for sample in &samples {
        window.step(sample);
    }
    assert!(window.open.duration_s < 30.0, "{}", window.open.duration_s);
    window.close_window();
    window.finish();
    // After a gap, in which the body came to rest.
    let start_us = samples.last().unwrap().time_us + 10_000_000;
    let still = |k: u64| Sample {
        time_us: start_us + k * 100_000,
        rate_rad_s: Vec3::zeros(),
        wheel_speed_rad_s: [],
        torque_n_m: Vec3::zeros(),
        attitude: None,
    };
    let mut sigmas = Vec::new();
    for (k, sample) in noisy((1..1001).map(still).collect(), NOISE_RAD_S).iter().enumerate() {
        window.step(sample);
        if k == 199 || k == 999 {
            sigmas.push(window.estimate().sigma_kg_m2());
        }
    }
    for i in 0..6 {
        let grown = (sigmas[1][i].powi(2) - sigmas[0][i].powi(2)) / (80.0 * walk * walk);
        assert!((0.9..1.5).contains(&grown), "element {i}: {grown}");
    }
}

#[test]
fn a_torque_that_nobody_told_is_called_diverged() {
    let samples: Vec<_> = tumble(600)
        .into_iter()
        .map(|s| Sample { torque_n_m: s.torque_n_m + Vec3::new(2e-3, 0.0, 0.0), ..s })
        .collect();
    assert_eq!(fly::<512>(config(NOISE_RAD_S), &samples).status, Status::Diverged);
}

/// Memory with storage for 512 blocks of four wheels, by the number of unknowns.
const _: () = assert!(size_of::<Window<f32, 4, 512, 9>>() <= 45 * 1024);
const _: () = assert!(size_of::<Window<f32, 4, 512, 15>>() <= 48 * 1024);
const _: () = assert!(size_of::<Window<f32, 4, 512, 18>>() <= 50 * 1024);

/// The tumble with an unmodelled torque, N m, and a gyro bias, rad/s.
fn disturbed(torque: Vec3<f64>, bias: Vec3<f64>) -> Vec<Sample<f32, 0>> {
    let samples = flight(900).fly(|_| [], |t| tumbling_torque_n_m(t) + torque);
    let (torque, bias) = (torque.map(|x| x as f32), bias.map(|x| x as f32));
    let off = |s: Sample<f32, 0>| Sample {
        torque_n_m: s.torque_n_m - torque,
        rate_rad_s: s.rate_rad_s + bias,
        ..s
    };
    samples.into_iter().map(off).collect()
}

#[test]
fn a_disturbance_torque_and_a_gyro_bias_are_found() {
    let (torque, bias) = (Vec3::new(2e-3, -1e-3, 1.5e-3), Vec3::new(1e-3, 2e-3, -1e-3));
    let config = Config {
        disturbance_torque_n_m: Some(0.1),
        gyro_bias_rad_s: Some(0.05),
        ..config(NOISE_RAD_S)
    };
    let mut window =
        Window::<f32, 0, 512, 15>::new(config, WheelArray::new([], []).unwrap()).unwrap();
    for sample in disturbed(torque, bias) {
        window.step(&sample);
    }
    let estimate = window.estimate();
    assert_eq!(estimate.status, Status::Converged);
    for i in 0..6 {
        let error = f64::from(estimate.inertia.elements_kg_m2()[i]) - INERTIA[i];
        // Sines known at their samples alone, and rounding.
        assert!(error.abs() < 4.0 * EXACT, "{estimate:?}");
    }
    let found = |v: Option<Vec3<f32>>| v.unwrap().map(f64::from);
    assert!((found(estimate.disturbance_torque_n_m) - torque).norm() < 2e-5, "{estimate:?}");
    assert!((found(estimate.gyro_bias_rad_s) - bias).norm() < 2e-5, "{estimate:?}");
}

#[test]
fn a_torque_that_is_not_asked_for_is_noticed() {
    let quiet = noisy(disturbed(Vec3::zeros(), Vec3::zeros()), 1e-4);
    assert_eq!(fly::<512>(config(1e-4), &quiet).residuals_white, Some(true));
    let pushed = noisy(disturbed(Vec3::new(1e-4, 0.0, 0.0), Vec3::zeros()), 1e-4);
    assert_eq!(fly::<512>(config(1e-4), &pushed).residuals_white, Some(false));
}

#[test]
fn a_prior_that_the_data_contradict_is_dropped() {
    let inertia_kg_m2 = [2.2, 1.8, 2.7, 0.0, 0.0, 0.0];
    let sure = Prior { inertia_kg_m2, sigma_kg_m2: [0.1; 6] };
    let unsure = Prior { sigma_kg_m2: [1.0; 6], ..sure };
    for (prior, is_dropped) in [(sure, true), (unsure, false)] {
        let mut window = window::<512>(Config { prior: Some(prior), ..config(NOISE_RAD_S) });
        let outcomes: Vec<Outcome> = tumble(900).iter().map(|s| window.step(s)).collect();
        assert_eq!(outcomes.contains(&Outcome::Reset(Reset::Changed)), is_dropped, "{prior:?}");
        assert!(worst_error(&window.estimate()) < EXACT);
    }
}

#[test]
fn a_spike_is_left_out() {
    let mut samples = tumble(600);
    samples[400].rate_rad_s += Vec3::new(0.0, 0.3, 0.0);
    let mut window = window::<512>(config(NOISE_RAD_S));
    let outcomes: Vec<Outcome> = samples.iter().map(|s| window.step(s)).collect();
    assert!(outcomes.contains(&Outcome::Coasting(Coasting::Spike)));
    assert!(worst_error(&window.estimate()) < EXACT);
    assert_eq!(window.estimate().status, Status::Converged);
}

/// The front hasn't come to the newest block yet when the window ends: what spikes there mustn't stay.
#[test]
fn a_spike_just_before_the_end_is_left_out_of_all_that_follows() {
    let mut samples = tumble(600);
    samples[398].rate_rad_s += Vec3::new(0.0, 0.3, 0.0);
    let mut window = window::<512>(config(NOISE_RAD_S));
    for sample in &samples[..400] {
        window.step(sample);
    }
    assert!(worst_error(&window.estimate()) < 1e-3, "{:?}", window.estimate());
    window.close_window();
    assert!(worst_error(&window.estimate()) < 1e-3, "{:?}", window.estimate());
}

/// Three seconds of readings that are not numbers, and two of zeros, in which the torque is known.
#[test]
fn a_hole_in_the_rate_is_bridged_by_the_drive() {
    let mut samples = noisy(tumble(900), NOISE_RAD_S);
    let whole = fly::<512>(config(NOISE_RAD_S), &samples);
    samples[400..430].iter_mut().for_each(|sample| sample.rate_rad_s.y = f32::NAN);
    samples[600..620].iter_mut().for_each(|sample| sample.rate_rad_s = Vec3::zeros());
    let mut window = window::<512>(config(NOISE_RAD_S));
    let outcomes: Vec<Outcome> = samples.iter().map(|s| window.step(s)).collect();
    window.finish();
    let estimate = window.estimate();
    let resets = outcomes.iter().filter(|outcome| matches!(outcome, Outcome::Reset(_)));
    assert_eq!(resets.count(), 1, "the first sample alone");
    for estimate in [&estimate, &whole] {
        assert_eq!((estimate.status, estimate.residuals_white), (Status::Converged, Some(true)));
    }
    let (sigma, of_whole) = (estimate.sigma_kg_m2(), whole.sigma_kg_m2());
    let elements = [&estimate, &whole].map(|estimate| estimate.inertia.elements_kg_m2());
    for i in 0..6 {
        let apart = (elements[0][i] - elements[1][i]).abs() / of_whole[i];
        let ratio = sigma[i] / of_whole[i];
        assert!((0.95..1.1).contains(&ratio) && apart < 1.0, "element {i}: {ratio}, {apart} sigma");
    }
}

/// After a hole of any length the outlier gate lets go of several samples at once: the blocks cover the whole flight.
#[test]
fn no_sample_is_lost_after_a_hole() {
    let covered_s = |samples: &[Sample<f32, 0>]| {
        let mut window = window::<512>(config(NOISE_RAD_S));
        samples.iter().for_each(|sample| {
            window.step(sample);
        });
        window.finish();
        let blocks = (0..window.blocks.len()).filter_map(|i| window.blocks.block(i));
        blocks.map(|block| block.duration_s).sum::<f32>()
    };
    let clean = noisy(tumble(200), NOISE_RAD_S);
    let whole_s = covered_s(&clean);
    for length in 1..=25 {
        let mut samples = clean.clone();
        samples[100..100 + length].iter_mut().for_each(|s| s.rate_rad_s.x = f32::NAN);
        let apart_s = covered_s(&samples) - whole_s;
        assert!(apart_s.abs() < 1e-3, "hole of {length} samples: {apart_s} s");
    }
}

/// Adds white noise, uniform, of one sigma in rad/s.
fn noisy<const W: usize>(mut samples: Vec<Sample<f32, W>>, sigma: f32) -> Vec<Sample<f32, W>> {
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    for sample in &mut samples {
        sample.rate_rad_s += Vec3::from_fn(|_, _| sigma * 3f32.sqrt() * uniform());
    }
    samples
}

/// Three wheels that speed up and slow down again, three times as fast as each other: the body turns
/// and comes to rest, at 100 s and once more at 300 s.
fn two_slews() -> Vec<Sample<f32, 3>> {
    let wheels = WheelArray::new([Vec3::x(), Vec3::y(), Vec3::z()], [0.01; 3]).unwrap();
    let body = TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::zeros(),
        wheels,
        period_us: 100_000,
        samples: 3600,
    };
    let swing = |t: f64, cycles: f64| {
        if !(0.0..100.0).contains(&t) {
            return 0.0;
        }
        let turn = std::f64::consts::TAU * cycles * t / 100.0;
        30.0 * turn.sin() * (std::f64::consts::PI * t / 100.0).sin().powi(2)
    };
    let speed = |t: f64| {
        let t = if t < 200.0 { t } else { t - 200.0 };
        [swing(t, 3.0), swing(t, 2.0), swing(t, 5.0)]
    };
    noisy(body.fly(speed, |_| Vec3::zeros()), NOISE_RAD_S)
}

#[test]
fn a_window_ends_at_rest_and_the_next_opens_with_the_next_motion() {
    let wheels = WheelArray::new([Vec3::x(), Vec3::y(), Vec3::z()], [0.01; 3]).unwrap();
    let mut window = Window::<f32, 3, 512, 12>::new(config(NOISE_RAD_S), wheels).unwrap();
    let mut was_open = false;
    let mut turns = Vec::new();
    let mut sigma = Vec::new();
    for sample in two_slews() {
        window.step(&sample);
        assert!(!(window.is_open() && window.is_at_rest()));
        if window.is_open() != was_open {
            was_open = window.is_open();
            turns.push(sample.time_us / 1_000_000);
            sigma.push(window.estimate().sigma_kg_m2()[0]);
        }
    }
    // Open from the first sample, closed after half a minute of rest, and so again.
    assert!(matches!(turns[..], [0, 125..=150, 200..=205, 325..=350]), "{turns:?}");
    assert!(sigma[3] < 0.8 * sigma[1], "two windows know more than one: {sigma:?}");
    assert!(window.is_at_rest());
    let found = window.estimate().inertia.elements_kg_m2();
    for i in 0..6 {
        assert!((f64::from(found[i]) - INERTIA[i]).abs() < EXACT, "{found:?}");
    }
}

#[test]
fn a_window_ends_and_begins_by_command() {
    let samples = tumble(600);
    let mut window = window::<512>(config(NOISE_RAD_S));
    for sample in &samples[..400] {
        window.step(sample);
    }
    let before = window.estimate();
    window.close_window();
    assert!(!window.is_open());
    let closed = window.estimate();
    assert_eq!(closed.status, Status::Converged);
    for i in 0..6 {
        let ratio = closed.sigma_kg_m2()[i] / before.sigma_kg_m2()[i];
        assert!((0.9..1.1).contains(&ratio), "element {i}: {ratio}");
    }
    window.open_window();
    for sample in &samples[400..] {
        window.step(sample);
    }
    assert!(window.is_open() && worst_error(&window.estimate()) < EXACT);
}

/// A window that ends while the one before it waits for its fit loses no blocks.
#[test]
fn a_second_window_waits_for_its_fit() {
    let samples = tumble(800);
    let (first, second) = samples.split_at(400);
    let fly = |is_idle: bool| {
        let mut window = window::<512>(Config { slices_per_step: 0, ..config(NOISE_RAD_S) });
        for part in [first, second] {
            window.open_window();
            for sample in part {
                window.step(sample);
            }
            window.close_window();
            if !is_idle {
                window.finish();
            }
        }
        window.finish();
        window.estimate()
    };
    let (idle, busy) = (fly(true), fly(false));
    assert_eq!((idle.status, busy.status), (Status::Converged, Status::Converged));
    for i in 0..6 {
        let ratio = idle.sigma_kg_m2()[i] / busy.sigma_kg_m2()[i];
        assert!((0.98..1.02).contains(&ratio), "element {i}: {ratio}");
    }
}

#[test]
fn noise_that_is_not_given_is_measured() {
    let noise = 5e-4;
    let samples = noisy(tumble(1200), noise);
    let unknown = Config { gyro_noise_rad_s: None, ..config(noise) };
    let (told, measured) = (fly::<512>(config(noise), &samples), fly::<512>(unknown, &samples));
    assert_eq!(measured.status, Status::Converged);
    assert!((measured.residual_rms_rad_s / noise - 1.0).abs() < 0.1, "{measured:?}");
    for i in 0..6 {
        let ratio = measured.sigma_kg_m2()[i] / told.sigma_kg_m2()[i];
        // Residuals that happen to hang together make it larger.
        assert!((0.85..1.4).contains(&ratio), "element {i}: {ratio}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_bits_leave_finite_numbers(
        bits in prop::collection::vec(prop::array::uniform6(any::<u32>()), 400),
        mild in any::<bool>(),
    ) {
        let mut window = window::<64>(Config::new(1e-3));
        for (k, b) in bits.iter().enumerate() {
            let f = b.map(|b| if mild { b as f32 * 1e-10 } else { f32::from_bits(b) });
            window.step(&Sample {
                time_us: 100_000 * k as u64,
                rate_rad_s: Vec3::new(f[0], f[1], f[2]),
                wheel_speed_rad_s: [],
                torque_n_m: Vec3::new(f[3], f[4], f[5]),
                attitude: None,
            });
            if k % 50 == 0 {
                let estimate = window.estimate();
                prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
                prop_assert!(estimate.covariance_kg2_m4.iter().all(|x| x.is_finite()));
            }
        }
    }
}
