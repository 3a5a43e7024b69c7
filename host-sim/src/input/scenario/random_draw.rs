//! A random spacecraft, its excitation and its gyro, drawn from a seed.
//!
//! | quantity | distribution |
//! |---|---|
//! | inertia | eight equal masses, uniform in a cube of a CubeSat's density: any physical tensor |
//! | actuators | none (external torque about three axes), three or four wheels on random axes |
//! | excitation | four sines per actuator, 1.5 to 8 cycles over the record, random phase |

use std::f64::consts::TAU;

use flight_input::craft::{Wheel, WheelLimits};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::definition::Scenario;
use super::gyro::SimulatedGyro;
use super::profile::{ExternalTorque, Sine, TorqueProfile};
use super::random_spacecraft::RandomSpacecraft;
use super::spacecraft::Spacecraft;
use super::wheel::SimulatedWheel;

/// Density of a CubeSat, 1.33 kg per litre, kg/m³.
const DENSITY_KG_M3: f64 = 1330.0;
/// Numbers of wheels, equally likely. Without wheels an external torque drives the body.
const WHEELS: [usize; 3] = [0, 3, 4];
/// Sines per actuator.
const SINES: usize = 4;
/// Largest rotation between two samples, rad: a faster body needs a gyro of a higher rate.
const MOST_RAD_PER_SAMPLE: f64 = 0.03;
/// Spin inertia of a wheel over the mean moment of the body.
const WHEEL_OVER_BODY: f64 = 1e-3;
/// Largest speed of a wheel over the body rate: the wheel's momentum then equals the body's.
const WHEEL_OVER_BODY_RATE: f64 = 1000.0;

/// Size of a body and of its motion: the scale of the other draws.
struct Scale {
    mean_moment_kg_m2: f64,
    rate_rad_s: f64,
    duration_s: f64,
}

/// The scenario of this seed. Scalars are log-uniform in their ranges.
///
/// The draws are the first numbers of the seed's sequence. The gyro noise of the same seed starts with
/// the same numbers, for the first few of hundreds of samples.
pub(super) fn scenario(ranges: &RandomSpacecraft, name: &str, seed: u64) -> Scenario {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut log_uniform =
        |[least, most]: [f64; 2]| random.random_range(least.ln()..=most.ln()).exp();
    let mass_kg = log_uniform(ranges.mass_kg);
    let rate_hz = log_uniform(ranges.rate_hz);
    let samples = log_uniform(ranges.samples).round();
    let rate_rad_s = log_uniform(ranges.body_rate_rad_s).min(MOST_RAD_PER_SAMPLE * rate_hz);
    let noise_rad_s = rate_rad_s * log_uniform(ranges.noise_over_rate);
    let duration_s = samples / rate_hz;

    let j = inertia_kg_m2(&mut random, mass_kg);
    let scale = Scale { mean_moment_kg_m2: j.trace() / 3.0, rate_rad_s, duration_s };
    let spacecraft = Spacecraft {
        inertia_kg_m2: [j.m11, j.m22, j.m33, j.m12, j.m13, j.m23],
        rate_rad_s: vector(&mut random, 0.3 * rate_rad_s),
        attitude: UnitQuaternion::identity(),
    };
    let count = WHEELS[random.random_range(0..WHEELS.len())];
    let motors: Vec<_> = (0..count).map(|_| scale.multisine(&mut random)).collect();
    let torque = match count {
        0 => ExternalTorque {
            axes: std::array::from_fn(|_| scale.multisine(&mut random)),
            ..ExternalTorque::ZERO
        },
        _ => ExternalTorque::ZERO,
    };
    let wheels = motors.into_iter().map(|motor| scale.wheel(&mut random, motor)).collect();
    let gyro = SimulatedGyro::white(rate_hz, noise_rad_s);
    let name = format!("{name}-{seed}");
    let mut hardware = ranges.hardware.clone();
    hardware.wheel_spin_inertia_sigma.resize(count, 0.0);
    hardware.wheel_axis_sigma_rad.resize(count, 0.0);
    let true_hardware = ranges.true_hardware.clone();
    Scenario {
        wheels,
        torque,
        hardware,
        true_hardware,
        ..Scenario::free(name, duration_s, spacecraft, gyro)
    }
}

/// Inertia of eight equal masses at random in a cube, kg m².
fn inertia_kg_m2(random: &mut Pcg64, mass_kg: f64) -> Matrix3<f64> {
    let side_m = (mass_kg / DENSITY_KG_M3).cbrt();
    let mut inertia = Matrix3::zeros();
    for _ in 0..8 {
        let r = vector(random, side_m / 2.0);
        inertia += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * (mass_kg / 8.0);
    }
    inertia
}

/// Components uniform within ± `half_width`.
fn vector(random: &mut Pcg64, half_width: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.random_range(-half_width..half_width))
}

impl Scale {
    /// Four sines. A sine of momentum amplitude a has torque amplitude a 2π f, and turns a body of
    /// inertia J at rates of about a/J.
    fn multisine(&self, random: &mut Pcg64) -> TorqueProfile {
        let momentum_n_m_s = 0.5 * self.mean_moment_kg_m2 * self.rate_rad_s;
        let term = |_| {
            let frequency_hz = random.random_range(1.5..8.0) / self.duration_s;
            let share = random.random_range(0.3..1.0);
            Sine {
                amplitude_n_m: momentum_n_m_s * share * TAU * frequency_hz,
                frequency_hz,
                sweep_hz_s: 0.0,
                phase_rad: random.random_range(0.0..TAU),
            }
        };
        TorqueProfile::Multisine { terms: (0..SINES).map(term).collect() }
    }

    fn wheel(&self, random: &mut Pcg64, torque: TorqueProfile) -> SimulatedWheel {
        SimulatedWheel {
            wheel: Wheel {
                name: None,
                axis: vector(random, 1.0).normalize(),
                spin_inertia_kg_m2: self.mean_moment_kg_m2 * WHEEL_OVER_BODY,
                limits: WheelLimits::default(),
            },
            speed_rad_s: self.rate_rad_s
                * random.random_range(-WHEEL_OVER_BODY_RATE..WHEEL_OVER_BODY_RATE),
            torque,
        }
    }
}
