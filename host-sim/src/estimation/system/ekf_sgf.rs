//! `ekf-sgf`: rate filter, Savitzky-Golay differentiator and regression, \[Kim2013\], \[Kim2016\].
//!
//! The nominal inertia of the rate filter is the prior's.

use fsw_core::estimator::ekf_sgf::{Config, EkfSgf};
use fsw_core::{Prior, Real, WheelArray};

use crate::estimation::adapter::{Acceleration, AnyEstimator, widen, with_acceleration};
use crate::estimation::error::SetUpError;
use crate::estimation::setup::Setup;

/// Recursive least squares of the three moments, \[Kim2013\].
pub fn rls<T: Real, const W: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    of_published(Config::kim_2013, setup, wheels)
}

/// Batch least squares of the six elements, \[Kim2016\].
pub fn lls<T: Real, const W: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    of_published(Config::kim_2016, setup, wheels)
}

fn of_published<T: Real, const W: usize>(
    published: fn(T, Prior<T>) -> Config<T>,
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let missing = SetUpError::NoNominalInertia { estimator: setup.estimator };
    let nominal = setup.prior().ok_or(missing)?;
    let mut config = published(setup.required_gyro_noise_rad_s()?, nominal);
    if let Some(walk) = setup.craft.filter.rate_walk_rad_s_sqrt_s {
        // The stated walk is the whole process noise, as in the papers.
        config.rate_ekf.rate_walk_rad_s_sqrt_s = T::lit(walk);
        config.rate_ekf.acceleration_doubt = T::zero();
    }
    if !setup.refuse_spikes {
        config.spikes.limit_sigma = T::MAX;
    }
    setup.configure_gate(&mut config.gate);
    let estimator = EkfSgf::<T, W>::new(config, wheels)?;
    Ok(with_acceleration::<T, _, W>(estimator, setup, acceleration))
}

/// Output of the differentiator at the last sample.
fn acceleration<T: Real, const W: usize>(ekf_sgf: &EkfSgf<T, W>) -> Option<Acceleration> {
    ekf_sgf.last_instant().map(|instant| Acceleration {
        rad_s2: widen(&instant.acceleration_rad_s2),
        delay_s: ekf_sgf.last_delay_s().to_f64(),
    })
}
