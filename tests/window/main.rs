//! The window estimator against the Cramér-Rao bound, in single precision and without a prior.
//!
//! An RMS over n runs scatters by √(1/2n), a mean NEES of six degrees of freedom by √(1/3n).

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::env;
use std::sync::atomic::AtomicBool;

use host_sim::campaign::{Campaign, Truths};
use host_sim::campaign::{Statistics, Verdict, reduce};
use host_sim::estimation::{EstimatorName, Precision};
use host_sim::input::scenario::Scenario;

/// So many runs of a scenario, seeds from 0 on, the prior left out.
fn campaign(scenario: &str, runs: u64) -> Statistics {
    fly(scenario, runs).0
}

/// The same, and in how many of the runs a change was found.
fn fly(scenario: &str, runs: u64) -> (Statistics, usize) {
    let scenario = Scenario { prior: None, ..Scenario::load(scenario).unwrap() };
    let campaign = Campaign {
        scenario: &scenario,
        truths: &Truths::simulate(&scenario).unwrap(),
        estimator: EstimatorName::Window,
        precision: Precision::F32,
        first_seed: 0,
        runs,
    };
    let runs = campaign.run_all(&AtomicBool::new(false), || ()).unwrap();
    for run in &runs {
        if matches!(run.score.verdict, Verdict::NotConverged | Verdict::Diverged) {
            println!("{} seed {}: {:?}", scenario.name, run.seed, run.score);
        }
    }
    let statistics = reduce(runs.iter().map(|run| &run.score));
    let changed = runs.iter().filter(|run| run.changes > 0).count();
    println!("{}: {changed} changes, {statistics:.3?}", scenario.name);
    (statistics, changed)
}

/// The worst of six, where there are six.
fn worst(values: [Option<f64>; 6]) -> f64 {
    values.iter().map(|x| x.unwrap().abs()).fold(0.0, f64::max)
}

/// Scatter of an RMS over a thousand runs is 2.2 %, of a mean 3.2 % of the bound, of NEES 1.8 %:
/// the bounds are above the best there is by three and a half of these.
#[test]
fn the_spin_up_is_estimated_at_the_bound() {
    let found = campaign("stsat3-spin-up", 1000);
    assert_eq!((found.diverged, found.not_converged), (0, 0));
    assert!(worst(found.rmse_over_bound) < 1.08, "{found:?}");
    assert!(worst(found.bias_over_bound) < 0.11, "{found:?}");
    assert!((found.nees_per_dof.unwrap() - 1.0).abs() < 0.065, "{found:?}");
}

/// Scatter of an RMS over three hundred runs is 4.1 %.
#[test]
fn wheels_do_as_well_as_torques() {
    for scenario in ["cubesat-pyramid", "microsat-slew"] {
        let found = campaign(scenario, 300);
        assert_eq!((found.diverged, found.not_converged), (0, 0));
        assert!(worst(found.rmse_over_bound) < 1.14, "{scenario} {found:?}");
        assert!((found.nees_per_dof.unwrap() - 1.0).abs() < 0.12, "{scenario} {found:?}");
    }
}

/// Torque that steps inside a block, goes straight between its samples, or is a sine with twelve blocks
/// to a period: an RMS over two hundred runs scatters by 5 %.
///
/// These records end after a minute in mid-motion, with the passes under way. With a slow sine the scale is
/// hardly seen, and finding it takes the most passes: what the last one has yet to find is as much as the
/// bound, so that the RMS is 1.42 of it, and two of 200 runs say that they are partial.
#[test]
fn any_torque_profile_does_as_well() {
    let profiles =
        [("prbs-a", 1.17, 0), ("random-c", 1.17, 0), ("chirp", 1.17, 0), ("sine-iso-0.2", 1.6, 5)];
    for (profile, most, partial) in profiles {
        let found = campaign(&format!("elhariry-2026-{profile}"), 200);
        assert_eq!(found.diverged, 0);
        assert!(found.not_converged <= partial, "{profile} {found:?}");
        assert!(worst(found.rmse_over_bound) < most, "{profile} {found:?}");
    }
}

/// A moment that grows by a twentieth between two manoeuvres is seen in the next, and nothing is where
/// nothing happens.
#[test]
fn a_deployment_is_told_from_noise() {
    let (_, changed) = fly("deployment", 100);
    assert_eq!(changed, 100);
    let (found, changed) = fly("no-change", 300);
    assert_eq!(changed, 0);
    assert!((found.nees_per_dof.unwrap() - 1.0).abs() < 0.12, "{found:?}");
}

/// A part that breaks off in mid-manoeuvre, before anything is known that this could contradict. What came
/// before is given up a few seconds later, and lost with it what came since: RMS 1.23 bounds at most in 2,000
/// runs, which scatters by 4.1 % over 300.
#[test]
fn a_break_off_is_told_from_a_poor_start() {
    let (found, changed) = fly("break-off", 300);
    assert_eq!((changed, found.diverged, found.not_converged), (300, 0, 0));
    assert!((found.nees_per_dof.unwrap() - 1.0).abs() < 0.12, "{found:?}");
    assert!(worst(found.rmse_over_bound) < 1.4, "{found:?}");
}

/// A prior that is wrong by half is outweighed if it says so, and dropped if it doesn't.
#[test]
fn a_wrong_prior_does_no_harm() {
    for (scenario, dropped) in
        [("stsat3-spin-up-wrong-prior", 0), ("stsat3-spin-up-overconfident-prior", 100)]
    {
        let scenario = Scenario::load(scenario).unwrap();
        let truths = Truths::simulate(&scenario).unwrap();
        let campaign = Campaign {
            scenario: &scenario,
            truths: &truths,
            estimator: EstimatorName::Window,
            precision: Precision::F32,
            first_seed: 0,
            runs: 100,
        };
        let runs = campaign.run_all(&AtomicBool::new(false), || ()).unwrap();
        let found = reduce(runs.iter().map(|run| &run.score));
        assert_eq!(runs.iter().filter(|run| run.changes > 0).count(), dropped);
        assert_eq!((found.diverged, found.not_converged), (0, 0));
        // An RMS over a hundred runs scatters by 7 %.
        assert!(worst(found.rmse_over_bound) < 1.25, "{found:?}");
    }
}

/// Spacecraft flown in the test, unless the environment variable `SPACECRAFT` says how many.
const SPACECRAFT: u64 = 100;

/// Whatever flies: no error beyond 20 bounds that is called converged, and at most one spacecraft in
/// 500, or begun 500, that isn't. Scatter of the RMS of six elements over a hundred spacecraft is
/// 2.9 %, of their NEES 5.8 %.
#[test]
fn random_spacecraft_are_estimated_at_the_bound() {
    let count = env::var("SPACECRAFT").map_or(SPACECRAFT, |text| text.parse().unwrap());
    let found = campaign("random-spacecraft", count);
    let rms = found.rmse_over_bound_of_all().unwrap();
    println!("RMS over bound of all elements {rms:.3}");
    let used = found.used as f64;
    assert_eq!(found.diverged, 0);
    assert!(found.not_converged <= found.used.div_ceil(500), "{}", found.not_converged);
    assert!(rms < 1.06 + 3.0 * (1.0 / (12.0 * used)).sqrt(), "{rms}");
    let nees_scatter = (1.0 / (3.0 * used)).sqrt();
    assert!((found.nees_per_dof.unwrap() - 1.0).abs() < 0.06 + 3.0 * nees_scatter, "{found:?}");
}
