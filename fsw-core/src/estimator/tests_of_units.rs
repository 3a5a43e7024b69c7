//! Units, axes and clock of an input are a choice: the estimate of the same flight in another choice is the same one,
//! to rounding in single precision.

use super::Estimator;
use super::ekf_sgf::regression::Elements;
use super::ekf_sgf::{self, EkfSgf};
use super::joint_ekf::{self, JointEkfUd};
use super::test_flight::{TestFlight, tumbling_torque_n_m};
use super::window::{self, Window};
use crate::dynamics::wheels::WheelArray;
use crate::estimate::{Estimate, Status};
use crate::math::{Mat, Vec3};
use crate::prior::Prior;
use crate::sample::Sample;
use crate::tensor::Inertia;
use std::vec::Vec;

const INERTIA_KG_M2: [f64; 6] = [1.0, 1.5, 2.0, 0.05, -0.1, 0.08];
const SPIN_KG_M2: [f64; 2] = [0.01, 0.02];
const NOISE_RAD_S: f32 = 1e-4;
/// Difference that rounding may make, in sigmas: of the window, which is solved anew, and of recursive filters, in
/// which every step rounds.
const OF_ROUNDING_SIGMAS: [(&str, f32); 3] =
    [("window", 0.1), ("joint-ekf", 0.5), ("ekf-sgf-rls", 0.5)];

/// A flight in one choice of units, axes and clock.
struct Choice {
    /// Unit of mass: all inertias and torques are multiplied by it.
    scale: f32,
    /// New axes from old ones.
    turn: Mat<f32, 3, 3>,
    /// Time of the first sample, µs.
    start_us: u64,
}

impl Choice {
    fn usual() -> Self {
        Self { scale: 1.0, turn: Mat::identity(), start_us: 0 }
    }

    fn inertia(&self, elements: [f32; 6]) -> Inertia<f32> {
        let turned = self.turn * Inertia::new(elements).matrix_kg_m2() * self.turn.transpose();
        let at = |i: usize, k: usize| turned[(i, k)] * self.scale;
        Inertia::new([at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(0, 2), at(1, 2)])
    }

    fn wheels(&self) -> WheelArray<f32, 2> {
        let axes =
            [Vec3::new(1.0, 0.0, 0.5), Vec3::new(0.0, 1.0, -0.3)].map(|axis| self.turn * axis);
        WheelArray::new(axes, SPIN_KG_M2.map(|spin| spin as f32 * self.scale)).unwrap()
    }

    /// 15 % off, with equal sigmas along all axes: those of a turned body are the same.
    fn prior(&self) -> Prior<f32> {
        let inertia_kg_m2 = self.inertia(INERTIA_KG_M2.map(|x| 1.15 * x as f32)).elements_kg_m2();
        Prior {
            inertia_kg_m2,
            sigma_kg_m2: [0.5, 0.5, 0.5, 0.35, 0.35, 0.35].map(|x| x * self.scale),
        }
    }

    fn samples(&self, flight: &[Sample<f32, 2>]) -> Vec<Sample<f32, 2>> {
        let of = |sample: &Sample<f32, 2>| Sample {
            time_us: sample.time_us + self.start_us,
            rate_rad_s: self.turn * sample.rate_rad_s,
            torque_n_m: self.turn * sample.torque_n_m * self.scale,
            ..*sample
        };
        flight.iter().map(of).collect()
    }

    /// Estimates of the three estimators that fly.
    fn estimates(&self, flight: &[Sample<f32, 2>]) -> [Estimate<f32>; 3] {
        let samples = self.samples(flight);
        let config =
            window::Config { prior: Some(self.prior()), ..window::Config::new(NOISE_RAD_S) };
        let window = Window::<f32, 2, 128, 9>::new(config, self.wheels()).unwrap();
        let config = joint_ekf::Config::new(NOISE_RAD_S);
        let config = joint_ekf::Config { prior: Some(self.prior()), ..config };
        let filter = JointEkfUd::<f32, 2>::new(config, self.wheels()).unwrap();
        let config = ekf_sgf::Config::kim_2013(NOISE_RAD_S, self.prior());
        let config = ekf_sgf::Config { elements: Elements::All, ..config };
        let regression = EkfSgf::<f32, 2>::new(config, self.wheels()).unwrap();
        [fly(window, &samples), fly(filter, &samples), fly(regression, &samples)]
    }
}

fn fly(mut estimator: impl Estimator<f32, 2>, samples: &[Sample<f32, 2>]) -> Estimate<f32> {
    for sample in samples {
        estimator.step(sample);
    }
    estimator.finish();
    estimator.estimate()
}

/// Sixty seconds at 10 Hz, with deterministic noise of one sigma.
fn flight() -> Vec<Sample<f32, 2>> {
    let flight = TestFlight {
        inertia_kg_m2: INERTIA_KG_M2,
        initial_rate_rad_s: Vec3::new(0.1, -0.05, 0.08),
        wheels: WheelArray::new([Vec3::new(1.0, 0.0, 0.5), Vec3::new(0.0, 1.0, -0.3)], SPIN_KG_M2)
            .unwrap(),
        period_us: 100_000,
        samples: 600,
    };
    let speed = |t: f64| [20.0 * (0.5 * t).sin(), 15.0 * (0.3 * t).cos()];
    let mut samples = flight.fly(speed, tumbling_torque_n_m);
    let mut word = 0x2545_f491_u32;
    for sample in &mut samples {
        for axis in 0..3 {
            // Sum of twelve uniform numbers: one sigma.
            let mut sum = -6.0;
            for _ in 0..12 {
                word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += (word >> 8) as f32 / 16_777_216.0;
            }
            sample.rate_rad_s[axis] += NOISE_RAD_S * sum;
        }
    }
    samples
}

/// Asserts that the estimates of another choice are those of the usual one.
fn assert_same(choice: &Choice) {
    let flight = flight();
    let usual = Choice::usual().estimates(&flight);
    let found = choice.estimates(&flight);
    for ((name, most), (usual, found)) in OF_ROUNDING_SIGMAS.iter().zip(usual.iter().zip(&found)) {
        assert!(matches!(usual.status, Status::Converged | Status::Partial), "{name}");
        assert_eq!(found.status, usual.status, "{name}, scale {:e}", choice.scale);
        let expected = choice.inertia(usual.inertia.elements_kg_m2()).elements_kg_m2();
        let pairs = found.inertia.elements_kg_m2().into_iter().zip(expected);
        for ((found, expected), sigma) in pairs.zip(found.sigma_kg_m2()) {
            let apart = (found - expected).abs() / sigma;
            assert!(apart < *most, "{name}, scale {:e}: {apart} sigma", choice.scale);
        }
    }
}

#[test]
fn unit_of_mass_scales_the_estimate() {
    for scale in [1e-6, 1e-3, 0.3, 1e3, 1e6] {
        assert_same(&Choice { scale, ..Choice::usual() });
    }
}

#[test]
fn permuted_axes_permute_the_estimate() {
    let turn = Mat::<f32, 3, 3>::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    assert_same(&Choice { turn, ..Choice::usual() });
    assert_same(&Choice { turn: turn * turn, ..Choice::usual() });
}

#[test]
fn turned_body_turns_the_estimate() {
    // Quaternion (1, 2, 3, 4) / √30, as a rotation.
    let turn = Mat::<f32, 3, 3>::new(-20.0, 4.0, 22.0, 20.0, -10.0, 20.0, 10.0, 28.0, 4.0) / 30.0;
    assert!((turn * turn.transpose() - Mat::identity()).amax() < 1e-6);
    assert_same(&Choice { turn, ..Choice::usual() });
}

#[test]
fn shifted_clock_changes_no_bit() {
    let flight = flight();
    let usual = Choice::usual().estimates(&flight);
    for start_us in [1, 1_767_225_600_000_000, 1 << 62] {
        assert_eq!(Choice { start_us, ..Choice::usual() }.estimates(&flight), usual, "{start_us}");
    }
}
