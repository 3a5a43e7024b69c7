//! Several logs and estimators on the command line: rows, documents, folders, exit status.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const HOST_SIM: &str = env!("CARGO_BIN_EXE_host-sim-for-tests");

fn host_sim(arguments: &[&str], folder: &Path) -> Output {
    Command::new(HOST_SIM).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A folder with a craft file and three logs of it: two of one flight, one that is no log.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let run = host_sim(&["run", "cubesat-pyramid", "--out", "flown"], folder.path());
    assert!(run.status.success(), "{}", text(&run.stderr));
    let logs = folder.path().join("logs");
    std::fs::create_dir(&logs).unwrap();
    std::fs::copy(folder.path().join("flown/craft.toml"), folder.path().join("craft.toml"))
        .unwrap();
    for name in ["a.csv", "b.csv"] {
        std::fs::copy(folder.path().join("flown/log.csv"), logs.join(name)).unwrap();
    }
    folder
}

#[test]
fn several_logs_and_estimators_give_a_row_a_document_and_a_folder_each() {
    let folder = folder();
    let both = ["--estimator", "window", "--estimator", "joint-ekf"];
    let base = ["replay", "--craft", "craft.toml", "logs"];
    let table = host_sim(&[&base[..], &both].concat(), folder.path());
    assert_eq!(table.status.code(), Some(0), "{}", text(&table.stderr));
    let table = text(&table.stdout);
    assert!(table.ends_with("4 results: 4 converged\n"), "{table}");
    assert_eq!(table.matches("logs/a.csv").count(), 2, "{table}");

    let json = host_sim(&[&base[..], &both, &["--json", "--out", "out"]].concat(), folder.path());
    let documents: Value = serde_json::from_slice(&json.stdout).unwrap();
    let documents = documents.as_array().unwrap();
    assert_eq!(documents.len(), 4);
    assert_eq!(documents[0]["log"], "logs/a.csv");
    assert_eq!(
        (&documents[0]["estimator"], &documents[0]["error"]),
        (&"window".into(), &Value::Null)
    );
    for file in ["a/window", "a/joint-ekf", "b/window", "b/joint-ekf"] {
        assert!(folder.path().join("out").join(file).join("result.json").exists(), "{file}");
    }

    // One log by name is one document.
    let single =
        host_sim(&["replay", "--craft", "craft.toml", "logs/a.csv", "--json"], folder.path());
    let document: Value = serde_json::from_slice(&single.stdout).unwrap();
    assert_eq!(document["inertia_kg_m2"], documents[0]["inertia_kg_m2"]);
}

#[test]
fn a_log_at_fault_does_not_stop_the_others() {
    let folder = folder();
    std::fs::write(folder.path().join("logs/c.csv"), "no,log\n1,2\n").unwrap();
    let output = host_sim(&["replay", "--craft", "craft.toml", "logs"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    let (table, errors) = (text(&output.stdout), text(&output.stderr));
    assert!(table.contains("3 results: 2 converged, 1 failed"), "{table}");
    assert!(errors.contains("error: logs/c.csv:1: no column `t_s`"), "{errors}");
    assert!(
        errors.ends_with("error: 1 of 3 results are missing: see the errors above\n"),
        "{errors}"
    );
}

#[test]
fn exit_status_is_that_of_fail_on() {
    let folder = folder();
    let arguments = ["replay", "--craft", "craft.toml", "logs", "--fail-on", "diverged,partial"];
    assert_eq!(host_sim(&arguments, folder.path()).status.code(), Some(0));
    let rest = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,wheel_1_rad_s,wheel_2_rad_s,wheel_3_rad_s,\
                wheel_4_rad_s\n0,0,0,0,0,0,0,0\n0.1,1e-5,0,0,0,0,0,0\n0.2,0,1e-5,0,0,0,0,0\n";
    std::fs::write(folder.path().join("logs/rest.csv"), rest).unwrap();
    let output = host_sim(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(3));
    let errors = text(&output.stderr);
    assert!(errors.ends_with("error: 1 partial of 3 results, as --fail-on asks for\n"), "{errors}");
}

#[test]
fn wheels_at_1_hz_beside_a_gyro_at_10_hz() {
    let folder = folder();
    let log = std::fs::read_to_string(folder.path().join("logs/a.csv")).unwrap();
    let header: Vec<&str> = log.lines().next().unwrap().split(',').collect();
    let slower = |(row, line): (usize, &str)| {
        let cells = line.split(',').zip(&header).map(|(cell, name)| {
            // Row 0 is the header.
            let is_kept = row == 0 || row % 10 == 1 || !name.starts_with("wheel_");
            if is_kept { cell } else { "" }
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let text: Vec<String> = log.lines().enumerate().map(slower).collect();
    std::fs::write(folder.path().join("slow.csv"), text.join("\n") + "\n").unwrap();
    let replay = ["replay", "--craft", "craft.toml", "slow.csv", "--json"];
    let document: Value = serde_json::from_slice(&host_sim(&replay, folder.path()).stdout).unwrap();
    assert_eq!(document["status"], "converged");
    let notes = document["notes"].to_string();
    assert!(notes.contains("the wheels have a reading every 1 s"), "{notes}");
    assert!(notes.contains("in the sigma, as a noise of"), "{notes}");
    // Elements of cubesat-pyramid. Largest error in 15 logs of other offsets: 2.1 sigma.
    const TRUTH_KG_M2: [f64; 6] = [0.058, 0.104, 0.118, -0.0021, 0.0016, 0.0028];
    let element = |i: usize| {
        let (row, column) = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)][i];
        document["inertia_kg_m2"][row][column].as_f64().unwrap()
    };
    for (i, truth) in TRUTH_KG_M2.iter().enumerate() {
        let sigma = document["sigma_kg_m2"][i].as_f64().unwrap();
        assert!((element(i) - truth).abs() < 4.0 * sigma, "element {i}: {document}");
        assert!(sigma < 0.005 * 0.1, "element {i}: {sigma}");
    }
}

#[test]
fn standard_input_is_a_log() {
    let folder = folder();
    let log = std::fs::File::open(folder.path().join("logs/a.csv")).unwrap();
    let output = Command::new(HOST_SIM)
        .args(["replay", "--craft", "craft.toml", "-", "--json"])
        .current_dir(folder.path())
        .stdin(log)
        .output()
        .unwrap();
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["status"], "converged");
}

#[test]
fn init_writes_files_that_run_and_keeps_files_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let init = host_sim(&["init", "mine"], folder.path());
    assert!(init.status.success(), "{}", text(&init.stderr));
    let run = host_sim(&["run", "mine/scenario.toml", "--out", "flown"], folder.path());
    assert!(run.status.success(), "{}", text(&run.stderr));
    let replay = ["replay", "--craft", "mine/craft.toml", "flown/log.csv", "--json"];
    let document: Value = serde_json::from_slice(&host_sim(&replay, folder.path()).stdout).unwrap();
    assert_eq!(document["status"], "converged");

    let again = host_sim(&["init", "mine"], folder.path());
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("mine/scenario.toml: exists already"));

    let draft = ["init", "--from", "flown/log.csv", "--out", "draft.toml"];
    assert!(host_sim(&draft, folder.path()).status.success());
    let unfilled = host_sim(&["replay", "--craft", "draft.toml", "flown/log.csv"], folder.path());
    assert_eq!(unfilled.status.code(), Some(2));
    assert!(text(&unfilled.stderr).contains("`wheel[1].axis` is [0, 0, 0]"));
}
