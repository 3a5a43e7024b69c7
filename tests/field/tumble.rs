//! Torque-free tumbles without wheel momentum, each seed with a body, a gyro and a motion of its own.
//!
//! | quantity | distribution |
//! |---|---|
//! | mean moment | log-uniform, 0.01 to 100 kg m² |
//! | shape | second moments of mass 0.05 to 1 of a common size, random axes: any physical tensor |
//! | rate | log-uniform, 0.03 to 3 rad/s, at most 0.1 rad per sample, random direction |
//! | gyro | noise log-uniform, 1e-5 to 2e-3 rad/s; sample rate and duration log-uniform as configured |
//!
//! The motion determines the ratios of the tensor and never its scale. Angular momentum is integrated
//! in body axes, `Ḣ = H × J⁻¹ H`, by a fourth-order Runge-Kutta step per sample and part of 0.02 rad.

use std::f64::consts::TAU;

use host_sim::campaign::{Reference, Truth};
use host_sim::input::Scenario;
use host_sim::input::craft::Prior;
use host_sim::truth::{Bound, Flight, Instant, Unknowns};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Offset of a seed's draw from its noise.
const STREAM: u64 = 0x5851_f42d_4c95_7f2d;
/// Largest rotation per sample, rad.
const MOST_RAD_PER_SAMPLE: f64 = 0.1;
/// Largest rotation per integration step, rad.
const STEP_RAD: f64 = 0.02;
/// Sigma of the prior, as a share of the mean moment, for moments and for products.
pub const PRIOR_SHARE: [f64; 2] = [0.3, 0.1];

/// Ranges of the tumbles.
#[derive(Clone, Debug)]
pub struct Tumbles {
    /// Scenario whose body, gyro, duration and prior are replaced: a free body without wheels.
    pub base: Scenario,
    /// Least and longest duration, s.
    pub duration_s: [f64; 2],
    /// Least and highest sample rate, Hz.
    pub rate_hz: [f64; 2],
    /// The estimator has a prior: the true tensor times a factor, with a sigma of 30 %.
    pub has_prior: bool,
}

impl Tumbles {
    /// Scenario and truth of a seed.
    pub fn draw(&self, seed: u64) -> (Scenario, Truth) {
        let mut random = Pcg64::seed_from_u64(seed ^ STREAM);
        let mut scenario = self.base.clone();
        let inertia = inertia_kg_m2(&mut random);
        let elements = elements(&inertia);
        scenario.spacecraft.inertia_kg_m2 = elements;
        scenario.duration_s = log_uniform(self.duration_s, &mut random);
        scenario.gyro.rate_hz = log_uniform(self.rate_hz, &mut random);
        scenario.gyro.noise_rad_s = log_uniform([1e-5, 2e-3], &mut random);
        let most_rad_s = MOST_RAD_PER_SAMPLE * scenario.gyro.rate_hz;
        let rate_rad_s = log_uniform([0.03, 3.0], &mut random).min(most_rad_s);
        scenario.spacecraft.rate_rad_s = direction(&mut random) * rate_rad_s;
        scenario.prior = self.has_prior.then(|| prior(&elements, &mut random));
        let flight = fly(&scenario, &inertia);
        let reference = Reference {
            truth_kg_m2: elements,
            bound_kg_m2: [None; 6],
            joint_bound_kg_m2: [None; 6],
        };
        (scenario, Truth { reference, flight })
    }
}

/// States at the gyro samples.
fn fly(scenario: &Scenario, inertia: &Matrix3<f64>) -> Flight {
    let inverse = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
    let period_s = 1.0 / scenario.gyro.rate_hz;
    let count = (scenario.duration_s * scenario.gyro.rate_hz) as u64;
    let mut momentum = inertia * scenario.spacecraft.rate_rad_s;
    let mut last_us = 0;
    let mut instants = Vec::with_capacity(count as usize + 1);
    for k in 0..=count {
        let time_us = (k as f64 * period_s * 1e6).round() as u64;
        momentum = advance(momentum, &inverse, (time_us - last_us) as f64 * 1e-6);
        last_us = time_us;
        instants.push(Instant {
            time_us,
            rate_rad_s: inverse * momentum,
            inertia_kg_m2: scenario.spacecraft.inertia_kg_m2,
            attitude: UnitQuaternion::identity(),
            wheel_speed_rad_s: Vec::new(),
            torque_n_m: Vector3::zeros(),
        });
    }
    let bound = Bound {
        unknowns: Unknowns::of(scenario),
        sigma_kg_m2: [None; 6],
        observed_directions: 5,
        torque: None,
        hardware: None,
    };
    Flight { instants, bound, trajectory: None }
}

/// Momentum in body axes after a time without torque, N m s.
fn advance(mut momentum: Vector3<f64>, inverse: &Matrix3<f64>, time_s: f64) -> Vector3<f64> {
    let slope = |h: Vector3<f64>| h.cross(&(inverse * h));
    let angle = (inverse * momentum).norm() * time_s;
    let steps = (angle / STEP_RAD).ceil().max(1.0);
    let step_s = time_s / steps;
    for _ in 0..steps as u32 {
        let a = slope(momentum);
        let b = slope(momentum + a * (step_s / 2.0));
        let c = slope(momentum + b * (step_s / 2.0));
        let d = slope(momentum + c * step_s);
        momentum += (a + (b + c) * 2.0 + d) * (step_s / 6.0);
    }
    momentum
}

/// A physical tensor: `J = tr(P) 1 − P` with the second moments of mass `P`, kg m².
fn inertia_kg_m2(random: &mut Pcg64) -> Matrix3<f64> {
    let size = log_uniform([0.01, 100.0], random);
    let second = Vector3::from_fn(|_, _| random.random_range(0.05..1.0));
    let axis = nalgebra::Unit::new_normalize(direction(random));
    let turn = UnitQuaternion::from_axis_angle(&axis, random.random_range(0.0..TAU));
    let turn = turn.to_rotation_matrix();
    let body = turn.matrix() * Matrix3::from_diagonal(&second) * turn.matrix().transpose();
    let inertia = Matrix3::identity() * body.trace() - body;
    inertia * (3.0 * size / inertia.trace())
}

/// `jxx jyy jzz jxy jxz jyz`.
fn elements(j: &Matrix3<f64>) -> [f64; 6] {
    [j[(0, 0)], j[(1, 1)], j[(2, 2)], j[(0, 1)], j[(0, 2)], j[(1, 2)]]
}

/// The true tensor times `1 + 0.3 ξ`, ξ uniform within ±1.5.
fn prior(elements_kg_m2: &[f64; 6], random: &mut Pcg64) -> Prior {
    let [moment, product] = PRIOR_SHARE;
    let factor = 1.0 + moment * random.random_range(-1.5..1.5);
    let mean = elements_kg_m2[..3].iter().sum::<f64>() / 3.0;
    Prior {
        inertia_kg_m2: elements_kg_m2.map(|j| j * factor),
        sigma_kg_m2: std::array::from_fn(|i| mean * if i < 3 { moment } else { product }),
    }
}

fn direction(random: &mut Pcg64) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0f64));
        if (0.01..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    }
}

fn log_uniform([least, most]: [f64; 2], random: &mut Pcg64) -> f64 {
    random.random_range(least.ln()..=most.ln()).exp()
}
