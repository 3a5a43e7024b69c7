//! 11\. Both precisions agree on every built-in scenario, with and without prior, and with torque and
//! bias asked for; a vague prior is no information.

use anyhow::Result;
use host_sim::input::Scenario;
use host_sim::input::craft::Prior;
use host_sim::input::scenario::built_in_names;

use super::super::campaign::{Campaign, Check, Limits, SINGLE};
use super::super::scenarios::{Pyramid, built_in, free_body, source};

/// Prior whose sigma is thirty times its moments, kg m².
const VAGUE: ([f64; 6], f64) = ([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 30.0);
/// Most samples of a built-in scenario in the small version.
const SMALL_SAMPLES: f64 = 7000.0;

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for name in built_in_names() {
        let scenario = built_in(name)?;
        let samples = scenario.duration_s * scenario.gyro.rate_hz;
        let small = if samples < SMALL_SAMPLES { 1 } else { 0 };
        let has_prior = scenario.prior.is_some();
        let agreement_of_all = agreement(name, scenario.clone(), small);
        // The estimators do not use the stated errors of the hardware yet: flown, and not held.
        let is_held = scenario.hardware.is_ideal();
        list.push(if is_held { agreement_of_all.held() } else { agreement_of_all });
        if has_prior {
            let without = Scenario { prior: None, ..scenario };
            list.push(agreement(&format!("{name}-no-prior"), without, small).held());
        }
    }
    list.extend(without_prior()?);
    list.extend(vague_prior()?);
    Ok(list)
}

fn agreement(name: &str, scenario: Scenario, small: u64) -> Campaign {
    Campaign {
        check: Check::Double,
        precisions: SINGLE,
        small,
        limits: Limits { over_reference: Some(1.05), ..Limits::HONEST },
        ..Campaign::new(11, format!("agree/{name}"), source(scenario), 20)
    }
}

/// The spin-up and the wheels without a prior, with torque and gyro bias among the unknowns.
fn without_prior() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    let wheels = Pyramid { rate_hz: 10.0, ..Pyramid::PLAIN }.scenario()?;
    let spin_up = Scenario { prior: None, ..built_in("stsat3-spin-up")? };
    for (motion, scenario) in [("spin-up", spin_up), ("wheels", wheels)] {
        for (unknowns, torque, gyro_bias) in
            [("torque", true, false), ("bias", false, true), ("torque-bias", true, true)]
        {
            let mut asked = scenario.clone();
            asked.solve_for.torque = torque;
            asked.solve_for.gyro_bias = gyro_bias;
            let is_observed = motion == "wheels" || !torque;
            let limits = Limits {
                converged: is_observed.then_some(0.999),
                found: Some(0.999),
                diverged: Some(0.0),
                over_bound: is_observed.then_some(1.08),
                nees: is_observed.then_some([0.8, 1.2]),
                ..Limits::HONEST
            };
            let name = format!("no-prior/{motion}-{unknowns}");
            list.push(Campaign {
                small: 4,
                held: motion == "wheels",
                limits,
                ..Campaign::new(11, name.clone(), source(asked.clone()), 1000)
            });
            list.push(agreement(&name, asked, 2));
        }
    }
    Ok(list)
}

/// Prior of 1 ± 30 kg m² with one sample, and with a minute at rest: nothing is observed.
fn vague_prior() -> Result<Vec<Campaign>> {
    let (inertia_kg_m2, sigma) = VAGUE;
    let mut still = free_body([0.5, 0.6, 0.7, 0.0, 0.0, 0.0], [0.0; 3], 10.0, 1e-4, 60.0)?;
    still.prior = Some(Prior { inertia_kg_m2, sigma_kg_m2: [sigma; 6] });
    let mut moving = Pyramid::PLAIN.scenario()?;
    moving.prior = still.prior.clone();
    let nothing = |name: &str, scenario: &Scenario, samples| Campaign {
        samples,
        check: Check::NoInformation,
        small: 4,
        ..Campaign::new(11, format!("vague-prior/{name}"), source(scenario.clone()), 100)
    };
    let with_motion = Campaign {
        small: 4,
        limits: Limits { converged: Some(0.999), over_bound: Some(1.08), ..Limits::HONEST },
        ..Campaign::new(11, "vague-prior/wheels", source(moving.clone()), 1000)
    };
    Ok(vec![nothing("one-sample", &moving, Some(1)), nothing("rest", &still, None), with_motion])
}
