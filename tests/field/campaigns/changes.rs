//! 9\. Changes of the inertia in mid-motion: right within ten seconds, or announced. Drifts within one
//! manoeuvre with a stated random walk.

use anyhow::Result;
use host_sim::input::scenario::change::SuddenChange;

use super::super::campaign::{Campaign, Check, Limits, MAX_WRONG_S};
use super::super::motion::Source;
use super::super::scenarios::{Pyramid, built_in, source};
use super::super::varying::{Course, Varying};

/// Motion, s.
const MOTION_S: f64 = 180.0;
/// Time of the change in the motion of the wheels, the slew and the spin-up, s.
const CHANGE_S: f64 = 60.0;
const SLEW_CHANGE_S: f64 = 30.0;
const SPIN_UP_CHANGE_S: f64 = 300.0;
/// Mean moment of the CubeSat, kg m².
const MEAN_MOMENT_KG_M2: f64 = 0.0933;
/// Period of the periodic inertia, s.
const PERIOD_S: f64 = 60.0;

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
    let wheels = Pyramid { motion_s: MOTION_S, ..Pyramid::PLAIN }.scenario()?;
    let motions = [
        ("wheels", CHANGE_S, wheels),
        ("slew", SLEW_CHANGE_S, built_in("microsat-slew")?),
        ("spin-up", SPIN_UP_CHANGE_S, built_in("stsat3-spin-up")?),
    ];
    for (motion, time_s, scenario) in motions {
        for percent in [2.0, 5.0, 10.0, 20.0] {
            let factor = 1.0 + percent / 100.0;
            for (kind, factors) in
                [("jyy", [1.0, factor, 1.0, 1.0, 1.0, 1.0]), ("all", [factor; 6])]
            {
                let before = scenario.spacecraft.inertia_kg_m2;
                let inertia_kg_m2 = std::array::from_fn(|i| factors[i] * before[i]);
                let mut changed = scenario.clone();
                changed.changes.sudden = vec![SuddenChange { time_s, inertia_kg_m2 }];
                let name = format!("change/{motion}-{kind}+{percent}%");
                list.push(Campaign {
                    check: Check::EachSecond([time_s, time_s]),
                    small: 4,
                    limits: SUDDEN,
                    ..Campaign::new(9, name, source(changed), RUNS)
                });
            }
        }
    }
    Ok(list)
}

const SUDDEN: Limits = Limits {
    converged: Some(0.99),
    diverged: Some(0.0),
    wrong_s: Some(MAX_WRONG_S),
    ..Limits::HONEST
};

/// Within a manoeuvre of two minutes: linear drift of 1 to 5 %, random walk of 1 to 5 %, each with the stated walk that
/// reaches as far in that time, and a periodic drift of 3 % from any phase.
fn gradual() -> Result<Vec<Campaign>> {
    let duration_s = 120.0;
    let hours = duration_s / 3600.0;
    let walk = |share: f64| {
        let walk = share * MEAN_MOMENT_KG_M2 / f64::sqrt(hours);
        format!("[filter]\ninertia_walk_kg_m2_sqrt_hour = {walk:?}\n")
    };
    let mut sources = Vec::new();
    for percent in [1.0, 2.0, 5.0] {
        let share = percent / 100.0;
        let tables =
            format!("[drift]\ninertia_rate_per_hour = {:?}\n{}", [share / hours; 6], walk(share));
        let flight = Pyramid { motion_s: duration_s, tables: &tables, ..Pyramid::PLAIN };
        sources.push((format!("drift/linear-{percent}%"), source(flight.scenario()?)));
    }
    let varying = |share: f64, course| -> Result<Source> {
        let tables = walk(share);
        let flight = Pyramid { motion_s: duration_s, tables: &tables, ..Pyramid::PLAIN };
        Ok(Source::Varying(Box::new(Varying { base: flight.scenario()?, course })))
    };
    for percent in [1.0, 2.0, 5.0] {
        let share = percent / 100.0;
        let walk = Course::Walk(share * MEAN_MOMENT_KG_M2 / f64::sqrt(duration_s));
        sources.push((format!("drift/walk-{percent}%"), varying(share, walk)?));
    }
    // Three per cent within a quarter of the period.
    let share = 0.03 * f64::sqrt(4.0 * duration_s / PERIOD_S);
    sources.push(("drift/periodic-3%".to_owned(), varying(share, Course::Swing(0.03, PERIOD_S))?));
    // A straight drift and a swing in step have other steps than the stated walk.
    let one = |(name, source): (String, Source)| Campaign {
        held: matches!(&source, Source::Varying(of) if matches!(of.course, Course::Walk(_))),
        small: 40,
        limits: Limits { diverged: Some(0.0), nees: Some([0.8, 1.3]), ..Limits::HONEST },
        ..Campaign::new(9, name, source, RUNS)
    };
    Ok(sources.into_iter().map(one).collect())
}
