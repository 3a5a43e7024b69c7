//! Tests of the regression.

use super::*;
use crate::monitor::observability::observed;
use proptest::prelude::*;

/// Elements of the body, kg m².
const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
/// Stated noise of the accelerations, rad/s².
const SIGMA_RAD_S2: f64 = 1e-4;

/// Prior, up to 0.8 kg m² from the truth.
fn prior<T: Real>() -> Prior<T> {
    Prior {
        inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0].map(T::lit),
        sigma_kg_m2: [1.0, 1.0, 1.0, 0.5, 0.5, 0.5].map(T::lit),
    }
}

/// An instant of any motion, with the torque of the equation of motion.
fn instant(j: &[f64; 6], rate: [f64; 3], acceleration: [f64; 3]) -> Instant<f64> {
    let (w, a) = (Vec3::from(rate), Vec3::from(acceleration));
    let j = Inertia::new(*j).matrix_kg_m2();
    Instant {
        rate_rad_s: w,
        acceleration_rad_s2: a,
        torque_n_m: j * a + w.cross(&(j * w)),
        acceleration_sigma_rad_s2: SIGMA_RAD_S2,
        imbalance_n_m: Vec3::zeros(),
    }
}

/// The same in single precision.
fn narrow(i: &Instant<f64>) -> Instant<f32> {
    let cast = |v: &Vec3<f64>| v.map(|x| x as f32);
    Instant {
        rate_rad_s: cast(&i.rate_rad_s),
        acceleration_rad_s2: cast(&i.acceleration_rad_s2),
        torque_n_m: cast(&i.torque_n_m),
        acceleration_sigma_rad_s2: i.acceleration_sigma_rad_s2 as f32,
        imbalance_n_m: cast(&i.imbalance_n_m),
    }
}

/// 20 s about all axes, 200 instants.
fn tumble(j: &[f64; 6]) -> impl Iterator<Item = Instant<f64>> {
    (0..200).map(move |k| {
        let t = 0.1 * f64::from(k);
        instant(
            j,
            [0.2 * t.sin(), 0.1 * (1.7 * t).cos(), 0.15 * (0.6 * t).sin()],
            [0.2 * t.cos(), -0.17 * (1.7 * t).sin(), 0.09 * (0.6 * t).cos()],
        )
    })
}

/// Shift of a noiseless solution by the prior, kg m²: its weight over that of the data.
const PRIOR_SHIFT: f64 = 1e-4;

#[test]
fn a_tumble_observes_all_six_elements_in_both_precisions() {
    let (mut double, mut single) =
        (Regression::<f64>::new(&prior()), Regression::<f32>::new(&prior()));
    for i in tumble(&INERTIA) {
        assert!(double.add(&i) && single.add(&narrow(&i)));
    }
    let double = double.solve(Elements::All, &prior());
    let single = single.solve(Elements::All, &prior());
    assert_eq!(observed(&double.covariance_kg2_m4, &prior().sigma_kg_m2).directions, 6);
    assert_eq!(observed(&single.covariance_kg2_m4, &prior().sigma_kg_m2).directions, 6);
    for k in 0..6 {
        assert!((double.inertia.elements_kg_m2()[k] - INERTIA[k]).abs() < PRIOR_SHIFT);
        assert!((f64::from(single.inertia.elements_kg_m2()[k]) - INERTIA[k]).abs() < PRIOR_SHIFT);
    }
}

#[test]
fn known_products_leave_the_moments_exact() {
    let known = Prior {
        inertia_kg_m2: [0.75, 0.6, 0.9, 0.1, -0.2, 0.05],
        sigma_kg_m2: [1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3],
    };
    let mut sums = Regression::new(&known);
    for i in tumble(&INERTIA) {
        sums.add(&i);
    }
    let found = sums.solve(Elements::Moments, &known);
    for k in 0..6 {
        assert!((found.inertia.elements_kg_m2()[k] - INERTIA[k]).abs() < PRIOR_SHIFT);
    }
    let observation = observed(&found.covariance_kg2_m4, &known.sigma_kg_m2);
    assert_eq!(observation.element, [true, true, true, false, false, false]);
}

/// The error of each moment is within three sigma.
#[test]
fn unknown_products_widen_the_sigma_of_the_moments() {
    let mut sums = Regression::new(&prior());
    for i in tumble(&INERTIA) {
        sums.add(&i);
    }
    let found = sums.solve(Elements::Moments, &prior());
    for k in 0..3 {
        let error = found.inertia.elements_kg_m2()[k] - INERTIA[k];
        assert!(error.abs() < 3.0 * found.covariance_kg2_m4[(k, k)].sqrt());
    }
}

proptest! {
    /// The recursion of \[Kim2013\], with the covariance in Joseph's form.
    #[test]
    fn agrees_with_the_printed_recursion(
        motion in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 30),
    ) {
        let mut sums = Regression::new(&prior());
        let mut x = Mat::<f64, 6, 1>::from(prior::<f64>().inertia_kg_m2);
        let mut p = Mat::<f64, 6, 6>::from_diagonal(
            &prior::<f64>().sigma_kg_m2.map(|s| s * s).into());
        for m in &motion {
            let mut i = instant(&INERTIA, [m[0], m[1], m[2]], [m[3], m[4], m[5]]);
            // Large, so that the prior still has weight.
            i.acceleration_sigma_rad_s2 = 1.0;
            sums.add(&i);
            let r = sums.moment_kg_m2 * sums.moment_kg_m2;
            let h = regressor(&i.acceleration_rad_s2) + gyroscopic_regressor(&i.rate_rad_s);
            let s = h * p * h.transpose() + Mat::<f64, 3, 3>::identity() * r;
            let k = p * h.transpose() * s.try_inverse().unwrap();
            x += k * (i.torque_n_m - h * x);
            let rest = Mat::<f64, 6, 6>::identity() - k * h;
            p = rest * p * rest.transpose() + k * k.transpose() * r;
        }
        let mut information = sums.information;
        for i in 0..6 {
            let mut row = [0.0; 6];
            row[i] = 1.0 / prior::<f64>().sigma_kg_m2[i];
            information.add(row, row[i] * prior::<f64>().inertia_kg_m2[i]);
        }
        let ours = information.solve().unwrap();
        let factor = information.covariance_factor().unwrap();
        for k in 0..6 {
            prop_assert!((ours[k] - x[k]).abs() < 1e-10);
        }
        prop_assert!((factor * factor.transpose() - p).abs().max() < 1e-10);
    }

    /// Observed are `Jzz` by the acceleration, `Jxz` and `Jyz` by the gyroscopic torque of the
    /// spin.
    #[test]
    fn a_constant_axis_observes_three_elements_in_any_noise(
        noise in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 400),
    ) {
        let mut sums = Regression::<f32>::new(&prior());
        for (k, v) in noise.iter().enumerate() {
            let spin = 0.05 * (0.1 * k as f64).sin();
            let mut i = instant(&INERTIA, [0.0, 0.0, 0.05], [0.0, 0.0, spin]);
            // Uniform noise of the stated sigma.
            i.acceleration_rad_s2 += Vec3::from(*v) * (SIGMA_RAD_S2 * 3.0f64.sqrt());
            sums.add(&narrow(&i));
        }
        let found = sums.solve(Elements::All, &prior());
        let j = found.inertia.elements_kg_m2();
        let observation = observed(&found.covariance_kg2_m4, &prior().sigma_kg_m2);
        // jzz by the acceleration; jxz and jyz by the gyroscopic torque of the same spin.
        prop_assert_eq!(observation.element, [false, false, true, false, true, true]);
        prop_assert_eq!(observation.directions, 3);
        prop_assert!((f64::from(j[2]) - INERTIA[2]).abs() < 0.02);
        for k in [0, 1, 3] {
            let sigma = prior::<f32>().sigma_kg_m2[k];
            prop_assert!((j[k] - prior::<f32>().inertia_kg_m2[k]).abs() < 0.1 * sigma);
            prop_assert!(found.covariance_kg2_m4[(k, k)].sqrt() > 0.9 * sigma);
        }
    }

    /// NaN, infinities and overflowing rows are left out.
    #[test]
    fn any_bits_leave_a_finite_solution(
        bits in prop::collection::vec(prop::array::uniform12(any::<u32>()), 40),
    ) {
        let mut sums = Regression::<f32>::new(&prior());
        for b in bits {
            let f = b.map(f32::from_bits);
            sums.add(&Instant {
                rate_rad_s: Vec3::new(f[0], f[1], f[2]),
                acceleration_rad_s2: Vec3::new(f[3], f[4], f[5]),
                torque_n_m: Vec3::new(f[6], f[7], f[8]),
                acceleration_sigma_rad_s2: f[9],
                imbalance_n_m: Vec3::new(f[10], f[11], f[10]),
            });
        }
        for elements in [Elements::Moments, Elements::All] {
            let found = sums.solve(elements, &prior());
            prop_assert!(found.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
            prop_assert!(found.covariance_kg2_m4.iter().all(|x| x.is_finite()));
        }
    }
}

/// A torque of 0.3 N m s times the rate: each error is within 1.1 sigma, the worst above 0.01 kg
/// m².
#[test]
fn a_known_imbalance_is_within_the_covariance() {
    let mut sums = Regression::new(&prior());
    for mut i in tumble(&INERTIA) {
        i.imbalance_n_m = i.rate_rad_s * 0.3;
        i.torque_n_m += i.imbalance_n_m;
        sums.add(&i);
    }
    let found = sums.solve(Elements::All, &prior());
    let mut worst = 0.0f64;
    for k in 0..6 {
        let error = found.inertia.elements_kg_m2()[k] - INERTIA[k];
        worst = worst.max(error.abs());
        assert!(error.abs() < 1.1 * found.covariance_kg2_m4[(k, k)].sqrt());
    }
    assert!(worst > 1e-2, "an imbalance that matters: {worst}");
}

#[test]
fn without_data_the_solution_is_the_prior() {
    let sums = Regression::<f32>::new(&prior());
    for elements in [Elements::Moments, Elements::All] {
        let found = sums.solve(elements, &prior());
        let observation = observed(&found.covariance_kg2_m4, &prior().sigma_kg_m2);
        assert_eq!(observation.directions, 0);
        for k in 0..6 {
            let error = found.inertia.elements_kg_m2()[k] - prior::<f32>().inertia_kg_m2[k];
            assert!(error.abs() < 1e-6);
        }
    }
}

/// λ = 0.95 over 200 instants leaves 3e-5 of the weight before the change.
#[test]
fn forgetting_follows_a_change() {
    let later = INERTIA.map(|x| 1.5 * x);
    let mut sums = Regression::new(&prior());
    for i in tumble(&INERTIA).chain(tumble(&later)) {
        sums.forget(0.95);
        sums.add(&i);
    }
    let found = sums.solve(Elements::All, &prior()).inertia.elements_kg_m2();
    for k in 0..6 {
        assert!((found[k] - later[k]).abs() < 1e-2, "{found:?}");
    }
}
