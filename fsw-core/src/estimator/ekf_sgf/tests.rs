//! Tests of the filter, the differentiator and the regression together.

use super::*;
use crate::estimator::ekf_sgf::regression::Elements;
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::gate::Rejection;
use crate::math::savgol::Fit;
use crate::prior::Prior;
use proptest::prelude::*;
use std::vec::Vec;

/// Elements of the body, kg m².
const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
const NOISE_RAD_S: f64 = 1e-5;
const PERIOD_US: u64 = 50_000;
const PERIOD_S: f64 = 0.05;

/// Nominal inertia, up to 0.6 kg m² from the truth.
fn prior() -> Prior<f32> {
    Prior {
        inertia_kg_m2: [1.2, 1.2, 1.2, 0.0, 0.0, 0.0],
        sigma_kg_m2: [1.0, 1.0, 1.0, 0.5, 0.5, 0.5],
    }
}

/// Speed of the wheel at time t (s), rad/s.
fn wheel_speed(t: f64) -> f64 {
    100.0 + 50.0 * (0.5 * t).sin()
}

/// One wheel about an axis in the x-y plane.
fn wheel<T: Real>() -> WheelArray<T, 1> {
    let axis = Vec3::new(T::one(), T::one(), T::zero());
    WheelArray::new([axis], [T::lit(1e-3)]).unwrap()
}

/// 100 s of known torques and one wheel of changing speed, without noise, at 20 Hz.
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

/// `ekf-sgf-lls`.
fn lls() -> EkfSgf<f32, 1> {
    EkfSgf::new(Config::kim_2016(NOISE_RAD_S as f32, prior()), wheel()).unwrap()
}

/// `ekf-sgf-rls`, for three moments or six elements.
fn rls(elements: Elements) -> EkfSgf<f32, 1> {
    let config = Config { elements, ..Config::kim_2013(NOISE_RAD_S as f32, prior()) };
    EkfSgf::new(config, wheel()).unwrap()
}

fn fly(estimator: &mut EkfSgf<f32, 1>, samples: &[Sample<f32, 1>]) -> Vec<Outcome> {
    samples.iter().map(|sample| estimator.step(sample)).collect()
}

/// Largest error of an element, kg m².
fn worst_error(estimator: &EkfSgf<f32, 1>) -> f64 {
    let found = estimator.estimate().inertia.elements_kg_m2();
    (0..6).map(|i| (f64::from(found[i]) - INERTIA[i]).abs()).fold(0.0, f64::max)
}

/// Systematic error, kg m², of moments near 1: the parabola over six samples of 0.05 s smooths
/// motions of up to 0.9 rad/s by about (0.9 · 0.3 / 2)² / 6, and the lag of the nominal inertia
/// adds as much.
const BLUR: f64 = 1e-2;

/// The window of six is full from the sixth sample on.
#[test]
fn lls_converges_on_a_quiet_flight_with_a_wheel() {
    let mut estimator = lls();
    let outcomes = fly(&mut estimator, &tumble());
    assert_eq!(outcomes[0], Outcome::Reset(Reset::FirstSample));
    assert_eq!(outcomes[1], Outcome::Coasting(Coasting::Refilling));
    assert!(outcomes[6..].iter().all(|o| *o == Outcome::Updated));
    let estimate = estimator.estimate();
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
    assert!(worst_error(&estimator) < BLUR, "{:?}", estimate.inertia);
}

#[test]
fn rls_converges_with_six_elements() {
    let mut estimator = rls(Elements::All);
    fly(&mut estimator, &tumble());
    assert_eq!(estimator.estimate().observed.directions, 6);
    assert!(worst_error(&estimator) < BLUR, "{:?}", estimator.estimate().inertia);
}

/// The error by the neglected products is within three sigma.
#[test]
fn rls_of_three_moments_reports_products_unobserved() {
    let mut estimator = rls(Elements::Moments);
    fly(&mut estimator, &tumble());
    let estimate = estimator.estimate();
    assert_eq!(estimate.observed.element[3..], [false; 3]);
    for k in 0..3 {
        let error = f64::from(estimate.inertia.elements_kg_m2()[k]) - INERTIA[k];
        assert!(error.abs() < 3.0 * f64::from(estimate.sigma_kg_m2()[k]));
    }
}

/// Sample 800 at 20 Hz is the first at 40 s.
#[test]
fn lls_has_no_estimate_before_the_first_interval_ends() {
    let (mut estimator, samples) = (lls(), tumble());
    fly(&mut estimator, &samples[..800]);
    assert_eq!(estimator.estimate().status, Status::Unobservable);
    assert_eq!(estimator.estimate().inertia.elements_kg_m2()[0], prior().inertia_kg_m2[0]);
    fly(&mut estimator, &samples[800..801]);
    assert_ne!(estimator.estimate().status, Status::Unobservable);
}

/// `J ω̇ + ω × J ω − τ` with the true J, N m.
#[test]
fn each_instant_balances_for_any_window() {
    // Evaluation points at the newest sample and between two samples are among them.
    let j = Inertia::new(INERTIA).matrix_kg_m2();
    for fit in [Fit::centred(6, 2, 1), Fit::centred(7, 2, 1), Fit::newest(5, 3, 1)] {
        let config = Config { fit, ..Config::kim_2016(NOISE_RAD_S as f32, prior()) };
        let mut estimator = EkfSgf::<f32, 1>::new(config, wheel()).unwrap();
        let mut worst = 0.0f64;
        for (k, sample) in tumble().iter().enumerate() {
            estimator.step(sample);
            let Some(i) = estimator.last_instant().filter(|_| k > 200) else { continue };
            let (w, a) = (i.rate_rad_s.map(f64::from), i.acceleration_rad_s2.map(f64::from));
            let balance = j * a + w.cross(&(j * w)) - i.torque_n_m.map(f64::from);
            worst = worst.max(balance.norm());
        }
        // Torques of 0.03 N m; a delay of one sample would cost 1e-3.
        assert!(worst < 3e-4, "{fit:?}: {worst}");
    }
}

#[test]
fn a_spin_about_one_axis_observes_three_elements() {
    // A body on a bearing about z, with the bearing's torque known.
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
    let mut estimator = lls();
    fly(&mut estimator, &(0..2000).map(spin).collect::<Vec<_>>());
    let estimate = estimator.estimate();
    assert_eq!(estimate.observed.element, [false, false, true, false, true, true]);
    assert_ne!(estimate.status, Status::Converged);
    for k in [0, 1, 3] {
        let shift = estimate.inertia.elements_kg_m2()[k] - prior().inertia_kg_m2[k];
        assert!(shift.abs() < prior().sigma_kg_m2[k]);
        assert!(estimate.sigma_kg_m2()[k] > 0.5 * prior().sigma_kg_m2[k]);
    }
}

#[test]
fn faulty_samples_coast_with_their_reason() {
    let (mut estimator, mut samples) = (lls(), tumble());
    samples[400].rate_rad_s.x = f32::NAN;
    samples[820].rate_rad_s.y += 0.5;
    let outcomes = fly(&mut estimator, &samples);
    assert_eq!(outcomes[400], Outcome::Coasting(Coasting::Rejected(Rejection::NotFinite)));
    // A missing sample makes the next interval uneven, so the window restarts.
    assert_eq!(outcomes[401], Outcome::Coasting(Coasting::Refilling));
    assert_eq!(outcomes[406], Outcome::Updated);
    assert_eq!(outcomes[820], Outcome::Coasting(Coasting::Spike));
    assert_eq!(outcomes[821], Outcome::Updated);
    assert!(worst_error(&estimator) < BLUR);
}

/// 5 s without samples: the estimate is unchanged, the rate is the sample's.
#[test]
fn a_gap_keeps_the_sums() {
    let (mut estimator, samples) = (rls(Elements::All), tumble());
    fly(&mut estimator, &samples[..1000]);
    let before = estimator.estimate().inertia;
    assert_eq!(estimator.step(&samples[1100]), Outcome::Reset(Reset::Gap));
    assert_eq!(estimator.estimate().inertia, before);
    assert_eq!(estimator.rate_rad_s(), samples[1100].rate_rad_s);
}

proptest! {
    /// Any bits in rate, torque and wheel speed, and in every third time stamp.
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
        for mut estimator in [lls(), rls(Elements::Moments)] {
            fly(&mut estimator, &samples);
            let estimate = estimator.estimate();
            prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
            prop_assert!(estimate.covariance_kg2_m4.iter().all(|x| x.is_finite()));
            prop_assert!(estimator.rate_rad_s().iter().all(|x| x.is_finite()));
        }
    }
}
