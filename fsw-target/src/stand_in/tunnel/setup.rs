//! Spacecraft data and sensor settings of the processor in the loop, sent by the simulator.

use crate::drivers::gyro::bmi088::{Range, Settings};
use crate::drivers::wheel_tach::{self, CaptureTimer, WheelTach};
use crate::flight::craft::{Craft, WHEELS};
use crate::flight::selected::SelectedEstimator;
use crate::link::authentication::{KEY_BYTES, Key};
use crate::link::wire::record;
use fsw_core::Prior;
use fsw_core::{ConfigError, Mat};

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
        /// Rotation from gyro axes to body axes, by columns.
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
    pub fn craft(&self) -> Craft<WHEELS> {
        let prior =
            |[inertia_kg_m2, sigma_kg_m2]: [[f32; 6]; 2]| Prior { inertia_kg_m2, sigma_kg_m2 };
        Craft {
            wheel_axes: self.wheel_axes,
            spin_inertia_kg_m2: self.spin_inertia_kg_m2,
            gyro_noise_rad_s: self.gyro_noise_rad_s,
            prior: self.prior_kg_m2.map(prior),
        }
    }

    /// The estimator, before its first sample.
    ///
    /// # Errors
    /// [`Unfit::Craft`].
    pub fn estimator(&self) -> Result<SelectedEstimator, Unfit> {
        SelectedEstimator::new(self.craft()).map_err(Unfit::Craft)
    }

    /// Settings of the gyro. Its data rate is the default one: the simulator determines the time of samples.
    ///
    /// # Errors
    /// [`Unfit::Range`].
    pub fn gyro(&self) -> Result<Settings, Unfit> {
        Ok(Settings {
            range: Range::from_register(self.range).ok_or(Unfit::Range)?,
            body_from_sensor: Mat::<f32, 3, 3>::from(self.body_from_sensor),
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
