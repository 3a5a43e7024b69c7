//! Logs as users have them: rows at fault, other notations, other units, a gyro slower than the log.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::program::{Files, host_sim, json as document, text};

/// A simulated flight of the CubeSat with its wheels, as `replay` reads it.
struct Flight {
    files: Files,
    log: String,
    clean: Value,
}

/// Result of a log of that flight.
struct Replayed {
    report: Value,
    notes: String,
}

impl Flight {
    fn new() -> Self {
        let files = Files::new();
        let folder = files.folder.path().join("clean");
        document(&["run", "cubesat-pyramid", "--json", "--out", text(&folder)]);
        let log = fs::read_to_string(folder.join("log.csv")).unwrap();
        let clean = replay(&folder.join("craft.toml"), &folder.join("log.csv")).report;
        Self { files, log, clean }
    }

    fn craft(&self) -> PathBuf {
        self.files.folder.path().join("clean/craft.toml")
    }

    fn replay(&self, log: &str) -> Replayed {
        replay(&self.craft(), &self.files.file("log.csv", log))
    }

    /// Log with each row changed: row number from zero, and cells.
    fn with_rows(&self, change: impl Fn(usize, &mut Vec<String>)) -> String {
        let mut lines = self.log.lines();
        let header = lines.next().unwrap().to_owned();
        let rows = lines.enumerate().map(|(index, row)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            change(index, &mut cells);
            cells.join(",")
        });
        [header].into_iter().chain(rows).map(|line| line + "\n").collect()
    }

    /// Requires the inertia of the clean log, within `sigmas` of each element's sigma.
    fn assert_same_inertia(&self, replayed: &Replayed, sigmas: f64) {
        let number = |report: &Value, key: &str, i: usize| report[key][i].as_f64().unwrap();
        assert_eq!(replayed.report["status"], "converged", "{}", replayed.report);
        for i in 0..3 {
            let moment = |report: &Value| report["inertia_kg_m2"][i][i].as_f64().unwrap();
            let difference = moment(&replayed.report) - moment(&self.clean);
            let sigma = number(&replayed.report, "sigma_kg_m2", i);
            assert!(difference.abs() <= sigmas * sigma, "moment {i}: {difference} {sigma}");
        }
    }
}

fn replay(craft: &Path, log: &Path) -> Replayed {
    let output = host_sim(&["replay", "--json", "--craft", text(craft), text(log)]);
    let notes = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{notes}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let listed = report["notes"].as_array().unwrap().iter();
    let printed: String =
        listed.map(|note| format!("note: {}\n", note.as_str().unwrap())).collect();
    assert_eq!(printed, notes, "the notes of the document are those of stderr");
    Replayed { report, notes }
}

#[test]
fn other_notations_of_the_same_log_give_the_same_result() {
    let flight = Flight::new();
    let (header, rows) = flight.log.split_once('\n').unwrap();
    for log in [
        format!("# exported by a tool\n# at 5 °C\n{header}\n# first row\n{rows}"),
        format!("sep=,\n{header}\n{rows}"),
        format!("# {header}\n{rows}"),
        flight.log.replace('\n', ",\n"),
        flight.log.replace('\n', "\r\n"),
        flight.log.trim_end().to_owned(),
    ] {
        let replayed = flight.replay(&log);
        assert_eq!(replayed.report, flight.clean);
        assert_eq!(replayed.notes, "");
    }
}

#[test]
fn rows_at_fault_are_skipped_counted_and_named() {
    let flight = Flight::new();
    let damaged = flight.with_rows(|index, cells| match index {
        100 => cells[2] = "NaN".to_owned(),
        200 => cells[3] = String::new(),
        300 => cells[0] = "86430".to_owned(),
        _ => (),
    });
    let cut = &damaged[..damaged.len() - 60];
    let replayed = flight.replay(&(cut.to_owned() + "\0\0\0\0\0\0"));
    let expected = json!({ "empty_cell": 1, "incomplete": 1, "not_finite": 1, "time_ahead": 1 });
    assert_eq!(replayed.report["skipped_rows"], expected);
    let note = "log.csv: 4 rows skipped: line 102: column `gyro_y_rad_s`: NaN is not a finite \
                number; line 202: column `gyro_z_rad_s` is empty; line 302: column `t_s`: 86430 is \
                ahead of the following rows; …\n";
    assert!(replayed.notes.ends_with(note), "{}", replayed.notes);
    flight.assert_same_inertia(&replayed, 1.0);
}

#[test]
fn time_since_1970_in_nanoseconds_gives_the_same_bits() {
    let flight = Flight::new();
    let log = flight.with_rows(|_, cells| {
        let tenths: f64 = cells[0].parse().unwrap();
        cells[0] = format!("1700000{:012}", (tenths * 10.0).round() as u64 * 100_000_000);
    });
    let replayed = flight.replay(&log);
    assert_eq!(replayed.report["inertia_kg_m2"], flight.clean["inertia_kg_m2"]);
    let note = "log.csv:2: column `t_s`: 1700000000000000000 is read as nanoseconds since 1970";
    assert!(replayed.notes.contains(note), "{}", replayed.notes);
}

#[test]
fn units_that_are_not_si_are_named() {
    let flight = Flight::new();
    let degrees = flight.with_rows(|_, cells| {
        for cell in &mut cells[1..4] {
            *cell = format!("{:?}", cell.parse::<f64>().unwrap().to_degrees());
        }
    });
    let degrees = flight.replay(&degrees);
    assert!(degrees.notes.contains("log.csv: rates look like deg/s: "), "{}", degrees.notes);
    assert!(degrees.notes.contains("state unit = \"deg/s\" in [log.gyro]"), "{}", degrees.notes);
    let milliseconds = flight.with_rows(|index, cells| cells[0] = (100 * index).to_string());
    let milliseconds = flight.replay(&milliseconds).notes;
    let note = "log.csv: median step 100 s: time looks like milliseconds: ";
    assert!(milliseconds.contains(note), "{milliseconds}");
}

#[test]
fn gyro_slower_than_the_log_is_read_at_its_own_rate() {
    let flight = Flight::new();
    let rows: Vec<&str> = flight.log.lines().skip(1).collect();
    let held = flight.with_rows(|index, cells| {
        let reading: Vec<&str> = rows[index - index % 5].split(',').collect();
        cells[1..4].iter_mut().zip(&reading[1..4]).for_each(|(cell, held)| *cell = (*held).into());
    });
    let replayed = flight.replay(&held);
    let note = "log.csv: the gyro's rate is 2 Hz, the log's 10 Hz: the 480 rows that repeat a reading \
                are left out\n";
    assert!(replayed.notes.ends_with(note), "{}", replayed.notes);
    assert_eq!(replayed.report["skipped_rows"], json!({ "gyro_held": 480 }));
    assert_eq!(replayed.report["samples"], 121);
    flight.assert_same_inertia(&replayed, 3.0);
}
