//! `[hardware]` as written, and its checks.

use flight_input::InputError;
use flight_input::craft::hardware::TachometerFile;
use flight_input::key::Key;
use flight_input::section::{List, Section};
use nalgebra::Unit;
use serde::Deserialize;
use toml::Spanned;

use super::super::problem::ScenarioProblem;
use super::keys::{
    AIR_DENSITY, ALTITUDE, AXES, AXIS_TILT, COMMON_SPIN_INERTIA, DAMPING, DELAY, DIPOLE, DRAG_AREA,
    DRIFT, DYNAMIC_IMBALANCE, FLICKER, FREQUENCY, INCLINATION, INERTIA_SHARE, JITTER, LAG,
    MODE_AXIS, NOISE_CORRELATION, NOISE_FACTOR, OUTLIER_SHARE, OUTLIER_SIGMA, PHASE, POSITION,
    PRESSURE_CENTRE, PULSE_DURATION, PULSE_TIME, PULSE_TORQUE, SCALE, SPIN_INERTIA,
    STATIC_IMBALANCE, TORQUE_SCALE,
};
use super::{
    ClockErrors, DEFAULT_OUTLIER_SIGMA, GyroErrors, Orbit, Pulse, TrueHardware, TrueMode,
    WheelErrors,
};

/// Parts of a whole per part per million.
const PER_MILLION: f64 = 1e-6;

type Number = Option<Spanned<f64>>;

/// Body that the hardware belongs to.
pub(in super::super) struct Carrier {
    /// Number of wheels.
    pub wheels: usize,
    /// Largest principal moment, kg m².
    pub largest_moment_kg_m2: f64,
    /// Smallest principal moment of the body without its wheels, kg m².
    pub smallest_moment_kg_m2: f64,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct HardwareFile {
    #[serde(default)]
    gyro: GyroFile,
    #[serde(default)]
    clock: ClockFile,
    #[serde(default)]
    wheel: Vec<Spanned<WheelFile>>,
    #[serde(default)]
    wheels: WheelsFile,
    #[serde(default)]
    tachometer: TachometerFile,
    #[serde(default)]
    torque: TorqueFile,
    orbit: Option<OrbitFile>,
    #[serde(default)]
    pulse: Vec<PulseFile>,
    #[serde(default)]
    mode: Vec<ModeFile>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct GyroFile {
    scale: Option<List>,
    axes_deg: Option<List>,
    delay_s: Number,
    lag_s: Number,
    #[serde(default)]
    averaged: bool,
    noise_factor: Number,
    noise_correlation: Number,
    flicker_rad_s: Number,
    outlier_share: Number,
    outlier_sigma: Option<List>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClockFile {
    drift_ppm: Number,
    jitter: Number,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelFile {
    spin_inertia: Number,
    axis_deg: Option<List>,
    static_imbalance_kg_m: Number,
    position_m: Option<List>,
    dynamic_imbalance_kg_m2: Number,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelsFile {
    common_spin_inertia: Number,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TorqueFile {
    scale: Number,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OrbitFile {
    altitude_km: Spanned<f64>,
    inclination_deg: Number,
    phase_deg: Number,
    gravity_gradient: Option<bool>,
    dipole_a_m2: Option<List>,
    air_density_kg_m3: Number,
    drag_area_m2: Number,
    pressure_centre_m: Option<List>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PulseFile {
    time_s: Spanned<f64>,
    duration_s: Spanned<f64>,
    torque_n_m: List,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModeFile {
    frequency_hz: Spanned<f64>,
    damping: Spanned<f64>,
    inertia_share: Spanned<f64>,
    axis: Option<List>,
}

impl HardwareFile {
    /// The checked errors of the file whose root is `root`.
    pub(in super::super) fn read(
        &self,
        root: &Section<'_>,
        carrier: &Carrier,
    ) -> Result<TrueHardware, InputError> {
        let section = root.table("hardware");
        if let Some(surplus) = self.wheel.get(carrier.wheels) {
            let problem = ScenarioProblem::SurplusWheelErrors {
                found: self.wheel.len(),
                wheels: carrier.wheels,
            };
            return Err(section.error(surplus, problem));
        }
        let wheels = self.wheel.iter().enumerate();
        let pulses = self.pulse.iter().enumerate();
        Ok(TrueHardware {
            gyro: self.gyro.read(&section.table("gyro"))?,
            clock: self.clock.read(&section.table("clock"))?,
            wheels: wheels
                .map(|(index, wheel)| wheel.get_ref().read(&section.entry("wheel", index)))
                .collect::<Result<_, _>>()?,
            common_spin_inertia: or(
                &section.table("wheels"),
                &COMMON_SPIN_INERTIA,
                &self.wheels.common_spin_inertia,
                0.0,
            )?,
            tachometer: self.tachometer.read(&section.table("tachometer"))?,
            torque_scale: or(&section.table("torque"), &TORQUE_SCALE, &self.torque.scale, 0.0)?,
            orbit: (self.orbit.as_ref())
                .map(|orbit| orbit.read(&section.table("orbit")))
                .transpose()?,
            pulses: pulses
                .map(|(index, pulse)| pulse.read(&section.entry("pulse", index)))
                .collect::<Result<_, _>>()?,
            modes: self.modes(&section, carrier)?,
        })
    }

    /// The modes. The body without wheels and modes has the tensor `J_b − Σ sₖ (aₖᵀ J aₖ) aₖ aₖᵀ`,
    /// which is positive definite for any axes if `Σ sₖ < λ_min(J_b) / λ_max(J)`.
    fn modes(&self, section: &Section<'_>, carrier: &Carrier) -> Result<Vec<TrueMode>, InputError> {
        let most = carrier.smallest_moment_kg_m2 / carrier.largest_moment_kg_m2;
        let mut sum = 0.0;
        let mut modes = Vec::new();
        for (index, mode) in self.mode.iter().enumerate() {
            let entry = section.entry("mode", index);
            let share = &mode.inertia_share;
            sum += share.get_ref();
            let inertia_share = entry.number_if(&INERTIA_SHARE, share, |_| sum < most)?;
            let axis = mode.axis.as_ref().map(|axis| entry.axis(&MODE_AXIS, axis)).transpose()?;
            modes.push(TrueMode {
                frequency_hz: entry.number(&FREQUENCY, &mode.frequency_hz)?,
                damping: entry.number(&DAMPING, &mode.damping)?,
                inertia_share,
                axis: axis.map(Unit::new_unchecked),
            });
        }
        Ok(modes)
    }
}

/// A number, or `default` where the key is absent.
fn or(section: &Section<'_>, key: &Key, value: &Number, default: f64) -> Result<f64, InputError> {
    Ok(section.optional_number(key, value)?.unwrap_or(default))
}

/// A list, or `default` where the key is absent.
fn list_or<const N: usize>(
    section: &Section<'_>,
    key: &Key,
    value: &Option<List>,
    default: [f64; N],
) -> Result<[f64; N], InputError> {
    value.as_ref().map_or(Ok(default), |value| section.list(key, value))
}

impl GyroFile {
    fn read(&self, section: &Section<'_>) -> Result<GyroErrors, InputError> {
        let axes_deg = list_or(section, &AXES, &self.axes_deg, [0.0; 6])?;
        let outlier_sigma =
            list_or(section, &OUTLIER_SIGMA, &self.outlier_sigma, DEFAULT_OUTLIER_SIGMA)?;
        Ok(GyroErrors {
            scale: section.vector_or_zero(&SCALE, &self.scale)?,
            axes_rad: axes_deg.map(f64::to_radians),
            delay_s: or(section, &DELAY, &self.delay_s, 0.0)?,
            lag_s: or(section, &LAG, &self.lag_s, 0.0)?,
            averaged: self.averaged,
            noise_factor: or(section, &NOISE_FACTOR, &self.noise_factor, 1.0)?,
            noise_correlation: or(section, &NOISE_CORRELATION, &self.noise_correlation, 0.0)?,
            flicker_rad_s: or(section, &FLICKER, &self.flicker_rad_s, 0.0)?,
            outlier_share: or(section, &OUTLIER_SHARE, &self.outlier_share, 0.0)?,
            outlier_sigma,
        })
    }
}

impl ClockFile {
    fn read(&self, section: &Section<'_>) -> Result<ClockErrors, InputError> {
        Ok(ClockErrors {
            drift: or(section, &DRIFT, &self.drift_ppm, 0.0)? * PER_MILLION,
            jitter: or(section, &JITTER, &self.jitter, 0.0)?,
        })
    }
}

impl WheelFile {
    fn read(&self, section: &Section<'_>) -> Result<WheelErrors, InputError> {
        let axis_deg = list_or(section, &AXIS_TILT, &self.axis_deg, [0.0; 2])?;
        let (static_imbalance, dynamic_imbalance) =
            (&self.static_imbalance_kg_m, &self.dynamic_imbalance_kg_m2);
        Ok(WheelErrors {
            spin_inertia: or(section, &SPIN_INERTIA, &self.spin_inertia, 0.0)?,
            axis_rad: axis_deg.map(f64::to_radians),
            static_imbalance_kg_m: or(section, &STATIC_IMBALANCE, static_imbalance, 0.0)?,
            position_m: section.vector_or_zero(&POSITION, &self.position_m)?,
            dynamic_imbalance_kg_m2: or(section, &DYNAMIC_IMBALANCE, dynamic_imbalance, 0.0)?,
        })
    }
}

impl OrbitFile {
    fn read(&self, section: &Section<'_>) -> Result<Orbit, InputError> {
        let angle_rad = |key, value| Ok(or(section, key, value, 0.0)?.to_radians());
        Ok(Orbit {
            altitude_km: section.number(&ALTITUDE, &self.altitude_km)?,
            inclination_rad: angle_rad(&INCLINATION, &self.inclination_deg)?,
            phase_rad: angle_rad(&PHASE, &self.phase_deg)?,
            gravity_gradient: self.gravity_gradient.unwrap_or(true),
            dipole_a_m2: section.vector_or_zero(&DIPOLE, &self.dipole_a_m2)?,
            air_density_kg_m3: or(section, &AIR_DENSITY, &self.air_density_kg_m3, 0.0)?,
            drag_area_m2: or(section, &DRAG_AREA, &self.drag_area_m2, 0.0)?,
            pressure_centre_m: section.vector_or_zero(&PRESSURE_CENTRE, &self.pressure_centre_m)?,
        })
    }
}

impl PulseFile {
    fn read(&self, section: &Section<'_>) -> Result<Pulse, InputError> {
        Ok(Pulse {
            time_s: section.number(&PULSE_TIME, &self.time_s)?,
            duration_s: section.number(&PULSE_DURATION, &self.duration_s)?,
            torque_n_m: section.vector(&PULSE_TORQUE, &self.torque_n_m)?,
        })
    }
}
