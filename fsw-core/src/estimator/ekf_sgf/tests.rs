//! Tests of the filter, the differentiator and the regression together.

use super::*;
use crate::estimator::ekf_sgf::regression::Elements;
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::gate::Rejection;
use crate::math::savgol::Fit;
use crate::prior::Prior;
use proptest::prelude::*;
use std::vec::Vec;

const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
const NOISE_RAD_S: f64 = 1e-5;
const PERIOD_US: u64 = 50_000;
const PERIOD_S: f64 = 0.05;

fn prior() -> Prior<f32> {
    Prior {
        inertia_kg_m2: [1.2, 1.2, 1.2, 0.0, 0.0, 0.0],
        sigma_kg_m2: [1.0, 1.0, 1.0, 0.5, 0.5, 0.5],
    }
}

fn wheel_speed(t: f64) -> f64 {
    100.0 + 50.0 * (0.5 * t).sin()
}

fn wheel<T: Real>() -> WheelArray<T, 1> {
    let axis = Vec3::new(T::one(), T::one(), T::zero());
    WheelArray::new([axis], [T::lit(1e-3)]).unwrap()
}

/// 100 s of known torques and one wheel that speeds up and down, without noise: 20 Hz.
fn tumble() -> Vec<Sample<f32, 1>> {
    let flight = TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels: wheel(),
        period_us: PERIOD_US,
        samples: 2000,
    };
    flight.fly(|t| [wheel_speed(t)], tumbling_torque_n_m)
}

fn lls() -> EkfSgf<f32, 1> {
    EkfSgf::new(Config::kim_2016(NOISE_RAD_S as f32, prior()), wheel()).unwrap()
}

fn rls(elements: Elements) -> EkfSgf<f32, 1> {
    let config = Config { elements, ..Config::kim_2013(NOISE_RAD_S as f32, prior()) };
    EkfSgf::new(config, wheel()).unwrap()
}

fn fly(chain: &mut EkfSgf<f32, 1>, samples: &[Sample<f32, 1>]) -> Vec<Outcome> {
    samples.iter().map(|sample| chain.step(sample)).collect()
}

fn worst_error(chain: &EkfSgf<f32, 1>) -> f64 {
    let found = chain.estimate().inertia.elements_kg_m2();
    (0..6).map(|i| (f64::from(found[i]) - INERTIA[i]).abs()).fold(0.0, f64::max)
}

/// The parabola over six samples of 0.05 s blurs motions of up to 0.9 rad/s by about
/// (0.9 · 0.3 / 2)² / 6, and the nominal inertia's lag adds as much: kg m² of moments near 1.
const BLUR: f64 = 1e-2;

#[test]
fn lls_converges_on_a_quiet_flight_with_a_wheel() {
    let mut chain = lls();
    let outcomes = fly(&mut chain, &tumble());
    assert_eq!(outcomes[0], Outcome::Reset(Reset::FirstSample));
    assert_eq!(outcomes[1], Outcome::Coasting(Coasting::Refilling));
    assert!(outcomes[6..].iter().all(|o| *o == Outcome::Updated));
    let estimate = chain.estimate();
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
    assert!(worst_error(&chain) < BLUR, "{:?}", estimate.inertia);
}

#[test]
fn rls_converges_with_six_elements() {
    let mut chain = rls(Elements::All);
    fly(&mut chain, &tumble());
    assert_eq!(chain.estimate().observed.directions, 6);
    assert!(worst_error(&chain) < BLUR, "{:?}", chain.estimate().inertia);
}

#[test]
fn rls_with_three_moments_says_that_products_are_not_seen() {
    let mut chain = rls(Elements::Moments);
    fly(&mut chain, &tumble());
    let estimate = chain.estimate();
    assert_eq!(estimate.observed.element[3..], [false; 3]);
    for k in 0..3 {
        let error = f64::from(estimate.inertia.elements_kg_m2()[k]) - INERTIA[k];
        assert!(error.abs() < 3.0 * f64::from(estimate.sigma_kg_m2()[k]));
    }
}

#[test]
fn lls_says_nothing_before_the_first_interval_ends() {
    let (mut chain, samples) = (lls(), tumble());
    fly(&mut chain, &samples[..800]);
    assert_eq!(chain.estimate().status, Status::Unobservable);
    assert_eq!(chain.estimate().inertia.elements_kg_m2()[0], prior().inertia_kg_m2[0]);
    fly(&mut chain, &samples[800..801]);
    assert_ne!(chain.estimate().status, Status::Unobservable);
}

#[test]
fn each_instant_balances_whatever_the_window() {
    // Also at the newest sample and between two: the terms belong together.
    let j = Inertia::new(INERTIA).matrix_kg_m2();
    for fit in [Fit::centred(6, 2, 1), Fit::centred(7, 2, 1), Fit::newest(5, 3, 1)] {
        let config = Config { fit, ..Config::kim_2016(NOISE_RAD_S as f32, prior()) };
        let mut chain = EkfSgf::<f32, 1>::new(config, wheel()).unwrap();
        let mut worst = 0.0f64;
        for (k, sample) in tumble().iter().enumerate() {
            chain.step(sample);
            let Some(i) = chain.last_instant().filter(|_| k > 200) else { continue };
            let (w, a) = (i.rate_rad_s.map(f64::from), i.acceleration_rad_s2.map(f64::from));
            let balance = j * a + w.cross(&(j * w)) - i.torque_n_m.map(f64::from);
            worst = worst.max(balance.norm());
        }
        // Torques of 0.03 N m; a delay of one sample would cost 1e-3.
        assert!(worst < 3e-4, "{fit:?}: {worst}");
    }
}

#[test]
fn a_spin_about_one_axis_shows_three_elements() {
    // Made up: a body on a bearing about z, the bearing's torque known.
    let j = Inertia::new(INERTIA).matrix_kg_m2();
    let spin = |k: u64| {
        let t = k as f64 * PERIOD_S * 0.2;
        let (w, a) = (Vec3::z() * (0.1 * t.sin()), Vec3::z() * (0.02 * t.cos()));
        let torque = j * a + w.cross(&(j * w));
        Sample {
            time_us: k * PERIOD_US,
            rate_rad_s: w.map(|x: f64| x as f32),
            wheel_speed_rad_s: [0.0],
            torque_n_m: torque.map(|x| x as f32),
            attitude: None,
        }
    };
    let mut chain = lls();
    fly(&mut chain, &(0..2000).map(spin).collect::<Vec<_>>());
    let estimate = chain.estimate();
    assert_eq!(estimate.observed.element, [false, false, true, false, true, true]);
    assert_ne!(estimate.status, Status::Converged);
    for k in [0, 1, 3] {
        let shift = estimate.inertia.elements_kg_m2()[k] - prior().inertia_kg_m2[k];
        assert!(shift.abs() < prior().sigma_kg_m2[k]);
        assert!(estimate.sigma_kg_m2()[k] > 0.5 * prior().sigma_kg_m2[k]);
    }
}

#[test]
fn broken_samples_are_passed_over_for_their_reason() {
    let (mut chain, mut samples) = (lls(), tumble());
    samples[400].rate_rad_s.x = f32::NAN;
    samples[820].rate_rad_s.y += 0.5;
    let outcomes = fly(&mut chain, &samples);
    assert_eq!(outcomes[400], Outcome::Coasting(Coasting::Rejected(Rejection::NotFinite)));
    // A missing sample makes the next interval uneven, and the window fills again.
    assert_eq!(outcomes[401], Outcome::Coasting(Coasting::Refilling));
    assert_eq!(outcomes[406], Outcome::Updated);
    assert_eq!(outcomes[820], Outcome::Coasting(Coasting::Spike));
    assert_eq!(outcomes[821], Outcome::Updated);
    assert!(worst_error(&chain) < BLUR);
}

#[test]
fn a_gap_keeps_the_sums() {
    let (mut chain, samples) = (rls(Elements::All), tumble());
    fly(&mut chain, &samples[..1000]);
    let before = chain.estimate().inertia;
    assert_eq!(chain.step(&samples[1100]), Outcome::Reset(Reset::Gap));
    assert_eq!(chain.estimate().inertia, before);
    assert_eq!(chain.rate_rad_s(), samples[1100].rate_rad_s);
}

proptest! {
    #[test]
    fn any_sequence_of_samples_leaves_a_finite_estimate(
        bits in prop::collection::vec((any::<u64>(), prop::array::uniform7(any::<u32>())), 50),
        spoil in 0..900usize,
    ) {
        let mut samples = tumble()[..900].to_vec();
        for (k, (time, values)) in bits.into_iter().enumerate() {
            let [a, b, c, d, e, f, g] = values.map(f32::from_bits);
            let sample = &mut samples[(spoil + 7 * k) % 900];
            if time % 3 == 0 {
                sample.time_us = time;
            }
            sample.rate_rad_s = Vec3::new(a, b, c);
            sample.torque_n_m = Vec3::new(d, e, f);
            sample.wheel_speed_rad_s = [g];
        }
        for mut chain in [lls(), rls(Elements::Moments)] {
            fly(&mut chain, &samples);
            let estimate = chain.estimate();
            prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
            prop_assert!(estimate.covariance_kg2_m4.iter().all(|x| x.is_finite()));
            prop_assert!(chain.rate_rad_s().iter().all(|x| x.is_finite()));
        }
    }
}
