//! 7\. A gyro of 1e-6 rad/s: at the bound in double precision; in single precision with a floor that
//! is in the sigma.

use anyhow::Result;
use host_sim::estimation::Precision;

use super::super::batch_fit::Scale;
use super::super::campaign::{Campaign, Check, Limits, SINGLE, StatedNoise};
use super::super::scenarios::{Pyramid, brick, source};

/// Noise of the gyro, rad/s.
const NOISE_RAD_S: f64 = 1e-6;
/// Runs of each campaign.
const RUNS: u64 = 200;

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let wheels = Pyramid { noise_rad_s: NOISE_RAD_S, ..Pyramid::PLAIN }.scenario()?;
    let at_the_bound = Limits {
        found: Some(1.0),
        diverged: Some(0.0),
        over_reference: Some(1.1),
        ..Limits::HONEST
    };
    let mut list = Vec::new();
    for (motion, scenario, scale) in
        [("brick", brick(NOISE_RAD_S)?, Scale::Unobserved), ("wheels", wheels, Scale::Observed)]
    {
        for (stated, noise) in
            [("stated", StatedNoise::Times(1.0)), ("unstated", StatedNoise::Unstated)]
        {
            for (precision, precisions, limits) in [
                ("f64", DOUBLE, at_the_bound),
                ("f32", SINGLE, Limits { over_reference: None, ..at_the_bound }),
            ] {
                list.push(Campaign {
                    noise,
                    precisions,
                    limits,
                    check: Check::BatchFit(scale),
                    small: 4,
                    ..Campaign::new(
                        7,
                        format!("fine-gyro/{motion}-{stated}-{precision}"),
                        source(scenario.clone()),
                        RUNS,
                    )
                });
            }
        }
    }
    Ok(list)
}

/// Double precision alone.
const DOUBLE: &[Precision] = &[Precision::F64];
