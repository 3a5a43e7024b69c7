//! Names and shapes of the documents.

use serde_json::{Value, json};

use super::{RunReport, examples};
use crate::campaign::Reference;

fn keys(document: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = document.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

const REPLAY_KEYS: [&str; 35] = [
    "accepted",
    "changes",
    "covariance_kg2_m4",
    "disturbance_torque_n_m",
    "element_observed",
    "estimator",
    "explanations",
    "gaps",
    "gyro_bias_rad_s",
    "hardware",
    "health",
    "health_changes",
    "health_driver",
    "inertia_kg_m2",
    "inertia_over_trace",
    "inertia_over_trace_sigma",
    "interruptions",
    "largest_systematic",
    "notes",
    "observed_directions",
    "physical",
    "precision",
    "projected",
    "rejected",
    "residual_rms_rad_s",
    "residuals_white",
    "restarts",
    "samples",
    "scale_observed",
    "sigma_kg_m2",
    "sigma_random_kg_m2",
    "sigma_systematic_kg_m2",
    "skipped_rows",
    "spikes",
    "status",
];

#[test]
fn replay_has_the_stable_names_and_shapes() {
    let document = serde_json::to_value(examples::replay()).unwrap();
    assert_eq!(keys(&document), REPLAY_KEYS);
    assert_eq!(document["status"], "converged");
    assert_eq!(document["rejected"], json!({ "spike": 2, "stuck": 1 }));
    assert_eq!(document["spikes"], json!({ "count": 2, "first_s": [12.3, 45.6] }));
    assert_eq!(document["inertia_kg_m2"][0][1], document["inertia_kg_m2"][1][0]);
    assert_eq!(document["inertia_kg_m2"][1][2], 0.6015);
    assert_eq!(document["covariance_kg2_m4"].as_array().unwrap().len(), 6);
    assert!(document["gyro_bias_rad_s"].is_null());
}

#[test]
fn hardware_has_the_stable_names_and_shapes() {
    let document = serde_json::to_value(examples::with_hardware()).unwrap();
    let expected =
        ["assumed", "effect_kg_m2", "key", "kind", "name", "sigma", "stated", "unit", "value"];
    assert_eq!(keys(&document["hardware"][1]), expected);
    assert_eq!(document["hardware"][1]["assumed"], true);
    assert_eq!(document["hardware"][2]["unit"], "s");
    assert_eq!(document["largest_systematic"], "wheel spin inertia");
    let of = |name: &str, i: usize| document[name][i].as_f64().unwrap();
    for i in 0..6 {
        let sum = of("sigma_random_kg_m2", i).hypot(of("sigma_systematic_kg_m2", i));
        assert!((of("sigma_kg_m2", i) - sum).abs() <= 1e-12 * sum);
        let variance = document["covariance_kg2_m4"][i][i].as_f64().unwrap();
        assert!((variance - sum * sum).abs() <= 1e-12 * variance);
    }
    let ideal = serde_json::to_value(examples::replay()).unwrap();
    assert!(ideal["largest_systematic"].is_null() && ideal["hardware"] == json!([]));
}

#[test]
fn run_has_the_names_of_replay_and_the_truth() {
    let document = serde_json::to_value(examples::run()).unwrap();
    let mut expected = REPLAY_KEYS.to_vec();
    expected.extend(["bound_kg_m2", "error_over_sigma", "error_percent", "joint_bound_kg_m2"]);
    expected.extend(["scenario", "seed", "truth_kg_m2"]);
    expected.sort_unstable();
    assert_eq!(keys(&document), expected);
    /// Rounding of the difference of two elements, per cent.
    const TOLERANCE_PERCENT: f64 = 1e-9;
    let error = document["error_percent"][0].as_f64().unwrap();
    assert!((error - 100.0 * 0.00102 / 14.2).abs() < TOLERANCE_PERCENT);
}

#[test]
fn mc_has_the_stable_names_and_shapes() {
    let document = serde_json::to_value(examples::mc()).unwrap();
    let expected = [
        "bias_kg_m2",
        "bias_over_bound",
        "bound_kg_m2",
        "changes",
        "diverged",
        "estimator",
        "joint_bound_kg_m2",
        "largest_systematic",
        "nees_95",
        "nees_per_dof",
        "nees_runs",
        "not_converged",
        "not_shown",
        "precision",
        "residuals_not_white",
        "rmse_kg_m2",
        "rmse_over_bound",
        "rmse_over_bound_of_all",
        "rmse_over_joint_bound",
        "runs",
        "scenario",
        "seed",
        "sigma_kg_m2",
        "sigma_random_kg_m2",
        "sigma_systematic_kg_m2",
        "silent_lies",
        "steps",
        "steps_per_s_per_core",
        "truth_kg_m2",
        "used",
        "wall_s",
    ];
    assert_eq!(keys(&document), expected);
    assert_eq!(document["rmse_over_bound"].as_array().unwrap().len(), 6);
    assert_eq!(document["nees_95"], json!([0.8881, 1.1187]));
}

#[test]
fn bound_of_an_unobserved_element_and_error_of_a_zero_element_are_null() {
    let document = serde_json::to_value(examples::crlb()).unwrap();
    assert!(document["bound_kg_m2"][2].is_null() && document["bound_percent"][2].is_null());
    /// The expected value has four decimals, per cent.
    const TOLERANCE_PERCENT: f64 = 1e-3;
    assert!((document["bound_percent"][3].as_f64().unwrap() - 1.2918).abs() < TOLERANCE_PERCENT);
    assert_eq!(document["observed_directions"], 4);
    assert_eq!(document["inertia_error_kg_m2_per_n_m"][0], json!([-1350.0, 12.5, -0.2]));
    assert!(document["inertia_error_kg_m2_per_n_m"][2].is_null());
    assert_eq!(document["torque_bound_n_m"], json!([3.21e-7, 4.5e-5, null]));

    let mut truth_kg_m2 = examples::TRUTH;
    truth_kg_m2[3] = 0.0;
    let mut reference =
        Reference { truth_kg_m2, bound_kg_m2: [Some(0.1); 6], joint_bound_kg_m2: [None; 6] };
    let run = |reference| RunReport::new("x", 0, examples::replay(), &reference);
    assert_eq!(run(reference).error_percent[3], None);
    assert_eq!(run(reference).measure(), ("bound", [Some(0.1); 6]));
    reference.joint_bound_kg_m2 = [Some(0.2); 6];
    assert_eq!(run(reference).measure(), ("joint bound", [Some(0.2); 6]));
}
