//! 9\. Changes of the inertia in mid-motion: right within ten seconds, or announced. Drifts within one
//! manoeuvre with a stated random walk.

use anyhow::Result;

use super::super::campaign::{Campaign, Check, Limits, MAX_WRONG_S};
use super::super::scenarios::{Pyramid, periodic, source};

/// Motion, s.
const MOTION_S: f64 = 180.0;
/// Time of the change, s.
const CHANGE_S: f64 = 60.0;
/// Mean moment of the CubeSat, kg m².
const MEAN_MOMENT_KG_M2: f64 = 0.0933;
/// Period of the periodic inertia, s, and step of its approximation, s.
const PERIOD_S: [f64; 2] = [60.0, 0.5];

/// Runs of each campaign.
const RUNS: u64 = 200;

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut list = sudden()?;
    list.extend(gradual()?);
    Ok(list)
}

/// +2 to +20 % of one moment, or of all elements.
fn sudden() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for percent in [2.0, 5.0, 10.0, 20.0] {
        let factor = 1.0 + percent / 100.0;
        for (kind, factors) in [("jyy", [1.0, factor, 1.0, 1.0, 1.0, 1.0]), ("all", [factor; 6])] {
            let tables =
                format!("[[change]]\ntime_s = {CHANGE_S:?}\ninertia_factor = {factors:?}\n");
            let flight = Pyramid { motion_s: MOTION_S, tables: &tables, ..Pyramid::PLAIN };
            list.push(Campaign {
                check: Check::EachSecond([CHANGE_S, CHANGE_S]),
                small: 4,
                limits: Limits {
                    converged: Some(0.99),
                    diverged: Some(0.0),
                    wrong_s: Some(MAX_WRONG_S),
                    ..Limits::HONEST
                },
                ..Campaign::new(
                    9,
                    format!("change/{kind}+{percent}%"),
                    source(flight.scenario()?),
                    RUNS,
                )
            });
        }
    }
    Ok(list)
}

/// Linear drift of 1 to 5 %, and a periodic one of 3 %, within a manoeuvre of two minutes, with the
/// random walk that reaches as far in that time.
fn gradual() -> Result<Vec<Campaign>> {
    let duration_s = 120.0;
    let hours = duration_s / 3600.0;
    let walk = |share: f64| {
        let walk = share * MEAN_MOMENT_KG_M2 / f64::sqrt(hours);
        format!("[filter]\ninertia_walk_kg_m2_sqrt_hour = {walk:?}\n")
    };
    let mut scenarios = Vec::new();
    for percent in [1.0, 2.0, 5.0] {
        let share = percent / 100.0;
        let tables =
            format!("[drift]\ninertia_rate_per_hour = {:?}\n{}", [share / hours; 6], walk(share));
        let flight = Pyramid { motion_s: duration_s, tables: &tables, ..Pyramid::PLAIN };
        scenarios.push((format!("drift/linear-{percent}%"), flight.scenario()?));
    }
    let tables = walk(0.03 * 4.0);
    let flight = Pyramid { motion_s: duration_s, tables: &tables, ..Pyramid::PLAIN };
    let [period_s, step_s] = PERIOD_S;
    let oscillating = periodic(flight.scenario()?, 0.03, period_s, step_s);
    scenarios.push(("drift/periodic-3%".to_owned(), oscillating));
    let one = |(name, scenario)| Campaign {
        small: 4,
        limits: Limits { diverged: Some(0.0), nees: Some([0.8, 1.3]), ..Limits::HONEST },
        ..Campaign::new(9, name, source(scenario), RUNS)
    };
    Ok(scenarios.into_iter().map(one).collect())
}
