//! From the stated keys of a file to [`StatedHardware`].

use serde::Deserialize;
use toml::Spanned;

use super::keys::{
    AXES_SIGMA, AXIS_SIGMA, BIAS_INSTABILITY, BIAS_SIGMA, BIAS_WALK, CLOCK_SIGMA,
    COMMON_SPIN_INERTIA_SIGMA, DATA_SHEET, DELAY, DELAY_SIGMA, EACH_AXIS_SIGMA,
    EACH_SPIN_INERTIA_SIGMA, KNOWN_AXES, KNOWN_SCALE, MODE_DAMPING, MODE_DAMPING_SIGMA,
    MODE_FREQUENCY, MODE_FREQUENCY_SIGMA, MOUNT_SIGMA, NOISE_TOLERANCE, SCALE_SIGMA,
    SPIN_INERTIA_SIGMA, TORQUE_SCALE_SIGMA, TORQUE_SIGMA, VARYING_TORQUE_SIGMA,
};
use super::tachometer::TachometerFile;
use super::{Mode, StatedHardware};
use crate::error::InputError;
use crate::key::Key;
use crate::section::{List, Section};

type Number = Option<Spanned<f64>>;

/// Value of a key that a file leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unstated {
    /// That of [`DATA_SHEET`]: a craft file.
    DataSheet,
    /// Zero: a scenario.
    Ideal,
}

/// Statements on the gyro.
#[derive(Clone, Debug, Default)]
pub struct GyroStatements {
    /// `scale`.
    pub scale: Option<List>,
    /// `axes_deg`.
    pub axes_deg: Option<List>,
    /// `scale_sigma`.
    pub scale_sigma: Number,
    /// `axes_sigma_deg`.
    pub axes_sigma_deg: Number,
    /// `delay_s`.
    pub delay_s: Number,
    /// `delay_sigma_s`.
    pub delay_sigma_s: Number,
    /// `averaged`.
    pub averaged: bool,
    /// `bias_sigma_rad_s`.
    pub bias_sigma_rad_s: Number,
    /// `bias_walk_rad_s_sqrt_s`.
    pub bias_walk_rad_s_sqrt_s: Number,
    /// `bias_instability_rad_s`.
    pub bias_instability_rad_s: Number,
    /// `clock_sigma`.
    pub clock_sigma: Number,
    /// `noise_tolerance`.
    pub noise_tolerance: Number,
}

/// Statements on one wheel.
#[derive(Clone, Debug, Default)]
pub struct WheelStatements {
    /// `spin_inertia_sigma`.
    pub spin_inertia_sigma: Number,
    /// `axis_sigma_deg`.
    pub axis_sigma_deg: Number,
    /// `[wheel.tachometer]`.
    pub tachometer: Option<TachometerFile>,
}

/// `[wheels]` as written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelsFile {
    spin_inertia_sigma: Number,
    axis_sigma_deg: Number,
    common_spin_inertia_sigma: Number,
    tachometer: Option<TachometerFile>,
}

/// `[torque]` of a craft file as written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueScaleFile {
    /// Scale error of the torque, one sigma.
    pub scale_sigma: Number,
}

/// `[mount]` as written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountFile {
    sigma_deg: Option<List>,
}

/// `[[mode]]` as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeFile {
    frequency_hz: Spanned<f64>,
    damping: Spanned<f64>,
    frequency_sigma: Number,
    damping_sigma: Number,
}

/// All statements of a file on its hardware.
#[derive(Clone, Debug, Default)]
pub struct Statements {
    /// Of `[gyro]`.
    pub gyro: GyroStatements,
    /// Of each `[[wheel]]`.
    pub each_wheel: Vec<WheelStatements>,
    /// `[wheels]`.
    pub wheels: WheelsFile,
    /// `scale_sigma` of `[torque]`.
    pub torque_scale_sigma: Number,
    /// `torque_sigma_n_m` of `[disturbance]`.
    pub torque_sigma_n_m: Number,
    /// `varying_torque_sigma_n_m` of `[disturbance]`.
    pub varying_torque_sigma_n_m: Number,
    /// `[mount]`.
    pub mount: MountFile,
    /// Each `[[mode]]`.
    pub modes: Vec<Spanned<ModeFile>>,
}

/// Reader of numbers with a data-sheet value.
struct Reader {
    unstated: Unstated,
    assumed: Vec<&'static str>,
}

impl Reader {
    /// The stated value; that of the data sheet, or zero, where there is none.
    fn value(
        &mut self,
        section: &Section<'_>,
        key: &Key,
        path: &'static str,
        stated: &Number,
    ) -> Result<f64, InputError> {
        match section.optional_number(key, stated)? {
            Some(value) => Ok(value),
            None => Ok(self.absent(path)),
        }
    }

    fn absent(&mut self, path: &'static str) -> f64 {
        let row = DATA_SHEET.iter().find(|row| row.path == path);
        let Some(row) = row.filter(|_| self.unstated == Unstated::DataSheet) else { return 0.0 };
        self.assumed.push(path);
        row.value
    }
}

impl Statements {
    /// The checked hardware of the file whose root is `root`.
    ///
    /// # Errors
    /// A value outside the range of its key.
    pub fn read(
        &self,
        root: &Section<'_>,
        unstated: Unstated,
    ) -> Result<StatedHardware, InputError> {
        let mut reader = Reader { unstated, assumed: Vec::new() };
        let mut hardware = self.gyro.read(&root.table("gyro"), &mut reader)?;
        self.read_wheels(root, &mut reader, &mut hardware)?;
        let (torque, disturbance) = (root.table("torque"), root.table("disturbance"));
        hardware.torque_scale_sigma = reader.value(
            &torque,
            &TORQUE_SCALE_SIGMA,
            "torque.scale_sigma",
            &self.torque_scale_sigma,
        )?;
        hardware.torque_sigma_n_m =
            disturbance.optional_number(&TORQUE_SIGMA, &self.torque_sigma_n_m)?;
        hardware.varying_torque_sigma_n_m = disturbance
            .optional_number(&VARYING_TORQUE_SIGMA, &self.varying_torque_sigma_n_m)?
            .unwrap_or(0.0);
        let mount_deg = root.table("mount").vector_or_zero(&MOUNT_SIGMA, &self.mount.sigma_deg)?;
        hardware.mount_sigma_rad = mount_deg.map(f64::to_radians).into();
        let modes = self.modes.iter().enumerate();
        hardware.modes = modes
            .map(|(index, mode)| mode.get_ref().read(&root.entry("mode", index), &mut reader))
            .collect::<Result<_, _>>()?;
        // In the order of the table.
        let rows = DATA_SHEET.iter().map(|row| row.path);
        let assumed = rows.filter(|path| reader.assumed.contains(path)).collect();
        Ok(StatedHardware { assumed, ..hardware })
    }

    fn read_wheels(
        &self,
        root: &Section<'_>,
        reader: &mut Reader,
        hardware: &mut StatedHardware,
    ) -> Result<(), InputError> {
        let section = root.table("wheels");
        let each = &self.wheels;
        let inertia =
            section.optional_number(&EACH_SPIN_INERTIA_SIGMA, &each.spin_inertia_sigma)?;
        let axis_deg = section.optional_number(&EACH_AXIS_SIGMA, &each.axis_sigma_deg)?;
        let tachometer = each.tachometer.clone().unwrap_or_default();
        let tachometer = tachometer.read(&section.table("tachometer"))?;
        for (index, wheel) in self.each_wheel.iter().enumerate() {
            let entry = root.entry("wheel", index);
            let own = entry.optional_number(&SPIN_INERTIA_SIGMA, &wheel.spin_inertia_sigma)?;
            let own_deg = entry.optional_number(&AXIS_SIGMA, &wheel.axis_sigma_deg)?;
            let sigma =
                own.or(inertia).unwrap_or_else(|| reader.absent("wheel.spin_inertia_sigma"));
            let tilt_deg =
                own_deg.or(axis_deg).unwrap_or_else(|| reader.absent("wheel.axis_sigma_deg"));
            hardware.wheel_spin_inertia_sigma.push(sigma);
            hardware.wheel_axis_sigma_rad.push(tilt_deg.to_radians());
            hardware.tachometers.push(match &wheel.tachometer {
                Some(own) => own.read(&entry.table("tachometer"))?,
                None => tachometer,
            });
        }
        let common = &each.common_spin_inertia_sigma;
        hardware.common_spin_inertia_sigma =
            section.optional_number(&COMMON_SPIN_INERTIA_SIGMA, common)?.unwrap_or(0.0);
        Ok(())
    }
}

impl GyroStatements {
    /// The part of the hardware that is the gyro's.
    fn read(
        &self,
        section: &Section<'_>,
        reader: &mut Reader,
    ) -> Result<StatedHardware, InputError> {
        let axes_deg: Option<[f64; 6]> =
            self.axes_deg.as_ref().map(|axes| section.list(&KNOWN_AXES, axes)).transpose()?;
        let axes_sigma_deg =
            reader.value(section, &AXES_SIGMA, "gyro.axes_sigma_deg", &self.axes_sigma_deg)?;
        Ok(StatedHardware {
            gyro_scale: section.vector_or_zero(&KNOWN_SCALE, &self.scale)?.into(),
            gyro_axes_rad: axes_deg.unwrap_or_default().map(f64::to_radians),
            gyro_scale_sigma: reader.value(
                section,
                &SCALE_SIGMA,
                "gyro.scale_sigma",
                &self.scale_sigma,
            )?,
            gyro_axes_sigma_rad: axes_sigma_deg.to_radians(),
            gyro_delay_s: section.optional_number(&DELAY, &self.delay_s)?.unwrap_or(0.0),
            gyro_delay_sigma_s: reader.value(
                section,
                &DELAY_SIGMA,
                "gyro.delay_sigma_s",
                &self.delay_sigma_s,
            )?,
            gyro_averaged: self.averaged,
            gyro_noise_tolerance: reader.value(
                section,
                &NOISE_TOLERANCE,
                "gyro.noise_tolerance",
                &self.noise_tolerance,
            )?,
            clock_sigma: section.optional_number(&CLOCK_SIGMA, &self.clock_sigma)?.unwrap_or(0.0),
            bias_sigma_rad_s: section.optional_number(&BIAS_SIGMA, &self.bias_sigma_rad_s)?,
            bias_walk_rad_s_sqrt_s: section
                .optional_number(&BIAS_WALK, &self.bias_walk_rad_s_sqrt_s)?
                .unwrap_or(0.0),
            bias_instability_rad_s: section
                .optional_number(&BIAS_INSTABILITY, &self.bias_instability_rad_s)?
                .unwrap_or(0.0),
            ..StatedHardware::default()
        })
    }
}

impl ModeFile {
    fn read(&self, section: &Section<'_>, reader: &mut Reader) -> Result<Mode, InputError> {
        Ok(Mode {
            frequency_hz: section.number(&MODE_FREQUENCY, &self.frequency_hz)?,
            damping: section.number(&MODE_DAMPING, &self.damping)?,
            frequency_sigma: reader.value(
                section,
                &MODE_FREQUENCY_SIGMA,
                "mode.frequency_sigma",
                &self.frequency_sigma,
            )?,
            damping_sigma: reader.value(
                section,
                &MODE_DAMPING_SIGMA,
                "mode.damping_sigma",
                &self.damping_sigma,
            )?,
        })
    }
}
