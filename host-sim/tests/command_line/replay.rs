//! `replay`: recorded logs.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

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
        for file in [
            "report.html",
            "result.json",
            "history.csv",
            "data/inertia.csv",
            "data/innovations.csv",
        ] {
            assert!(out.join(file).is_file(), "{file}");
        }
    }
}

#[test]
fn report_in_the_folder_of_its_log_keeps_log_and_craft() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("flown");
    json(&["run", "cubesat-pyramid", "--json", "--out", text(&out)]);
    let (craft, log) = (out.join("craft.toml"), out.join("log.csv"));
    json(&["replay", "--json", "--craft", text(&craft), text(&log), "--out", text(&out)]);
    assert!(craft.is_file() && log.is_file() && out.join("report.html").is_file());
    // A log has no truth and no scenario.
    for stale in ["data/attitude.csv", "scenario/scenario.toml"] {
        assert!(!out.join(stale).exists(), "{stale}");
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

/// Log of the CubeSat by the simulator, without the rows of this range of lines, and with a spike in
/// this line; lines are counted from zero, the header included.
fn damaged_log(folder: &Path, gap: Range<usize>, spike: usize) -> PathBuf {
    json(&["run", "cubesat-pyramid", "--json", "--out", text(folder)]);
    let log = fs::read_to_string(folder.join("log.csv")).unwrap();
    let mut damaged = String::new();
    for (line, row) in log.lines().enumerate().filter(|(line, _)| !gap.contains(line)) {
        let mut cells: Vec<&str> = row.split(',').collect();
        if line == spike {
            cells[1] = "0.05";
        }
        damaged += &(cells.join(",") + "\n");
    }
    let path = folder.join("damaged.csv");
    fs::write(&path, damaged).unwrap();
    path
}

#[test]
fn gap_and_spike_are_reported_with_their_times() {
    let folder = TempDir::new().unwrap();
    // Line n has the time (n - 1) / 10 s.
    let log = damaged_log(folder.path(), 300..400, 501);
    let craft = folder.path().join("craft.toml");
    let out = folder.path().join("out");
    let arguments = ["replay", "--craft", text(&craft), text(&log), "--estimator", "joint-ekf"];
    let report = json(&[&arguments[..], &["--json", "--out", text(&out)]].concat());
    assert_eq!(report["gaps"], serde_json::json!([39.9]), "{report}");
    assert_eq!(report["spikes"], serde_json::json!({ "count": 1, "first_s": [50.0] }));
    for events in ["restarts", "changes", "notes"] {
        assert_eq!(report[events], serde_json::json!([]), "{events}");
    }
    let events = fs::read_to_string(out.join("events.csv")).unwrap();
    assert!(events.contains("\n39.9,reset_gap\n50,spike\n"), "{events}");
    let table = String::from_utf8(host_sim(&arguments).stdout).unwrap();
    for line in ["gaps                1, at 39.9 s\n", "spikes              1, at 50 s\n"] {
        assert!(table.contains(line), "{table}");
    }
    assert!(!table.contains("changes") && !table.contains("restarts"), "{table}");
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
        assert_eq!(report["notes"].as_array().unwrap().len(), usize::from(is_repeated));
        assert_eq!(report["status"], "converged");
        let residual = report["residual_rms_rad_s"].as_f64().unwrap();
        assert!((residual / 1e-4 - 1.0).abs() < 0.1, "{estimator}: {residual}");
    }
}
