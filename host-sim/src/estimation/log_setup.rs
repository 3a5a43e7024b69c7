//! Set-up of an estimator from the craft and the log that it will process.

use super::error::SetUpError;
use super::gyro_noise;
use super::name::Method;
use super::setup::Setup;
use super::stream::median_period_s;
use crate::input::Craft;
use crate::input::log::LogRow;

impl<'a> Setup<'a> {
    /// Set-up for a log: median sample period, and the gyro noise of the craft with the rounding
    /// error of its quantum. A noise that the craft does not state and the estimator cannot estimate is estimated from the residuals of a
    /// first pass.
    ///
    /// # Errors
    /// [`SetUpError::NoAttitude`], [`SetUpError::UnmeasurableGyroNoise`], or an error of setting up
    /// the estimator of the first pass.
    pub fn for_log(method: Method, craft: &'a Craft, rows: &[LogRow]) -> Result<Self, SetUpError> {
        let Method { estimator, precision } = method;
        let properties = estimator.properties();
        if properties.needs_attitude && rows.iter().all(|row| row.attitude.is_none()) {
            return Err(SetUpError::NoAttitude { estimator });
        }
        let mut setup = Self {
            estimator,
            precision,
            craft,
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
            sample_period_s: median_period_s(rows),
            refuse_spikes: true,
        };
        if setup.gyro_noise_rad_s.is_none() && !properties.measures_gyro_noise {
            setup.gyro_noise_rad_s = Some(gyro_noise::from_residuals(&setup, rows)?);
        }
        Ok(setup)
    }

    /// Gyro noise estimated by [`Setup::for_log`], rad/s; none if the craft states it.
    pub fn measured_gyro_noise_rad_s(&self) -> Option<f64> {
        self.gyro_noise_rad_s.filter(|_| self.craft.gyro.noise_rad_s.is_none())
    }
}
