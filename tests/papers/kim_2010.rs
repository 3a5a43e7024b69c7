//! Estimates of the four methods of \[Kim2010\] on the paper's slew, beside Table 2.

use std::sync::atomic::AtomicBool;

use fsw_core::Status;
use host_sim::campaign::{Campaign, CampaignRun, Truths};
use host_sim::estimation::{EstimatorName, Precision};
use host_sim::input::Scenario;

/// Columns of Table 2, kg m², in the order `jxx jyy jzz jxy jxz jyz`.
const CONVENTIONAL: [f64; 6] = [14.1181, 17.5350, 20.6816, 16.3578, 17.4000, 19.1201];
const SUGGESTED: [f64; 6] = [14.1181, 17.5350, 20.6816, 0.1197, 0.1560, 0.1538];
const BATCH: [f64; 6] = [4.2859, 7.1157, 6.1224, 4.8224, 6.2786, 6.1667];

/// Differences from Table 2, share of the published element. The moments of three methods are the
/// conventional ones. The formulas are determined by the slew and almost independent of the noise.
const MOMENTS: f64 = 0.015;
/// Conventional products.
const PRODUCTS: f64 = 0.025;
/// Products of the suggested method: `n σ² / Σ ω²` of a moment. They depend on the length and the
/// rate of the record, which the paper does not give.
const SUGGESTED_PRODUCTS: f64 = 0.6;
/// Batch estimates depend on the noise alone, and scatter by 3 % from run to run.
const BATCH_ELEMENTS: f64 = 0.15;

/// Twenty runs of one method.
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

/// Largest relative difference of an element from the published one, over the runs.
fn worst_difference(
    runs: &[CampaignRun],
    table: &[f64; 6],
    elements: std::ops::Range<usize>,
) -> f64 {
    let share = |run: &CampaignRun, i: usize| (run.score.inertia_kg_m2[i] / table[i] - 1.0).abs();
    runs.iter().flat_map(|run| elements.clone().map(move |i| share(run, i))).fold(0.0, f64::max)
}

#[test]
fn kim_2010_conventional_column_is_reproduced_in_every_run() {
    let runs = runs(EstimatorName::MomentumConventional);
    assert!(worst_difference(&runs, &CONVENTIONAL, 0..3) < MOMENTS);
    assert!(worst_difference(&runs, &CONVENTIONAL, 3..6) < PRODUCTS);
}

#[test]
fn kim_2010_columns_of_suggested_and_batch_are_reproduced() {
    let suggested = runs(EstimatorName::MomentumSuggested);
    assert!(worst_difference(&suggested, &SUGGESTED, 0..3) < MOMENTS);
    assert!(worst_difference(&suggested, &SUGGESTED, 3..6) < SUGGESTED_PRODUCTS);
    let batch = runs(EstimatorName::MomentumBatch);
    assert!(worst_difference(&batch, &BATCH, 0..6) < BATCH_ELEMENTS);
}

#[test]
fn kim_2010_errors_are_within_two_reported_sigma() {
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
