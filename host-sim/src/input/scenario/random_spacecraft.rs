//! A spacecraft at random, another for each seed: from 1U to 500 kg, driven by wheels on random axes
//! or by external torque, with a gyro of any quality.
//!
//! ```toml
//! name = "random-spacecraft"
//! [random_spacecraft]                # the least and the most of each, log-uniform in between
//! mass_kg = [1.33, 500.0]
//! rate_hz = [4.0, 1000.0]            # of the gyro
//! samples = [500, 5000]              # of the record, rounded
//! body_rate_rad_s = [0.01, 1.0]      # and at most 0.03 rad a sample
//! noise_over_rate = [1e-4, 1e-1]     # one sigma of a gyro sample over the body rate
//! [disturbance]                      # optional: see `scenario`
//! torque = false
//! ```
//!
//! Such a file has no other tables: what they would say is drawn.
//!
//! | what | distribution |
//! |---|---|
//! | inertia | eight equal masses at random in a cube of a CubeSat's density: anything physical |
//! | actuators | none (external torque about three axes), three or four wheels on random axes |
//! | excitation | four sines an actuator, 1.5 to 8 cycles over the record, random phase |

use std::f64::consts::TAU;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Deserialize;
use toml::Spanned;

use super::super::check::Check;
use super::super::craft::Wheel;
use super::super::error::InputError;
use super::{
    Changes, Dispersion, ExternalTorque, MAX_RATE_HZ, MAX_SAMPLES, Scenario, SimulatedGyro,
    SimulatedWheel, Sine, Spacecraft, TorqueProfile,
};

/// Density of a CubeSat, 1.33 kg per litre, kg/m³.
const DENSITY_KG_M3: f64 = 1330.0;
/// Numbers of wheels, equally likely. Without any, external torque drives the body.
const WHEELS: [usize; 3] = [0, 3, 4];
/// Sines per actuator.
const SINES: usize = 4;
/// Turn between two samples, rad, at most: beyond, a gyro of this rate is the wrong one.
const MOST_RAD_PER_SAMPLE: f64 = 0.03;
/// Spin inertia of a wheel over the mean moment of the body.
const WHEEL_OVER_BODY: f64 = 1e-3;
/// Speed of a wheel over the body rate, at most: its momentum is then that of the body.
const WHEEL_OVER_BODY_RATE: f64 = 1000.0;

/// What spacecraft are drawn from: of each quantity the least and the most.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomSpacecraft {
    /// Mass, kg.
    pub mass_kg: [f64; 2],
    /// Samples of the gyro per second, Hz.
    pub rate_hz: [f64; 2],
    /// Samples of the record.
    pub samples: [f64; 2],
    /// Typical body rate, rad/s.
    pub body_rate_rad_s: [f64; 2],
    /// Gyro noise of one sample over the body rate.
    pub noise_over_rate: [f64; 2],
}

/// The size of a body and of its motion, from which the rest is drawn.
struct Scale {
    mean_moment_kg_m2: f64,
    rate_rad_s: f64,
    duration_s: f64,
}

impl RandomSpacecraft {
    /// The spacecraft, excitation and gyro of this seed, all of them log-uniform in their ranges.
    ///
    /// The seed's first numbers are drawn, which are also those of the gyro's first few of hundreds
    /// of samples.
    pub(super) fn draw(&self, name: &str, seed: u64) -> Scenario {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut log_uniform =
            |[least, most]: [f64; 2]| random.random_range(least.ln()..=most.ln()).exp();
        let mass_kg = log_uniform(self.mass_kg);
        let rate_hz = log_uniform(self.rate_hz);
        let samples = log_uniform(self.samples).round();
        let rate_rad_s = log_uniform(self.body_rate_rad_s).min(MOST_RAD_PER_SAMPLE * rate_hz);
        let noise_rad_s = rate_rad_s * log_uniform(self.noise_over_rate);
        let duration_s = samples / rate_hz;

        let j = inertia_kg_m2(&mut random, mass_kg);
        let scale = Scale { mean_moment_kg_m2: j.trace() / 3.0, rate_rad_s, duration_s };
        let initial_rate_rad_s = vector(&mut random, 0.3 * rate_rad_s);
        let count = WHEELS[random.random_range(0..WHEELS.len())];
        let motors: Vec<_> = (0..count).map(|_| scale.multisine(&mut random)).collect();
        let torque = match count {
            0 => ExternalTorque { axes: std::array::from_fn(|_| scale.multisine(&mut random)) },
            _ => ExternalTorque::ZERO,
        };
        let wheels = motors.into_iter().map(|motor| scale.wheel(&mut random, motor)).collect();
        Scenario {
            name: format!("{name}-{seed}"),
            duration_s,
            spacecraft: Spacecraft {
                inertia_kg_m2: [j.m11, j.m22, j.m33, j.m12, j.m13, j.m23],
                rate_rad_s: initial_rate_rad_s,
                attitude: UnitQuaternion::identity(),
            },
            changes: Changes::default(),
            wheels,
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
}

/// Eight equal masses at random in a cube.
fn inertia_kg_m2(random: &mut Pcg64, mass_kg: f64) -> Matrix3<f64> {
    let side_m = (mass_kg / DENSITY_KG_M3).cbrt();
    let mut inertia = Matrix3::zeros();
    for _ in 0..8 {
        let r = vector(random, side_m / 2.0);
        inertia += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * (mass_kg / 8.0);
    }
    inertia
}

/// Components uniform within ± of this.
fn vector(random: &mut Pcg64, half_width: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.random_range(-half_width..half_width))
}

impl Scale {
    /// A sine of momentum a, and so of torque a 2π f, moves the body by about a over its inertia.
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
            },
            speed_rad_s: self.rate_rad_s
                * random.random_range(-WHEEL_OVER_BODY_RATE..WHEEL_OVER_BODY_RATE),
            torque,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RandomSpacecraftFile {
    mass_kg: Spanned<Vec<f64>>,
    rate_hz: Spanned<Vec<f64>>,
    samples: Spanned<Vec<f64>>,
    body_rate_rad_s: Spanned<Vec<f64>>,
    noise_over_rate: Spanned<Vec<f64>>,
}

impl RandomSpacecraftFile {
    pub(super) fn check(&self, check: &Check<'_>) -> Result<RandomSpacecraft, InputError> {
        let range = |key: &str, value, most: f64, required| {
            let key = format!("random_spacecraft.{key}");
            let range = check.list::<2>(&key, value)?;
            if 0.0 < range[0] && range[0] <= range[1] && range[1] <= most {
                return Ok(range);
            }
            Err(check.bad_list(&key, value, required))
        };
        let any = "a positive number, and one that is no smaller";
        Ok(RandomSpacecraft {
            mass_kg: range("mass_kg", &self.mass_kg, f64::MAX, any)?,
            rate_hz: range(
                "rate_hz",
                &self.rate_hz,
                MAX_RATE_HZ,
                "a positive rate, and one that is no smaller, at most 100 kHz",
            )?,
            samples: range(
                "samples",
                &self.samples,
                MAX_SAMPLES,
                "a positive number, and one that is no smaller, at most 1e7",
            )?,
            body_rate_rad_s: range("body_rate_rad_s", &self.body_rate_rad_s, f64::MAX, any)?,
            noise_over_rate: range("noise_over_rate", &self.noise_over_rate, f64::MAX, any)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use fsw_core::Inertia;

    use super::*;

    const GOOD: &str = r#"name = "test"
[random_spacecraft]
mass_kg = [1, 500]
rate_hz = [4, 1000]
samples = [500, 5000]
body_rate_rad_s = [0.01, 1]
noise_over_rate = [1e-4, 1e-1]
"#;

    fn parse(text: &str) -> Result<Scenario, InputError> {
        Scenario::from_toml("s.toml", text, Path::new(""))
    }

    #[test]
    fn each_seed_has_a_spacecraft_of_its_own_within_the_ranges() {
        let scenario = parse(GOOD).unwrap();
        let mut wheels = [0; 5];
        for seed in 0..300 {
            let drawn = scenario.of_seed(seed);
            assert_eq!(drawn, scenario.of_seed(seed));
            assert_ne!(drawn.spacecraft, scenario.of_seed(seed + 1).spacecraft);
            assert_eq!(drawn.name, format!("test-{seed}"));
            assert!(Inertia::new(drawn.spacecraft.inertia_kg_m2).check().is_ok());
            let rate_hz = drawn.gyro.rate_hz;
            assert!((4.0..1000.0).contains(&rate_hz));
            assert!((499.9..5000.1).contains(&(drawn.duration_s * rate_hz)));
            assert!((1e-6..0.1).contains(&drawn.gyro.noise_rad_s));
            wheels[drawn.wheels.len()] += 1;
            assert_eq!(drawn.wheels.is_empty(), drawn.torque != ExternalTorque::ZERO);
        }
        // A third of each: 100, standard deviation 8.
        assert!([0, 3, 4].iter().all(|count| (60..140).contains(&wheels[*count])), "{wheels:?}");
    }

    #[test]
    fn a_range_may_be_a_single_value() {
        let one = parse(&GOOD.replace("[4, 1000]", "[10, 10]")).unwrap();
        assert!((0..20).all(|seed| (one.of_seed(seed).gyro.rate_hz - 10.0).abs() < 1e-12));
    }

    #[test]
    fn what_is_asked_of_the_estimator_goes_for_all() {
        let asked = parse(&format!("{GOOD}[disturbance]\ntorque = true\n")).unwrap();
        assert!(asked.solve_for.torque && asked.of_seed(5).solve_for.torque);
    }

    #[test]
    fn each_bad_value_is_named() {
        let at = "s.toml:3: `random_spacecraft.mass_kg`";
        for (good, bad, expected) in [
            ("[1, 500]", "[1]", format!("{at} has 1 entries, but takes 2")),
            ("[1, 500]", "[0, 500]", format!("{at} is [0, 500]; it must be a positive number")),
            ("[1, 500]", "[500, 1]", format!("{at} is [500, 1]; it must be a positive number")),
            ("mass_kg", "mass", "s.toml:3: unknown key `mass` (did you mean `mass_kg`?)".into()),
            ("1000]", "1e6]", "s.toml:4: `random_spacecraft.rate_hz` is [4, 1e6]; it".into()),
            ("5000]", "1e9]", "s.toml:5: `random_spacecraft.samples` is [500, 1e9]".into()),
            ("samples = [500, 5000]\n", "", "s.toml:2: missing key `samples`".into()),
            ("name = \"test\"", "duration_s = 5", "s.toml:1: unknown key `duration_s`".into()),
        ] {
            let message = parse(&GOOD.replacen(good, bad, 1)).unwrap_err().to_string();
            assert!(message.starts_with(&expected), "{message}\n  expected: {expected}");
        }
    }
}
