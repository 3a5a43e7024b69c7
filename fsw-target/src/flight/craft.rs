//! Spacecraft data: reaction wheels, gyro noise, stated errors of the hardware, and prior.
//!
//! [`CRAFT`] is the spacecraft of the flight image. The build script generates it from `craft.toml` at the
//! root of this crate, in the format of `host-sim replay --craft`: simulator and firmware read the same
//! file.

use fsw_core::hardware::Hardware;
use fsw_core::{ConfigError, Prior, Vec3, WheelArray};

pub use fsw_steps::WHEELS;

/// Data of a spacecraft with up to W wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Craft<const W: usize> {
    /// Spin axis of each wheel, body axes; normalised by [`wheels`](Self::wheels).
    pub wheel_axes: [[f32; 3]; W],
    /// Spin inertia of each wheel, kg m²; zero for an absent wheel.
    pub spin_inertia_kg_m2: [f32; W],
    /// Gyro noise, one sigma per sample, rad/s.
    pub gyro_noise_rad_s: f32,
    /// Errors of gyro, wheels and torque, one sigma each.
    pub hardware: Hardware<f32, W>,
    /// Inertia before the flight with its uncertainty, if known.
    pub prior: Option<Prior<f32>>,
}

impl<const W: usize> Craft<W> {
    /// The wheels, in the form that estimators take.
    ///
    /// # Errors
    /// Names the value outside the range of a wheel.
    pub fn wheels(&self) -> Result<WheelArray<f32, W>, ConfigError> {
        WheelArray::new(self.wheel_axes.map(Vec3::from), self.spin_inertia_kg_m2)
    }
}

mod generated {
    use super::{Craft, Hardware};
    #[allow(unused_imports)] // unused if the craft file has no prior
    use fsw_core::Prior;

    include!(concat!(env!("OUT_DIR"), "/craft.rs"));
}

/// Spacecraft of the flight image.
pub const CRAFT: Craft<WHEELS> = generated::CRAFT;
