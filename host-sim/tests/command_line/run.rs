//! `run` and `crlb`: one simulated flight, and its bound.

use serde_json::Value;

use crate::program::{Files, SCENARIO, host_sim, json, text};

#[test]
fn run_without_arguments_converges_within_five_bounds() {
    let report = json(&["run", "--json"]);
    assert_eq!(report["scenario"], "stsat3-spin-up");
    assert_eq!((&report["estimator"], &report["precision"]), (&"window".into(), &"f32".into()));
    assert_eq!((&report["samples"], &report["accepted"]), (&6001.into(), &6001.into()));
    assert_eq!(report["status"], "converged");
    assert_eq!(report["observed_directions"], 6);
    for i in 0..6 {
        let truth = report["truth_kg_m2"][i].as_f64().unwrap();
        let error = report["error_percent"][i].as_f64().unwrap() / 100.0 * truth;
        assert!(error.abs() < 5.0 * report["bound_kg_m2"][i].as_f64().unwrap(), "element {i}");
    }
}

#[test]
fn equal_seeds_give_equal_results_and_other_seeds_do_not() {
    let inertia = |seed: &str| json(&["run", "--json", "--seed", seed])["inertia_kg_m2"].clone();
    assert_eq!(inertia("3"), inertia("3"));
    assert_ne!(inertia("3"), inertia("4"));
}

#[test]
fn bound_of_the_spin_up_is_the_known_one() {
    /// Difference from the known bound, share.
    const TOLERANCE: f64 = 0.02;
    const KNOWN_PERCENT: [f64; 6] = [0.0194, 0.0144, 0.0157, 1.294, 1.196, 0.142];
    let report = json(&["crlb", "stsat3-spin-up", "--json"]);
    for (i, known) in KNOWN_PERCENT.iter().enumerate() {
        let percent = report["bound_percent"][i].as_f64().unwrap();
        assert!((percent / known - 1.0).abs() < TOLERANCE, "element {i}: {percent} %");
    }
    assert_eq!(report["unknowns"].as_array().unwrap().len(), 9);
}

#[test]
fn crlb_has_the_effect_of_a_torque_unless_the_torque_is_unknown() {
    /// Numerical error of the first-order sensitivity, kg m².
    const TOLERANCE_KG_M2: f64 = 1e-3;
    /// One sigma of a constant torque over ten minutes, N m.
    const LARGEST_TORQUE_BOUND_N_M: f64 = 1e-6;
    let report = json(&["crlb", "stsat3-spin-up", "--json"]);
    // A torque equal to the commanded one doubles the torque: the error is minus the inertia.
    for (i, truth) in [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016].iter().enumerate() {
        let row = &report["inertia_error_kg_m2_per_n_m"][i];
        let error = |axis: usize, torque_n_m: f64| row[axis].as_f64().unwrap() * torque_n_m;
        let error = error(0, 1e-3) + error(1, 1e-3) + error(2, -2e-3);
        assert!((error + truth).abs() < TOLERANCE_KG_M2, "element {i}: {error}");
    }
    assert!(report["torque_bound_n_m"][0].as_f64().unwrap() < LARGEST_TORQUE_BOUND_N_M);

    let files = Files::new();
    let path = files.file("asks.toml", &format!("{SCENARIO}[disturbance]\ntorque = true\n"));
    let report = json(&["crlb", text(&path), "--json"]);
    assert_eq!(report["unknowns"].as_array().unwrap().len(), 12);
    assert!(report["inertia_error_kg_m2_per_n_m"].is_null());
}

#[test]
fn inertia_that_changes_is_compared_at_the_end_with_a_note() {
    for (scenario, note, jyy) in [
        ("deployment", "the bound is of the data after the last change, at 750 s", 1.05 * 2.31),
        (
            "fuel-burn",
            "the inertia drifts; the truth is at the end of the flight",
            2.31 * (1.0 - 0.11 / 3.6),
        ),
    ] {
        let output = host_sim(&["run", scenario, "--json"]);
        assert!(String::from_utf8_lossy(&output.stderr).contains(note), "{output:?}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let truth = report["truth_kg_m2"][1].as_f64().unwrap();
        assert!((truth - jyy).abs() < 1e-9, "{scenario}: {truth}");
        // The moments are observed to a few tenths of a per cent in the last manoeuvre.
        for i in 0..3 {
            let share = report["bound_kg_m2"][i].as_f64().unwrap() / truth;
            assert!((1e-4..5e-3).contains(&share), "{scenario}, element {i}: {share}");
        }
    }
}

/// An unmodelled torque, requested as an unknown together with the gyro bias.
const DISTURBED: &str = "[torque]\nkind = 'multisine'\nphase_rad = [[0], [1], [2]]\n\
    amplitude_n_m = [[0.02], [0.03], [0.02]]\nfrequency_hz = [[0.03], [0.05], [0.07]]\n\
    [disturbance]\ntorque = true\ngyro_bias = true\ntorque_n_m = [1e-4, -2e-4, 5e-5]\n";

#[test]
fn window_estimates_torque_and_bias_on_request() {
    let files = Files::new();
    let biased = format!("{SCENARIO}bias_rad_s = [1e-3, -2e-3, 5e-4]\n{DISTURBED}");
    let path = files.file("disturbed.toml", &biased.replace("s = 10.0\n[", "s = 300.0\n["));
    let output = host_sim(&["run", text(&path), "--json"]);
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["status"], "converged");
    for (key, truth, tolerance) in [
        ("disturbance_torque_n_m", [1e-4, -2e-4, 5e-5], 5e-6),
        ("gyro_bias_rad_s", [1e-3, -2e-3, 5e-4], 1e-4),
    ] {
        for axis in 0..3 {
            let error = report[key][axis].as_f64().unwrap() - truth[axis];
            assert!(error.abs() < tolerance, "{key} {axis}: {error}");
        }
    }
    let filter = host_sim(&["run", text(&path), "--estimator", "joint-ekf"]);
    assert!(String::from_utf8_lossy(&filter.stderr).contains("[disturbance] is ignored"));

    let free = format!("{SCENARIO}[disturbance]\ntorque = true\ngyro_bias = true\n");
    let report = json(&["run", text(&files.file("free.toml", &free)), "--json"]);
    for key in ["disturbance_torque_n_m", "gyro_bias_rad_s"] {
        assert!(report[key].is_null(), "unobservable for a free body: {report}");
    }
}

#[test]
fn flight_without_motion_is_unobservable() {
    // A free body at rest: no direction of the inertia is observable.
    let still = SCENARIO.replace("[0.1, 0.2, 0.3]", "[0, 0, 0]");
    let files = Files::new();
    let path = files.file("still.toml", &still);
    let report = json(&["run", text(&path), "--json"]);
    assert_eq!(report["status"], "unobservable");
    assert_eq!(report["observed_directions"], 0);
    let campaign = json(&["mc", text(&path), "--runs", "4", "--json"]);
    assert_eq!((&campaign["used"], &campaign["not_converged"]), (&4.into(), &4.into()));
    assert!(campaign["bound_kg_m2"][0].is_null() && campaign["rmse_over_bound"][0].is_null());
    let bound = json(&["crlb", text(&path), "--json"]);
    assert_eq!(bound["observed_directions"], 0);
    assert!(bound["bound_kg_m2"][0].is_null());
}
