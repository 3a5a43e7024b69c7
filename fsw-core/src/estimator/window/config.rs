//! What the window estimator is told.

use super::unknowns::{has_bias, has_torque};
use crate::error::{ConfigError, Invalid};
use crate::gate;
use crate::math::range::{not_negative, positive};
use crate::math::scalar::Real;
use crate::prior::Prior;

/// Configuration, fixed for the estimator's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// What is known of the inertia beforehand. Default none, and none is needed. One that the data
    /// contradict is dropped.
    pub prior: Option<Prior<T>>,
    /// Gyro noise, one sigma, white, per sample, rad/s. Where it isn't given it is measured, and the
    /// covariance is scaled by what the residuals are.
    pub gyro_noise_rad_s: Option<T>,
    /// One sigma of the range in which a constant disturbance torque is estimated, N m, each axis.
    /// Default none: it is held at zero, and the residuals are tested for one.
    pub disturbance_torque_n_m: Option<T>,
    /// One sigma of the range in which a constant gyro bias is estimated, rad/s, each axis. Default
    /// none: it is held at zero.
    pub gyro_bias_rad_s: Option<T>,
    /// Random walk of each element of the inertia from one manoeuvre to the next, one sigma after a
    /// second, kg m²/√s. Default zero.
    pub inertia_walk_kg_m2_sqrt_s: T,
    /// Samples averaged into a block at first; twice as many whenever storage is full of blocks
    /// that don't turn far. Default 4: half as many leave less work for linearising anew, twice as
    /// many model a fast torque less well.
    pub block_samples: u32,
    /// A block ends once it has turned by so much, rad. Default 0.6: it is crossed in two steps then,
    /// which err by 4e-9, and storage for 512 blocks holds 48 turns of the body.
    pub block_turn_rad: T,
    /// Whether the external torque swings between its samples, like a sine, rather than going straight
    /// from one to the next, like a table. Default no.
    pub is_torque_smooth: bool,
    /// Instructions of a Cortex-M4F that a step may cost, in single precision. Default none: 6,000 for
    /// momentum and inertia, 10,000 where torque or bias are among the unknowns, 12,000 with drag. With
    /// more, passes over the data follow one another faster, and find the solution sooner where
    /// the body turns fast or noise is high.
    pub instructions_per_step: Option<u32>,
    /// A manoeuvre is over once nothing has moved for so long, s. Default 30.
    pub quiet_s: T,
    /// Which samples are looked at.
    pub gate: gate::Config<T>,
}

// A command may set the prior.
crate::persist!([T: Real] Config<T> {
    prior;
    unchanged gyro_noise_rad_s, disturbance_torque_n_m, gyro_bias_rad_s, inertia_walk_kg_m2_sqrt_s,
    block_samples, block_turn_rad, is_torque_smooth, instructions_per_step, quiet_s, gate
});

impl<T: Real> Config<T> {
    /// Defaults for a gyro of this noise (one sigma, white, per sample, rad/s).
    pub fn new(gyro_noise_rad_s: T) -> Self {
        Self { gyro_noise_rad_s: Some(gyro_noise_rad_s), ..Self::of_unknown_noise() }
    }

    /// Defaults for a gyro of which nothing is known.
    pub fn of_unknown_noise() -> Self {
        Self {
            prior: None,
            gyro_noise_rad_s: None,
            disturbance_torque_n_m: None,
            gyro_bias_rad_s: None,
            inertia_walk_kg_m2_sqrt_s: T::zero(),
            block_samples: 4,
            block_turn_rad: T::lit(0.6),
            is_torque_smooth: false,
            instructions_per_step: None,
            quiet_s: T::lit(30.0),
            gate: gate::Config::default(),
        }
    }

    /// Refuses, by name, the first field that is out of its range, or that asks for more than U
    /// unknowns hold.
    pub fn validate<const U: usize>(&self) -> Result<(), ConfigError> {
        let optional = [
            ("gyro_noise_rad_s", self.gyro_noise_rad_s, true),
            ("disturbance_torque_n_m", self.disturbance_torque_n_m, has_torque(U)),
            ("gyro_bias_rad_s", self.gyro_bias_rad_s, has_bias(U)),
        ];
        for (field, value, has_room) in optional {
            if let Some(value) = value {
                positive(field, value)?;
                if !has_room {
                    return Err(ConfigError { field, reason: Invalid::NoRoom });
                }
            }
        }
        positive("block_turn_rad", self.block_turn_rad)?;
        positive("quiet_s", self.quiet_s)?;
        not_negative("inertia_walk_kg_m2_sqrt_s", self.inertia_walk_kg_m2_sqrt_s)?;
        for (field, number) in [
            ("block_samples", Some(self.block_samples)),
            ("instructions_per_step", self.instructions_per_step),
        ] {
            if number == Some(0) {
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
            assert_eq!(config.validate::<12>(), Ok(()));
            change(&mut config);
            config.validate::<12>().unwrap_err().field
        };
        assert_eq!(refused(|c| c.gyro_noise_rad_s = Some(0.0)), "gyro_noise_rad_s");
        assert_eq!(refused(|c| c.disturbance_torque_n_m = Some(-1.0)), "disturbance_torque_n_m");
        assert_eq!(refused(|c| c.gyro_bias_rad_s = Some(1.0)), "gyro_bias_rad_s", "no room");
        assert_eq!(refused(|c| c.block_turn_rad = f32::NAN), "block_turn_rad");
        assert_eq!(refused(|c| c.quiet_s = 0.0), "quiet_s");
        assert_eq!(refused(|c| c.inertia_walk_kg_m2_sqrt_s = -1.0), "inertia_walk_kg_m2_sqrt_s");
        assert_eq!(refused(|c| c.block_samples = 0), "block_samples");
        assert_eq!(refused(|c| c.instructions_per_step = Some(0)), "instructions_per_step");
        assert_eq!(refused(|c| c.gate.range_rad_s = 0.0), "gate.range_rad_s");
    }
}
