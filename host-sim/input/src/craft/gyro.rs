//! `[gyro]`: the gyro's data sheet.

use serde::Deserialize;
use toml::Spanned;

use super::hardware::{
    AVERAGED, AXES_SIGMA, BIAS_INSTABILITY, BIAS_SIGMA, BIAS_WALK, CLOCK_SIGMA, DELAY, DELAY_SIGMA,
    GyroStatements, KNOWN_AXES, KNOWN_SCALE, NOISE_TOLERANCE, SCALE_SIGMA, StatedHardware,
};
use crate::error::{InputError, Problem};
use crate::key::{Key, NUMBER, POSITIVE, Table};
use crate::section::{List, Section};

const NOISE: Key = Key::required(
    "noise_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "White noise of one sample, one sigma per axis",
)
.or("estimated from the residuals");
/// Noise as a data sheet gives it.
pub const NOISE_DENSITY: Key = Key::required(
    "noise_density_deg_s_sqrt_hz",
    NUMBER,
    "(deg/s)/√Hz",
    POSITIVE,
    "Density N of the noise, in place of `noise_rad_s`: σ = N √B, with B the bandwidth",
)
.or("`noise_rad_s`");
/// Bandwidth of that noise.
pub const NOISE_BANDWIDTH: Key = Key::required(
    "noise_bandwidth_hz",
    NUMBER,
    "Hz",
    POSITIVE,
    "Bandwidth B of that noise: of the gyro's filter, or half the sample rate without one",
)
.or("required with a density");
const RANGE: Key =
    Key::required("range_rad_s", NUMBER, "rad/s", POSITIVE, "Full scale per axis").or("unlimited");
const QUANTUM: Key = Key::required(
    "quantum_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "Least significant bit, added to the noise as its uniform rounding error, q/√12",
)
.or("negligible");

/// The keys of `[gyro]` in a craft file.
pub const TABLE: Table = Table {
    header: "[gyro]",
    about: "The gyro. Optional.",
    keys: &[
        NOISE,
        NOISE_DENSITY,
        NOISE_BANDWIDTH,
        RANGE,
        QUANTUM,
        KNOWN_SCALE,
        KNOWN_AXES,
        SCALE_SIGMA,
        AXES_SIGMA,
        DELAY,
        DELAY_SIGMA,
        AVERAGED,
        BIAS_SIGMA,
        BIAS_WALK,
        BIAS_INSTABILITY,
        CLOCK_SIGMA,
        NOISE_TOLERANCE,
    ],
};

/// Known properties of the gyro.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GyroData {
    /// White noise of one sample, one sigma per axis, rad/s; none if unknown.
    pub noise_rad_s: Option<f64>,
    /// Full scale per axis, rad/s; none if unknown or unlimited.
    pub range_rad_s: Option<f64>,
    /// Least significant bit, rad/s; none if unknown or negligible.
    pub quantum_rad_s: Option<f64>,
}

impl GyroData {
    /// Standard deviation of one reading on one axis, `√(σ² + q²/12)`, rad/s, with the noise `σ` and
    /// the quantum `q`, rad/s; none if the noise is unknown.
    ///
    /// Assumption: the rounding error is uniform and white, which holds unless both the noise and the
    /// change of the rate between two samples are far below the quantum.
    pub fn reading_sigma_rad_s(&self) -> Option<f64> {
        let noise = self.noise_rad_s?;
        Some(match self.rounding_sigma_rad_s() {
            Some(rounding) => noise.hypot(rounding),
            None => noise,
        })
    }

    /// Standard deviation of the rounding error, `q/√12`, rad/s; none if the quantum is unknown.
    pub fn rounding_sigma_rad_s(&self) -> Option<f64> {
        self.quantum_rad_s.map(|quantum| quantum / 12.0f64.sqrt())
    }

    pub(super) fn write(&self, text: &mut String, hardware: &StatedHardware) {
        *text += "[gyro]\n";
        let Self { noise_rad_s, range_rad_s, quantum_rad_s } = *self;
        for (key, value) in [(NOISE, noise_rad_s), (RANGE, range_rad_s), (QUANTUM, quantum_rad_s)] {
            if let Some(value) = value {
                *text += &format!("{} = {value:?}\n", key.name);
            }
        }
        hardware.write_gyro(text);
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GyroFile {
    noise_rad_s: Option<Spanned<f64>>,
    noise_density_deg_s_sqrt_hz: Option<Spanned<f64>>,
    noise_bandwidth_hz: Option<Spanned<f64>>,
    range_rad_s: Option<Spanned<f64>>,
    quantum_rad_s: Option<Spanned<f64>>,
    scale: Option<List>,
    axes_deg: Option<List>,
    scale_sigma: Option<Spanned<f64>>,
    axes_sigma_deg: Option<Spanned<f64>>,
    delay_s: Option<Spanned<f64>>,
    delay_sigma_s: Option<Spanned<f64>>,
    #[serde(default)]
    averaged: bool,
    bias_sigma_rad_s: Option<Spanned<f64>>,
    bias_walk_rad_s_sqrt_s: Option<Spanned<f64>>,
    bias_instability_rad_s: Option<Spanned<f64>>,
    clock_sigma: Option<Spanned<f64>>,
    noise_tolerance: Option<Spanned<f64>>,
}

/// The noise of a gyro as stated: of a sample, or as a density.
pub struct NoiseStatement<'a> {
    /// `noise_rad_s`.
    pub noise_rad_s: &'a Option<Spanned<f64>>,
    /// `noise_density_deg_s_sqrt_hz`.
    pub density: &'a Option<Spanned<f64>>,
    /// `noise_bandwidth_hz`.
    pub bandwidth_hz: &'a Option<Spanned<f64>>,
}

impl NoiseStatement<'_> {
    /// Noise of a sample, one sigma per axis, rad/s; none if it is not stated. A density N of white noise
    /// within the bandwidth B gives `N √B`; without `noise_bandwidth_hz`, B is `half_rate_hz`.
    ///
    /// # Errors
    /// A value outside its range, both forms, or a density without a bandwidth.
    pub fn read(
        &self,
        section: &Section<'_>,
        noise: &Key,
        half_rate_hz: Option<f64>,
    ) -> Result<Option<f64>, InputError> {
        let noise_rad_s = section.optional_number(noise, self.noise_rad_s)?;
        let bandwidth_hz = section.optional_number(&NOISE_BANDWIDTH, self.bandwidth_hz)?;
        let Some(stated) = self.density else { return Ok(noise_rad_s) };
        let density = section.number(&NOISE_DENSITY, stated)?;
        if noise_rad_s.is_some() {
            let required = "absent beside `noise_rad_s`".to_owned();
            let key = section.full(&NOISE_DENSITY);
            let problem = Problem::BadValue { key, found: density.to_string(), required };
            return Err(section.error(stated, problem));
        }
        let bandwidth_hz = bandwidth_hz.or(half_rate_hz);
        let bandwidth_hz = bandwidth_hz.ok_or_else(|| section.missing(&NOISE_BANDWIDTH, stated))?;
        Ok(Some(density.to_radians() * bandwidth_hz.sqrt()))
    }
}

impl GyroFile {
    /// The statements on errors.
    pub(super) fn statements(self) -> GyroStatements {
        GyroStatements {
            scale: self.scale,
            axes_deg: self.axes_deg,
            scale_sigma: self.scale_sigma,
            axes_sigma_deg: self.axes_sigma_deg,
            delay_s: self.delay_s,
            delay_sigma_s: self.delay_sigma_s,
            averaged: self.averaged,
            bias_sigma_rad_s: self.bias_sigma_rad_s,
            bias_walk_rad_s_sqrt_s: self.bias_walk_rad_s_sqrt_s,
            bias_instability_rad_s: self.bias_instability_rad_s,
            clock_sigma: self.clock_sigma,
            noise_tolerance: self.noise_tolerance,
        }
    }

    pub(super) fn read(&self, section: &Section<'_>) -> Result<GyroData, InputError> {
        let stated = NoiseStatement {
            noise_rad_s: &self.noise_rad_s,
            density: &self.noise_density_deg_s_sqrt_hz,
            bandwidth_hz: &self.noise_bandwidth_hz,
        };
        Ok(GyroData {
            noise_rad_s: stated.read(section, &NOISE, None)?,
            range_rad_s: section.optional_number(&RANGE, &self.range_rad_s)?,
            quantum_rad_s: section.optional_number(&QUANTUM, &self.quantum_rad_s)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Craft;
    use super::*;

    #[test]
    fn density_and_bandwidth_give_the_noise_of_a_sample() {
        let read = |keys: &str| Craft::from_toml("craft.toml", &format!("[gyro]\n{keys}"));
        // A BMI088: 0.014 (deg/s)/√Hz within 47 Hz.
        let craft = read("noise_density_deg_s_sqrt_hz = 0.014\nnoise_bandwidth_hz = 47\n").unwrap();
        let noise = craft.gyro.noise_rad_s.unwrap();
        assert!((noise.to_degrees() - 0.014 * 47f64.sqrt()).abs() < 1e-12, "{noise}");
        let message = read("noise_density_deg_s_sqrt_hz = 0.014\n").unwrap_err().to_string();
        assert!(
            message.starts_with("craft.toml:2: missing key `gyro.noise_bandwidth_hz`"),
            "{message}"
        );
        let both = "noise_rad_s = 1e-3\nnoise_density_deg_s_sqrt_hz = 0.014\n";
        let message = read(both).unwrap_err().to_string();
        assert!(message.contains("is 0.014; it must be absent beside `noise_rad_s`"), "{message}");
    }

    #[test]
    fn reading_sigma_includes_the_rounding_error() {
        let gyro =
            |noise_rad_s, quantum_rad_s| GyroData { noise_rad_s, range_rad_s: None, quantum_rad_s };
        assert_eq!(gyro(None, Some(1e-3)).reading_sigma_rad_s(), None);
        assert_eq!(gyro(Some(1e-4), None).reading_sigma_rad_s(), Some(1e-4));
        let sigma = gyro(Some(1e-4), Some(1e-3)).reading_sigma_rad_s().unwrap();
        assert!((sigma * sigma / (1e-8 + 1e-6 / 12.0) - 1.0).abs() < 1e-12, "{sigma}");
    }
}
