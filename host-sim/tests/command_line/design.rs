//! Designed manoeuvres: table, document, folder, trade, rejections.

use crate::program::{Files, host_sim, json, rejected, text};

/// A satellite at rest with three wheels.
const CRAFT: &str = "[gyro]\nnoise_rad_s = 1e-4\nscale_sigma = 0\naxes_sigma_deg = 0\ndelay_sigma_s = 0\n\
    [prior]\ninertia_kg_m2 = [0.26, 0.26, 0.16, 0, 0, 0]\nsigma_kg_m2 = [0.02, 0.02, 0.02, 0.01, 0.01, 0.01]\n\
    [[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-4\nmax_torque_n_m = 0.01\nmax_speed_rad_s = 460\n\
    [[wheel]]\naxis = [0, 1, 0]\nspin_inertia_kg_m2 = 1e-4\nmax_torque_n_m = 0.01\nmax_speed_rad_s = 460\n\
    [[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1e-4\nmax_torque_n_m = 0.01\nmax_speed_rad_s = 460\n";

#[test]
fn design_is_written_and_flies() {
    let files = Files::new();
    let craft = files.file("craft.toml", CRAFT);
    let folder = files.folder.path().join("out");
    let arguments =
        ["design", text(&craft), "--duration", "15", "--starts", "1", "--excursion", "2"];
    let design = json(&[&arguments[..], &["--json", "--out", text(&folder)]].concat());
    assert!(design["gain"].as_f64().unwrap() > 1.0);
    assert_eq!(design["torque_n_m"].as_array().unwrap().len(), 151);
    for name in [
        "report.html",
        "result.json",
        "torque.csv",
        "spline.csv",
        "telecommands.csv",
        "series.csv",
        "series-standard.csv",
    ] {
        assert!(folder.join(name).metadata().unwrap().len() > 0, "{name}");
    }
    let scenario = folder.join("scenario.toml");
    let crlb = json(&["crlb", text(&scenario), "--json"]);
    assert_eq!(crlb["observed_directions"], 6);
    let run = json(&["run", text(&scenario), "--json"]);
    assert_eq!(run["notes"].as_array().unwrap().len(), 0, "{}", run["notes"]);
    assert_eq!(run["status"], "converged");
}

#[test]
fn trade_has_a_row_for_each_value() {
    let files = Files::new();
    let craft = files.file("craft.toml", CRAFT);
    let folder = files.folder.path().join("out");
    let trade = json(&[
        "design",
        text(&craft),
        "--duration",
        "10",
        "--starts",
        "1",
        "--trade",
        "excursion",
        "--range",
        "0.5..5deg",
        "--points",
        "2",
        "--json",
        "--out",
        text(&folder),
    ]);
    let rows = trade["rows"].as_array().unwrap();
    let sigma = |row: usize| rows[row]["sigma_percent"].as_f64().unwrap();
    assert_eq!(rows.len(), 2);
    assert!(sigma(0) > sigma(1));
    let csv = std::fs::read_to_string(folder.join("trade.csv")).unwrap();
    assert_eq!(csv.lines().count(), 3);
}

#[test]
fn unsuitable_input_is_rejected() {
    let files = Files::new();
    let craft = |text: &str| files.file("craft.toml", text);
    let design =
        |file: &std::path::Path, more: &[&str]| host_sim(&[&["design", text(file)], more].concat());
    let file = craft(&CRAFT.replace("max_torque_n_m = 0.01\n", ""));
    rejected(&design(&file, &[]), &["craft", "wheel[1]", "max_torque_n_m"]);
    let file = craft("[gyro]\nnoise_rad_s = 1e-4\n");
    rejected(&design(&file, &[]), &["craft.toml", "[prior]"]);
    let file = craft(CRAFT);
    rejected(
        &design(&file, &["--keep-out", "0,0,1:1,0"]),
        &["--keep-out", "BORESIGHT:DIRECTION:DEG"],
    );
    rejected(
        &design(&file, &["--keep-out", "0,0,1:0,0,1:20"]),
        &["keep-out cone 1", "another attitude"],
    );
    rejected(&design(&file, &["--excursion", "0"]), &["--excursion"]);
    rejected(&design(&file, &["--duration", "2"]), &["20 samples", "--duration"]);
    rejected(&design(&file, &["--trade", "noise", "--range", "1"]), &["FROM..TO"]);
}
