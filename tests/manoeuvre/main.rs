//! A small part of the benchmark of designed manoeuvres. The program `manoeuvre` has all of it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use host_sim::manoeuvre::Effort;
use tests::manoeuvre::random::{Worst, fly};
use tests::manoeuvre::{Case, SATELLITES};

const SHORT: Effort = Effort { starts: 2, rounds: 5, iterations: 25, samples: 1 };

/// Gain over the best standard manoeuvre in one minute: three times at 2 deg, twice at 5 deg.
#[test]
fn design_beats_the_best_standard_manoeuvre() {
    for (excursion_deg, least) in [(2.0, 3.0), (5.0, 2.0)] {
        let case = Case {
            excursion_deg,
            momentum_share: 1.0,
            duration_s: 60.0,
            prior_error: 0.0,
            has_cone: false,
        };
        for satellite in &SATELLITES {
            let score = case.score(satellite, SHORT, 0).unwrap();
            assert!(
                score.gain() >= least,
                "{}, {excursion_deg} deg: {}",
                satellite.name,
                score.gain()
            );
        }
    }
}

#[test]
fn no_random_design_exceeds_a_limit() {
    let mut worst = Worst::default();
    for seed in 0..20 {
        let flown = fly(seed).unwrap();
        assert_eq!(flown.missed(), None, "seed {seed}");
        worst.add(&flown);
    }
    assert!(worst.none <= 2, "{worst}");
}
