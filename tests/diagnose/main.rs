//! The campaign of `diagnose` in its small version; `cargo run --release -p tests --bin diagnose` flies all of it.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

use tests::diagnose::{Row, fly};

/// Errors of the small version: one of each kind of cause.
const SMALL: [&str; 9] = [
    "gyro y flipped",
    "gyro x and z exchanged",
    "sign of one wheel",
    "two wheels exchanged",
    "wheels late by 2 rows",
    "one wheel in rpm",
    "one wheel inertia in g m²",
    "gyro scale 0.5 to 1 %",
    "wheel axes 0.5° to 1°",
];

#[test]
fn planted_errors_are_named_first() {
    let rows = fly("microsat-slew", 2, 0, false, |name| SMALL.contains(&name)).unwrap();
    assert_eq!(rows.len(), SMALL.len());
    let missed: Vec<&Row> = rows.iter().filter(|row| row.counts() != [2, 2, 2]).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn healthy_log_has_no_explanation() {
    use host_sim::diagnosis::diagnose;
    use host_sim::input::Scenario;
    use host_sim::simulation::log_of;
    use host_sim::truth::Flight;

    for name in tests::diagnose::SCENARIOS {
        let scenario = Scenario::load(name).unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        for seed in 1..=5 {
            let found = diagnose(&scenario.craft(), &log_of(&scenario, &flight, seed)).unwrap();
            assert_eq!(found.explanations, [], "{name} {seed}");
            // Degrees of freedom are 9 fewer, and the measured noise is a few per cent low.
            let ratio = found.chi_square / found.readings;
            assert!((0.9..1.2).contains(&ratio), "{name} {seed}: {ratio}");
        }
    }
}
