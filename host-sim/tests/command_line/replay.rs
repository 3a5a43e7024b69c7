//! `replay`: recorded logs.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{CRAFT, Files, HEADER, ROWS, host_sim, json, rejected, text};

#[test]
fn replay_of_a_simulated_log_has_the_bits_of_the_run() {
    let folder = TempDir::new().unwrap();
    for precision in ["f32", "f64"] {
        let out = folder.path().join(precision);
        let arguments = ["run", "cubesat-pyramid", "--json", "--precision", precision];
        let run = json(&[&arguments[..], &["--out", text(&out)]].concat());
        let (craft, log) = (out.join("craft.toml"), out.join("log.csv"));
        let arguments = ["replay", "--json", "--precision", precision, "--craft", text(&craft)];
        let replay = json(&[&arguments[..], &[text(&log)]].concat());
        for key in ["inertia_kg_m2", "covariance_kg2_m4", "accepted", "residual_rms_rad_s"] {
            assert_eq!(run[key], replay[key], "{precision} {key}");
        }
        for file in ["report.md", "result.json", "history.csv", "inertia.svg", "rates.svg"] {
            assert!(out.join(file).is_file(), "{file}");
        }
    }
}

#[test]
fn replay_of_a_log_with_attitude_has_the_bits_of_the_run() {
    let folder = TempDir::new().unwrap();
    let out = text(folder.path());
    let estimator = ["--estimator", "momentum-suggested"];
    let ran = json(&[&["run", "kim-2010-slew", "--json", "--out", out], &estimator[..]].concat());
    let craft = folder.path().join("craft.toml");
    let log = folder.path().join("log.csv");
    let replay = ["replay", "--json", "--craft", text(&craft), text(&log)];
    let replayed = json(&[&replay[..], &estimator].concat());
    assert_eq!(ran["inertia_kg_m2"], replayed["inertia_kg_m2"]);
    assert_eq!(ran["covariance_kg2_m4"], replayed["covariance_kg2_m4"]);
    assert_eq!(
        (&replayed["status"], &replayed["observed_directions"]),
        (&"partial".into(), &3.into())
    );
}

#[test]
fn momentum_estimators_without_attitude_are_rejected() {
    let files = Files::new();
    let craft = files.file("craft.toml", CRAFT);
    let log = files.file("log.csv", &[HEADER, ROWS].concat());
    for method in ["batch", "conventional", "pre-estimate", "suggested"] {
        let name = format!("momentum-{method}");
        let output =
            host_sim(&["replay", "--craft", text(&craft), text(&log), "--estimator", &name]);
        rejected(&output, &[&name, "needs the attitude", "attitude_q1", "scalar last"]);
    }
}

#[test]
fn gyro_noise_is_estimated_if_the_craft_does_not_state_it() {
    let folder = TempDir::new().unwrap();
    json(&["run", "cubesat-pyramid", "--json", "--out", text(folder.path())]);
    let craft = folder.path().join("craft.toml");
    let stated = fs::read_to_string(&craft).unwrap();
    fs::write(&craft, stated.replace("noise_rad_s = 0.0001\n", "")).unwrap();
    let log = folder.path().join("log.csv");
    // The window estimates the noise in flight. The filter is repeated with the noise of its residuals.
    for (estimator, is_repeated) in [("window", false), ("joint-ekf", true)] {
        let arguments = ["replay", "--json", "--craft", text(&craft), text(&log), "--estimator"];
        let output = host_sim(&[&arguments[..], &[estimator]].concat());
        let notes = String::from_utf8_lossy(&output.stderr);
        assert_eq!(notes.contains("estimated from the residuals"), is_repeated, "{notes}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["status"], "converged");
        let residual = report["residual_rms_rad_s"].as_f64().unwrap();
        assert!((residual / 1e-4 - 1.0).abs() < 0.1, "{estimator}: {residual}");
    }
}
