//! Rejected files and arguments. Each error names the file, line or key, and the remedy.

use crate::program::{CRAFT, Files, HEADER, ROWS, SCENARIO, host_sim, rejected, text};

#[test]
fn valid_craft_and_log_are_accepted() {
    let output = Files::new().replay(CRAFT, &[HEADER, ROWS].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn invalid_log_is_rejected_with_line_and_column() {
    let files = Files::new();
    let log = |text: &str| files.replay(CRAFT, text);
    let rows = |rows: &str| files.replay(CRAFT, &[HEADER, rows].concat());
    rejected(&log(""), &["log.csv", "empty"]);
    rejected(
        &log("t_s,gyro_x_rad_s,gyro_z_rad_s,wheel_1_rad_s\n0,1,2,3\n"),
        &["log.csv", "gyro_y_rad_s"],
    );
    rejected(&log(HEADER), &["log.csv"]);
    rejected(&rows("0,0.1,zero,0.3,100\n"), &["log.csv:2", "gyro_y_rad_s", "zero"]);
    rejected(&rows("0,0.1,NaN,0.3,100\n"), &["log.csv:2", "gyro_y_rad_s", "NaN"]);
    rejected(&rows("0,0.1,inf,0.3,100\n"), &["log.csv:2", "gyro_y_rad_s", "inf"]);
    rejected(&rows("0,0.1,,0.3,100\n"), &["log.csv:2", "gyro_y_rad_s", "empty"]);
    rejected(&rows("0.1,1,2,3,100\n0,1,2,3,101\n"), &["log.csv:3", "t_s"]);
    rejected(&rows("0.1,1,2,3,100\n0.1,1,2,3,101\n"), &["log.csv:3", "t_s"]);
    rejected(&rows("0.1,1,2"), &["log.csv:2", "cut"]);
    rejected(&rows("0,1,2\n0.1,1,2\n"), &["log.csv:2"]);
    rejected(&log(ROWS), &["log.csv:1", "numbers only", "t_s,gyro_x_rad_s"]);
    let same_stamps: String = (0..20).map(|i| format!("1.73e+09,0.1,{i},0.3,100\n")).collect();
    rejected(&rows(&same_stamps), &["log.csv:3", "too few digits", "19 of 20 rows"]);
}

#[test]
fn log_with_other_wheels_than_the_craft_is_rejected() {
    let files = Files::new();
    let log = [HEADER, ROWS].concat();
    rejected(&files.replay("", &log), &["wheel"]);
    rejected(
        &files.replay(
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
fn invalid_craft_is_rejected_with_line_and_key() {
    let files = Files::new();
    let log = [HEADER, ROWS].concat();
    let craft = |from: &str, to: &str| files.replay(&CRAFT.replace(from, to), &log);
    rejected(&craft("axis = [0, 0, 1]", "axis = [0, 0, 0]"), &["craft.toml:2", "axis"]);
    rejected(&craft("noise_rad_s = 1e-4", "noise_rad_s = -1e-4"), &["craft.toml:5", "noise_rad_s"]);
    rejected(&craft("noise_rad_s", "noise_rads"), &["craft.toml:5", "noise_rads", "noise_rad_s"]);
    rejected(&craft("1e-3", "0"), &["craft.toml:3", "spin_inertia_kg_m2"]);
    let prior = "[prior]\ninertia_kg_m2 = [1, 1, 3, 0, 0, 0]\nsigma_kg_m2 = [1, 1, 1, 1, 1, 1]\n";
    rejected(
        &files.replay(&[CRAFT, prior].concat(), &log),
        &["craft.toml:7", "prior.inertia_kg_m2"],
    );
    rejected(&files.replay("[gyro\n", &log), &["craft.toml:1"]);
}

#[test]
fn invalid_scenario_is_rejected_with_line_and_key() {
    let files = Files::new();
    assert!(files.run(SCENARIO).status.success());
    let scenario = |from: &str, to: &str| files.run(&SCENARIO.replace(from, to));
    rejected(&scenario("duration_s", "durations"), &["scenario.toml:2", "durations", "duration_s"]);
    rejected(&scenario("1e-4", "-1e-4"), &["scenario.toml:8", "noise_rad_s"]);
    rejected(
        &scenario("[1, 1.1, 1.2, 0", "[1, 1.1, 3.2, 0"),
        &["scenario.toml:4", "inertia_kg_m2"],
    );
    rejected(&scenario("10.0\n[", "-1\n["), &["scenario.toml:2", "duration_s"]);
    rejected(&host_sim(&["run", "no-such-scenario"]), &["no-such-scenario", "stsat3-spin-up"]);
    rejected(&host_sim(&["crlb", "missing.toml"]), &["missing.toml"]);
}

#[test]
fn output_folder_that_cannot_be_written_is_a_failure() {
    let files = Files::new();
    let file = files.file("existing", "");
    let output = host_sim(&["run", "cubesat-pyramid", "--out", text(&file)]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("existing"));
}

#[test]
fn wrong_arguments_are_rejected_in_at_most_two_lines() {
    let wrong: [(&[&str], &[&str]); 9] = [
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
    for (arguments, named) in wrong {
        rejected(&host_sim(arguments), named);
    }
    for flag in ["--help", "--version"] {
        let output = host_sim(&[flag]);
        assert!(output.status.success() && output.stderr.is_empty() && !output.stdout.is_empty());
    }
}

#[test]
#[cfg(unix)]
fn mission_that_the_image_cannot_fly_is_rejected() {
    for (arguments, reason) in [
        (&["pil", "nowhere"][..], "neither a file nor a built-in scenario"),
        (&["pil", "--estimator", "momentum-batch"], "invalid value 'momentum-batch'"),
        (&["pil", "microsat-slew", "--estimator", "ekf-sgf-rls"], "needs a nominal inertia"),
        (&["pil", "microsat-slew", "--restart-at", "1501"], "give one from 1 to 1500"),
    ] {
        let output = host_sim(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(reason) && error.trim_end().lines().count() <= 2, "{error}");
    }
    let output = host_sim(&["pil", "--image", "no/such.elf"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.trim_end(), "error: no/such.elf: no such image");
}
