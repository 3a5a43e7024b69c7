//! What the window estimator is told.

use crate::error::{ConfigError, Invalid, positive};
use crate::estimator::Prior;
use crate::gate;
use crate::math::scalar::Real;

/// Configuration, fixed for the estimator's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// What is known of the inertia beforehand. Default none, and none is needed.
    pub prior: Option<Prior<T>>,
    /// Gyro noise, one sigma, white, per sample, rad/s. Must be given.
    pub gyro_noise_rad_s: T,
    /// Samples averaged into a block at first; twice as many whenever storage is full of blocks
    /// that don't turn far. Default 4: half as many leave less work for linearising anew, twice as
    /// many model a fast torque less well.
    pub block_samples: u32,
    /// A block may turn by so much, rad. Default 0.2, up to which the integration across a block
    /// errs by 1e-8: storage for 512 blocks then holds sixteen turns of the body.
    pub block_turn_rad: T,
    /// Slices of work per step: a block takes four, its integration and three rows. Default 8:
    /// with a block for each sample, half of the work goes into what arrives and half into
    /// linearising anew.
    pub slices_per_step: u32,
    /// Which samples are looked at.
    pub gate: gate::Config<T>,
}

impl<T: Real> Config<T> {
    /// Defaults for a gyro of this noise (one sigma, white, per sample, rad/s).
    pub fn new(gyro_noise_rad_s: T) -> Self {
        Self {
            prior: None,
            gyro_noise_rad_s,
            block_samples: 4,
            block_turn_rad: T::lit(0.2),
            slices_per_step: 8,
            gate: gate::Config::default(),
        }
    }

    /// Refuses the first field that is out of its range, by name.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gyro_noise_rad_s", self.gyro_noise_rad_s)?;
        positive("block_turn_rad", self.block_turn_rad)?;
        for (field, number) in
            [("block_samples", self.block_samples), ("slices_per_step", self.slices_per_step)]
        {
            if number == 0 {
                return Err(ConfigError { field, reason: Invalid::NotPositive });
            }
        }
        if let Some(prior) = &self.prior {
            prior.validate()?;
        }
        self.gate.validate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_field_that_is_out_of_range() {
        let refused = |change: fn(&mut Config<f32>)| {
            let mut config = Config::new(1e-4);
            assert_eq!(config.validate(), Ok(()));
            change(&mut config);
            config.validate().unwrap_err().field
        };
        assert_eq!(refused(|c| c.gyro_noise_rad_s = 0.0), "gyro_noise_rad_s");
        assert_eq!(refused(|c| c.block_turn_rad = f32::NAN), "block_turn_rad");
        assert_eq!(refused(|c| c.block_samples = 0), "block_samples");
        assert_eq!(refused(|c| c.slices_per_step = 0), "slices_per_step");
        assert_eq!(refused(|c| c.gate.range_rad_s = 0.0), "gate.range_rad_s");
    }
}
