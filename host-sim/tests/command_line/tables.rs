//! `tables`: published tables beside reproduced ones.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// Three runs on this number of threads. Output: the document, and the text of the folder.
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

/// Paper, table, number of tables, and number of rows; zero rows are not checked.
const TABLES: [(&str, &str, usize, usize); 9] = [
    ("Kim2010", "2", 4, 6),
    ("Kim2010", "3", 4, 6),
    ("Kim2013", "slide 16", 1, 6),
    ("Kim2013", "slide 17", 1, 21),
    ("Kim2016", "5", 1, 15),
    ("Kim2016", "6", 1, 12),
    ("Bellar2019", "3", 1, 12),
    ("Bellar2019", "text", 6, 0),
    ("ElHariry2026", "rung 3", 3, 0),
];

/// Some files of the output folder.
const FILES: [&str; 10] = [
    "report.html",
    "kim-2010/figure-1.csv",
    "kim-2010/figure-4.csv",
    "kim-2013/slide-16-inertia.csv",
    "kim-2016/figure-1.csv",
    "kim-2016/figure-5.csv",
    "bellar-2019/figure-1.csv",
    "bellar-2019/figure-8.csv",
    "bellar-2019/tables.csv",
    "elhariry-2026/tables.csv",
];

/// Longest line of the text, characters.
const WIDTH: usize = 100;

#[test]
fn every_published_table_and_figure_is_reproduced_on_any_number_of_cores() {
    let folder = TempDir::new().unwrap();
    let two = tables_on("2", &folder.path().join("two"));
    assert_eq!(two, tables_on("1", &folder.path().join("one")));
    let (report, text) = two;
    assert_eq!((&report["runs"], &report["seed"]), (&3.into(), &5.into()));
    let tables = report["tables"].as_array().unwrap();
    for (paper, table, count, rows) in TABLES {
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
        assert!(line.chars().count() <= WIDTH, "{line}");
    }
    for file in FILES {
        assert!(folder.path().join("two").join(file).is_file(), "{file}");
    }
}

/// The slew determines the estimates of the four formulas; the noise has little influence.
#[test]
fn conventional_column_of_kim_2010_is_reproduced() {
    /// Difference from the published estimates, share: moments, products.
    const TOLERANCE: [f64; 2] = [0.015, 0.025];
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
        let tolerance = TOLERANCE[usize::from(i >= 3)];
        assert!((ratio - 1.0).abs() < tolerance, "{row}");
        assert!(row["own_mean"].is_null(), "an unobserved element has no value: {row}");
    }
}
