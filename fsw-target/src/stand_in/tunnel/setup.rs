//! Spacecraft data and sensor settings of the processor in the loop, sent by the simulator.

use crate::drivers::gyro::bmi088::{Range, Settings};
use crate::drivers::wheel_tach::{self, CaptureTimer, WheelTach};
use crate::flight::craft::{Craft, WHEELS};
use crate::flight::selected::SelectedEstimator;
use crate::link::authentication::{KEY_BYTES, Key};
use crate::link::wire::record;
use fsw_core::hardware::Hardware;
use fsw_core::{ConfigError, Prior};

record! {
    /// Spacecraft data and sensor settings.
    struct Setup {
        /// Time of the clock that stamps samples.
        now_us: u64, "µs";
        /// Spin axis of each wheel, body axes.
        wheel_axes: [[f32; 3]; WHEELS], "–";
        /// Spin inertia of each wheel; zero for an absent wheel.
        spin_inertia_kg_m2: [f32; WHEELS], "kg m²";
        /// Gyro noise, one sigma per sample.
        gyro_noise_rad_s: f32, "rad/s";
        /// Inertia before the flight and one sigma of each element, if known.
        prior_kg_m2: Option<[[f32; 6]; 2]>, "kg m²";
        /// Range of the gyro, by the value of its register.
        range: u8, "–";
        /// Rotation from gyro axes to body axes, by rows.
        body_from_sensor: [[f32; 3]; 3], "–";
        /// Edges per turn of each wheel; zero for an absent wheel.
        edges_per_turn: [u16; WHEELS], "edges";
        /// Time without an edge after which a wheel is at rest.
        zero_after_s: f32, "s";
        /// Rate of the wheel timer.
        ticks_per_s: u32, "1/s";
        /// Master key of telecommands; absent for telecommands without a tag.
        master_key: Option<[u8; KEY_BYTES]>, "–";
    }
}

record! {
    /// Stated errors of the hardware, one sigma each; fields as of [`Hardware`].
    struct Stated {
        /// Scale factor of each gyro axis.
        gyro_scale: f32, "1";
        /// Each error of the gyro's axes.
        gyro_axes_rad: f32, "rad";
        /// Known time offset of the gyro.
        delay_s: f32, "s";
        /// Error of it.
        delay_sigma_s: f32, "s";
        /// Spin inertia of each wheel, share.
        wheel_inertia: [f32; WHEELS], "1";
        /// Each tilt of a spin axis.
        wheel_axis_rad: [f32; WHEELS], "rad";
        /// Error common to all spin inertias, share.
        common_wheel_inertia: f32, "1";
        /// Known external torque, share.
        torque_scale: f32, "1";
        /// Rate of the clock, share.
        clock: f32, "1";
        /// Turn of all sensors as one, about each axis.
        mount_rad: [f32; 3], "rad";
    }
}

impl From<&Stated> for Hardware<f32, WHEELS> {
    fn from(stated: &Stated) -> Self {
        Self {
            gyro_scale: stated.gyro_scale,
            gyro_axes_rad: stated.gyro_axes_rad,
            delay_s: stated.delay_s,
            delay_sigma_s: stated.delay_sigma_s,
            wheel_inertia: stated.wheel_inertia,
            wheel_axis_rad: stated.wheel_axis_rad,
            common_wheel_inertia: stated.common_wheel_inertia,
            torque_scale: stated.torque_scale,
            clock: stated.clock,
            mount_rad: stated.mount_rad,
        }
    }
}

/// Reason why a setup is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Unfit {
    /// The estimator does not accept the craft.
    Craft(ConfigError),
    /// Invalid settings of the tachometers.
    Tachometers(wheel_tach::ConfigError),
    /// Unknown range of the gyro.
    Range,
}

impl Setup {
    /// The spacecraft, as estimators are configured for it.
    pub fn craft(&self, stated: &Stated) -> Craft<WHEELS> {
        let prior =
            |[inertia_kg_m2, sigma_kg_m2]: [[f32; 6]; 2]| Prior { inertia_kg_m2, sigma_kg_m2 };
        Craft {
            wheel_axes: self.wheel_axes,
            spin_inertia_kg_m2: self.spin_inertia_kg_m2,
            gyro_noise_rad_s: self.gyro_noise_rad_s,
            hardware: stated.into(),
            prior: self.prior_kg_m2.map(prior),
        }
    }

    /// The estimator, before its first sample.
    ///
    /// # Errors
    /// [`Unfit::Craft`].
    pub fn estimator(&self, stated: &Stated) -> Result<SelectedEstimator, Unfit> {
        SelectedEstimator::new(self.craft(stated)).map_err(Unfit::Craft)
    }

    /// Settings of the gyro. Its data rate is the default one: the simulator determines the time of samples.
    ///
    /// # Errors
    /// [`Unfit::Range`].
    pub fn gyro(&self) -> Result<Settings, Unfit> {
        Ok(Settings {
            range: Range::from_register(self.range).ok_or(Unfit::Range)?,
            body_from_sensor: self.body_from_sensor,
            ..Settings::default()
        })
    }

    /// The tachometers of a timer.
    ///
    /// # Errors
    /// [`Unfit::Tachometers`].
    pub fn tachometers<C: CaptureTimer<WHEELS>>(
        &self,
        timer: C,
    ) -> Result<WheelTach<C, WHEELS>, Unfit> {
        let config = wheel_tach::Config {
            edges_per_turn: self.edges_per_turn,
            reversed: [false; WHEELS],
            zero_after_s: self.zero_after_s,
            // The wheels of a scenario have no largest acceleration.
            largest_acceleration_rad_s2: f32::INFINITY,
            delay_us: Settings::default().delay_us,
        };
        WheelTach::new(timer, &config).map_err(Unfit::Tachometers)
    }

    /// Master key of telecommands.
    pub fn master_key(&self) -> Option<Key> {
        self.master_key.map(Key::new)
    }

    /// True if the spacecraft has a wheel.
    pub fn has_wheels(&self) -> bool {
        self.edges_per_turn.iter().any(|edges| *edges > 0)
    }
}
