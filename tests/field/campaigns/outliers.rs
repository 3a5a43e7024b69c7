//! 5\. Bad frames, outliers, bursts of zeros: refused or counted, and the result as without them.

use anyhow::Result;
use host_sim::input::Scenario;

use super::super::campaign::{Campaign, Check, Limits, StatedNoise};
use super::super::fault::{Fault, Reading};
use super::super::scenarios::{built_in, source};

/// Readings of one bad frame.
const READINGS: [(&str, Reading); 4] = [
    ("zero", Reading::Zero),
    ("minus-one", Reading::MinusOneCount),
    ("full-scale", Reading::FullScale),
    ("step", Reading::Step),
];
/// Shares of outliers.
const OUTLIERS: [f64; 5] = [0.0003, 0.001, 0.003, 0.01, 0.03];
/// Shares of zeros in bursts.
const ZEROS: [f64; 4] = [0.01, 0.03, 0.05, 0.10];
/// Largest share of bad samples with which an estimate must still be found.
const USABLE_SHARE: f64 = 0.01;

/// Name, scenario: spin-up by torque, wheels, slew.
fn motions() -> Result<[(&'static str, Scenario); 3]> {
    Ok([
        ("spin-up", built_in("stsat3-spin-up")?),
        ("wheels", built_in("cubesat-pyramid")?),
        ("slew", built_in("microsat-slew")?),
    ])
}

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for (motion, scenario) in motions()? {
        for (name, reading) in READINGS {
            list.push(Campaign {
                fault: Fault::Frame(reading),
                check: Check::Clean,
                small: 10,
                limits: ONE_FRAME,
                ..Campaign::new(5, format!("frame/{motion}-{name}"), source(scenario.clone()), 1000)
            });
        }
        let faults = OUTLIERS.map(|share| ("outliers", share, Fault::Outliers(share)));
        let zeros = ZEROS.map(|share| ("zeros", share, Fault::ZeroBursts(share)));
        for (kind, share, fault) in faults.into_iter().chain(zeros) {
            for (stated, noise) in
                [("stated", StatedNoise::Times(1.0)), ("unstated", StatedNoise::Unstated)]
            {
                let percent = 100.0 * share;
                let name = format!("outliers/{motion}-{kind}-{percent:.2}%-{stated}");
                list.push(Campaign {
                    fault,
                    noise,
                    check: Check::Clean,
                    small: 2,
                    limits: if share <= USABLE_SHARE { FEW } else { Limits::HONEST },
                    ..Campaign::new(5, name, source(scenario.clone()), 200)
                });
            }
        }
    }
    Ok(list)
}

/// One bad frame: none diverges, 99 % counted, error within 1.1 of the clean flight's.
const ONE_FRAME: Limits = Limits {
    converged: Some(0.999),
    diverged: Some(0.0),
    over_reference: Some(1.1),
    told: Some(0.99),
    ..Limits::HONEST
};
/// Up to 1 % of bad samples: 99 % converged, error within 1.2 of the bound.
const FEW: Limits = Limits { converged: Some(0.99), over_bound: Some(1.2), ..Limits::HONEST };
