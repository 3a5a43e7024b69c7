//! 2\. A rest before the motion: the noise gathered at rest must not displace the start of the fit.

use anyhow::Result;

use super::super::campaign::{Campaign, Limits};
use super::super::scenarios::{Pyramid, source};

/// Rests before one minute of motion, s.
const RESTS_S: [f64; 4] = [10.0, 60.0, 600.0, 3600.0];
/// Name and noise of the gyros, rad/s: a good MEMS gyro, and one of the class of the BMI088.
const GYROS: [(&str, f64); 2] = [("quiet", 1e-4), ("bmi088", 1.7e-3)];
/// Longest rest at 10 and 100 Hz in the small version, s.
const SMALL_REST_S: [(f64, f64); 2] = [(10.0, 600.0), (100.0, 60.0)];

/// Runs of each campaign.
const RUNS: u64 = 1000;

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for (rate_hz, longest_small_s) in SMALL_REST_S {
        for rest_s in RESTS_S {
            for (gyro, noise_rad_s) in GYROS {
                for (end, after_s) in [("cut", 0.0), ("coast", 60.0)] {
                    let flight =
                        Pyramid { rest_s, after_s, rate_hz, noise_rad_s, ..Pyramid::PLAIN };
                    let name = format!("rest/{rest_s}s-{rate_hz}hz-{gyro}-{end}");
                    let small = if rest_s <= longest_small_s { 4 } else { 0 };
                    list.push(Campaign {
                        small,
                        limits: LIMITS,
                        ..Campaign::new(2, name, source(flight.scenario()?), RUNS)
                    });
                }
            }
        }
    }
    Ok(list)
}

const LIMITS: Limits = Limits {
    converged: Some(0.999),
    diverged: Some(0.0),
    over_bound: Some(1.08),
    nees: Some([0.8, 1.2]),
    ..Limits::HONEST
};
