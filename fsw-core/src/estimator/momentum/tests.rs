//! Tests of the four methods.

use super::*;
use crate::attitude::Quaternion;
use crate::prior::Prior;
use proptest::prelude::*;
use std::vec::Vec;

/// Elements of the body, kg m².
const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
const NOISE_RAD_S: f64 = 1e-4;
const PERIOD_US: u64 = 100_000;
const PERIOD_S: f64 = 0.1;
/// Spin inertia of each wheel.
const WHEEL_KG_M2: f64 = 1e-3;
/// Momentum in inertial axes at the start, N m s: that of spinning wheels.
const INITIAL_MOMENTUM: [f64; 3] = [0.05, -0.08, 0.03];
const METHODS: [Method; 4] =
    [Method::Batch, Method::Conventional, Method::PreEstimate, Method::Suggested];

/// Prescribed motion: three orthogonal wheels take up the momentum that it needs.
struct Flight<'a> {
    inertia: [f64; 6],
    seconds: f64,
    rate: &'a dyn Fn(f64) -> Vec3<f64>,
    /// Constant external torque in inertial axes, N m.
    torque: Vec3<f64>,
}

impl Flight<'_> {
    /// Samples without noise. The attitude is integrated in steps of a twentieth of a sample.
    fn samples(&self) -> Vec<Sample<f64, 3>> {
        let j = Inertia::new(self.inertia).matrix_kg_m2();
        let fine = 20;
        let dt = PERIOD_S / f64::from(fine);
        let mut q = [0.1, -0.3, 0.2, 0.86f64.sqrt()];
        let mut samples = Vec::new();
        for k in 0..=(self.seconds / PERIOD_S) as u64 {
            let t = k as f64 * PERIOD_S;
            let attitude = Quaternion::new(q);
            let to_body = attitude.to_body().unwrap();
            let momentum = Vec3::from(INITIAL_MOMENTUM) + self.torque * t;
            let rate = (self.rate)(t);
            let h_w = to_body * momentum - j * rate;
            samples.push(Sample {
                time_us: k * PERIOD_US,
                rate_rad_s: rate,
                wheel_speed_rad_s: (h_w / WHEEL_KG_M2).into(),
                torque_n_m: to_body * self.torque,
                attitude: Some(attitude),
            });
            for i in 0..fine {
                q = turned(q, &((self.rate)(t + (f64::from(i) + 0.5) * dt) * dt));
            }
        }
        samples
    }
}

/// q after a small turn of the body: `q̇ = ½ Ω(ω) q`, scalar last, to third order and scaled
/// to one.
fn turned(q: [f64; 4], angle: &Vec3<f64>) -> [f64; 4] {
    let [q1, q2, q3, q4] = q;
    let half = angle * (0.5 - angle.norm_squared() / 48.0);
    let (v, w) = (Vec3::new(q1, q2, q3), 1.0 - angle.norm_squared() / 8.0);
    let v = v * w + half * q4 + v.cross(&half);
    let w = q4 * w - Vec3::new(q1, q2, q3).dot(&half);
    let norm = (v.norm_squared() + w * w).sqrt();
    [v.x / norm, v.y / norm, v.z / norm, w / norm]
}

/// Three orthogonal wheels.
fn wheels<T: Real>() -> WheelArray<T, 3> {
    WheelArray::new([Vec3::x(), Vec3::y(), Vec3::z()], [T::lit(WHEEL_KG_M2); 3]).unwrap()
}

/// The same sample in single precision.
fn narrow(s: &Sample<f64, 3>) -> Sample<f32, 3> {
    Sample {
        time_us: s.time_us,
        rate_rad_s: s.rate_rad_s.map(|x| x as f32),
        wheel_speed_rad_s: s.wheel_speed_rad_s.map(|x| x as f32),
        torque_n_m: s.torque_n_m.map(|x| x as f32),
        attitude: s.attitude.map(|q| Quaternion::new(q.elements().map(|x| x as f32))),
    }
}

/// The paper's method for gyro noise of [`NOISE_RAD_S`].
fn config(method: Method) -> Config<f64> {
    Config::kim_2010(method, NOISE_RAD_S)
}

/// Estimate of a flight in double precision.
fn fly(config: Config<f64>, samples: &[Sample<f64, 3>]) -> Estimate<f64> {
    let mut estimator = Momentum::new(config, wheels()).unwrap();
    for sample in samples {
        estimator.step(sample);
    }
    estimator.estimate()
}

/// Estimate of a flight in single precision, with the default prior.
fn fly_f32(method: Method, samples: &[Sample<f64, 3>]) -> Estimate<f32> {
    let config = Config::kim_2010(method, NOISE_RAD_S as f32);
    let mut estimator = Momentum::new(config, wheels()).unwrap();
    for sample in samples {
        estimator.step(&narrow(sample));
    }
    estimator.estimate()
}

/// Normal noise of one sigma from a fixed seed: twelve uniform numbers of a linear
/// congruential generator (Knuth's constants).
struct Normal(u64);

impl Normal {
    fn draw(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    fn vector(&mut self) -> Vec3<f64> {
        Vec3::from_fn(|_, _| self.draw())
    }
}

/// Adds white gyro noise of [`NOISE_RAD_S`].
fn with_noise(mut samples: Vec<Sample<f64, 3>>, seed: u64) -> Vec<Sample<f64, 3>> {
    let mut normal = Normal(seed);
    for sample in &mut samples {
        sample.rate_rad_s += normal.vector() * NOISE_RAD_S;
    }
    samples
}

/// From rest, about all axes in turn and at once.
fn tumble(t: f64) -> Vec3<f64> {
    Vec3::new(0.05 * (0.11 * t).sin(), 0.04 * (0.17 * t).sin(), 0.06 * (0.23 * t).sin())
}

/// From rest about one axis and to rest again: the rates are proportional.
fn slew(t: f64) -> Vec3<f64> {
    Vec3::new(0.5, 0.6, 0.6) * (0.01 * t * (-0.05 * t).exp())
}

/// No torque.
fn still() -> Vec3<f64> {
    Vec3::zeros()
}

/// 200 s of this motion without torque.
fn flight(rate: &dyn Fn(f64) -> Vec3<f64>) -> Flight<'_> {
    Flight { inertia: INERTIA, seconds: 200.0, rate, torque: still() }
}

/// Largest error of an element, kg m².
fn worst_error(found: [f64; 6]) -> f64 {
    (0..6).map(|i| (found[i] - INERTIA[i]).abs()).fold(0.0, f64::max)
}

/// Error of the attitude's integration in 1.5 kg m²: (0.06 rad/s · 5 ms)² / 12 of the turns.
const EXACT: f64 = 1e-7;

#[test]
fn without_noise_the_batch_is_exact() {
    let quiet = Config { gyro_noise_rad_s: 1e-9, ..config(Method::Batch) };
    let estimate = fly(quiet, &flight(&tumble).samples());
    assert!(worst_error(estimate.inertia.elements_kg_m2()) < EXACT, "{estimate:?}");
    assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
}

#[test]
fn without_noise_the_conventional_is_exact_for_one_axis_at_a_time() {
    let one_after_the_other = |t: f64| {
        let pulse = |from: f64| 0.05 * (0.05 * (t - from).clamp(0.0, 62.8)).sin();
        Vec3::new(pulse(0.0), pulse(65.0), pulse(130.0)).map(|x| if x < 1e-4 { 0.0 } else { x })
    };
    let quiet = Config { gyro_noise_rad_s: 1e-9, ..config(Method::Conventional) };
    let estimate = fly(quiet, &flight(&one_after_the_other).samples());
    assert!(worst_error(estimate.inertia.elements_kg_m2()) < EXACT, "{estimate:?}");
}

/// Motion about x: `Jxx`, `Jxy` and `Jxz` are exact, the other three keep the prior.
#[test]
fn without_noise_a_single_axis_determines_its_column_alone() {
    let about_x = |t: f64| Vec3::new(0.05 * (0.1 * t).sin(), 0.0, 0.0);
    let prior = Prior { inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], sigma_kg_m2: [0.5; 6] };
    let samples = flight(&about_x).samples();
    for method in [Method::Conventional, Method::Suggested, Method::PreEstimate] {
        let config = Config { gyro_noise_rad_s: 1e-9, prior: Some(prior), ..config(method) };
        let estimate = fly(config, &samples);
        let found = estimate.inertia.elements_kg_m2();
        assert_eq!(estimate.observed.directions, 3);
        assert_eq!(estimate.observed.element, [true, false, false, true, true, false]);
        assert_eq!(estimate.status, Status::Partial);
        for i in [0, 3, 4] {
            assert!((found[i] - INERTIA[i]).abs() < EXACT, "{method:?} {found:?}");
            assert!(estimate.sigma_kg_m2()[i] < EXACT);
        }
        for i in [1, 2, 5] {
            assert_eq!(found[i], prior.inertia_kg_m2[i]);
            assert!((estimate.sigma_kg_m2()[i] - 0.5).abs() < 1e-12);
        }
    }
    // The nine unknowns of the batch have no solution: all keep the prior.
    let batch = Config { prior: Some(prior), gyro_noise_rad_s: 1e-9, ..config(Method::Batch) };
    let estimate = fly(batch, &samples);
    assert_eq!(estimate.inertia.elements_kg_m2(), prior.inertia_kg_m2);
    assert_eq!(estimate.observed.directions, 3);
}

/// The impulse of a constant torque in inertial axes joins the balance.
#[test]
fn a_known_torque_leaves_the_elements_exact() {
    let quiet = Config { gyro_noise_rad_s: 1e-9, ..config(Method::Batch) };
    let torque = Vec3::new(1e-3, -2e-3, 1e-3);
    let estimate = fly(quiet, &Flight { torque, ..flight(&tumble) }.samples());
    assert!(worst_error(estimate.inertia.elements_kg_m2()) < EXACT, "{estimate:?}");
    assert_eq!(estimate.status, Status::Converged);
}

/// 50 s in motion, then a start at rest.
#[test]
fn a_moving_body_coasts_until_rest() {
    let comes_to_rest = |t: f64| if t < 50.0 { tumble(t + 3.0) } else { tumble(t - 50.0) };
    let quiet = Config { gyro_noise_rad_s: 1e-9, ..config(Method::Batch) };
    let mut estimator = Momentum::new(quiet, wheels()).unwrap();
    for (k, sample) in flight(&comes_to_rest).samples().iter().enumerate() {
        let outcome = estimator.step(sample);
        match k {
            ..500 => assert_eq!(outcome, Outcome::Coasting(Coasting::WaitingForRest)),
            500 => assert_eq!(outcome, Outcome::Reset(Reset::FirstSample)),
            _ => assert_eq!(outcome, Outcome::Updated),
        }
        if k == 499 {
            assert_eq!(estimator.estimate().status, Status::Unobservable);
        }
    }
    assert!(worst_error(estimator.estimate().inertia.elements_kg_m2()) < EXACT);
}

#[test]
fn a_gap_is_bridged_without_torque_and_resets_with_it() {
    let quiet = Config { gyro_noise_rad_s: 1e-9, ..config(Method::Batch) };
    for torque in [still(), Vec3::new(1e-3, -2e-3, 1e-3)] {
        let samples = Flight { torque, ..flight(&tumble) }.samples();
        let mut estimator = Momentum::new(quiet, wheels()).unwrap();
        let with_gap = [&samples[..301], &samples[400..]].concat();
        let outcomes: Vec<Outcome> = with_gap.iter().map(|s| estimator.step(s)).collect();
        let after = if torque == still() {
            [Outcome::Updated; 2]
        } else {
            [Outcome::Reset(Reset::Gap), Outcome::Coasting(Coasting::WaitingForRest)]
        };
        assert_eq!(outcomes[301..303], after);
        let found = estimator.estimate();
        assert_eq!(found.observed.directions, 6);
        assert!(worst_error(found.inertia.elements_kg_m2()) < EXACT, "{found:?}");
    }
}

/// The rates are proportional, so the regressor has rank 1; each error is within two sigma.
#[test]
fn every_method_observes_three_directions_of_a_slew_about_one_axis() {
    let samples = with_noise(flight(&slew).samples(), 1);
    for method in METHODS {
        let estimate = fly(config(method), &samples);
        assert_eq!(estimate.observed.directions, 3, "{method:?}");
        assert_eq!(estimate.status, Status::Partial);
        assert_eq!(fly_f32(method, &samples).observed, estimate.observed, "{method:?}");
        for i in 0..6 {
            let error = estimate.inertia.elements_kg_m2()[i] - INERTIA[i];
            let sigma = estimate.sigma_kg_m2()[i];
            assert!(error.abs() < 2.0 * sigma, "{method:?} element {i}: {error} ± {sigma}");
        }
    }
}

#[test]
fn single_precision_gives_the_same_elements() {
    // Rounding of a wheel's momentum, 6e-8 of 0.1 N m s, beside 0.05 rad/s of motion.
    let rounding = 1e-5;
    for (rate, seed) in [(&tumble as &dyn Fn(f64) -> Vec3<f64>, 2), (&slew, 3)] {
        let samples = with_noise(flight(rate).samples(), seed);
        for method in METHODS {
            let double = fly(config(method), &samples);
            let single = fly_f32(method, &samples);
            for i in 0..6 {
                let difference = f64::from(single.inertia.elements_kg_m2()[i])
                    - double.inertia.elements_kg_m2()[i];
                assert!(difference.abs() < rounding, "{method:?} element {i}: {difference}");
                let ratio = f64::from(single.sigma_kg_m2()[i]) / double.sigma_kg_m2()[i];
                assert!((ratio - 1.0).abs() < 0.01, "{method:?} element {i}: {ratio}");
            }
        }
    }
}

/// Mean NEES per degree of freedom over 100 spacecraft drawn from the prior.
fn nees(method: Method, rate: &dyn Fn(f64) -> Vec3<f64>) -> f64 {
    let prior = Prior {
        inertia_kg_m2: [1.5, 1.2, 1.8, 0.0, 0.0, 0.0],
        sigma_kg_m2: [0.1, 0.1, 0.1, 0.1, 0.1, 0.1],
    };
    let runs = 100;
    let mut normal = Normal(4);
    let mut sum = 0.0;
    for seed in 0..runs {
        let inertia =
            core::array::from_fn(|i| prior.inertia_kg_m2[i] + prior.sigma_kg_m2[i] * normal.draw());
        let samples = Flight { inertia, ..flight(rate) }.samples();
        let config = Config { prior: Some(prior), ..config(method) };
        let estimate = fly(config, &with_noise(samples, 100 + seed));
        let error = Mat::<f64, 6, 1>::from(estimate.inertia.elements_kg_m2())
            - Mat::<f64, 6, 1>::from(inertia);
        let inverse = estimate.covariance_kg2_m4.try_inverse().unwrap();
        sum += (error.transpose() * inverse * error)[0] / 6.0;
    }
    sum / runs as f64
}

#[test]
fn the_covariance_is_that_of_the_error_of_each_formula() {
    // A covariance that fits gives 1 ± 0.06 over 600 degrees of freedom. Along directions of noise
    // alone Σ ω vᵀ follows from Σ ω ωᵀ, which is left out: sigma is then a little too large.
    for method in METHODS {
        for (name, rate) in [("tumble", &tumble as &dyn Fn(f64) -> Vec3<f64>), ("slew", &slew)] {
            let nees = nees(method, rate);
            std::println!("{method:?} on {name}: NEES {nees:.3}");
            assert!((0.7..1.25).contains(&nees), "{method:?} on {name}: {nees}");
        }
    }
}

/// 2e-4 N m for 200 s, left out of the samples.
#[test]
fn an_unmodelled_torque_is_reported_as_diverged() {
    let mut samples = Flight { torque: Vec3::new(2e-4, 0.0, 0.0), ..flight(&tumble) }.samples();
    for sample in &mut samples {
        sample.torque_n_m = still();
    }
    let samples = with_noise(samples, 5);
    assert_eq!(fly(config(Method::Batch), &samples).status, Status::Diverged);
    let honest = with_noise(flight(&tumble).samples(), 5);
    let estimate = fly(config(Method::Batch), &honest);
    assert_eq!(estimate.status, Status::Converged);
    assert!((estimate.residual_rms_rad_s / NOISE_RAD_S - 1.0).abs() < 0.05);
}

#[test]
fn an_unusable_attitude_coasts_with_its_reason() {
    let samples = flight(&tumble).samples();
    let mut estimator = Momentum::new(config(Method::Batch), wheels()).unwrap();
    let mut step = |attitude: Option<Quaternion<f64>>, k: usize| {
        estimator.step(&Sample { attitude, ..samples[k] })
    };
    let coasting = |why| Outcome::Coasting(Coasting::NoAttitude(why));
    assert_eq!(step(samples[0].attitude, 0), Outcome::Reset(Reset::FirstSample));
    assert_eq!(step(None, 1), coasting(NoAttitude::Missing));
    assert_eq!(step(Some(Quaternion::new([0.0; 4])), 2), coasting(NoAttitude::NotUnit));
    let nan = Quaternion::new([f64::NAN, 0.0, 0.0, 1.0]);
    assert_eq!(step(Some(nan), 3), coasting(NoAttitude::NotFinite));
    assert_eq!(step(samples[4].attitude, 4), Outcome::Updated);
}

/// Without noise and with it: every sigma stays that of an unknown body.
#[test]
fn at_rest_nothing_is_observed() {
    let rest = |_: f64| Vec3::zeros();
    for samples in [flight(&rest).samples(), with_noise(flight(&rest).samples(), 6)] {
        for method in METHODS {
            let estimate = fly(config(method), &samples);
            assert_eq!(estimate.status, Status::Unobservable, "{method:?}");
            assert_eq!(estimate.observed, Observed::default());
            assert!(estimate.sigma_kg_m2().iter().all(|sigma| *sigma > 0.9));
        }
    }
}

proptest! {
    /// Any bits, and plausible attitudes with momenta of 1e-30 to 1e30 N m s.
    #[test]
    fn any_bits_leave_a_finite_estimate(
        rows in prop::collection::vec(prop::array::uniform16(any::<u32>()), 30),
        turns in prop::collection::vec(prop::array::uniform3(-1.0..1.0f32), 30),
        scale in prop::sample::select(std::vec![1e-30f32, 1e-12, 1.0, 1e12, 1e30]),
    ) {
        for method in METHODS {
            let config = Config::kim_2010(method, 1e-4f32);
            let mut estimator = Momentum::new(config, wheels()).unwrap();
            for (k, (bits, turn)) in rows.iter().zip(&turns).enumerate() {
                let f = bits.map(f32::from_bits);
                // Random bits mostly fail the gate, so every other sample is plausible but for its
                // scale.
                let is_plausible = k % 2 == 0;
                let pick = |any: [f32; 3]| if is_plausible { turn.map(|x| x * scale) } else { any };
                estimator.step(&Sample {
                    time_us: k as u64 * PERIOD_US,
                    rate_rad_s: if is_plausible {
                        Vec3::from(*turn)
                    } else {
                        [f[0], f[1], f[2]].into()
                    },
                    wheel_speed_rad_s: pick([f[3], f[4], f[5]]),
                    torque_n_m: pick([f[6], f[7], f[8]]).into(),
                    attitude: Some(if is_plausible {
                        Quaternion::identity()
                    } else {
                        Quaternion::new([f[9], f[10], f[11], f[12]])
                    }),
                });
            }
            let e = estimator.estimate();
            prop_assert!(e.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
            prop_assert!(e.covariance_kg2_m4.iter().all(|x| x.is_finite()));
            prop_assert!(e.residual_rms_rad_s.is_finite());
        }
    }
}
