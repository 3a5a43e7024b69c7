//! The program as a user runs it: verbs, exit codes, and what it says of bad input.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

fn host_sim(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim")).args(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = host_sim(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn run_needs_nothing_and_converges() {
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
fn seeds_repeat_and_differ() {
    let inertia = |seed: &str| json(&["run", "--json", "--seed", seed])["inertia_kg_m2"].clone();
    assert_eq!(inertia("3"), inertia("3"));
    assert_ne!(inertia("3"), inertia("4"));
}

#[test]
fn crlb_gives_the_known_bound_of_the_spin_up() {
    const KNOWN_PERCENT: [f64; 6] = [0.0194, 0.0144, 0.0157, 1.294, 1.196, 0.142];
    let report = json(&["crlb", "stsat3-spin-up", "--json"]);
    for (i, known) in KNOWN_PERCENT.iter().enumerate() {
        let percent = report["bound_percent"][i].as_f64().unwrap();
        assert!((percent / known - 1.0).abs() < 0.02, "element {i}: {percent} %");
    }
    assert_eq!(report["unknowns"].as_array().unwrap().len(), 9);
}

#[test]
fn crlb_says_what_a_torque_does_unless_it_is_among_the_unknowns() {
    let report = json(&["crlb", "stsat3-spin-up", "--json"]);
    // Along the commanded torque: the whole inertia by the whole torque.
    for (i, truth) in [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016].iter().enumerate() {
        let row = &report["inertia_error_kg_m2_per_n_m"][i];
        let error = |axis: usize, torque_n_m: f64| row[axis].as_f64().unwrap() * torque_n_m;
        let error = error(0, 1e-3) + error(1, 1e-3) + error(2, -2e-3);
        assert!((error + truth).abs() < 1e-3, "element {i}: {error}");
    }
    assert!(report["torque_bound_n_m"][0].as_f64().unwrap() < 1e-6);

    let bench = Bench::new();
    let path = bench.file("asks.toml", &format!("{SCENARIO}[disturbance]\ntorque = true\n"));
    let report = json(&["crlb", text(&path), "--json"]);
    assert_eq!(report["unknowns"].as_array().unwrap().len(), 12);
    assert!(report["inertia_error_kg_m2_per_n_m"].is_null());
}

#[test]
fn mc_finds_the_estimator_at_the_bound_and_honest() {
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
        // Four sigma of an RMS over fifty.
        assert!((0.6..1.4).contains(&over_bound), "element {i}: {over_bound}");
        assert!((number(&report["rmse_kg_m2"][i]) / bound - over_bound).abs() < 1e-9);
        // Five sigma of a mean over fifty.
        assert!(number(&report["bias_kg_m2"][i]).abs() < 0.71 * over_bound * bound, "element {i}");
    }
    let nees = number(&report["nees_per_dof"]);
    // Four sigma of a mean over fifty.
    assert!((0.67..1.33).contains(&nees), "{nees}");
    assert_eq!(report["changes"], 0);
    // One in a hundred by chance: more than four in fifty are a matter of 2e-4.
    assert!(report["residuals_not_white"].as_u64().unwrap() <= 4, "{report}");
    // Chi-square with 300 degrees of freedom: 253.912 and 349.874.
    assert!((number(&report["nees_95"][0]) - 0.846_375).abs() < 1e-4);
    assert!((number(&report["nees_95"][1]) - 1.166_248).abs() < 1e-4);
    assert!(number(&report["wall_s"]) > 0.0 && number(&report["steps_per_s_per_core"]) > 0.0);
}

#[test]
fn what_changes_in_flight_is_measured_at_its_end_and_said() {
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
        // Three moments to a few tenths of a per cent in the last manoeuvre, or better by all.
        for i in 0..3 {
            let share = report["bound_kg_m2"][i].as_f64().unwrap() / truth;
            assert!((1e-4..5e-3).contains(&share), "{scenario}, element {i}: {share}");
        }
    }
}

#[test]
fn mc_gives_the_same_on_any_number_of_cores() {
    let folder = TempDir::new().unwrap();
    let on_cores = |cores: &str| {
        let rows = folder.path().join(cores);
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

/// A campaign's document without what depends on the clock.
fn without_times(stdout: &[u8]) -> Value {
    let mut report: Value = serde_json::from_slice(stdout).unwrap();
    for time in ["wall_s", "steps_per_s_per_core"] {
        assert!(report.as_object_mut().unwrap().remove(time).is_some(), "{time}");
    }
    report
}

#[test]
fn mc_flies_what_run_flies() {
    for scenario in ["cubesat-pyramid", "bellar-2019-campaign"] {
        mc_flies_what_run_flies_of(scenario);
    }
}

fn mc_flies_what_run_flies_of(scenario: &str) {
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
        // The JSON reader may be off in the last digit, which the text says exactly.
        let same = |number: &Value, at: usize| {
            let (number, cell) = (number.as_f64().unwrap(), last[at].parse::<f64>().unwrap());
            (number - cell).abs() <= 2.0 * f64::EPSILON * cell.abs()
        };
        assert!(same(&inertia[row][column], 3 + i), "element {i}");
        assert!(same(&run["sigma_kg_m2"][i], 9 + i), "element {i}");
    }
}

/// Gyros too noisy for their motion, so that some spacecraft aren't shown.
const NOISY_SPACECRAFT: &str = "name = 'noisy'\n[random_spacecraft]\nmass_kg = [1, 100]\n\
    rate_hz = [10, 20]\nsamples = [500, 600]\nbody_rate_rad_s = [0.01, 0.02]\n\
    noise_over_rate = [0.02, 0.5]\n";

#[test]
fn spacecraft_at_random_are_those_of_their_seeds_and_counted_where_they_are_not_shown() {
    let bench = Bench::new();
    let path = bench.file("noisy.toml", NOISY_SPACECRAFT);
    let on_cores = |cores: &str| {
        let rows = bench.folder.path().join(cores);
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
        assert_eq!(cells[cells.len() - 1], is_shown.to_string(), "{row}");
    }
}

#[test]
fn a_campaign_from_any_start_is_for_a_filter_that_needs_none() {
    let fly = |estimator: &str| {
        let arguments = ["mc", "bellar-2019-campaign", "--runs", "50", "--json", "--estimator"];
        json(&[&arguments[..], &[estimator]].concat())
    };
    let flying = fly("joint-ekf");
    assert_eq!((&flying["diverged"], &flying["not_converged"]), (&0.into(), &0.into()));
    // The mean of 0.9 to 0.5 of the moment.
    assert!((flying["truth_kg_m2"][0].as_f64().unwrap() - 0.7 * 14.2).abs() < 1e-9);
    for estimator in ["joint-ekf-published", "joint-ekf-unaligned"] {
        let lost = fly(estimator)["diverged"].as_u64().unwrap();
        assert!(lost > 40, "{estimator}: {lost} of 50");
    }
}

#[test]
fn mc_refuses_bad_input() {
    let bad: [&[&str]; 4] = [
        &["mc", "stsat3-spin-up", "--runs", "0"],
        &["mc", "stsat3-spin-up", "--runs", "-1"],
        &["mc", "stsat3-spin-up"],
        &["mc", "--runs", "5"],
    ];
    for arguments in bad {
        let missing = if arguments[1] == "--runs" { "<SCENARIO>" } else { "--runs" };
        refused(&host_sim(arguments), &[missing]);
    }
    refused(&host_sim(&["mc", "no-such-scenario", "--runs", "5"]), &["no-such-scenario"]);

    let folder = TempDir::new().unwrap();
    let arguments = ["mc", "cubesat-pyramid", "--runs", "5", "--out", text(folder.path())];
    let output = host_sim(&arguments);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains(text(folder.path())));
}

#[cfg(unix)]
#[test]
fn mc_ends_early_on_ctrl_c_with_what_it_has() {
    use std::process::Stdio;
    use std::thread::sleep;
    use std::time::Duration;

    let folder = TempDir::new().unwrap();
    let file = folder.path().join("runs.csv");
    // How long until the first run is complete depends on the machine.
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
            // The file is made once Ctrl-C is caught, just before the first run.
            while !file.exists() {
                sleep(Duration::from_millis(20));
            }
            sleep(patience);
            let interrupt = ["-INT".to_owned(), campaign.id().to_string()];
            assert!(Command::new("kill").args(interrupt).output().unwrap().status.success());
            let output = campaign.wait_with_output().unwrap();
            (output.status.code() != Some(1)).then_some(output)
        })
        .expect("no run was complete in time");

    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && message.starts_with("note: stopped after"), "{message}");
    let stopped = without_times(&output.stdout);
    let runs = stopped["runs"].to_string();
    let rows = fs::read_to_string(&file).unwrap().lines().count() - 1;
    assert_eq!(rows.to_string(), runs);
    let shorter = host_sim(&["mc", "cubesat-pyramid", "--runs", &runs, "--json"]);
    assert_eq!(stopped, without_times(&shorter.stdout));
}

#[test]
fn a_simulated_log_replays_to_the_same_bits() {
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
fn a_log_with_attitude_replays_to_the_same_bits() {
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
fn estimators_by_momentum_ask_for_the_attitude() {
    let bench = Bench::new();
    let craft = bench.file("craft.toml", CRAFT);
    let log = bench.file("log.csv", &[HEADER, ROWS].concat());
    for method in ["batch", "conventional", "pre-estimate", "suggested"] {
        let name = format!("momentum-{method}");
        let output =
            host_sim(&["replay", "--craft", text(&craft), text(&log), "--estimator", &name]);
        refused(&output, &[&name, "needs the attitude", "attitude_q1", "scalar last"]);
    }
}

#[test]
fn without_a_stated_noise_the_residuals_give_it() {
    let folder = TempDir::new().unwrap();
    json(&["run", "cubesat-pyramid", "--json", "--out", text(folder.path())]);
    let craft = folder.path().join("craft.toml");
    let stated = fs::read_to_string(&craft).unwrap();
    fs::write(&craft, stated.replace("noise_rad_s = 0.0001\n", "")).unwrap();
    let log = folder.path().join("log.csv");
    // One measures it while it estimates, the other is flown several times until it is found.
    for (estimator, is_flown_again) in [("window", false), ("joint-ekf", true)] {
        let arguments = ["replay", "--json", "--craft", text(&craft), text(&log), "--estimator"];
        let output = host_sim(&[&arguments[..], &[estimator]].concat());
        let notes = String::from_utf8_lossy(&output.stderr);
        assert_eq!(notes.contains("estimated from the residuals"), is_flown_again, "{notes}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["status"], "converged");
        let residual = report["residual_rms_rad_s"].as_f64().unwrap();
        assert!((residual / 1e-4 - 1.0).abs() < 0.1, "{estimator}: {residual}");
    }
}

/// What acts on the body and the gyro, is told to nobody, and asked for.
const DISTURBED: &str = "[torque]\nkind = 'multisine'\nphase_rad = [[0], [1], [2]]\n\
    amplitude_n_m = [[0.02], [0.03], [0.02]]\nfrequency_hz = [[0.03], [0.05], [0.07]]\n\
    [disturbance]\ntorque = true\ngyro_bias = true\ntorque_n_m = [1e-4, -2e-4, 5e-5]\n";

#[test]
fn window_finds_torque_and_bias_where_they_are_asked_for() {
    let bench = Bench::new();
    let biased = format!("{SCENARIO}bias_rad_s = [1e-3, -2e-3, 5e-4]\n{DISTURBED}");
    let path = bench.file("disturbed.toml", &biased.replace("s = 10.0\n[", "s = 300.0\n["));
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
    let report = json(&["run", text(&bench.file("free.toml", &free)), "--json"]);
    for key in ["disturbance_torque_n_m", "gyro_bias_rad_s"] {
        assert!(report[key].is_null(), "a free body doesn't show it: {report}");
    }
}

/// A good craft and log, and a place to spoil them.
struct Bench {
    folder: TempDir,
}

const CRAFT: &str = "[[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1e-3\n\
                     [gyro]\nnoise_rad_s = 1e-4\n";
const HEADER: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,wheel_1_rad_s\n";
const ROWS: &str = "0,0.1,0.2,0.3,100\n0.1,0.1,0.2,0.3,101\n0.2,0.1,0.2,0.3,102\n";

impl Bench {
    fn new() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    fn file(&self, name: &str, content: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        fs::write(&path, content).unwrap();
        path
    }

    fn replay(&self, craft: &str, log: &str) -> Output {
        let (craft, log) = (self.file("craft.toml", craft), self.file("log.csv", log));
        host_sim(&["replay", "--craft", text(&craft), text(&log)])
    }

    fn run(&self, scenario: &str) -> Output {
        host_sim(&["run", text(&self.file("scenario.toml", scenario))])
    }
}

/// Exit code 2, nothing on stdout, one or two lines on stderr that name each of `named`.
fn refused(output: &Output, named: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert!((1..=2).contains(&message.lines().count()), "{message}");
    for name in named {
        assert!(message.contains(name), "{name:?} isn't in {message:?}");
    }
}

#[test]
fn the_unspoilt_bench_is_accepted() {
    let output = Bench::new().replay(CRAFT, &[HEADER, ROWS].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_spoilt_log_is_refused_with_place_and_remedy() {
    let bench = Bench::new();
    let log = |text: &str| bench.replay(CRAFT, text);
    let rows = |rows: &str| bench.replay(CRAFT, &[HEADER, rows].concat());
    refused(&log(""), &["log.csv", "empty"]);
    refused(
        &log("t_s,gyro_x_rad_s,gyro_z_rad_s,wheel_1_rad_s\n0,1,2,3\n"),
        &["log.csv", "gyro_y_rad_s"],
    );
    refused(&log(HEADER), &["log.csv"]);
    refused(
        &rows("0,0.1,0.2,0.3,100\n0.1,0.1,zero,0.3,101\n"),
        &["log.csv:3", "gyro_y_rad_s", "zero"],
    );
    refused(&rows("0,0.1,NaN,0.3,100\n"), &["log.csv:2", "gyro_y_rad_s", "NaN"]);
    refused(&rows("0,0.1,inf,0.3,100\n"), &["log.csv:2", "gyro_y_rad_s", "inf"]);
    refused(&rows("0.1,1,2,3,100\n0,1,2,3,101\n"), &["log.csv:3", "t_s"]);
    refused(&rows("0.1,1,2,3,100\n0.1,1,2,3,101\n"), &["log.csv:3", "t_s"]);
    refused(&rows("0,1,2,3,100\n0.1,1,2"), &["log.csv:3", "cut"]);
    refused(&rows("0,1,2,3,100\n0.1,1,2\n0.2,1,2,3,101\n"), &["log.csv:3"]);
}

#[test]
fn a_log_that_does_not_fit_the_craft_is_refused() {
    let bench = Bench::new();
    let log = [HEADER, ROWS].concat();
    refused(&bench.replay("", &log), &["wheel"]);
    refused(
        &bench.replay(
            &CRAFT.replace(
                "[gyro]",
                "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n[gyro]",
            ),
            &log,
        ),
        &["wheel_2_rad_s"],
    );
}

#[test]
fn a_spoilt_craft_is_refused_by_key() {
    let bench = Bench::new();
    let log = [HEADER, ROWS].concat();
    let craft = |from: &str, to: &str| bench.replay(&CRAFT.replace(from, to), &log);
    refused(&craft("axis = [0, 0, 1]", "axis = [0, 0, 0]"), &["craft.toml:2", "axis"]);
    refused(&craft("noise_rad_s = 1e-4", "noise_rad_s = -1e-4"), &["craft.toml:5", "noise_rad_s"]);
    refused(&craft("noise_rad_s", "noise_rads"), &["craft.toml:5", "noise_rads", "noise_rad_s"]);
    refused(&craft("1e-3", "0"), &["craft.toml:3", "spin_inertia_kg_m2"]);
    let prior = "[prior]\ninertia_kg_m2 = [1, 1, 3, 0, 0, 0]\nsigma_kg_m2 = [1, 1, 1, 1, 1, 1]\n";
    refused(
        &bench.replay(&[CRAFT, prior].concat(), &log),
        &["craft.toml:7", "prior.inertia_kg_m2"],
    );
    refused(&bench.replay("[gyro\n", &log), &["craft.toml:1"]);
}

const SCENARIO: &str = "name = \"bench\"\nduration_s = 10.0\n[spacecraft]\n\
                        inertia_kg_m2 = [1, 1.1, 1.2, 0, 0, 0]\nrate_rad_s = [0.1, 0.2, 0.3]\n\
                        [gyro]\nrate_hz = 10.0\nnoise_rad_s = 1e-4\n";

#[test]
fn a_spoilt_scenario_is_refused_by_key() {
    let bench = Bench::new();
    assert!(bench.run(SCENARIO).status.success());
    let scenario = |from: &str, to: &str| bench.run(&SCENARIO.replace(from, to));
    refused(&scenario("duration_s", "durations"), &["scenario.toml:2", "durations", "duration_s"]);
    refused(&scenario("1e-4", "-1e-4"), &["scenario.toml:8", "noise_rad_s"]);
    refused(&scenario("[1, 1.1, 1.2, 0", "[1, 1.1, 3.2, 0"), &["scenario.toml:4", "inertia_kg_m2"]);
    refused(&scenario("10.0\n[", "-1\n["), &["scenario.toml:2", "duration_s"]);
    refused(&host_sim(&["run", "no-such-scenario"]), &["no-such-scenario", "stsat3-spin-up"]);
    refused(&host_sim(&["crlb", "missing.toml"]), &["missing.toml"]);
}

/// Three runs of each published table, on so many threads; the document, and the folder's tables.
fn tables_on(threads: &str, folder: &Path) -> (Value, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(["tables", "--runs", "3", "--seed", "5", "--json", "--out"])
        .arg(folder)
        .env("RAYON_NUM_THREADS", threads)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
    let text = fs::read_to_string(folder.join("tables.txt")).unwrap();
    (serde_json::from_slice(&output.stdout).unwrap(), text)
}

#[test]
fn tables_has_every_published_table_and_figure_on_any_number_of_cores() {
    let folder = TempDir::new().unwrap();
    let two = tables_on("2", &folder.path().join("two"));
    assert_eq!(two, tables_on("1", &folder.path().join("one")));
    let (report, text) = two;
    assert_eq!((&report["runs"], &report["seed"]), (&3.into(), &5.into()));
    let tables = report["tables"].as_array().unwrap();
    for (paper, table, count, rows) in [
        ("Kim2010", "2", 4, 6),
        ("Kim2010", "3", 4, 6),
        ("Kim2013", "slide 16", 1, 6),
        ("Kim2013", "slide 17", 1, 21),
        ("Kim2016", "5", 1, 15),
        ("Kim2016", "6", 1, 12),
        ("Bellar2019", "3", 1, 12),
        ("Bellar2019", "text", 6, 0),
        ("ElHariry2026", "rung 3", 3, 0),
    ] {
        let is_it = |t: &&Value| t["paper"] == paper && t["table"] == table;
        let found: Vec<&Value> = tables.iter().filter(is_it).collect();
        assert_eq!(found.len(), count, "{paper} {table}");
        for table in found {
            let found = table["rows"].as_array().unwrap();
            assert!(rows == 0 || found.len() == rows, "{table}");
            for row in found {
                let percentile = row["percentile"].as_f64().unwrap_or(50.0);
                assert!((0.0..=100.0).contains(&percentile), "{row}");
                assert!(row["quantity"].is_string() && row["unit"].is_string(), "{row}");
            }
        }
    }
    for line in text.lines() {
        assert!(line.chars().count() <= 100, "{line}");
    }
    for figure in [
        "kim-2010/figure-1.svg",
        "kim-2010/figure-4.svg",
        "kim-2013/slide-16-inertia.svg",
        "kim-2016/figure-1.svg",
        "kim-2016/figure-5.svg",
        "bellar-2019/figure-1.svg",
        "bellar-2019/figure-8.svg",
        "bellar-2019/tables.csv",
        "elhariry-2026/tables.csv",
    ] {
        assert!(folder.path().join("two").join(figure).is_file(), "{figure}");
    }
}

/// What the four formulas make of the slew is set by the slew, not by the noise.
#[test]
fn tables_reproduces_what_kim_2010_printed() {
    let folder = TempDir::new().unwrap();
    let (report, _) = tables_on("2", folder.path());
    let table = |estimator: &str| {
        let tables = report["tables"].as_array().unwrap();
        let is_it = |t: &&Value| t["table"] == "2" && t["estimator"] == estimator;
        tables.iter().find(is_it).unwrap().clone()
    };
    let conventional = table("momentum-conventional");
    assert_eq!(conventional["observed_directions"], 3);
    for (i, row) in conventional["rows"].as_array().unwrap().iter().enumerate() {
        let ratio = row["mean"].as_f64().unwrap() / row["published"].as_f64().unwrap();
        // Moments within 1.5 %, products within 2.5 %.
        let tolerance = if i < 3 { 0.015 } else { 0.025 };
        assert!((ratio - 1.0).abs() < tolerance, "{row}");
        assert!(row["own_mean"].is_null(), "an unseen element has no number: {row}");
    }
}

#[test]
fn a_flight_without_motion_is_reported_not_invented() {
    // A free body that doesn't even turn: no direction of the inertia can be seen.
    let still = SCENARIO.replace("[0.1, 0.2, 0.3]", "[0, 0, 0]");
    let bench = Bench::new();
    let path = bench.file("still.toml", &still);
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

#[test]
fn a_folder_that_cannot_be_written_is_a_failed_run() {
    let bench = Bench::new();
    let file = bench.file("taken", "");
    let output = host_sim(&["run", "cubesat-pyramid", "--out", text(&file)]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("taken"));
}

#[test]
fn misuse_is_told_in_two_lines() {
    let misuses: [(&[&str], &[&str]); 9] = [
        (&[], &["requires a subcommand", "run, mc,", "--help"]),
        (&["fly"], &["'fly'", "Usage: host-sim"]),
        (&["run", "--precision", "f16"], &["'f16'", "--precision", "f32, f64"]),
        (&["run", "--estimator", "windows"], &["'windows'", "tip", "'window'"]),
        (&["run", "--sed", "5"], &["'--sed'", "'--seed'", "Usage: host-sim run"]),
        (&["run", "a", "b"], &["'b'", "Usage: host-sim run"]),
        (&["replay", "log.csv"], &["--craft <CRAFT.toml>", "Usage: host-sim replay"]),
        (&["mc", "stsat3-spin-up", "--runs", "0"], &["'0'", "--runs", "--help"]),
        (&["tables", "--runs", "-1"], &["'-1'"]),
    ];
    for (arguments, named) in misuses {
        refused(&host_sim(arguments), named);
    }
    for asked in ["--help", "--version"] {
        let output = host_sim(&[asked]);
        assert!(output.status.success() && output.stderr.is_empty() && !output.stdout.is_empty());
    }
}

#[test]
#[cfg(unix)]
fn pil_refuses_what_the_image_cannot_fly_before_it_starts_one() {
    for (arguments, says) in [
        (&["pil", "nowhere"][..], "neither a file nor a built-in scenario"),
        (&["pil", "--estimator", "momentum-batch"], "invalid value 'momentum-batch'"),
        (&["pil", "microsat-slew", "--estimator", "ekf-sgf-rls"], "needs a nominal inertia"),
        (&["pil", "microsat-slew", "--restart-at", "1501"], "give one from 1 to 1500"),
    ] {
        let output = host_sim(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(says) && error.trim_end().lines().count() <= 2, "{error}");
    }
    let output = host_sim(&["pil", "--image", "no/such.elf"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.trim_end(), "error: no/such.elf: there is no such image");
}
