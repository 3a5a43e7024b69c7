//! Tests of the considered parameters: columns against finite differences, consistency with errors of the hardware.

use super::*;
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::estimator::test_hardware::*;
use crate::hardware::Parameter;
use std::vec::Vec;

type Filter<T> = JointEkfUd<T, 1, 21>;

/// Filter with a prior of 0.1 kg m² at the truth: without innovations its gain does not depend on the parameters.
fn filter(wheel: (Vec3<f64>, f64)) -> Filter<f64> {
    let prior = Prior { inertia_kg_m2: INERTIA, sigma_kg_m2: [0.1; 6] };
    let config = Config { prior: Some(prior), ..Config::new(NOISE_RAD_S) };
    let wheels = WheelArray::new([wheel.0], [wheel.1]).unwrap();
    Filter::considering(config, wheels, &HARDWARE, &DISTURBANCE).unwrap()
}

fn findings(filter: &Filter<f64>) -> Vec<Finding<f64>> {
    let mut findings = Vec::new();
    filter.each_of_hardware(&mut |finding| findings.push(finding));
    findings
}

/// Each column against two filters of which one meets a thousandth of a sigma of the parameter. Tolerance 2 % of the
/// largest element for terms of second order in the step. Of a time offset 15 %: the effects of the first reading and of
/// the later ones are ten times as large, and opposite.
#[test]
fn columns_are_the_derivatives_of_the_filter() {
    const SHARE: f64 = 1e-3;
    const TOLERANCE: f64 = 0.02;
    const OF_DELAY: f64 = 0.15;
    let wheel = (Vec3::from(AXIS), SPIN_INERTIA);
    let samples = flight();
    let mut exact = filter(wheel);
    samples
        .iter()
        .for_each(|sample| assert!(exact.step(sample) != Outcome::Coasting(Coasting::Spike)));
    let columns = findings(&exact);
    assert_eq!(columns.len(), 21);
    for Finding { parameter, stated, effect_kg_m2, .. } in columns {
        let mut known = wheel;
        let changed = with_error(&samples, &mut known, parameter, stated * SHARE);
        let mut other = filter(known);
        changed.iter().for_each(|sample| {
            other.step(sample);
        });
        let apart = |i: usize| (exact.state()[3 + i] - other.state()[3 + i]) / SHARE;
        let largest = effect_kg_m2.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let tolerance = if parameter == Parameter::Delay { OF_DELAY } else { TOLERANCE };
        for (i, effect) in effect_kg_m2.iter().enumerate() {
            let error = (apart(i) - effect).abs();
            assert!(error < tolerance * largest, "{parameter:?} {i}: {} {effect}", apart(i));
        }
    }
}

/// Mean over 40 flights without a prior: its sampling error is 0.09 for a consistent filter. No flight is restarted,
/// diverged or not white.
#[test]
fn all_errors_of_the_hardware_are_covered() {
    let samples = flight();
    let (hardware, disturbance) = stated();
    let mut sum = 0.0;
    for seed in 0..40 {
        let (readings, wheels) = drawn(&samples, seed);
        let config = Config::new(NOISE_RAD_S as f32);
        let mut filter = Filter::considering(config, wheels, &hardware, &disturbance).unwrap();
        let mut counts = crate::outcome::OutcomeCounts::default();
        readings.iter().for_each(|sample| counts.add(&filter.step(sample)));
        let estimate = filter.estimate();
        assert_eq!((estimate.status, counts.lockout_resets), (Status::Converged, 0), "{seed}");
        assert_eq!(estimate.residuals_white, Some(true), "{seed}");
        sum += nees(&estimate);
    }
    assert!((0.7..1.3).contains(&(sum / 40.0)), "{}", sum / 40.0);
}

/// The same flights by a filter for ideal hardware: overconfident, and none of them called converged and white.
#[test]
fn unstated_errors_are_not_white() {
    let samples = flight();
    for seed in 0..10 {
        let (readings, wheels) = drawn(&samples, seed);
        let mut filter = JointEkfUd::new(Config::new(NOISE_RAD_S as f32), wheels).unwrap();
        readings.iter().for_each(|sample| {
            filter.step(sample);
        });
        let estimate = filter.estimate();
        let is_trusted =
            estimate.status == Status::Converged && estimate.residuals_white == Some(true);
        assert!(!is_trusted, "{seed}");
    }
}

/// Three sigma of the gyro's scale and ten times less noise than stated errors: neither spike, shift nor divergence.
#[test]
fn stated_errors_raise_no_alarm() {
    let mut wheel = (Vec3::from(AXIS), SPIN_INERTIA);
    let mut samples = flight();
    for axis in 0..3 {
        samples =
            with_error(&samples, &mut wheel, Parameter::GyroScale(axis), 3.0 * HARDWARE.gyro_scale);
    }
    let config = Config { prior: filter(wheel).config.prior, ..Config::new(1e-6) };
    let wheels = WheelArray::new([wheel.0], [wheel.1]).unwrap();
    let mut filter = Filter::considering(config, wheels, &HARDWARE, &DISTURBANCE).unwrap();
    filter.step(&samples[0]);
    for (k, sample) in samples.iter().enumerate().skip(1) {
        assert_eq!(filter.step(sample), Outcome::Updated, "{k}");
    }
    assert_ne!(filter.estimate().status, Status::Diverged);
}

/// Columns of no parameter leave every bit; a turn of the sensors adds to the covariance alone.
#[test]
fn ideal_hardware_leaves_the_bits() {
    let wheels = WheelArray::new([Vec3::from(AXIS)], [SPIN_INERTIA]).unwrap();
    let (config, none) = (Config::new(NOISE_RAD_S), Disturbance::none());
    let mut plain = JointEkfUd::new(config, wheels).unwrap();
    let ideal = Hardware::ideal();
    let mut with_places = Filter::considering(config, wheels, &ideal, &none).unwrap();
    let mounted = Hardware { mount_rad: [0.0, 0.01, 0.0], ..ideal };
    let mut mounted = Filter::considering(config, wheels, &mounted, &none).unwrap();
    for sample in &flight() {
        assert_eq!(plain.step(sample), with_places.step(sample));
        mounted.step(sample);
    }
    assert_eq!(plain.estimate(), with_places.estimate());
    assert_eq!(plain.state(), mounted.state());
    let (plain, mounted) = (plain.estimate().sigma_kg_m2(), mounted.estimate());
    assert_eq!(mounted.sigma_random_kg_m2, Some(plain));
    // Jxz by a turn of 0.01 rad about y: (Jzz − Jxx) 0.01.
    assert!((mounted.sigma_systematic_kg_m2()[4] / 0.003 - 1.0).abs() < 0.01);
}

/// A gyro that is late by 0.07 s: readings by interpolation of a flight at a tenth of the period.
#[test]
fn a_known_time_offset_is_corrected() {
    const LATE: u64 = 7;
    let wheels = WheelArray::new([Vec3::from(AXIS)], [SPIN_INERTIA]).unwrap();
    let fine = TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels,
        period_us: 10_000,
        samples: 12_000,
    };
    let fine = fine.fly(|t| [60.0 * (0.7 * t).sin() + 20.0], tumbling_torque_n_m);
    let late: Vec<Sample<f32, 1>> = (10..fine.len())
        .step_by(10)
        .map(|k| Sample { rate_rad_s: fine[k - LATE as usize].rate_rad_s, ..fine[k] })
        .collect();
    let error = |delay_s: f32| {
        let hardware = Hardware { delay_s, delay_sigma_s: 1e-4, ..Hardware::ideal() };
        let known = WheelArray::new([Vec3::from(AXIS).map(|x| x as f32)], [SPIN_INERTIA as f32]);
        let config = Config::new(NOISE_RAD_S as f32);
        let none = Disturbance::none();
        let mut filter = Filter::considering(config, known.unwrap(), &hardware, &none).unwrap();
        late.iter().for_each(|sample| {
            filter.step(sample);
        });
        let found = filter.estimate().inertia.elements_kg_m2();
        (0..6).map(|i| (f64::from(found[i]) - INERTIA[i]).abs()).fold(0.0, f64::max)
    };
    let (corrected, uncorrected) = (error(0.07), error(0.0));
    assert!(corrected < 2e-3 && uncorrected > 5.0 * corrected, "{corrected} {uncorrected}");
}
