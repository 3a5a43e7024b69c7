//! `diagnose`, the explanations of `replay`, and the systematic part of its sigma.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json as value};
use tempfile::TempDir;

use crate::program::{CRAFT, Files, HEADER, host_sim, json, rejected, text};

/// A flight of `cubesat-pyramid`, and a craft file with another text in it.
struct Flown {
    folder: TempDir,
    craft: PathBuf,
    log: PathBuf,
}

impl Flown {
    fn with_craft(change: impl Fn(&str) -> String) -> Self {
        let folder = TempDir::new().unwrap();
        json(&["run", "cubesat-pyramid", "--json", "--out", text(folder.path())]);
        let (craft, log) = (folder.path().join("craft.toml"), folder.path().join("log.csv"));
        fs::write(&craft, change(&fs::read_to_string(&craft).unwrap())).unwrap();
        Self { folder, craft, log }
    }

    fn json(&self, verb: &str) -> Value {
        json(&[verb, "--json", "--craft", text(&self.craft), text(&self.log)])
    }
}

fn with_first_axis_reversed(craft: &str) -> String {
    let axis = "[0.5773502691896258, 0.5773502691896258, 0.5773502691896258]";
    assert!(craft.contains(axis));
    craft.replacen(axis, "[-1.0, -1.0, -1.0]", 1)
}

#[test]
fn reversed_wheel_is_the_first_explanation_of_diagnose_and_replay() {
    let flown = Flown::with_craft(with_first_axis_reversed);
    let found = flown.json("diagnose");
    let first = &found["explanations"][0];
    assert_eq!(first["name"], "sign of wheel 1");
    assert_eq!(first["remedy"], "negate axis of [[wheel]] 1");
    assert!(first["value"].is_null() && first["sigma"].is_null() && first["unit"] == "");
    assert!(first["share_explained"].as_f64().unwrap() > 0.999);
    assert!(first["chi_square"].as_f64().unwrap() > 1e6);
    assert!(first["indistinguishable_from"].is_array());

    let replayed = flown.json("replay");
    assert_eq!(replayed["explanations"][0]["name"], "sign of wheel 1");
    let table = host_sim(&["replay", "--craft", text(&flown.craft), text(&flown.log)]);
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(table.contains("sign of wheel 1: negate axis of [[wheel]] 1\n"), "{table}");
    assert!(flown.folder.path().is_dir());
}

#[test]
fn healthy_log_has_no_explanation() {
    let flown = Flown::with_craft(str::to_owned);
    assert_eq!(flown.json("diagnose")["explanations"], value!([]));
    assert_eq!(flown.json("replay")["explanations"], value!([]));
}

#[test]
fn log_too_short_for_a_diagnosis_is_rejected() {
    let files = Files::new();
    let craft = files.file("craft.toml", CRAFT);
    let rows: String = (0..10).map(|row| format!("0.{row},0.1,0.2,0.{row},100\n")).collect();
    let log = files.file("log.csv", &format!("{HEADER}{rows}"));
    let output = host_sim(&["diagnose", "--craft", text(&craft), text(&log)]);
    rejected(&output, &["log.csv", "10 rows are too few for a diagnosis"]);
}

/// Data-sheet values where the craft file states nothing: the systematic part is two orders above the noise.
#[test]
fn unstated_hardware_is_assumed_named_and_part_of_the_sigma() {
    let is_statement = |line: &&str| !line.contains("sigma") && !line.contains("tolerance");
    let flown = Flown::with_craft(|craft| {
        craft.lines().filter(is_statement).map(|line| format!("{line}\n")).collect()
    });
    let found = flown.json("replay");
    assert_eq!(found["largest_systematic"], "wheel spin inertia");
    for i in 0..6 {
        let of = |name: &str| found[name][i].as_f64().unwrap();
        let (random, systematic) = (of("sigma_random_kg_m2"), of("sigma_systematic_kg_m2"));
        assert!((of("sigma_kg_m2") - random.hypot(systematic)).abs() < 1e-6 * of("sigma_kg_m2"));
        assert!(systematic > 10.0 * random, "{i}: {systematic} {random}");
    }
    let hardware = found["hardware"].as_array().unwrap();
    let wheel = hardware.iter().find(|p| p["name"] == "wheel spin inertia 2").unwrap();
    assert_eq!((&wheel["assumed"], &wheel["unit"]), (&value!(true), &value!("")));
    assert!((wheel["stated"].as_f64().unwrap() - 0.01).abs() < 1e-6);
    let notes = found["notes"].to_string();
    assert!(notes.contains("assumed: gyro.scale_sigma 0.005,"), "{notes}");
    assert!(notes.contains("zero included"), "{notes}");

    let table = host_sim(&["replay", "--craft", text(&flown.craft), text(&flown.log)]);
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(table.contains("systematic          scale to 0.5"), "{table}");
    assert!(table.contains(": wheel spin inertia, assumed 1 %\n"), "{table}");
    assert!(table.contains("\nsolved "), "{table}");
}
