//! A satellite, a case, and its score.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use host_sim::input::Scenario;
use host_sim::manoeuvre::{Criterion, Design, Effort, KeepOut, Limits, Request, Treatment, design};
use nalgebra::Vector3;

/// A satellite of El Hariry et al. (2025).
#[derive(Clone, Copy, Debug)]
pub struct Satellite {
    /// Name.
    pub name: &'static str,
    /// Principal moments as published, kg m².
    pub moments_kg_m2: [f64; 3],
    /// Spin inertia of each of three orthogonal wheels, kg m².
    pub wheel_kg_m2: f64,
    /// Largest torque of a wheel, N m.
    pub torque_n_m: f64,
    /// Largest speed of a wheel, rad/s.
    pub speed_rad_s: f64,
}

/// The satellites of 24, 95 and 118 kg.
pub const SATELLITES: [Satellite; 3] = [
    Satellite {
        name: "24 kg",
        moments_kg_m2: [0.26, 0.26, 0.16],
        wheel_kg_m2: 1e-4,
        torque_n_m: 0.01,
        speed_rad_s: 460.0,
    },
    Satellite {
        name: "95 kg",
        moments_kg_m2: [6.53, 5.96, 4.53],
        wheel_kg_m2: 2e-3,
        torque_n_m: 0.1,
        speed_rad_s: 900.0,
    },
    Satellite {
        name: "118 kg",
        moments_kg_m2: [10.6, 14.2, 15.3],
        wheel_kg_m2: 3e-3,
        torque_n_m: 0.1,
        speed_rad_s: 1500.0,
    },
];

/// Products of inertia over the mean moment. The paper has none; these are those of its sequel for the
/// satellite of 95 kg, 0.45, −0.30 and 0.22 kg m².
const PRODUCTS: [f64; 3] = [0.079, -0.053, 0.039];
/// Gyro of the sequel: noise of a sample, rad/s, and rate, Hz.
const NOISE_RAD_S: f64 = 1e-4;
const RATE_HZ: f64 = 10.0;
/// Half angle of the keep-out cone, deg, and angle of its axis from the boresight at the start, deg.
const CONE_DEG: [f64; 2] = [30.0, 31.0];

/// Limits of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Largest excursion, deg.
    pub excursion_deg: f64,
    /// Momentum of the wheels allowed, share of the largest.
    pub momentum_share: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Error of the prior: two sigma of each moment over the moment, and of each product over a tenth of the
    /// mean moment.
    pub prior_error: f64,
    /// The boresight z starts one degree outside a keep-out cone.
    pub has_cone: bool,
}

/// Result of a case.
#[derive(Clone, Debug)]
pub struct Score {
    /// Bound of the inertia expected, √tr C / ‖j‖.
    pub sigma: f64,
    /// The same of the best fixed manoeuvre.
    pub fixed_sigma: f64,
    /// Name of that one.
    pub fixed: String,
    /// The design.
    pub design: Design,
}

impl Score {
    /// Sigma of the best fixed manoeuvre over that of the design.
    pub fn gain(&self) -> f64 {
        self.fixed_sigma / self.sigma
    }
}

impl Satellite {
    /// The six elements, kg m².
    pub fn inertia_kg_m2(&self) -> [f64; 6] {
        let [x, y, z] = self.moments_kg_m2;
        let mean = (x + y + z) / 3.0;
        let [xy, xz, yz] = PRODUCTS.map(|share| share * mean);
        [x, y, z, xy, xz, yz]
    }

    /// The satellite at rest, with this error of the prior.
    ///
    /// # Errors
    /// A rejected file, which is a fault of this program.
    pub fn scenario(&self, prior_error: f64) -> Result<Scenario> {
        let inertia = self.inertia_kg_m2();
        let mean = self.moments_kg_m2.iter().sum::<f64>() / 3.0;
        let sigma: Vec<f64> = (0..6)
            .map(|i| 0.5 * prior_error * if i < 3 { inertia[i] } else { 0.1 * mean })
            .collect();
        let Self { wheel_kg_m2, torque_n_m, speed_rad_s, .. } = self;
        let mut text = format!(
            "name = {:?}\nduration_s = 1\n[spacecraft]\ninertia_kg_m2 = {inertia:?}\n\
             [gyro]\nrate_hz = {RATE_HZ}\nnoise_rad_s = {NOISE_RAD_S}\n\
             [disturbance]\ntorque = true\n",
            self.name
        );
        if prior_error > 0.0 {
            text += &format!("[prior]\ninertia_kg_m2 = {inertia:?}\nsigma_kg_m2 = {sigma:?}\n");
        }
        for axis in [[1, 0, 0], [0, 1, 0], [0, 0, 1]] {
            text += &format!(
                "[[wheel]]\naxis = {axis:?}\nspin_inertia_kg_m2 = {wheel_kg_m2}\n\
                 max_torque_n_m = {torque_n_m}\nmax_speed_rad_s = {speed_rad_s}\n"
            );
        }
        Scenario::from_toml(self.name, &text, Path::new("")).context("satellite")
    }
}

impl Case {
    /// The request of this case.
    pub fn request(&self, effort: Effort, seed: u64) -> Request {
        let [half, from] = CONE_DEG.map(f64::to_radians);
        let cone = KeepOut {
            boresight: Vector3::z(),
            direction: Vector3::new(from.sin(), 0.0, from.cos()),
            half_angle_rad: half,
        };
        Request {
            duration_s: self.duration_s,
            limits: Limits {
                excursion_rad: self.excursion_deg.to_radians(),
                rate_rad_s: None,
                torque_share: 1.0,
                momentum_share: self.momentum_share,
                return_rad: 0.1f64.to_radians(),
                keep_out: if self.has_cone { vec![cone] } else { Vec::new() },
            },
            criterion: Criterion::A,
            treatment: Treatment::Considered,
            uses_prior: false,
            seed,
            effort,
        }
    }

    /// Designs for a satellite.
    ///
    /// # Errors
    /// No manoeuvre within the limits.
    pub fn score(&self, satellite: &Satellite, effort: Effort, seed: u64) -> Result<Score> {
        let scenario = satellite.scenario(self.prior_error)?;
        let design =
            design(&scenario, &self.request(effort, seed), &AtomicBool::new(false), &|_| ())?;
        let inertia = satellite.inertia_kg_m2();
        let size = inertia.iter().map(|j| j * j).sum::<f64>().sqrt();
        let mean = satellite.moments_kg_m2.iter().sum::<f64>() / 3.0;
        let relative = |log_size: f64| log_size.exp() * mean / size;
        let fixed = design.fixed.first().context("no fixed manoeuvre")?;
        Ok(Score {
            sigma: relative(design.best.log_size),
            fixed_sigma: relative(fixed.log_size),
            fixed: fixed.name.clone(),
            design,
        })
    }
}
