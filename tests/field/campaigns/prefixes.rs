//! 6\. Simulated logs cut at every fiftieth sample: nothing is converged, white and wrong.

use anyhow::Result;

use super::super::campaign::{Campaign, Check, StatedNoise};
use super::super::scenarios::{Pyramid, built_in, racquet, source, throw};

/// Samples between two cuts.
const EVERY: usize = 50;
/// Duration of the longer scenarios, s.
const LONGEST_S: f64 = 150.0;

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut spin_up = built_in("stsat3-spin-up")?;
    spin_up.duration_s = LONGEST_S;
    let rest = Pyramid { rest_s: 30.0, ..Pyramid::PLAIN }.scenario()?;
    let motions = [
        ("spin-up", spin_up),
        ("wheels", built_in("cubesat-pyramid")?),
        ("wheels-disturbed", built_in("cubesat-pyramid-disturbed")?),
        ("slew", built_in("microsat-slew")?),
        ("rest-wheels", rest),
        ("throw", throw()?),
        ("racquet", racquet()?),
        ("random", built_in("random-spacecraft")?),
    ];
    let mut list = Vec::new();
    for (motion, scenario) in motions {
        for (stated, noise) in
            [("stated", StatedNoise::Times(1.0)), ("unstated", StatedNoise::Unstated)]
        {
            list.push(Campaign {
                noise,
                check: Check::Prefixes(EVERY),
                small: 2,
                ..Campaign::new(
                    6,
                    format!("prefix/{motion}-{stated}"),
                    source(scenario.clone()),
                    25,
                )
            });
        }
    }
    Ok(list)
}
