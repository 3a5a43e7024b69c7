//! What spacecraft the processor flies, and how its sensors are made.

use crate::drivers::gyro::bmi088::{Range, Settings};
use crate::drivers::wheel_tach::{self, CaptureTimer, WheelTach};
use crate::flight::craft::{Craft, WHEELS};
use crate::flight::selected::SelectedEstimator;
use crate::link::wire::record;
use fsw_core::Prior;
use fsw_core::{ConfigError, Mat};

record! {
    /// What spacecraft the processor flies, and how its sensors are made.
    struct Setup {
        /// The time now, by the clock that stamps samples.
        now_us: u64, "µs";
        /// Spin axis of each wheel, body axes.
        wheel_axes: [[f32; 3]; WHEELS], "–";
        /// Spin inertia of each wheel; zero where there is none.
        spin_inertia_kg_m2: [f32; WHEELS], "kg m²";
        /// Gyro noise, one sigma per sample.
        gyro_noise_rad_s: f32, "rad/s";
        /// The inertia before the flight, and one sigma of each element, if anything is known.
        prior_kg_m2: Option<[[f32; 6]; 2]>, "kg m²";
        /// The gyro's range, as its register has it.
        range: u8, "–";
        /// Rotation from the gyro's axes to the body's, column by column.
        body_from_sensor: [[f32; 3]; 3], "–";
        /// Edges in a turn of each wheel; zero where there is none.
        edges_per_turn: [u16; WHEELS], "edges";
        /// A wheel without an edge for so long stands still.
        zero_after_s: f32, "s";
        /// The wheels' timer.
        ticks_per_s: u32, "1/s";
    }
}

/// Why a flight computer can't be set up so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Unfit {
    /// The estimators refuse the craft.
    Craft(ConfigError),
    /// The tachometers' settings can't be.
    Tachometers(wheel_tach::ConfigError),
    /// No range of the gyro has this number.
    Range,
}

impl Setup {
    /// What the estimators are told.
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

    /// The estimators, at their start.
    ///
    /// # Errors
    /// [`Unfit::Craft`].
    pub fn estimator(&self) -> Result<SelectedEstimator, Unfit> {
        SelectedEstimator::new(self.craft()).map_err(Unfit::Craft)
    }

    /// How the gyro is set up. Its data rate is the default: whoever announces samples has the time.
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

    /// The tachometers on a timer.
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
        };
        WheelTach::new(timer, &config).map_err(Unfit::Tachometers)
    }

    /// Whether there is any wheel to ask for.
    pub fn has_wheels(&self) -> bool {
        self.edges_per_turn.iter().any(|edges| *edges > 0)
    }
}
