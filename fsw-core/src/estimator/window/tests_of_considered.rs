//! Tests of the considered hardware: effects against fits of changed readings, consistency of the covariance.

use super::*;
use crate::estimate::Status;
use crate::estimator::test_hardware::*;
use crate::hardware::{Hardware, Parameter};
use crate::math::Mat;
use std::vec::Vec;

/// Torque, bias, time offset with common scales, and the place that four groups take in turn.
type Considering<T> = Window<T, 1, 512, 21, 4>;
/// The same with a place for each group.
type Solving<T> = Window<T, 1, 512, 30>;

fn config<T: Real>(hardware: Hardware<T, 1>, noise_rad_s: f64) -> Config<T, 1> {
    Config {
        hardware,
        gyro_bias_rad_s: Some(T::lit(DISTURBANCE.gyro_bias_rad_s)),
        disturbance_torque_n_m: Some(T::lit(DISTURBANCE.torque_n_m)),
        is_torque_smooth: true,
        slices_per_step: 64,
        ..Config::new(T::lit(noise_rad_s))
    }
}

/// After a flight with noise, always the same.
fn flown(samples: &[Sample<f64, 1>], wheel: (Vec3<f64>, f64)) -> Considering<f64> {
    let wheels = WheelArray::new([wheel.0], [wheel.1]).unwrap();
    let mut window = Considering::new(config(HARDWARE, NOISE_RAD_S), wheels).unwrap();
    let mut draw = normal(1);
    for sample in samples {
        let noise_rad_s = Vec3::from_fn(|_, _| NOISE_RAD_S * draw());
        window.step(&Sample { rate_rad_s: sample.rate_rad_s + noise_rad_s, ..*sample });
    }
    window.finish();
    window
}

/// Groups that are considered here.
fn is_considered(parameter: Parameter) -> bool {
    use Parameter::{GyroAxes, GyroScale, WheelAxis, WheelInertia};
    matches!(parameter, GyroScale(_) | GyroAxes(..) | WheelInertia(_) | WheelAxis(..))
}

/// Each effect against two fits of which one meets a tenth of a sigma of the parameter. Tolerance 3 % of the largest
/// element: of robust weights, and of terms of second order.
#[test]
fn effects_are_the_derivatives_of_the_fit() {
    const SHARE: f64 = 0.1;
    const TOLERANCE: f64 = 0.03;
    let wheel = (Vec3::from(AXIS), SPIN_INERTIA);
    let samples = flight();
    let exact = flown(&samples, wheel);
    let mut findings = Vec::new();
    exact.each_of_hardware(&mut |finding| findings.push(finding));
    findings.retain(|finding| is_considered(finding.parameter));
    assert_eq!(findings.len(), 12);
    let inertia = |window: &Considering<f64>| window.estimate().inertia.elements_kg_m2();
    for Finding { parameter, stated, effect_kg_m2, .. } in findings {
        let mut known = wheel;
        let changed = with_error(&samples, &mut known, parameter, stated * SHARE);
        let (before, after) = (inertia(&exact), inertia(&flown(&changed, known)));
        let largest = effect_kg_m2.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (i, effect) in effect_kg_m2.iter().enumerate() {
            let apart = (after[i] - before[i]) / SHARE;
            let error = (apart - effect).abs();
            assert!(error < TOLERANCE * largest, "{parameter:?} {i}: {apart} {effect}");
        }
    }
}

/// Mean NEES over flights with all errors drawn, of windows that end at these samples. None diverges, none is called
/// not white. The mean square of the time offset's error over its sigma is 1, within 2.7 sampling errors of 40 flights.
fn mean_nees(flights: u64, ends: &[usize]) -> f64 {
    let samples = flight();
    let (hardware, _) = stated();
    let (mut sum, mut of_delay) = (0.0, 0.0);
    for seed in 0..flights {
        let (readings, wheels) = drawn(&samples, seed);
        let config = config(hardware, NOISE_RAD_S);
        let mut window = Considering::<f32>::new(config, wheels).unwrap();
        for (k, sample) in readings.iter().enumerate() {
            if ends.contains(&k) {
                window.close_window();
                window.finish();
                window.open_window();
            }
            window.step(sample);
        }
        window.finish();
        let estimate = window.estimate();
        assert_eq!(estimate.status, Status::Converged, "{seed}");
        assert_eq!(estimate.residuals_white, Some(true), "{seed}");
        let random = estimate.sigma_random_kg_m2.unwrap();
        let is_within = |i: usize| random[i] < estimate.sigma_kg_m2()[i];
        assert!((0..6).all(is_within), "{seed}");
        sum += nees(&estimate);
        window.each_of_hardware(&mut |finding| {
            if finding.parameter == Parameter::Delay {
                let error = f64::from(finding.value) - drawn_delay_s(seed);
                of_delay += (error / f64::from(finding.sigma)).powi(2);
            }
        });
    }
    let of_delay = of_delay / flights as f64;
    assert!((0.5..1.6).contains(&of_delay), "{of_delay}");
    sum / flights as f64
}

/// Time offset of the flight with this seed, s.
fn drawn_delay_s(seed: u64) -> f64 {
    let mut draw = normal(seed);
    let mut values = HARDWARE.parameters().map(|(parameter, sigma)| (parameter, sigma * draw()));
    values.find(|(parameter, _)| *parameter == Parameter::Delay).unwrap().1
}

/// Sampling error of the mean over 40 flights: 0.09.
#[test]
fn all_errors_of_the_considered_hardware_are_covered() {
    let nees = mean_nees(40, &[]);
    assert!((0.7..1.3).contains(&nees), "{nees}");
}

/// Errors of the hardware that three windows share do not average out.
#[test]
fn windows_share_the_errors_of_the_hardware() {
    let nees = mean_nees(40, &[400, 800]);
    assert!((0.7..1.3).contains(&nees), "{nees}");
}

/// A place for each group: all are solved for. Without a place to take turns: rejected.
#[test]
fn groups_are_solved_where_all_have_a_place() {
    let config = config(HARDWARE, NOISE_RAD_S);
    assert_eq!(config.validate::<30, 0, 0>(), Ok(()));
    assert_eq!(config.validate::<21, 4, 0>(), Ok(()));
    for refused in [
        config.validate::<21, 3, 0>(),
        config.validate::<27, 0, 0>(),
        config.validate::<15, 9, 0>(),
    ] {
        assert_eq!(refused.unwrap_err().field, "hardware");
    }
    let wheels = WheelArray::new([Vec3::from(AXIS)], [SPIN_INERTIA]).unwrap();
    assert!(!Solving::new(config, wheels).unwrap().considers());
}

/// Hardware that is stated at a tenth of its errors: with sigmas that do not grow with the contradiction, mean NEES is 50.
#[test]
fn sigma_grows_where_the_hardware_contradicts_what_is_stated() {
    let (samples, (stated, _)) = (flight(), stated());
    let tenth = Hardware {
        gyro_scale: stated.gyro_scale * 0.1,
        gyro_axes_rad: stated.gyro_axes_rad * 0.1,
        delay_sigma_s: stated.delay_sigma_s * 0.1,
        wheel_inertia: stated.wheel_inertia.map(|sigma| sigma * 0.1),
        wheel_axis_rad: stated.wheel_axis_rad.map(|sigma| sigma * 0.1),
        common_wheel_inertia: stated.common_wheel_inertia * 0.1,
        torque_scale: stated.torque_scale * 0.1,
        ..stated
    };
    let mut sum = 0.0;
    for seed in 0..10 {
        let (readings, wheels) = drawn(&samples, seed);
        let mut window = Solving::<f32>::new(config(tenth, NOISE_RAD_S), wheels).unwrap();
        readings.iter().for_each(|sample| _ = window.step(sample));
        window.finish();
        sum += nees(&window.estimate());
    }
    assert!((0.3..3.0).contains(&(sum / 10.0)), "{}", sum / 10.0);
}

/// A turn of all sensors about x leaves the trace and Jxx, and no motion shows it: its sigma is the stated one.
#[test]
fn turn_of_all_sensors_is_reported_as_stated() {
    const STATED_RAD: f64 = 1e-2;
    let hardware = Hardware { mount_rad: [STATED_RAD, 0.0, 0.0], ..Hardware::ideal() };
    let wheels = WheelArray::new([Vec3::from(AXIS)], [SPIN_INERTIA]).unwrap();
    let mut window = Considering::<f64>::new(config(hardware, NOISE_RAD_S), wheels).unwrap();
    flight().iter().for_each(|sample| _ = window.step(sample));
    window.finish();
    let mut mounts = Vec::new();
    window.each_of_hardware(&mut |finding| {
        if let Parameter::Mount(axis) = finding.parameter {
            mounts.push((axis, finding));
        }
    });
    let [(0, Finding { value, sigma, effect_kg_m2, .. })] = mounts[..] else {
        panic!("{}", mounts.len())
    };
    assert_eq!((value, sigma), (0.0, STATED_RAD));
    let inertia = window.estimate().inertia.matrix_kg_m2();
    let (sin, cos) = STATED_RAD.sin_cos();
    let turn = Mat::<f64, 3, 3>::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
    let of_turn = turn * inertia * turn.transpose() - inertia;
    let of_turn = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| of_turn[at]);
    // To second order in the angle.
    let error = |i: usize| (effect_kg_m2[i] - of_turn[i]).abs();
    let largest = (0..6).map(error).fold(0.0, f64::max);
    assert!(largest < 3.0 * STATED_RAD * STATED_RAD, "{effect_kg_m2:?} {of_turn:?}");
}

/// Sigma by the noise alone: that of a fit for ideal hardware, of which nothing is considered.
#[test]
fn random_sigma_is_that_of_ideal_hardware() {
    let samples = flight();
    let wheel = (Vec3::from(AXIS), SPIN_INERTIA);
    let considering = flown(&samples, wheel).estimate();
    let wheels = WheelArray::new([wheel.0], [wheel.1]).unwrap();
    let ideal = config(Hardware::ideal(), NOISE_RAD_S);
    let mut window = Considering::<f64>::new(ideal, wheels).unwrap();
    let mut draw = normal(1);
    for sample in &samples {
        let noise_rad_s = Vec3::from_fn(|_, _| NOISE_RAD_S * draw());
        window.step(&Sample { rate_rad_s: sample.rate_rad_s + noise_rad_s, ..*sample });
    }
    window.finish();
    let (random, sigma) =
        (considering.sigma_random_kg_m2.unwrap(), window.estimate().sigma_kg_m2());
    for i in 0..6 {
        let ratio = random[i] / sigma[i];
        assert!((0.9..1.1).contains(&ratio), "element {i}: {ratio}");
        assert!(random[i] < 0.9 * considering.sigma_kg_m2()[i], "element {i}");
    }
}

/// With hardware that is known exactly, places for considered groups leave every bit.
#[test]
fn ideal_hardware_leaves_the_bits() {
    let wheels = WheelArray::new([Vec3::from(AXIS)], [SPIN_INERTIA]).unwrap();
    let config = config(Hardware::ideal(), NOISE_RAD_S);
    let mut without = Window::<f64, 1, 512, 21>::new(config, wheels).unwrap();
    let mut with = Considering::new(config, wheels).unwrap();
    for sample in &flight() {
        assert_eq!(without.step(sample), with.step(sample));
    }
    assert_eq!(without.estimate(), with.estimate());
}
