//! Tests of the nine-state filter in single precision, in the form that flies.

use super::*;
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::gate::Rejection;
use crate::monitor::observability::Observed;
use crate::outcome::OutcomeCounts;
use proptest::prelude::*;
use std::vec::Vec;

/// Elements of the body, kg m².
const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
/// Gyro noise that the filter is configured for, rad/s; the flights have none.
const NOISE_RAD_S: f64 = 1e-4;
const PERIOD_US: u64 = 100_000;

/// Accepted error after a noiseless minute, kg m²: 0.1 % of the moments.
const CONVERGED: f64 = 1e-3;
/// The same after a change of the body, when the last minute alone counts: 1 %.
const RECONVERGED: f64 = 1e-2;

/// A minute of motion under known torques, without noise: 10 Hz, no wheels.
fn flight(inertia: [f64; 6]) -> Vec<Sample<f32, 0>> {
    let flight = TestFlight {
        inertia_kg_m2: inertia,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels: WheelArray::<f64, 0>::new([], []).unwrap(),
        period_us: PERIOD_US,
        samples: 600,
    };
    flight.fly(|_| [], tumbling_torque_n_m)
}

/// A filter without a prior.
fn filter() -> JointEkfUd<f32, 0> {
    let wheels = WheelArray::new([], []).unwrap();
    JointEkfUd::new(Config::new(NOISE_RAD_S as f32), wheels).unwrap()
}

/// Largest error of an element, kg m², of moments near 1.
fn worst_error(filter: &JointEkfUd<f32, 0>, truth: [f64; 6]) -> f64 {
    let found = filter.estimate().inertia.elements_kg_m2();
    (0..6).map(|i| (f64::from(found[i]) - truth[i]).abs()).fold(0.0, f64::max)
}

/// One [`Reset::Aligned`], then updates to the end.
#[test]
fn without_a_prior_it_aligns_and_converges() {
    let mut filter = filter();
    let outcomes: Vec<Outcome> = flight(INERTIA).iter().map(|sample| filter.step(sample)).collect();
    assert_eq!(outcomes[0], Outcome::Reset(Reset::FirstSample));
    assert_eq!(outcomes[1], Outcome::Coasting(Coasting::Aligning));
    assert_eq!(outcomes.iter().filter(|o| **o == Outcome::Reset(Reset::Aligned)).count(), 1);
    assert_eq!(outcomes[599], Outcome::Updated);
    let estimate = filter.estimate();
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
    assert!(worst_error(&filter, INERTIA) < CONVERGED);
}

/// The prior of an unknown body has sigmas of 1e3 kg m² or more.
#[test]
fn before_any_sample_nothing_is_observed() {
    let estimate = filter().estimate();
    assert_eq!((estimate.status, estimate.observed), (Status::Unobservable, Observed::default()));
    assert!(estimate.sigma_kg_m2().iter().all(|s| *s >= 1e3));
}

/// A NaN, a spike of 0.5 rad/s and a repeated time stamp: each costs one sample.
#[test]
fn faulty_samples_coast_with_their_reason() {
    let mut filter = filter();
    let mut samples = flight(INERTIA);
    samples[400].rate_rad_s.x = f32::NAN;
    samples[420].rate_rad_s.y += 0.5;
    samples[440].time_us = samples[439].time_us;
    let outcomes: Vec<Outcome> = samples.iter().map(|sample| filter.step(sample)).collect();
    let rejected = |why| Outcome::Coasting(Coasting::Rejected(why));
    assert_eq!(outcomes[400], rejected(Rejection::NotFinite));
    assert_eq!(outcomes[420], Outcome::Coasting(Coasting::Spike));
    assert_eq!(outcomes[440], rejected(Rejection::OutOfOrder));
    for next in [401, 421, 441] {
        assert_eq!(outcomes[next], Outcome::Updated, "sample {next}");
    }
    assert!(worst_error(&filter, INERTIA) < CONVERGED);
}

/// 5 s without samples, five times the longest gap that is bridged.
#[test]
fn a_gap_restarts_the_rate_and_keeps_the_inertia() {
    let mut filter = filter();
    let samples = flight(INERTIA);
    samples[..400].iter().for_each(|sample| {
        filter.step(sample);
    });
    let before = filter.estimate();
    assert_eq!(filter.step(&samples[450]), Outcome::Reset(Reset::Gap));
    assert_eq!(filter.rate_rad_s(), samples[450].rate_rad_s);
    assert_eq!(filter.estimate().inertia, before.inertia);
    assert_eq!(filter.step(&samples[451]), Outcome::Updated);
}

/// Three seconds of readings that are not numbers, with a known torque: the prediction is that of the clean flight.
#[test]
fn a_hole_in_the_rate_is_bridged_by_the_drive() {
    let mut filter = filter();
    let samples = flight(INERTIA);
    for (k, sample) in samples.iter().enumerate() {
        let bad = Sample { rate_rad_s: Vec3::repeat(f32::NAN), ..*sample };
        let is_bad = (400..430).contains(&k);
        let outcome = filter.step(if is_bad { &bad } else { sample });
        if is_bad {
            assert_eq!(outcome, Outcome::Coasting(Coasting::Rejected(Rejection::NotFinite)));
            assert!((filter.rate_rad_s() - sample.rate_rad_s).norm() < NOISE_RAD_S as f32);
        } else if k >= 430 {
            assert_eq!(outcome, Outcome::Updated, "sample {k}");
        }
    }
    assert!(worst_error(&filter, INERTIA) < CONVERGED);
}

/// The moments change by 33 to 100 % between two samples.
#[test]
fn a_deployment_locks_out_and_realigns() {
    let deployed = [3.0, 1.6, 2.6, 0.2, -0.1, 0.05];
    let mut filter = filter();
    flight(INERTIA).iter().for_each(|sample| {
        filter.step(sample);
    });
    let later = flight(deployed).into_iter().map(|mut sample| {
        sample.time_us += 600 * PERIOD_US;
        sample
    });
    let outcomes: Vec<Outcome> = later.map(|sample| filter.step(&sample)).collect();
    assert!(outcomes.contains(&Outcome::Reset(Reset::Lockout)));
    assert_eq!(outcomes[599], Outcome::Updated);
    assert_eq!(filter.estimate().status, Status::Converged);
    assert!(worst_error(&filter, deployed) < RECONVERGED);
}

proptest! {
    /// Any bits in rate and torque, and in every third time stamp.
    #[test]
    fn any_sequence_of_samples_leaves_a_finite_estimate(
        bits in prop::collection::vec((any::<u64>(), prop::array::uniform6(any::<u32>())), 50),
        spoil in 0..600usize,
    ) {
        let mut filter = filter();
        let mut samples = flight(INERTIA);
        for (k, (time, values)) in bits.into_iter().enumerate() {
            let [a, b, c, d, e, f] = values.map(f32::from_bits);
            let sample = &mut samples[(spoil + 7 * k) % 600];
            if time % 3 == 0 {
                sample.time_us = time;
            }
            sample.rate_rad_s = Vec3::new(a, b, c);
            sample.torque_n_m = Vec3::new(d, e, f);
        }
        for sample in &samples {
            filter.step(sample);
        }
        let estimate = filter.estimate();
        prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
        prop_assert!(estimate.sigma_kg_m2().iter().all(|x| x.is_finite()));
        prop_assert!(filter.state().iter().all(|x| x.is_finite()));
    }
}

/// Body and noise of the STSAT-3 spin-up: kg m², rad/s.
const STSAT: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
const STSAT_NOISE_RAD_S: f64 = 1.8e-4;
/// Accepted error of a converged estimate, sigmas: 3e-6 of consistent ones exceed it.
const CONSISTENT: f64 = 5.0;

/// The STSAT-3 body from rest under known torques without noise: ten minutes at 10 Hz.
fn spin_up() -> Vec<Sample<f32, 0>> {
    let flight = TestFlight {
        inertia_kg_m2: STSAT,
        initial_rate_rad_s: Vec3::zeros(),
        wheels: WheelArray::<f64, 0>::new([], []).unwrap(),
        period_us: PERIOD_US,
        samples: 6000,
    };
    flight.fly(|_| [], |t| tumbling_torque_n_m(0.3 * t) * if t < 5.0 { 0.0 } else { 1.0 })
}

/// Adds white noise, by xorshift and Box-Muller.
fn with_noise(mut samples: Vec<Sample<f32, 0>>, seed: u64) -> Vec<Sample<f32, 0>> {
    let mut x = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut flat = || {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        ((x >> 11) as f64 / (1u64 << 53) as f64).max(1e-300)
    };
    for sample in &mut samples {
        for axis in 0..3 {
            let (a, b) = (flat(), flat());
            let normal = libm::sqrt(-2.0 * libm::log(a)) * libm::cos(core::f64::consts::TAU * b);
            sample.rate_rad_s[axis] += (STSAT_NOISE_RAD_S * normal) as f32;
        }
    }
    samples
}

/// Status at the end, largest error in sigmas, counts.
fn fly(samples: &[Sample<f32, 0>]) -> (Status, f64, OutcomeCounts) {
    let wheels = WheelArray::new([], []).unwrap();
    let mut filter = JointEkfUd::new(Config::new(STSAT_NOISE_RAD_S as f32), wheels).unwrap();
    let mut counts = OutcomeCounts::default();
    samples.iter().for_each(|sample| counts.add(&filter.step(sample)));
    let estimate = filter.estimate();
    let (found, sigma) = (estimate.inertia.elements_kg_m2(), estimate.sigma_kg_m2());
    let errors = (0..6).map(|i| (f64::from(found[i]) - STSAT[i]).abs() / f64::from(sigma[i]));
    (estimate.status, errors.fold(0.0, f64::max), counts)
}

/// One spike of 20, 100 and 1000 sigma among the first 220 samples, most of them before the
/// alignment ends.
#[test]
fn a_spike_before_the_end_of_the_alignment_is_without_effect() {
    let clean = spin_up();
    for k in 0..60u64 {
        let mut samples = with_noise(clean[..1500].to_vec(), k);
        let (place, axis) = ((k * 37) as usize % 220, k as usize % 3);
        let sigmas = [20.0, 100.0, 1000.0][k as usize / 3 % 3];
        samples[place].rate_rad_s[axis] += (sigmas * STSAT_NOISE_RAD_S) as f32;
        let (status, error, counts) = fly(&samples);
        assert_eq!((status, counts.lockout_resets), (Status::Converged, 0), "{place} {sigmas}");
        assert!(error < CONSISTENT, "{place} {sigmas}: {error}");
        assert!(place < 3 || counts.spike >= 1, "{place} {sigmas}");
    }
}

/// 20 s of a shifted axis, or of one that sticks: no estimate is converged and wrong, neither soon
/// after the fault nor at the end, and at the end all are converged.
#[test]
fn a_fault_of_one_axis_is_never_converged_and_wrong() {
    let clean = spin_up();
    for k in 0..36u64 {
        let mut samples = with_noise(clean[..4000].to_vec(), k);
        let (start, axis) = (800 + (k as usize * 37) % 1000, k as usize % 3);
        let stuck = samples[start].rate_rad_s[axis];
        for sample in &mut samples[start..start + 200] {
            match [1.0f32, 2.0, 3.0, 5.0, 10.0, 0.0][k as usize / 3 % 6] {
                0.0 => sample.rate_rad_s[axis] = stuck,
                sigmas => sample.rate_rad_s[axis] += sigmas * STSAT_NOISE_RAD_S as f32,
            }
        }
        for end in [start + 100, start + 235, start + 250, start + 700, 4000] {
            let (status, error, _) = fly(&samples[..end]);
            assert!(status != Status::Converged || error < CONSISTENT, "{k} {end}: {error}");
            assert!(status == Status::Converged || end < 4000, "{k}");
        }
    }
}

/// Five sigmas on one axis for ten seconds.
#[test]
fn a_shift_is_called_diverged_while_it_lasts() {
    let mut samples = with_noise(spin_up()[..2500].to_vec(), 1);
    for sample in &mut samples[1500..1600] {
        sample.rate_rad_s.y += 5.0 * STSAT_NOISE_RAD_S as f32;
    }
    let status = |end: usize| fly(&samples[..end]).0;
    assert_eq!(
        [status(1500), status(1560), status(2500)],
        [Status::Converged, Status::Diverged, Status::Converged]
    );
}

/// A clean flight: no sample is refused in ten minutes.
#[test]
fn white_noise_raises_no_alarm() {
    let clean = spin_up();
    for seed in 0..10 {
        let (status, error, counts) = fly(&with_noise(clean.clone(), seed));
        assert_eq!((status, counts.spike, counts.lockout_resets), (Status::Converged, 0, 0));
        assert!(error < CONSISTENT);
    }
}

/// A prior of 1 ± 30 kg m², one sample and a minute at rest.
#[test]
fn a_vague_prior_observes_nothing_at_rest() {
    let prior = Prior { inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], sigma_kg_m2: [30.0; 6] };
    let config = Config { prior: Some(prior), ..Config::new(NOISE_RAD_S as f32) };
    for align_above in [0.2, f32::MAX] {
        let config = Config { align_above, ..config };
        let wheels = WheelArray::new([], []).unwrap();
        let mut filter = JointEkfUd::<f32, 0>::new(config, wheels).unwrap();
        let sample = Sample { rate_rad_s: Vec3::zeros(), ..flight(INERTIA)[0] };
        for k in 0..600 {
            let noise = 1e-5 * (k % 7) as f32;
            let rate_rad_s = Vec3::new(noise, 2e-5 - noise, 0.5 * noise);
            filter.step(&Sample { time_us: k * PERIOD_US, rate_rad_s, ..sample });
            if k == 0 || k == 599 {
                let estimate = filter.estimate();
                assert_eq!(estimate.status, Status::Unobservable);
                assert_eq!(estimate.observed, Observed::default());
            }
        }
    }
}
