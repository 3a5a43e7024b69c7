//! \[Kim2010\] Table 2 from the paper's own slew: what the simulator and the four estimators make
//! of it, over seeds.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::sync::atomic::AtomicBool;

use fsw_core::Status;
use host_sim::campaign::{Campaign, CampaignRun, Truths};
use host_sim::estimation::{EstimatorName, Precision};
use host_sim::input::Scenario;

/// The columns of Table 2, kg m², in the order `jxx jyy jzz jxy jxz jyz`.
const CONVENTIONAL: [f64; 6] = [14.1181, 17.5350, 20.6816, 16.3578, 17.4000, 19.1201];
const SUGGESTED: [f64; 6] = [14.1181, 17.5350, 20.6816, 0.1197, 0.1560, 0.1538];
const BATCH: [f64; 6] = [4.2859, 7.1157, 6.1224, 4.8224, 6.2786, 6.1667];

fn runs(estimator: EstimatorName) -> Vec<CampaignRun> {
    let scenario = Scenario::load("kim-2010-slew").unwrap();
    let truths = Truths::simulate(&scenario).unwrap();
    let campaign = Campaign {
        scenario: &scenario,
        truths: &truths,
        estimator,
        precision: Precision::F32,
        first_seed: 0,
        runs: 20,
    };
    campaign.run_all(&AtomicBool::new(false), || ()).unwrap()
}

/// Every run's element against the paper's, as a share of it.
fn worst_share(runs: &[CampaignRun], table: &[f64; 6], elements: std::ops::Range<usize>) -> f64 {
    let share = |run: &CampaignRun, i: usize| (run.score.inertia_kg_m2[i] / table[i] - 1.0).abs();
    runs.iter().flat_map(|run| elements.clone().map(move |i| share(run, i))).fold(0.0, f64::max)
}

#[test]
fn the_conventional_column_comes_out_whatever_the_noise() {
    let runs = runs(EstimatorName::MomentumConventional);
    assert!(worst_share(&runs, &CONVENTIONAL, 0..3) < 0.015);
    assert!(worst_share(&runs, &CONVENTIONAL, 3..6) < 0.025);
}

#[test]
fn the_other_columns_come_out_as_the_noise_has_it() {
    // Moments are the conventional ones. Products of the suggested method are n σ² / Σ ω² of a
    // moment, so they measure the length and rate of the record, which the paper doesn't give.
    let suggested = runs(EstimatorName::MomentumSuggested);
    assert!(worst_share(&suggested, &SUGGESTED, 0..3) < 0.015);
    assert!(worst_share(&suggested, &SUGGESTED, 3..6) < 0.6);
    // Noise and nothing else: 3 % from run to run.
    let batch = runs(EstimatorName::MomentumBatch);
    assert!(worst_share(&batch, &BATCH, 0..6) < 0.15);
}

#[test]
fn every_method_owns_up_to_what_the_slew_does_not_show() {
    for estimator in [
        EstimatorName::MomentumBatch,
        EstimatorName::MomentumConventional,
        EstimatorName::MomentumPreEstimate,
        EstimatorName::MomentumSuggested,
    ] {
        for run in runs(estimator) {
            let score = run.score;
            assert_eq!(score.status, Status::Partial, "{estimator}");
            for i in 0..6 {
                let (error, sigma) = (score.error_kg_m2[i], score.sigma_kg_m2[i]);
                assert!(error.abs() < 2.0 * sigma, "{estimator} element {i}: {error} ± {sigma}");
            }
        }
    }
}
