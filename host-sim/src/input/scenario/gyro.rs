//! `[gyro]` of a scenario: the simulated gyro.

use flight_input::InputError;
use flight_input::craft::gyro::{NOISE_BANDWIDTH, NOISE_DENSITY, NoiseStatement};
use flight_input::craft::hardware::{
    AVERAGED, AXES_SIGMA, BIAS_INSTABILITY, BIAS_SIGMA, CLOCK_SIGMA, DELAY, DELAY_SIGMA,
    GyroStatements, NOISE_TOLERANCE, SCALE_SIGMA,
};
use flight_input::key::{FINITE, Key, NOT_NEGATIVE, NUMBER, POSITIVE, Range, Table, VECTOR};
use flight_input::section::{List, Section};
use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::limits::MAX_RATE_HZ;

const UP_TO_100_KHZ: Range =
    Range::new("positive, and at most 100 kHz", |rate| rate > 0.0 && rate <= MAX_RATE_HZ);

const RATE: Key = Key::required("rate_hz", NUMBER, "Hz", UP_TO_100_KHZ, "Samples per second");
const NOISE: Key = Key::required(
    "noise_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "White noise of one sample, one sigma per axis; known to the estimator",
)
.or("that of the density");
const BIAS: Key =
    Key::required("bias_rad_s", VECTOR, "rad/s", FINITE, "Bias at the start").or("`[0, 0, 0]`");
const BIAS_WALK: Key = Key::required(
    "bias_walk_rad_s_sqrt_s",
    NUMBER,
    "(rad/s)/√s",
    NOT_NEGATIVE,
    "Random walk of the bias: one sigma per axis after 1 s",
)
.or("0");
const QUANTUM: Key = Key::required(
    "quantum_rad_s",
    NUMBER,
    "rad/s",
    NOT_NEGATIVE,
    "Least significant bit, known to the estimator; 0 for a continuous output",
)
.or("0");
const RANGE: Key = Key::required(
    "range_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "Full scale per axis, at which the output saturates",
)
.or("unlimited");

/// The keys of `[gyro]` in a scenario.
pub(super) const TABLE: Table = Table {
    header: "[gyro]",
    about: "The simulated gyro. The errors of a run are drawn from the keys of one sigma, which the \
            estimator knows.",
    keys: &[
        RATE,
        NOISE,
        NOISE_DENSITY,
        NOISE_BANDWIDTH.or("half of `rate_hz`"),
        BIAS,
        BIAS_WALK,
        QUANTUM,
        RANGE,
        SCALE_SIGMA.or("0"),
        AXES_SIGMA.or("0"),
        DELAY,
        DELAY_SIGMA.or("0"),
        AVERAGED,
        BIAS_SIGMA,
        BIAS_INSTABILITY,
        CLOCK_SIGMA,
        NOISE_TOLERANCE.or("0"),
    ],
};

/// The simulated gyro.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedGyro {
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// White noise of one sample, one sigma per axis, rad/s.
    pub noise_rad_s: f64,
    /// Bias at the start, body axes, rad/s.
    pub bias_rad_s: Vector3<f64>,
    /// Random walk of the bias: one sigma per axis after 1 s, (rad/s)/√s.
    pub bias_walk_rad_s_sqrt_s: f64,
    /// Least significant bit, rad/s; none if the output is continuous.
    pub quantum_rad_s: Option<f64>,
    /// Full scale per axis, at which the output saturates, rad/s; none if unlimited.
    pub range_rad_s: Option<f64>,
}

impl SimulatedGyro {
    /// Variance of one reading on one axis about the biased rate, `σ² + q²/12`, rad²/s², with the
    /// noise `σ` and the quantum `q`, rad/s.
    ///
    /// Assumption: the rounding error is uniform, which holds unless the noise is far below the
    /// quantum.
    pub fn reading_variance_rad2_s2(&self) -> f64 {
        let quantum = self.quantum_rad_s.unwrap_or(0.0);
        self.noise_rad_s * self.noise_rad_s + quantum * quantum / 12.0
    }
}

impl SimulatedGyro {
    /// A gyro with white noise as its only error.
    pub(super) fn white(rate_hz: f64, noise_rad_s: f64) -> Self {
        Self {
            rate_hz,
            noise_rad_s,
            bias_rad_s: Vector3::zeros(),
            bias_walk_rad_s_sqrt_s: 0.0,
            quantum_rad_s: None,
            range_rad_s: None,
        }
    }
}

/// `[gyro]` of a scenario of random spacecraft: errors alone.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GyroErrorsFile {
    scale_sigma: Option<Spanned<f64>>,
    axes_sigma_deg: Option<Spanned<f64>>,
    delay_s: Option<Spanned<f64>>,
    delay_sigma_s: Option<Spanned<f64>>,
    #[serde(default)]
    averaged: bool,
    bias_sigma_rad_s: Option<Spanned<f64>>,
    bias_instability_rad_s: Option<Spanned<f64>>,
    clock_sigma: Option<Spanned<f64>>,
    noise_tolerance: Option<Spanned<f64>>,
}

impl GyroErrorsFile {
    /// The statements on errors.
    pub(super) fn statements(&self) -> GyroStatements {
        GyroStatements {
            scale_sigma: self.scale_sigma.clone(),
            axes_sigma_deg: self.axes_sigma_deg.clone(),
            delay_s: self.delay_s.clone(),
            delay_sigma_s: self.delay_sigma_s.clone(),
            averaged: self.averaged,
            bias_sigma_rad_s: self.bias_sigma_rad_s.clone(),
            bias_instability_rad_s: self.bias_instability_rad_s.clone(),
            clock_sigma: self.clock_sigma.clone(),
            noise_tolerance: self.noise_tolerance.clone(),
            ..GyroStatements::default()
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GyroFile {
    rate_hz: Spanned<f64>,
    noise_rad_s: Option<Spanned<f64>>,
    noise_density_deg_s_sqrt_hz: Option<Spanned<f64>>,
    noise_bandwidth_hz: Option<Spanned<f64>>,
    bias_rad_s: Option<List>,
    bias_walk_rad_s_sqrt_s: Option<Spanned<f64>>,
    quantum_rad_s: Option<Spanned<f64>>,
    range_rad_s: Option<Spanned<f64>>,
    scale_sigma: Option<Spanned<f64>>,
    axes_sigma_deg: Option<Spanned<f64>>,
    delay_s: Option<Spanned<f64>>,
    delay_sigma_s: Option<Spanned<f64>>,
    #[serde(default)]
    averaged: bool,
    bias_sigma_rad_s: Option<Spanned<f64>>,
    bias_instability_rad_s: Option<Spanned<f64>>,
    clock_sigma: Option<Spanned<f64>>,
    noise_tolerance: Option<Spanned<f64>>,
}

impl GyroFile {
    /// The statements on errors. The bias walk of a scenario is the true one, and known.
    pub(super) fn statements(&self) -> GyroStatements {
        GyroStatements {
            scale: None,
            axes_deg: None,
            scale_sigma: self.scale_sigma.clone(),
            axes_sigma_deg: self.axes_sigma_deg.clone(),
            delay_s: self.delay_s.clone(),
            delay_sigma_s: self.delay_sigma_s.clone(),
            averaged: self.averaged,
            bias_sigma_rad_s: self.bias_sigma_rad_s.clone(),
            bias_instability_rad_s: self.bias_instability_rad_s.clone(),
            bias_walk_rad_s_sqrt_s: self.bias_walk_rad_s_sqrt_s.clone(),
            clock_sigma: self.clock_sigma.clone(),
            noise_tolerance: self.noise_tolerance.clone(),
        }
    }

    pub(super) fn read(&self, section: &Section<'_>) -> Result<SimulatedGyro, InputError> {
        let bias_walk = section.optional_number(&BIAS_WALK, &self.bias_walk_rad_s_sqrt_s)?;
        let quantum_rad_s = section.optional_number(&QUANTUM, &self.quantum_rad_s)?;
        let rate_hz = section.number(&RATE, &self.rate_hz)?;
        let stated = NoiseStatement {
            noise_rad_s: &self.noise_rad_s,
            density: &self.noise_density_deg_s_sqrt_hz,
            bandwidth_hz: &self.noise_bandwidth_hz,
        };
        let noise_rad_s = stated.read(section, &NOISE, Some(0.5 * rate_hz))?;
        Ok(SimulatedGyro {
            rate_hz,
            noise_rad_s: noise_rad_s.ok_or_else(|| section.missing(&NOISE, &self.rate_hz))?,
            bias_rad_s: section.vector_or_zero(&BIAS, &self.bias_rad_s)?,
            bias_walk_rad_s_sqrt_s: bias_walk.unwrap_or(0.0),
            quantum_rad_s: quantum_rad_s.filter(|quantum| *quantum > 0.0),
            range_rad_s: section.optional_number(&RANGE, &self.range_rad_s)?,
        })
    }
}
