//! The window estimator against the Cramér-Rao bound, in single precision and without a prior.
//!
//! An RMS over n runs scatters by √(1/2n), a mean NEES of six degrees of freedom by √(1/3n).

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod random_spacecraft;

use std::env;
use std::sync::atomic::AtomicBool;

use host_sim::campaign::statistics::{Score, Statistics, Verdict, Yardstick, reduce};
use host_sim::campaign::{Campaign, Truths};
use host_sim::estimation::{EstimatorName, Precision, Setup, fly, set_up};
use host_sim::input::scenario::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::Flight;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// So many runs of a scenario, seeds from 0 on, the prior left out.
fn campaign(scenario: &str, runs: u64) -> Statistics {
    let scenario = Scenario { prior: None, ..Scenario::load(scenario).unwrap() };
    let campaign = Campaign {
        scenario: &scenario,
        truths: &Truths::simulate(&scenario).unwrap(),
        estimator: EstimatorName::Window,
        precision: Precision::F32,
        first_seed: 0,
        runs,
    };
    let runs = campaign.fly(&AtomicBool::new(false), || ()).unwrap();
    let statistics = reduce(runs.iter().map(|run| &run.score));
    println!("{}: {statistics:.3?}", scenario.name);
    statistics
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

/// Spacecraft flown in the test, unless the environment variable `SPACECRAFT` says how many.
const SPACECRAFT: u64 = 100;

/// An element whose bound is above this share of the mean moment isn't shown by the motion.
const SHOWN: f64 = 0.1;

/// One random spacecraft, if its motion shows all six elements.
fn fly_one(seed: u64) -> Option<Score> {
    let scenario = random_spacecraft::draw(seed);
    let flight = Flight::simulate(&scenario).unwrap();
    let truth_kg_m2 = scenario.spacecraft.inertia_kg_m2;
    let mean_moment = truth_kg_m2[..3].iter().sum::<f64>() / 3.0;
    let bound_kg_m2 = flight.bound.sigma_kg_m2;
    if !bound_kg_m2.iter().all(|bound| bound.is_some_and(|b| b < SHOWN * mean_moment)) {
        return None;
    }
    let on_board = set_up(&Setup {
        estimator: EstimatorName::Window,
        precision: Precision::F32,
        craft: &scenario.craft(),
        gyro_noise_rad_s: scenario.gyro.noise_rad_s,
        sample_period_s: 1.0 / scenario.gyro.rate_hz,
        refuse_spikes: true,
    });
    let log = log_of(&scenario, &flight, seed);
    let flown = fly(&log, on_board.unwrap(), |_, _, _| ());
    let score = Yardstick { truth_kg_m2, bound_kg_m2 }.score(&flown.estimate);
    if score.verdict != Verdict::Converged {
        println!("{}: {score:?}", scenario.name);
    }
    Some(score)
}

/// Whatever flies: no error beyond 20 bounds that is called converged, and at most one spacecraft in
/// 500, or begun 500, that isn't. Scatter of the RMS of six elements over a hundred spacecraft is 2.9 %, of their NEES
/// 5.8 %.
#[test]
fn random_spacecraft_are_estimated_at_the_bound() {
    let count = env::var("SPACECRAFT").map_or(SPACECRAFT, |text| text.parse().unwrap());
    let scores: Vec<Score> = (0..count).into_par_iter().filter_map(fly_one).collect();
    let found = reduce(&scores);
    let squares = found.rmse_over_bound.iter().map(|rms| rms.unwrap().powi(2));
    let rms = (squares.sum::<f64>() / 6.0).sqrt();
    println!("{count} spacecraft, RMS over bound of all elements {rms:.3}: {found:.3?}");
    let failures = scores.iter().filter(|score| score.verdict != Verdict::Converged).count();
    assert_eq!(found.diverged, 0);
    assert!(failures <= scores.len().div_ceil(500), "{failures}");
    assert!(rms < 1.06 + 3.0 * (1.0 / (12.0 * scores.len() as f64)).sqrt(), "{rms}");
    let nees_scatter = (1.0 / (3.0 * scores.len() as f64)).sqrt();
    assert!((found.nees_per_dof.unwrap() - 1.0).abs() < 0.06 + 3.0 * nees_scatter, "{found:?}");
}
