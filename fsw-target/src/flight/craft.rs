//! What is known of the spacecraft before it flies: its wheels, its gyro's noise, a prior.
//!
//! [`FLOWN`] is the one that the flight image is built for. It comes from `craft.toml` at the root
//! of this crate, in the format of `host-sim replay --craft`, so that the simulator and the firmware
//! read the same file.

use fsw_core::Prior;
use fsw_core::{ConfigError, Vec3, WheelArray};

pub use fsw_steps::WHEELS;

/// What is known of a spacecraft with up to W wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Craft<const W: usize> {
    /// Spin axis of each wheel in body axes; need not be normalised.
    pub wheel_axes: [[f32; 3]; W],
    /// Spin inertia of each wheel, kg m²; zero where there is no wheel.
    pub spin_inertia_kg_m2: [f32; W],
    /// Gyro noise, one sigma per sample, rad/s.
    pub gyro_noise_rad_s: f32,
    /// What is known of the inertia before the flight, if anything.
    pub prior: Option<Prior<f32>>,
}

impl<const W: usize> Craft<W> {
    /// The wheels, as an estimator wants them.
    ///
    /// # Errors
    /// Names the value that no wheel has.
    pub fn wheels(&self) -> Result<WheelArray<f32, W>, ConfigError> {
        WheelArray::new(self.wheel_axes.map(Vec3::from), self.spin_inertia_kg_m2)
    }
}

mod flown {
    use super::Craft;
    #[allow(unused_imports)] // unused if the craft file has no prior
    use fsw_core::Prior;

    include!(concat!(env!("OUT_DIR"), "/craft.rs"));
}

/// The spacecraft that the flight image is built for.
pub const FLOWN: Craft<WHEELS> = flown::CRAFT;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::selected::SelectedEstimator;

    #[test]
    fn the_flown_craft_is_one_that_the_estimators_accept() {
        assert_eq!(SelectedEstimator::new(FLOWN).map(|onboard| onboard.prior()), Ok(FLOWN.prior));
    }
}
