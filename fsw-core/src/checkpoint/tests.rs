//! Checkpoints of every estimator: resumption, truncation, bit flips, configuration, fingerprints.
//!
//! The property under test: a flight that is interrupted after any sample and resumed from a
//! checkpoint has the outcomes and the state, bit for bit, of the same flight without interruption.
//! Samples come from [`TestFlight`]; generic cases run in both precisions.

use super::*;
use crate::dynamics::wheels::WheelArray;
use crate::estimator::Estimator;
use crate::estimator::ekf_sgf::regression::Elements;
use crate::estimator::ekf_sgf::{self, EkfSgf};
use crate::estimator::joint_ekf::{self, JointEkf, JointEkfPublished, JointEkfUd};
use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::estimator::window::{self, Window};
use crate::hardware::{Disturbance, Hardware};
use crate::math::{Mat, Vec3, scalar::Real};
use crate::outcome::{Outcome, Reset};
use crate::prior::Prior;
use crate::sample::Sample;
use proptest::prelude::*;
use std::vec::Vec;

/// Elements of the first body, kg m².
const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
/// Elements of the second body, after the deployment, kg m².
const DEPLOYED: [f64; 6] = [3.0, 1.6, 2.6, 0.2, -0.1, 0.05];
/// One sigma of the gyro noise, rad/s.
const NOISE_RAD_S: f64 = 1e-4;
/// Sample period, µs.
const PERIOD_US: u64 = 100_000;
/// Samples of each of the two bodies.
const SAMPLES: u64 = 400;

/// One wheel of 1e-3 kg m² along (1, 1, 0).
fn wheels<T: Real>() -> WheelArray<T, 1> {
    let axis = Vec3::new(T::one(), T::one(), T::zero());
    WheelArray::new([axis], [T::lit(1e-3)]).unwrap()
}

/// Noise-free flight of a body under [`tumbling_torque_n_m`].
fn tumble(inertia_kg_m2: [f64; 6]) -> Vec<Sample<f32, 1>> {
    let flight = TestFlight {
        inertia_kg_m2,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels: wheels(),
        period_us: PERIOD_US,
        samples: SAMPLES,
    };
    flight.fly(|t| [100.0 + 50.0 * (0.5 * t).sin()], tumbling_torque_n_m)
}

/// Flight with all events: a body, and a second one after a deployment; gyro noise; samples that are
/// not finite, out of order, repeated, spikes or missing.
fn eventful<T: Real>() -> Vec<Sample<T, 1>> {
    let mut samples = tumble(INERTIA);
    samples.extend(
        tumble(DEPLOYED)
            .into_iter()
            .map(|sample| Sample { time_us: sample.time_us + SAMPLES * PERIOD_US, ..sample }),
    );
    let mut noise = noise();
    for sample in &mut samples {
        sample.rate_rad_s += Vec3::from([0, 1, 2].map(&mut noise));
    }
    samples[250].rate_rad_s.x = f32::NAN;
    samples[260].time_us = samples[259].time_us;
    samples[270].rate_rad_s.y += 0.5;
    for k in 281..295 {
        samples[k].rate_rad_s = samples[280].rate_rad_s;
    }
    samples.drain(320..335);
    samples.iter().map(cast).collect()
}

/// Noise by a linear congruential generator (\[Knuth1997\]), uniform within ±√3 sigma, rad/s.
fn noise() -> impl FnMut(u8) -> f32 {
    let mut state = 1u64;
    move |_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let uniform = (state >> 40) as f64 / (1u64 << 23) as f64 - 1.0;
        (uniform * 3f64.sqrt() * NOISE_RAD_S) as f32
    }
}

/// Sample in the precision under test.
fn cast<T: Real>(sample: &Sample<f32, 1>) -> Sample<T, 1> {
    Sample {
        time_us: sample.time_us,
        rate_rad_s: sample.rate_rad_s.map(T::from_f32),
        wheel_speed_rad_s: sample.wheel_speed_rad_s.map(T::from_f32),
        torque_n_m: sample.torque_n_m.map(T::from_f32),
        attitude: None,
    }
}

/// Nine-state filter without a prior: it aligns on the motion.
fn joint_ekf<T: Real>() -> JointEkfUd<T, 1> {
    JointEkf::new(joint_ekf::Config::new(T::lit(NOISE_RAD_S)), wheels()).unwrap()
}

/// Nine-state filter that considers errors of gyro and wheel, and corrects for a late gyro.
fn considering<T: Real>() -> JointEkfUd<T, 1, 15> {
    let lit = |x: f64| T::lit(x);
    let hardware = Hardware {
        gyro_scale: lit(5e-3),
        gyro_axes_rad: lit(1e-3),
        delay_s: lit(0.02),
        delay_sigma_s: lit(5e-3),
        wheel_inertia: [lit(0.01)],
        wheel_axis_rad: [lit(1e-3)],
        ..Hardware::ideal()
    };
    let config = joint_ekf::Config::new(lit(NOISE_RAD_S));
    JointEkf::considering(config, wheels(), &hardware, &Disturbance::none()).unwrap()
}

/// Nine-state filter as published, with a prior.
fn published<T: Real>() -> JointEkfPublished<T, 1> {
    let config = joint_ekf::Config { prior: Some(prior()), ..joint_ekf::Config::new(T::lit(1e-4)) };
    JointEkf::new(config, wheels()).unwrap()
}

/// Recursive least squares for all six elements.
fn rls<T: Real>() -> EkfSgf<T, 1> {
    let config = ekf_sgf::Config::kim_2013(T::lit(NOISE_RAD_S), prior());
    EkfSgf::new(ekf_sgf::Config { elements: Elements::All, ..config }, wheels()).unwrap()
}

/// Batch least squares.
fn lls<T: Real>() -> EkfSgf<T, 1> {
    EkfSgf::new(ekf_sgf::Config::kim_2016(T::lit(NOISE_RAD_S), prior()), wheels()).unwrap()
}

/// Prior within 30 % of the first body.
fn prior<T: Real>() -> Prior<T> {
    Prior {
        inertia_kg_m2: [1.2, 1.2, 1.2, 0.0, 0.0, 0.0].map(T::lit),
        sigma_kg_m2: [0.2, 0.2, 0.2, 0.1, 0.1, 0.1].map(T::lit),
    }
}

/// Bound on the words of every state in these tests.
const MOST_WORDS: usize = 8192;

/// Words of a state, or the rejection of a number that is not finite.
fn try_to_write<P: Persist>(state: &mut P) -> Result<Vec<u32>, InvalidWord> {
    let mut words = std::vec![0; MOST_WORDS];
    let mut medium = ToWords::new(&mut words);
    transfer(state, &mut medium)?;
    let length = medium.written();
    words.truncate(length);
    Ok(words)
}

/// Words of a state with finite numbers.
fn written<P: Persist>(state: &mut P) -> Vec<u32> {
    try_to_write(state).unwrap()
}

/// Reads a state from words, all of which must be used.
fn read_back<P: Persist>(state: &mut P, words: &[u32]) -> Result<(), InvalidWord> {
    let mut medium = FromWords::new(words);
    transfer(state, &mut medium)?;
    assert_eq!(medium.remaining(), 0);
    Ok(())
}

/// Flight without interruption: outcome of each sample and the whole state after it, as words.
fn uninterrupted<T: Real, E: Estimator<T, 1> + Persist>(
    mut estimator: E,
    samples: &[Sample<T, 1>],
) -> Vec<(Outcome, Vec<u32>)> {
    samples.iter().map(|sample| (estimator.step(sample), written(&mut estimator))).collect()
}

/// Restores the state after each of these samples into a fresh estimator, and compares the rest of the
/// flight: outcomes, and the whole state near the restart and every 50 samples.
fn resumes<T: Real, E: Estimator<T, 1> + Persist>(
    fresh: impl Fn() -> E,
    samples: &[Sample<T, 1>],
    after: impl Iterator<Item = usize>,
) {
    let flown = uninterrupted(fresh(), samples);
    let mut last = fresh();
    samples.iter().for_each(|sample| {
        last.step(sample);
    });
    for at in after {
        let mut restored = fresh();
        read_back(&mut restored, &flown[at].1).unwrap();
        for k in at + 1..samples.len() {
            assert_eq!(restored.step(&samples[k]), flown[k].0, "from {at}, sample {k}");
            if k < at + 20 || k % 50 == 0 {
                assert_eq!(written(&mut restored), flown[k].1, "from {at}, sample {k}");
            }
        }
        assert_eq!(restored.estimate(), last.estimate(), "from {at}");
        assert_eq!(restored.rate_rad_s(), last.rate_rad_s());
        assert_eq!(restored.innovation(), last.innovation());
    }
}

/// Every `step`-th index of a flight.
fn some_of<T: Real>(samples: &[Sample<T, 1>], step: usize) -> impl Iterator<Item = usize> {
    (0..samples.len()).step_by(step)
}

/// The flight of these tests leads to every outcome that the estimators distinguish.
#[test]
fn the_flight_contains_every_event() {
    let outcomes: Vec<Outcome> =
        uninterrupted(joint_ekf::<f32>(), &eventful()).into_iter().map(|(o, _)| o).collect();
    for name in ["aligning", "updated", "not_finite", "out_of_order", "spike", "stuck", "reset_gap"]
    {
        assert!(outcomes.iter().any(|o| o.name() == name), "{name}");
    }
    let aligned = outcomes.iter().filter(|o| **o == Outcome::Reset(Reset::Aligned)).count();
    assert!(outcomes.contains(&Outcome::Reset(Reset::Lockout)));
    assert_eq!(aligned, 2);
}

/// Interruption after every third, eleventh or 37th sample.
#[test]
fn joint_ekf_resumes_bit_for_bit() {
    let (single, double) = (eventful::<f32>(), eventful::<f64>());
    resumes(joint_ekf::<f32>, &single, some_of(&single, 3));
    resumes(joint_ekf::<f64>, &double, some_of(&double, 11));
    resumes(considering::<f32>, &single, some_of(&single, 11));
    resumes(published::<f64>, &double, some_of(&double, 37));
}

/// Interruption after every fifth to 37th sample.
#[test]
fn ekf_sgf_resumes_bit_for_bit() {
    let (single, double) = (eventful::<f32>(), eventful::<f64>());
    resumes(rls::<f32>, &single, some_of(&single, 5));
    resumes(rls::<f64>, &double, some_of(&double, 17));
    resumes(lls::<f32>, &single, some_of(&single, 17));
    resumes(lls::<f64>, &double, some_of(&double, 37));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    /// Random bits in every field of 20 samples, and an interruption at a random sample.
    #[test]
    fn any_flight_resumes_after_any_sample(
        at in 0..400usize,
        bits in prop::collection::vec((any::<u64>(), prop::array::uniform7(any::<u32>())), 20),
        spoil in 0..400usize,
    ) {
        let mut samples = eventful::<f32>();
        samples.truncate(500);
        for (k, (time, values)) in bits.into_iter().enumerate() {
            let [a, b, c, d, e, f, g] = values.map(f32::from_bits);
            let sample = &mut samples[(spoil + 7 * k) % 500];
            if time % 5 == 0 {
                sample.time_us = time;
            }
            (sample.rate_rad_s, sample.torque_n_m) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            sample.wheel_speed_rad_s = [g];
        }
        any_resumes(joint_ekf, &samples, at);
        any_resumes(rls, &samples, at);
        any_resumes(window::<f32, 9>, &samples, at);
        any_resumes(window_18, &samples, at);
    }
}

/// As [`resumes`]. A state with a number that is not finite cannot be written, and ends the test.
fn any_resumes<E: Estimator<f32, 1> + Persist>(
    fresh: impl Fn() -> E,
    samples: &[Sample<f32, 1>],
    at: usize,
) {
    let mut flying = fresh();
    samples[..=at].iter().for_each(|sample| {
        flying.step(sample);
    });
    let Ok(words) = try_to_write(&mut flying) else { return };
    let mut restored = fresh();
    read_back(&mut restored, &words).unwrap();
    for sample in &samples[at + 1..] {
        assert_eq!(restored.step(sample), flying.step(sample));
    }
    assert_eq!(std::format!("{:?}", restored.estimate()), std::format!("{:?}", flying.estimate()));
}

/// Every length below the full one is rejected with the place `end`.
#[test]
fn a_truncated_checkpoint_is_rejected() {
    fn all_rejected<E: Estimator<f32, 1> + Persist>(fresh: impl Fn() -> E) {
        let samples = eventful();
        for (_, words) in uninterrupted(fresh(), &samples).iter().step_by(150) {
            for length in (0..words.len()).step_by(3) {
                let cut = read_back(&mut fresh(), &words[..length]);
                assert_eq!(cut, Err(InvalidWord { place: "end" }), "{length} of {}", words.len());
            }
        }
    }
    all_rejected(joint_ekf);
    all_rejected(rls);
    all_rejected(window::<f32, 9>);
}

/// Flips every `each`-th bit of a checkpoint in turn. An estimator restored from one that is accepted
/// has finite estimates for another 39 samples.
fn flipped_bits<E: Estimator<f32, 1> + Persist>(fresh: impl Fn() -> E, at: usize, each: usize) {
    let samples = eventful();
    let words = uninterrupted(fresh(), &samples[..=at]).pop().unwrap().1;
    let (mut rejected, mut finite) = (0, 0);
    for bit in (0..32 * words.len()).step_by(each) {
        let mut flipped = words.clone();
        flipped[bit / 32] ^= 1 << (bit % 32);
        let mut estimator = fresh();
        let mut medium = FromWords::new(&flipped);
        // A state shorter than the checkpoint is rejected by its length.
        if transfer(&mut estimator, &mut medium).is_err() || medium.remaining() > 0 {
            rejected += 1;
            continue;
        }
        for sample in &samples[at + 1..at + 40] {
            estimator.step(sample);
        }
        let estimate = estimator.estimate();
        assert!(
            estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()),
            "bit {bit} of {at}: {estimate:?}"
        );
        assert!(
            estimate.sigma_kg_m2().iter().all(|x| x.is_finite()),
            "bit {bit} of {at}: {estimate:?}"
        );
        assert!(estimate.residual_rms_rad_s.is_finite(), "bit {bit} of {at}: {estimate:?}");
        assert!(
            estimator.rate_rad_s().iter().all(|x| x.is_finite()),
            "bit {bit} of {at}: {estimate:?}"
        );
        finite += 1;
    }
    assert!(rejected > 0 && finite > 0, "{rejected} rejected, {finite} finite");
}

/// Bit flips at several times of the flight, in every phase of the estimators.
#[test]
fn a_flipped_bit_is_rejected_or_leaves_finite_numbers() {
    for at in [3, 100, 240, 500] {
        flipped_bits(joint_ekf, at, 1);
    }
    for at in [3, 300] {
        flipped_bits(rls, at, 1);
    }
    // Every third or eleventh bit of a larger state: both are prime to 32, so that every place in a word
    // is covered.
    for at in [10, 100, 240, 500] {
        flipped_bits(window::<f32, 9>, at, 3);
    }
    for at in [100, 500] {
        flipped_bits(window_18, at, 11);
    }
}

/// Tags, flags and numbers outside their type, in both directions.
#[test]
fn an_undefined_value_is_rejected() {
    fn is_rejected<P: Persist>(mut state: P, word: u32) -> bool {
        let outcome = transfer(&mut state, &mut FromWords::new(&[word, 0]));
        outcome.is_err_and(|why| why.place != "end")
    }
    assert!(is_rejected(false, 2));
    assert!(is_rejected(None::<u32>, 2));
    assert!(is_rejected(0u16, 0x1_0000));
    assert!(is_rejected(0f32, f32::NAN.to_bits()));
    assert!(is_rejected(0f32, f32::INFINITY.to_bits()));
    assert!(is_rejected(Elements::All, 2));
    let mut not_a_number = f64::NAN;
    assert!(try_to_write(&mut not_a_number).is_err(), "nor is it written");
}

/// Another gyro noise, another unknown, another wheel.
#[test]
fn another_configuration_is_rejected() {
    let words = written(&mut joint_ekf::<f32>());
    let config = joint_ekf::Config::new(2.0 * NOISE_RAD_S as f32);
    let mut other = JointEkfUd::<f32, 1>::new(config, wheels()).unwrap();
    let configuration = Err(InvalidWord { place: "configuration" });
    assert_eq!(read_back(&mut other, &words), configuration);

    let with_bias = window::Config { gyro_bias_rad_s: Some(1e-3), ..window_config() };
    let mut other = Window::<f32, 1, 64, 15>::new(with_bias, wheels()).unwrap();
    let words_window = written(&mut window::<f32, 15>());
    assert_eq!(read_back(&mut other, &words_window), configuration);

    let heavier = WheelArray::new([Vec3::new(1.0, 1.0, 0.0)], [2e-3]).unwrap();
    let config = joint_ekf::Config::new(NOISE_RAD_S as f32);
    let mut other = JointEkfUd::<f32, 1>::new(config, heavier).unwrap();
    assert_eq!(read_back(&mut other, &words), configuration);
}

/// A prior set by telecommand is restored into an estimator configured without it.
#[test]
fn a_prior_is_part_of_the_state() {
    let config = joint_ekf::Config::new(NOISE_RAD_S as f32);
    let with_prior = joint_ekf::Config { prior: Some(prior()), ..config };
    let mut reference = JointEkfUd::<f32, 1>::new(with_prior, wheels()).unwrap();
    let mut restored = joint_ekf::<f32>();
    read_back(&mut restored, &written(&mut reference)).unwrap();
    assert_eq!(written(&mut restored), written(&mut reference));
    for sample in &eventful() {
        assert_eq!(restored.step(sample), reference.step(sample));
    }

    let other = Prior { sigma_kg_m2: [0.3; 6], ..prior() };
    let config =
        ekf_sgf::Config { elements: Elements::All, ..ekf_sgf::Config::kim_2013(1e-4, other) };
    let mut reference = EkfSgf::<f32, 1>::new(config, wheels()).unwrap();
    let mut restored = rls::<f32>();
    read_back(&mut restored, &written(&mut reference)).unwrap();
    for sample in &eventful() {
        assert_eq!(restored.step(sample), reference.step(sample));
    }
    assert_eq!(restored.estimate(), reference.estimate());

    let config = window::Config { prior: Some(prior()), ..window_config() };
    let mut reference = Window::<f32, 1, 64, 9>::new(config, wheels()).unwrap();
    let mut restored = window::<f32, 9>();
    read_back(&mut restored, &written(&mut reference)).unwrap();
    for sample in &eventful() {
        assert_eq!(restored.step(sample), reference.step(sample));
    }
    assert_eq!(restored.estimate(), reference.estimate());
}

/// The condition of a type is checked on reading.
#[test]
fn an_unphysical_prior_is_rejected() {
    let mut prior = prior::<f32>();
    let mut words = written(&mut prior);
    words[0] = 10f32.to_bits();
    assert!(read_back(&mut prior, &words).is_err());
}

/// The words that follow a state are left to the next one.
#[test]
fn two_states_follow_one_another() {
    let mut words = [0; 8];
    let mut medium = ToWords::new(&mut words);
    transfer(&mut (1u32, 2.0f64), &mut medium).unwrap();
    transfer(&mut 3u8, &mut medium).unwrap();
    assert_eq!(medium.written(), 4);
    let mut medium = FromWords::new(&words);
    let mut states = ((0u32, 0.0f64), 0u8);
    transfer(&mut states.0, &mut medium).unwrap();
    assert_eq!(medium.remaining(), 5);
    transfer(&mut states.1, &mut medium).unwrap();
    assert_eq!((states, medium.remaining()), (((1, 2.0), 3), 4));
}

/// Published values of FNV-1a, 32 bits.
#[test]
fn hash_of_a_name_is_that_of_the_definition() {
    for (text, hash) in [("", 0x811c_9dc5), ("a", 0xe40c_292c), ("foobar", 0xbf9c_f968)] {
        assert_eq!(crate::persist::name(text), hash, "{text}");
    }
}

/// Names, types, order and role of the fields, sizes and precision enter the fingerprint.
#[test]
fn each_layout_has_its_own_fingerprint() {
    struct A {
        x: u32,
        y: u32,
    }
    struct B {
        x: u32,
        y: u16,
    }
    struct C {
        x: u32,
        y: Option<u32>,
    }
    crate::persist!([] A { x, y });
    crate::persist!([] B { x, y });
    crate::persist!([] C { x, y });
    mod renamed {
        pub struct A {
            pub x: u32,
            pub z: u32,
        }
        crate::persist!([] A { x, z });
    }
    mod reordered {
        pub struct A {
            pub x: u32,
            pub y: u32,
        }
        crate::persist!([] A { y, x });
    }
    mod configured {
        pub struct A {
            pub x: u32,
            pub y: u32,
        }
        crate::persist!([] A { y; unchanged x });
    }
    let mut all = std::vec![
        fingerprint::<A>(),
        fingerprint::<B>(),
        fingerprint::<C>(),
        fingerprint::<renamed::A>(),
        fingerprint::<reordered::A>(),
        fingerprint::<configured::A>(),
        fingerprint::<(A, B)>(),
        fingerprint::<(B, A)>(),
        fingerprint::<(A, C)>(),
        fingerprint::<Mat<f32, 2, 3>>(),
        fingerprint::<Mat<f32, 3, 2>>(),
        fingerprint::<Mat<f64, 2, 3>>(),
        fingerprint::<Mat<f32, 2, 2>>(),
        fingerprint::<Option<u8>>(),
        fingerprint::<Option<u16>>(),
        fingerprint::<[A; 2]>(),
        fingerprint::<[A; 3]>(),
        fingerprint::<JointEkfUd<f32, 4>>(),
        fingerprint::<JointEkfUd<f32, 3>>(),
        fingerprint::<JointEkfUd<f64, 4>>(),
        fingerprint::<JointEkfUd<f32, 4, 24>>(),
        fingerprint::<JointEkfPublished<f32, 4>>(),
        fingerprint::<EkfSgf<f32, 4>>(),
        fingerprint::<EkfSgf<f32, 4, 16>>(),
        fingerprint::<Window<f32, 4, 512, 9>>(),
        fingerprint::<Window<f32, 4, 256, 9>>(),
        fingerprint::<Window<f32, 4, 512, 12>>(),
    ];
    let layouts = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), layouts);
}

/// Two rest-to-rest manoeuvres, the second one with the deployed body.
fn two_manoeuvres<T: Real>() -> Vec<Sample<T, 1>> {
    let shake = |inertia_kg_m2, start: u64| {
        let flight = TestFlight {
            inertia_kg_m2,
            initial_rate_rad_s: Vec3::zeros(),
            wheels: wheels(),
            period_us: PERIOD_US,
            samples: 700,
        };
        let torque = |t: f64| {
            let pulse = |from: f64| match t - from {
                0.0..4.0 => 0.05,
                4.0..8.0 => -0.05,
                _ => 0.0,
            };
            Vec3::new(pulse(0.0), pulse(8.0), pulse(16.0))
        };
        let flown = flight.fly(|_| [100.0], torque);
        flown.into_iter().map(move |s| Sample { time_us: s.time_us + start * PERIOD_US, ..s })
    };
    let mut samples: Vec<Sample<f32, 1>> = shake(INERTIA, 0).chain(shake(DEPLOYED, 700)).collect();
    let mut noise = noise();
    for sample in &mut samples {
        sample.rate_rad_s += Vec3::from([0, 1, 2].map(&mut noise));
    }
    samples.iter().map(cast).collect()
}

/// Window with U unknowns and known gyro noise.
fn window<T: Real, const U: usize>() -> Window<T, 1, 64, U> {
    Window::new(window_config(), wheels()).unwrap()
}

/// Configuration with a short end of a manoeuvre, so that the test flights close windows.
fn window_config<T: Real>() -> window::Config<T, 1> {
    let noise = T::lit(NOISE_RAD_S);
    window::Config {
        quiet_s: T::lit(8.0),
        block_samples: 2,
        slices_per_step: 16,
        ..window::Config::new(noise)
    }
}

/// Window with 18 unknowns, unknown gyro noise, disturbance torque and gyro bias.
fn window_18<T: Real>() -> Window<T, 1, 64, 18> {
    let config = window::Config {
        gyro_noise_rad_s: None,
        disturbance_torque_n_m: Some(T::lit(1e-3)),
        gyro_bias_rad_s: Some(T::lit(1e-3)),
        ..window_config()
    };
    Window::new(config, wheels()).unwrap()
}

/// The two flights lead to open and closed windows, spikes and gaps.
#[test]
fn the_flights_of_the_window_contain_every_event() {
    let has_all = |samples: &[Sample<f32, 1>], names: &[&str]| {
        let mut window = window::<f32, 9>();
        let mut found = std::collections::BTreeSet::new();
        for sample in samples {
            found.insert(window.step(sample).name());
            found.insert(if window.is_open() { "open" } else { "closed" });
        }
        assert!(names.iter().all(|name| found.contains(name)), "{found:?}");
    };
    has_all(&eventful(), &["aligning", "updated", "spike", "reset_gap", "open"]);
    has_all(&two_manoeuvres(), &["updated", "closed", "open"]);
}

/// Interruption after every third to 37th sample, for 9, 12 and 18 unknowns.
#[test]
fn window_resumes_bit_for_bit() {
    let (single, double) = (eventful::<f32>(), eventful::<f64>());
    resumes(window::<f32, 9>, &single, some_of(&single, 3));
    resumes(window::<f64, 12>, &double, some_of(&double, 31));
    resumes(window_18::<f32>, &single, some_of(&single, 31));
    let (single, double) = (two_manoeuvres::<f32>(), two_manoeuvres::<f64>());
    resumes(window::<f32, 9>, &single, some_of(&single, 7));
    resumes(window::<f64, 9>, &double, some_of(&double, 37));
}
