//! 8\. A stated noise that is 0.5 to 1.5 times the true one, and axes of the gyro that are turned: a
//! model error, which is no change of the inertia.

use anyhow::Result;

use super::super::campaign::{Campaign, Limits, StatedNoise};
use super::super::fault::Fault;
use super::super::scenarios::{built_in, source};

/// Stated over true noise.
const FACTORS: [f64; 6] = [0.5, 0.7, 0.83, 1.0, 1.2, 1.5];

/// Angles between the axes of the gyro and of the body, deg. The error of the inertia is in the axes,
/// which the residuals need not show.
const MISALIGNMENTS_DEG: [f64; 2] = [0.1, 1.0];

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
                held: factor == 1.0,
                limits: LIMITS,
                ..Campaign::new(
                    8,
                    format!("noise/{motion}-{factor}"),
                    source(scenario.clone()),
                    1000,
                )
            });
        }
        for angle_deg in MISALIGNMENTS_DEG {
            list.push(Campaign {
                fault: Fault::AxesTurned(angle_deg),
                small: 4,
                held: angle_deg == 1.0,
                limits: Limits { changes: Some(0.0), silent: 1.0, ..Limits::HONEST },
                ..Campaign::new(
                    8,
                    format!("misaligned/{motion}-{angle_deg}deg"),
                    source(scenario.clone()),
                    200,
                )
            });
        }
    }
    Ok(list)
}
