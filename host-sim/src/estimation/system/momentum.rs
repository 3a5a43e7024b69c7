//! `momentum`: least squares from conservation of angular momentum, \[Kim2010\].

use fsw_core::estimator::momentum::{Config, Method, Momentum};
use fsw_core::{Real, WheelArray};

use crate::estimation::adapter::{AnyEstimator, without_checkpoints};
use crate::estimation::error::SetUpError;
use crate::estimation::setup::Setup;

/// The estimator with one of the paper's four solutions.
pub fn set_up<T: Real, const W: usize>(
    method: Method,
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let mut config = Config::kim_2010(method, setup.required_gyro_noise_rad_s()?);
    config.prior = setup.prior();
    setup.configure_gate(&mut config.gate);
    Ok(without_checkpoints::<T, _, W>(Momentum::new(config, wheels)?, setup))
}
