//! A spacecraft at random: from 1U to 500 kg, driven by wheels on random axes or by external
//! torque, with a gyro of any quality.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use host_sim::input::craft::Wheel;
use host_sim::input::scenario::dispersion::Dispersion;
use host_sim::input::scenario::{
    Changes, ExternalTorque, Scenario, SimulatedGyro, SimulatedWheel, Sine, Spacecraft,
    TorqueProfile,
};

/// Sines per actuator.
const SINES: usize = 4;

/// The spacecraft, excitation and gyro of this seed.
///
/// | what | distribution |
/// |---|---|
/// | mass | log-uniform, 1.33 to 500 kg, at the density of a CubeSat (1.33 kg per litre) |
/// | inertia | eight equal masses at random in a cube of that volume: anything physical |
/// | actuators | none (external torque about three axes), three or four wheels on random axes |
/// | gyro rate | log-uniform, 4 Hz to 1 kHz |
/// | record | log-uniform, 500 to 5000 samples |
/// | excitation | four sines an actuator, 1.5 to 8 cycles over the record, random phase |
/// | body rate | log-uniform, 0.01 to 1 rad/s, and at most 0.03 rad per sample |
/// | gyro noise | log-uniform, 10⁻⁴ to 10⁻¹ of the body rate per sample |
pub fn draw(seed: u64) -> Scenario {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut log_uniform = |low: f64, high: f64| (random.random_range(low.ln()..high.ln())).exp();
    let mass_kg = log_uniform(1.33, 500.0);
    let rate_hz = log_uniform(4.0, 1000.0);
    let samples = log_uniform(500.0, 5000.0).round();
    let rate_rad_s = log_uniform(0.01, 1.0).min(0.03 * rate_hz);
    let noise_rad_s = rate_rad_s * log_uniform(1e-4, 1e-1);
    let duration_s = samples / rate_hz;

    let side_m = (mass_kg / 1330.0).cbrt();
    let mut vector = |size: f64| Vector3::from_fn(|_, _| random.random_range(-size..size));
    let mut inertia = Matrix3::zeros();
    for _ in 0..8 {
        let r = vector(side_m / 2.0);
        inertia += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * (mass_kg / 8.0);
    }
    let initial_rate = vector(0.3 * rate_rad_s);
    let count = [0, 3, 4][random.random_range(0..3)];
    let typical = inertia.trace() / 3.0;
    // A sine of momentum a, and so of torque a 2π f, moves the body by about a over its inertia.
    let mut multisine = || TorqueProfile::Multisine {
        terms: (0..SINES)
            .map(|_| {
                let frequency_hz = random.random_range(1.5..8.0) / duration_s;
                let momentum = 0.5 * typical * rate_rad_s * random.random_range(0.3..1.0);
                Sine {
                    amplitude_n_m: momentum * std::f64::consts::TAU * frequency_hz,
                    frequency_hz,
                    phase_rad: random.random_range(0.0..std::f64::consts::TAU),
                }
            })
            .collect(),
    };
    let motors: Vec<_> = (0..count).map(|_| multisine()).collect();
    let torque = if count == 0 {
        ExternalTorque { axes: std::array::from_fn(|_| multisine()) }
    } else {
        ExternalTorque::ZERO
    };
    let wheels = motors.into_iter().map(|torque| SimulatedWheel {
        wheel: Wheel {
            name: None,
            axis: Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)).normalize(),
            // A wheel of a hundredth of the body's inertia, at up to some tens of its rate.
            spin_inertia_kg_m2: typical * 1e-3,
        },
        speed_rad_s: random.random_range(-1000.0..1000.0) * rate_rad_s,
        torque,
    });
    let j = inertia;
    Scenario {
        name: format!("random-spacecraft-{seed}"),
        duration_s,
        spacecraft: Spacecraft {
            inertia_kg_m2: [j.m11, j.m22, j.m33, j.m12, j.m13, j.m23],
            rate_rad_s: initial_rate,
            attitude: UnitQuaternion::identity(),
        },
        changes: Changes::default(),
        wheels: wheels.collect(),
        torque,
        gyro: SimulatedGyro {
            rate_hz,
            noise_rad_s,
            bias_rad_s: Vector3::zeros(),
            bias_walk_rad_s_sqrt_s: 0.0,
            quantum_rad_s: None,
            range_rad_s: None,
        },
        disturbance_torque_n_m: Vector3::zeros(),
        solve_for: Default::default(),
        prior: None,
        control: None,
        rate_walk_rad_s_sqrt_s: None,
        inertia_walk_kg_m2_sqrt_hour: None,
        dispersion: Dispersion::default(),
        initial_estimate: None,
    }
}
