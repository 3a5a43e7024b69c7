//! 8\. A stated noise that is 0.5 to 1.5 times the true one.

use anyhow::Result;

use super::super::campaign::{Campaign, Limits, StatedNoise};
use super::super::scenarios::{built_in, source};

/// Stated over true noise.
const FACTORS: [f64; 6] = [0.5, 0.7, 0.83, 1.0, 1.2, 1.5];

const LIMITS: Limits = Limits {
    converged: Some(0.999),
    diverged: Some(0.0),
    over_bound: Some(1.08),
    nees: Some([0.8, 1.2]),
    changes: Some(0.0),
    ..Limits::HONEST
};

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for motion in ["stsat3-spin-up", "cubesat-pyramid", "microsat-slew", "no-change"] {
        let scenario = built_in(motion)?;
        for factor in FACTORS {
            list.push(Campaign {
                noise: StatedNoise::Times(factor),
                small: 4,
                limits: LIMITS,
                ..Campaign::new(
                    8,
                    format!("noise/{motion}-{factor}"),
                    source(scenario.clone()),
                    1000,
                )
            });
        }
    }
    Ok(list)
}
