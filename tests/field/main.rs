//! The field campaigns in their small version. Campaigns whose limits hold are asserted; `cargo run
//! --release -p tests --bin field` flies all of them, with the listed number of runs.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

use std::collections::HashSet;

use fsw_core::Inertia;
use host_sim::input::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::Flight;
use tests::field::batch_fit::{Scale, fit};
use tests::field::campaigns::all;
use tests::field::fault::{Fault, Gyro};
use tests::field::figures::Figures;
use tests::field::flying::fly_all;
use tests::field::motion::Library;
use tests::field::scenarios::free_body;
use tests::field::table;
use tests::field::tumble::Tumbles;

#[test]
fn names_of_campaigns_are_unique() {
    let campaigns = all().unwrap();
    let names: HashSet<&str> = campaigns.iter().map(|campaign| campaign.name.as_str()).collect();
    assert_eq!(names.len(), campaigns.len());
}

/// Flies the small version of every campaign whose limits hold.
#[test]
fn held_limits_hold() {
    let mut library = Library::default();
    let mut missed = Vec::new();
    println!("{}", table::head());
    for campaign in all().unwrap().iter().filter(|campaign| campaign.held && campaign.small > 0) {
        for precision in campaign.precisions {
            let runs = fly_all(campaign, *precision, &mut library, 0, campaign.small).unwrap();
            let figures = Figures::of(&runs);
            let row = table::row(campaign, *precision, &figures);
            println!("{row}");
            if !figures.missed(campaign).is_empty() {
                missed.push(row);
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Sigmas of the batch fit agree with the Cramér-Rao bound, an independent derivation from other
/// equations, and its errors with its sigmas. One sigma of the NEES over 20 runs of six degrees of
/// freedom is 13 %; the allowance is three.
#[test]
fn batch_fit_is_at_the_bound() {
    for name in ["cubesat-pyramid", "cubesat-pyramid-disturbed", "microsat-slew"] {
        let scenario = Scenario::load(name).unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        let truth = scenario.spacecraft.inertia_kg_m2;
        let runs = 20;
        let mut squares = [0.0; 6];
        for seed in 0..runs {
            let log = log_of(&scenario, &flight, seed);
            let rate = flight.instants[0].rate_rad_s;
            let found = fit(&log, &scenario, &rate, Scale::Observed).unwrap();
            for i in 0..6 {
                let ratio = found.sigma_kg_m2[i] / flight.bound.sigma_kg_m2[i].unwrap();
                // The sigma is that at the estimate, the bound that at the truth.
                assert!((ratio - 1.0).abs() < 0.05, "{name}, seed {seed}, element {i}: {ratio}");
                let error = found.inertia_kg_m2[i] - truth[i];
                squares[i] += (error / found.sigma_kg_m2[i]).powi(2) / runs as f64;
            }
        }
        let mean = squares.iter().sum::<f64>() / 6.0;
        assert!((mean - 1.0).abs() < 0.4, "{name}: {squares:?}");
    }
}

/// The motions of the drawn tumbles are those of the simulator, and their bodies are physical.
#[test]
fn drawn_tumbles_match_the_simulator() {
    let base = free_body([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [0.0; 3], 10.0, 1e-4, 10.0).unwrap();
    let (duration_s, rate_hz) = ([5.0, 20.0], [4.0, 20.0]);
    let tumbles = Tumbles { base, duration_s, rate_hz, has_prior: true };
    for seed in 0..10 {
        let (scenario, truth) = tumbles.draw(seed);
        assert!(Inertia::new(scenario.spacecraft.inertia_kg_m2).check().is_ok());
        assert!(Inertia::new(scenario.prior.clone().unwrap().inertia_kg_m2).check().is_ok());
        let simulated = Flight::simulate(&scenario).unwrap();
        assert_eq!(truth.flight.instants.len(), simulated.instants.len());
        for (drawn, simulated) in truth.flight.instants.iter().zip(&simulated.instants) {
            assert_eq!(drawn.time_us, simulated.time_us);
            let difference = (drawn.rate_rad_s - simulated.rate_rad_s).norm();
            // The smallest gyro noise is 1e-5 rad/s.
            assert!(difference < 1e-7, "seed {seed}, {} us: {difference}", drawn.time_us);
        }
        // A slow and short tumble observes fewer.
        assert!(simulated.bound.observed_directions <= 5, "seed {seed}");
    }
}

/// The share of damaged samples is the configured one, and a seed gives the same damage.
#[test]
fn faults_damage_the_configured_share() {
    let scenario = Scenario::load("stsat3-spin-up").unwrap();
    let clean = log_of(&scenario, &Flight::simulate(&scenario).unwrap(), 0);
    let gyro = Gyro { noise_rad_s: scenario.gyro.noise_rad_s, range_rad_s: None };
    let damaged = |fault: Fault, seed| {
        let mut rows = clean.clone();
        fault.apply(&mut rows, gyro, seed);
        rows
    };
    let differing = |fault: Fault| {
        damaged(fault, 3).iter().zip(&clean).filter(|(damaged, clean)| damaged != clean).count()
    };
    // Binomial: 180 ± 13 of 6,001; bursts may overlap.
    assert!((130..230).contains(&differing(Fault::Outliers(0.03))));
    assert!((150..=180).contains(&differing(Fault::ZeroBursts(0.03))));
    assert_eq!(differing(Fault::StampAhead), 1);
    assert_eq!(differing(Fault::GyroGarbage([100.0, 110.0])), 100);
    assert_eq!(differing(Fault::None), 0);
    let outliers = |seed| damaged(Fault::Outliers(0.03), seed);
    assert_eq!(outliers(5), outliers(5));
    assert_ne!(outliers(5), outliers(6));
}
