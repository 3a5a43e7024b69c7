//! The report of each verb.

use std::path::Path;
use std::process::Command;

use tests::program::repository;

use super::browser::{self, Browser, Found};

const HOST_SIM: &str = env!("CARGO_BIN_EXE_host-sim-for-tests");

/// Widths of a phone and of a desk, px.
const WIDTHS: [u32; 2] = [390, 1280];
/// Fewest painted pixels of a plot: a thin line over half the plot of a phone.
const FEWEST_PIXELS: u64 = 150;

/// Runs `host-sim` with these arguments and a folder for `--out`.
fn report(arguments: &[&str], folder: &Path) {
    let output = Command::new(HOST_SIM).args(arguments).arg("--out").arg(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Opens the report of a folder at every width and in both schemes. Output: the last one.
fn checked(folder: &Path) -> Option<Found> {
    let browser = Browser::find()?;
    let mut last = None;
    let mut grounds = Vec::new();
    for width in WIDTHS {
        for is_dark in [false, true] {
            let found = browser.open(folder, width, is_dark);
            let case = format!("{}, {width} px, dark {is_dark}", folder.display());
            assert_eq!((found.width, found.is_dark), (width, is_dark), "{case}");
            assert_eq!(found.page_width, width, "{case}: wider than the page");
            assert!(found.errors.is_empty() && found.requests.is_empty(), "{case}: {found:?}");
            assert!(!found.verdict.is_empty() && !found.figures.is_empty(), "{case}");
            found.figures.iter().for_each(|figure| check_figure(figure, &case));
            grounds.push(found.ground.clone());
            last = Some(found);
        }
    }
    assert_ne!(grounds[0], grounds[1], "the schemes have different grounds");
    last
}

fn check_figure(figure: &browser::Figure, case: &str) {
    assert!(!figure.panels.is_empty(), "{case}: {} has no panel", figure.name);
    for panel in &figure.panels {
        let case = format!("{case}: {}, {}: {panel:?}", figure.name, panel.label);
        assert!(panel.painted > FEWEST_PIXELS, "{case}: empty");
        assert!(
            panel.values.iter().skip(1).any(|value| !value.is_empty()) || is_gap(figure),
            "{case}: no value on hover"
        );
        assert!(panel.zoomed && panel.returned, "{case}: no zoom");
    }
}

/// Bars by category have no value between them.
fn is_gap(figure: &browser::Figure) -> bool {
    figure.name == "data/hardware"
}

fn names(found: &Found) -> Vec<&str> {
    found.figures.iter().map(|figure| figure.name.as_str()).collect()
}

#[test]
fn flight_with_stated_hardware() {
    let folder = tempfile::tempdir().unwrap();
    report(&["run", "cubesat-pyramid-data-sheet"], folder.path());
    let Some(found) = checked(folder.path()) else { return };
    let expected = [
        "data/inertia",
        "data/sigma",
        "data/hardware",
        "data/innovations",
        "data/rates",
        "data/rate-errors",
        "data/wheel-speeds",
        "data/control-torque",
        "data/attitude",
    ];
    assert_eq!(names(&found), expected);
    assert!(found.verdict.contains("limited by"), "{}", found.verdict);
}

#[test]
fn flight_of_a_filter_with_accelerations_and_its_replay() {
    let folder = tempfile::tempdir().unwrap();
    let (flown, replayed) = (folder.path().join("flown"), folder.path().join("replayed"));
    report(&["run", "kim-2016", "--estimator", "ekf-sgf-lls"], &flown);
    let (craft, log) = (flown.join("craft.toml"), flown.join("log.csv"));
    let (craft, log) = (craft.to_str().unwrap(), log.to_str().unwrap());
    report(&["replay", "--estimator", "joint-ekf", "--craft", craft, log], &replayed);
    let Some(found) = checked(&flown) else { return };
    assert!(names(&found).contains(&"data/accelerations"));
    let Some(found) = checked(&replayed) else { return };
    assert_eq!(names(&found), ["data/inertia", "data/sigma", "data/innovations", "data/rates"]);
}

#[test]
fn overview_of_several_results() {
    let folder = tempfile::tempdir().unwrap();
    let (flown, replayed) = (folder.path().join("flown"), folder.path().join("replayed"));
    report(&["run", "cubesat-pyramid"], &flown);
    let (craft, log) = (flown.join("craft.toml"), flown.join("log.csv"));
    let (craft, log) = (craft.to_str().unwrap(), log.to_str().unwrap());
    let both = ["--estimator", "window", "--estimator", "joint-ekf"];
    report(&[&["replay", "--craft", craft, log], &both[..]].concat(), &replayed);
    assert!(replayed.join("log/joint-ekf/report.html").is_file());
    let Some(found) = checked(&replayed) else { return };
    assert_eq!(names(&found), ["data/elements"]);
    assert_eq!(found.verdict, "2 converged.");
}

#[test]
fn campaign() {
    let folder = tempfile::tempdir().unwrap();
    report(&["mc", "cubesat-pyramid", "--runs", "40"], folder.path());
    let Some(found) = checked(folder.path()) else { return };
    assert_eq!(names(&found), ["data/error-over-bound", "data/error-over-sigma", "data/nees"]);
}

#[test]
fn design_and_trade() {
    let folder = tempfile::tempdir().unwrap();
    let (design, trade) = (folder.path().join("design"), folder.path().join("trade"));
    let craft = repository().join("host-sim/templates/craft-12u.toml");
    let of = ["design", craft.to_str().unwrap(), "--duration", "15", "--starts", "1"];
    report(&of, &design);
    report(
        &[&of[..], &["--trade", "excursion", "--range", "1..4", "--points", "2"]].concat(),
        &trade,
    );
    let Some(found) = checked(&design) else { return };
    assert_eq!(names(&found), ["data/sigma", "data/wheels", "data/body"]);
    assert!(found.verdict.contains("times better than"), "{}", found.verdict);
    let Some(found) = checked(&trade) else { return };
    assert_eq!(names(&found), ["data/trade"]);
}

#[test]
fn faults() {
    let folder = tempfile::tempdir().unwrap();
    report(&["faults", "--runs", "1", "--fault", "gyro"], folder.path());
    let Some(found) = checked(folder.path()) else { return };
    assert_eq!(names(&found), ["data/outcomes", "data/errors"]);
}

#[test]
fn papers() {
    let folder = tempfile::tempdir().unwrap();
    report(&["tables", "--runs", "3"], folder.path());
    let Some(found) = checked(folder.path()) else { return };
    assert_eq!(found.figures.len(), 23);
}
