//! Configuration of the four momentum estimators.

use super::Method;
use crate::error::ConfigError;
use crate::gate;
use crate::math::range::{not_negative, positive};
use crate::math::scalar::Real;
use crate::prior::Prior;

/// Configuration, fixed for the estimator's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// The paper's formula. Must be given.
    pub method: Method,
    /// Gyro noise, one sigma, white, per sample, rad/s, above zero. Must be given.
    pub gyro_noise_rad_s: T,
    /// Inertia before the data. The paper has none and the formulas do not use it: it is the value
    /// and sigma of an element without data, and the second moment of j in the covariance. Default
    /// none: a sphere of the inertia along the motion, with a sigma of as much on the moments and
    /// half of it on the products.
    pub prior: Option<Prior<T>>,
    /// Largest rate on any axis, in sigmas of the gyro, that counts as rest, zero or above. The
    /// paper starts at rest. Default 5. A slow drift that is taken as rest appears in the residual.
    pub rest_sigma: T,
    /// Sample gate. Default as for every estimator.
    pub gate: gate::Config<T>,
}

impl<T: Real> Config<T> {
    /// The paper's `method` for a gyro of this noise (one sigma, white, per sample, rad/s).
    pub fn kim_2010(method: Method, gyro_noise_rad_s: T) -> Self {
        let gate = gate::Config::default();
        Self { method, gyro_noise_rad_s, prior: None, rest_sigma: T::lit(5.0), gate }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// Names the first field that is out of its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gyro_noise_rad_s", self.gyro_noise_rad_s)?;
        if let Some(prior) = &self.prior {
            prior.validate()?;
        }
        not_negative("rest_sigma", self.rest_sigma)?;
        self.gate.validate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_field_that_is_out_of_range() {
        let field = |config: Config<f64>| config.validate().unwrap_err().field;
        let good = Config::kim_2010(Method::Suggested, 1e-4);
        assert_eq!(good.validate(), Ok(()));
        assert_eq!(field(Config { gyro_noise_rad_s: 0.0, ..good }), "gyro_noise_rad_s");
        assert_eq!(field(Config { rest_sigma: -1.0, ..good }), "rest_sigma");
        let prior = Prior { inertia_kg_m2: [1.0; 6], sigma_kg_m2: [1.0; 6] };
        assert_eq!(field(Config { prior: Some(prior), ..good }), "prior.inertia_kg_m2");
    }
}
