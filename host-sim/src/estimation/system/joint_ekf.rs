//! `joint-ekf`: nine-state filter of rate and inertia, \[Bellar2019\].

use fsw_core::estimator::joint_ekf::{Config, InitialRate, JointEkfPublished, JointEkfUd};
use fsw_core::hardware::{Disturbance, Hardware};
use fsw_core::{Prior, Real, WheelArray};

use crate::estimation::adapter::{AnyEstimator, narrow, of_setup};
use crate::estimation::error::SetUpError;
use crate::estimation::setup::Setup;

/// The filter that flies: UD form, start by alignment. It considers the errors of the hardware and the
/// disturbances that the craft states, up to P parameters; without any it is the filter without columns.
pub fn aligned<T: Real, const W: usize, const P: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let config = configure(Config::new(setup.required_gyro_noise_rad_s()?), setup);
    let (hardware, disturbance) = (setup.hardware::<T, W>(), setup.disturbance());
    if hardware == Hardware::ideal() && disturbance == Disturbance::none() {
        return Ok(of_setup::<T, _, W>(JointEkfUd::new(config, wheels)?, setup));
    }
    let filter = JointEkfUd::<T, W, P>::considering(config, wheels, &hardware, &disturbance)?;
    Ok(of_setup::<T, _, W>(filter, setup))
}

/// The filter as printed.
pub fn published<T: Real, const W: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let filter = JointEkfPublished::new(bellar_2019(setup)?, wheels)?;
    Ok(of_setup::<T, _, W>(filter, setup))
}

/// The UD form with the start of the printed filter.
pub fn unaligned<T: Real, const W: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let filter = JointEkfUd::new(bellar_2019(setup)?, wheels)?;
    Ok(of_setup::<T, _, W>(filter, setup))
}

/// The configuration of the paper, with the initial estimate that a campaign has drawn.
fn bellar_2019<T: Real>(setup: &Setup<'_>) -> Result<Config<T>, SetUpError> {
    let published = Config::bellar_2019(setup.required_gyro_noise_rad_s()?);
    let mut config = configure(published, setup);
    if let (Some(start), Some(prior)) = (&setup.craft.initial_estimate, published.prior) {
        config.initial_rate = Some(InitialRate {
            rate_rad_s: narrow(&start.rate_rad_s),
            sigma_rad_s: T::lit(start.rate_sigma_rad_s),
        });
        config.initial_inertia_kg_m2 = Some(start.inertia_kg_m2.map(T::lit));
        let sigma_kg_m2 = start.sigma_kg_m2.map(T::lit);
        config.prior = Some(Prior { sigma_kg_m2, ..prior });
    }
    Ok(config)
}

/// Defaults replaced by the properties that the craft states.
fn configure<T: Real>(mut config: Config<T>, setup: &Setup<'_>) -> Config<T> {
    config.prior = setup.prior().or(config.prior);
    if let Some(walk) = setup.craft.filter.rate_walk_rad_s_sqrt_s {
        config.rate_walk_rad_s_sqrt_s = T::lit(walk);
    }
    if let Some(walk) = setup.inertia_walk_kg_m2_sqrt_s() {
        config.inertia_walk_kg_m2_sqrt_s = [walk; 6];
    }
    if !setup.refuse_spikes {
        config.spikes.limit_sigma = T::MAX;
    }
    setup.configure_gate(&mut config.gate);
    config
}
