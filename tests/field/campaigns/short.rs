//! 3\. Short records: as good as a batch fit in double precision from the truth, wherever that finds a
//! solution, and honest where the linearised sigma is too small.

use anyhow::Result;
use host_sim::input::Scenario;

use super::super::batch_fit::Scale;
use super::super::campaign::{Campaign, Check, Limits};
use super::super::scenarios::{Pyramid, built_in, racquet, source, throw};

/// Lengths of the records, samples.
const SAMPLES: [usize; 5] = [20, 40, 80, 150, 300];
/// Runs of each length.
const RUNS: u64 = 1000;
/// Duration of the longest slew, s.
const SLEW_S: f64 = 30.0;

const LIMITS: Limits = Limits { over_reference: Some(1.1), silent: 0.001, ..Limits::HONEST };

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut slew = built_in("microsat-slew")?;
    slew.duration_s = SLEW_S;
    let mut throw_with_torque = throw()?;
    throw_with_torque.solve_for.torque = true;
    let motions: [(&str, Scenario, Scale); 5] = [
        ("tumble", racquet()?, Scale::Unobserved),
        ("throw", throw()?, Scale::Observed),
        ("throw-torque", throw_with_torque, Scale::Observed),
        ("slew", slew, Scale::Observed),
        ("wheels", Pyramid { motion_s: SLEW_S, ..Pyramid::PLAIN }.scenario()?, Scale::Observed),
    ];
    let mut list = Vec::new();
    for (motion, scenario, scale) in motions {
        for samples in SAMPLES {
            list.push(Campaign {
                samples: Some(samples),
                check: Check::BatchFit(scale),
                limits: LIMITS,
                small: 10,
                ..Campaign::new(
                    3,
                    format!("short/{motion}-{samples}"),
                    source(scenario.clone()),
                    RUNS,
                )
            });
        }
    }
    Ok(list)
}
