//! `mc`: campaigns.

use std::fs;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{Files, host_sim, json, rejected, text};

#[test]
fn errors_of_the_window_are_at_the_bound_and_its_covariance_is_consistent() {
    let report = json(&["mc", "stsat3-spin-up", "--runs", "50", "--json"]);
    assert_eq!(report["scenario"], "stsat3-spin-up");
    assert_eq!((&report["estimator"], &report["precision"]), (&"window".into(), &"f32".into()));
    for (count, expected) in
        [("runs", 50), ("used", 50), ("diverged", 0), ("not_converged", 0), ("steps", 50 * 6001)]
    {
        assert_eq!(report[count], expected, "{count}");
    }
    let number = |value: &Value| value.as_f64().unwrap();
    for i in 0..6 {
        let bound = number(&report["bound_kg_m2"][i]);
        let over_bound = number(&report["rmse_over_bound"][i]);
        // Four sigma of the RMS over 50 runs.
        assert!((0.6..1.4).contains(&over_bound), "element {i}: {over_bound}");
        assert!((number(&report["rmse_kg_m2"][i]) / bound - over_bound).abs() < 1e-9);
        // Five sigma of the mean over 50 runs.
        assert!(number(&report["bias_kg_m2"][i]).abs() < 0.71 * over_bound * bound, "element {i}");
    }
    let nees = number(&report["nees_per_dof"]);
    // Four sigma of the mean over 50 runs.
    assert!((0.67..1.33).contains(&nees), "{nees}");
    assert_eq!((&report["changes"], &report["silent_lies"]), (&0.into(), &0.into()));
    // The test rejects white residuals with probability 0.01: more than 4 of 50 with 2e-4.
    assert!(report["residuals_not_white"].as_u64().unwrap() <= 4, "{report}");
    // Chi-square with 300 degrees of freedom: 253.912 and 349.874.
    assert!((number(&report["nees_95"][0]) - 0.846_375).abs() < 1e-4);
    assert!((number(&report["nees_95"][1]) - 1.166_248).abs() < 1e-4);
    assert!(number(&report["wall_s"]) > 0.0 && number(&report["steps_per_s_per_core"]) > 0.0);
}

#[test]
fn rounding_error_of_a_coarse_gyro_is_part_of_its_noise() {
    let files = Files::new();
    let scenario = fs::read_to_string("scenarios/cubesat-pyramid.toml").unwrap();
    // A quantum of ten sigma: the rounding error is three times the noise.
    let coarse = files.file("coarse.toml", &(scenario + "\nquantum_rad_s = 1e-3\n"));
    for estimator in ["window", "joint-ekf"] {
        let arguments = ["mc", text(&coarse), "--runs", "20", "--json", "--estimator", estimator];
        let report = json(&arguments);
        for count in ["diverged", "not_converged", "changes"] {
            assert_eq!(report[count], 0, "{estimator}: {report}");
        }
        let nees = report["nees_per_dof"].as_f64().unwrap();
        // The rounding errors of successive samples are correlated: somewhat below 1.
        assert!((0.4..1.3).contains(&nees), "{estimator}: {nees}");
    }
    let out = files.folder.path().join("out");
    let ran = json(&["run", text(&coarse), "--json", "--out", text(&out)]);
    let (craft, log) = (out.join("craft.toml"), out.join("log.csv"));
    let replayed = json(&["replay", "--json", "--craft", text(&craft), text(&log)]);
    assert_eq!(ran["status"], "converged");
    assert_eq!(ran["inertia_kg_m2"], replayed["inertia_kg_m2"]);
}

#[test]
fn result_does_not_depend_on_the_number_of_cores() {
    let folder = TempDir::new().unwrap();
    let on_cores = |cores: &str| {
        let rows = folder.path().join(cores).with_extension("csv");
        let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(["mc", "cubesat-pyramid", "--runs", "40", "--seed", "7", "--json", "--out"])
            .arg(&rows)
            .env("RAYON_NUM_THREADS", cores)
            .output()
            .unwrap();
        assert!(output.status.success() && output.stderr.is_empty());
        (without_times(&output.stdout), fs::read_to_string(rows).unwrap())
    };
    assert_eq!(on_cores("1"), on_cores("2"));
}

/// Document of a campaign without its timing.
fn without_times(stdout: &[u8]) -> Value {
    let mut report: Value = serde_json::from_slice(stdout).unwrap();
    for time in ["wall_s", "steps_per_s_per_core"] {
        assert!(report.as_object_mut().unwrap().remove(time).is_some(), "{time}");
    }
    report
}

#[test]
fn runs_of_a_campaign_equal_single_runs() {
    for scenario in ["cubesat-pyramid", "bellar-2019-campaign"] {
        compare_with_single_run(scenario);
    }
}

fn compare_with_single_run(scenario: &str) {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("runs.csv");
    json(&["mc", scenario, "--runs", "3", "--seed", "5", "--json", "--out", text(&file)]);
    let rows = fs::read_to_string(&file).unwrap();
    assert_eq!(rows.lines().count(), 4);
    let last: Vec<&str> = rows.lines().last().unwrap().split(',').collect();
    assert_eq!(&last[..3], ["2", "7", "converged"]);
    let run = json(&["run", scenario, "--seed", "7", "--json"]);
    let inertia = &run["inertia_kg_m2"];
    for (i, (row, column)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].iter().enumerate() {
        // The JSON reader may differ in the last digit from the text, which is exact.
        let same = |number: &Value, at: usize| {
            let (number, cell) = (number.as_f64().unwrap(), last[at].parse::<f64>().unwrap());
            (number - cell).abs() <= 2.0 * f64::EPSILON * cell.abs()
        };
        assert!(same(&inertia[row][column], 3 + i), "element {i}");
        assert!(same(&run["sigma_kg_m2"][i], 9 + i), "element {i}");
    }
}

/// Random spacecraft with gyro noise that leaves the elements of some of them unobserved.
const NOISY_SPACECRAFT: &str = "name = 'noisy'\n[random_spacecraft]\nmass_kg = [1, 100]\n\
    rate_hz = [10, 20]\nsamples = [500, 600]\nbody_rate_rad_s = [0.01, 0.02]\n\
    noise_over_rate = [0.02, 0.5]\n";

#[test]
fn random_spacecraft_follow_from_their_seeds_and_unobserved_ones_are_counted() {
    let files = Files::new();
    let path = files.file("noisy.toml", NOISY_SPACECRAFT);
    let on_cores = |cores: &str| {
        let rows = files.folder.path().join(cores).with_extension("csv");
        let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(["mc", text(&path), "--runs", "12", "--json", "--out"])
            .arg(&rows)
            .env("RAYON_NUM_THREADS", cores)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (without_times(&output.stdout), fs::read_to_string(rows).unwrap())
    };
    let (report, rows) = on_cores("1");
    assert_eq!((&report, &rows), (&on_cores("2").0, &on_cores("2").1));
    let count = |key: &str| report[key].as_u64().unwrap();
    assert!((1..12).contains(&count("not_shown")), "{report}");
    assert_eq!(count("used") + count("not_shown") + count("diverged"), 12);

    for row in rows.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let bound = json(&["crlb", text(&path), "--seed", cells[1], "--json"]);
        let run = json(&["run", text(&path), "--seed", cells[1], "--json"]);
        assert_eq!(bound["scenario"], format!("noisy-{}", cells[1]));
        assert_eq!(
            (&bound["bound_kg_m2"], &bound["scenario"]),
            (&run["bound_kg_m2"], &run["scenario"])
        );
        let truth = |i: usize| run["truth_kg_m2"][i].as_f64().unwrap();
        let mean_moment = (truth(0) + truth(1) + truth(2)) / 3.0;
        let is_shown = (0..6).all(|i| {
            bound["bound_kg_m2"][i].as_f64().is_some_and(|bound| bound < 0.1 * mean_moment)
        });
        assert_eq!(cells[cells.len() - 2], is_shown.to_string(), "{row}");
    }
}

#[test]
fn filters_without_alignment_diverge_from_random_initial_estimates() {
    let fly = |estimator: &str| {
        let arguments = ["mc", "bellar-2019-campaign", "--runs", "50", "--json", "--estimator"];
        json(&[&arguments[..], &[estimator]].concat())
    };
    let aligned = fly("joint-ekf");
    assert_eq!((&aligned["diverged"], &aligned["not_converged"]), (&0.into(), &0.into()));
    // Mean of the five steps from 0.9 to 0.5 of the moment.
    assert!((aligned["truth_kg_m2"][0].as_f64().unwrap() - 0.7 * 14.2).abs() < 1e-9);
    for estimator in ["joint-ekf-published", "joint-ekf-unaligned"] {
        let diverged = fly(estimator)["diverged"].as_u64().unwrap();
        assert!(diverged > 40, "{estimator}: {diverged} of 50");
    }
}

#[test]
fn converged_runs_beyond_their_sigma_are_silent_lies() {
    let files = Files::new();
    // The printed filter is overconfident in single precision.
    let rows = files.folder.path().join("runs.csv");
    let estimator = ["--estimator", "joint-ekf-published"];
    let arguments = ["mc", "stsat3-spin-up", "--runs", "10", "--json"];
    let report = json(&[&arguments[..], &estimator, &["--out", text(&rows)]].concat());
    let rows = fs::read_to_string(&rows).unwrap();
    let (mut lies, mut header) = (0, rows.lines().next().unwrap().split(','));
    let column = |name: &str| rows.lines().next().unwrap().split(',').position(|c| c == name);
    assert_eq!(header.next_back(), Some("silent_lie"));
    for row in rows.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |name: String| cells[column(&name).unwrap()].parse::<f64>().unwrap();
        let is_beyond = ["jxx", "jyy", "jzz", "jxy", "jxz", "jyz"].iter().any(|j| {
            number(format!("error_{j}_kg_m2")).abs() > 5.0 * number(format!("sigma_{j}_kg_m2"))
        });
        let is_called_good = cells[column("status").unwrap()] == "converged"
            && cells[column("residuals_white").unwrap()] != "false";
        let is_lie = is_beyond && is_called_good;
        assert_eq!(cells[cells.len() - 1], is_lie.to_string(), "{row}");
        lies += u64::from(is_lie);
    }
    assert!(lies > 0);
    assert_eq!(report["silent_lies"], lies);
}

#[test]
fn bad_arguments_of_mc_are_rejected() {
    let bad: [&[&str]; 4] = [
        &["mc", "stsat3-spin-up", "--runs", "0"],
        &["mc", "stsat3-spin-up", "--runs", "-1"],
        &["mc", "stsat3-spin-up"],
        &["mc", "--runs", "5"],
    ];
    for arguments in bad {
        let missing = if arguments[1] == "--runs" { "<SCENARIO>" } else { "--runs" };
        rejected(&host_sim(arguments), &[missing]);
    }
    rejected(&host_sim(&["mc", "no-such-scenario", "--runs", "5"]), &["no-such-scenario"]);

    let folder = TempDir::new().unwrap();
    let obstacle = folder.path().join("obstacle");
    fs::write(&obstacle, "").unwrap();
    for out in [obstacle.join("runs.csv"), obstacle] {
        let output = host_sim(&["mc", "cubesat-pyramid", "--runs", "5", "--out", text(&out)]);
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stderr).contains(text(&out)));
    }
}

#[test]
fn folder_has_the_page_the_rows_and_the_scenario() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("campaign");
    json(&["mc", "cubesat-pyramid", "--runs", "3", "--json", "--out", text(&out)]);
    for file in ["report.html", "result.json", "runs.parquet", "scenario/scenario.toml"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    assert_eq!(fs::read_to_string(out.join("runs.csv")).unwrap().lines().count(), 4);
    // The rows alone.
    let rows = folder.path().join("rows.parquet");
    json(&["mc", "cubesat-pyramid", "--runs", "3", "--json", "--out", text(&rows)]);
    assert_eq!(fs::read(&rows).unwrap(), fs::read(out.join("runs.parquet")).unwrap());
}

#[cfg(unix)]
#[test]
fn campaign_stopped_by_ctrl_c_equals_a_shorter_one() {
    use std::process::Stdio;
    use std::thread::sleep;
    use std::time::Duration;

    let folder = TempDir::new().unwrap();
    let file = folder.path().join("runs.csv");
    // Time until the first run is complete, which depends on the machine.
    let output = [1, 4, 16]
        .map(Duration::from_secs)
        .into_iter()
        .find_map(|patience| {
            let _ = fs::remove_file(&file);
            let campaign = std::process::Command::new(env!("CARGO_BIN_EXE_host-sim"))
                .args(["mc", "cubesat-pyramid", "--runs", "100000000", "--json", "--out"])
                .arg(&file)
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            // A file of a temporary name is created once the handler of Ctrl-C is set, before the first run.
            while fs::read_dir(folder.path()).unwrap().next().is_none() {
                sleep(Duration::from_millis(20));
            }
            sleep(patience);
            let interrupt = ["-INT".to_owned(), campaign.id().to_string()];
            assert!(Command::new("kill").args(interrupt).output().unwrap().status.success());
            let output = campaign.wait_with_output().unwrap();
            (output.status.code() != Some(1)).then_some(output)
        })
        .expect("no run was complete after 16 s");

    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && message.starts_with("note: stopped after"), "{message}");
    let stopped = without_times(&output.stdout);
    let runs = stopped["runs"].to_string();
    let rows = fs::read_to_string(&file).unwrap().lines().count() - 1;
    assert_eq!(rows.to_string(), runs);
    let shorter = host_sim(&["mc", "cubesat-pyramid", "--runs", &runs, "--json"]);
    assert_eq!(stopped, without_times(&shorter.stdout));
}
