//! `mc --shard` and `merge`: a campaign in parts.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{host_sim, rejected, text};

/// A campaign, and the folder of its shards.
struct Campaign {
    folder: TempDir,
    arguments: Vec<String>,
}

impl Campaign {
    fn new(arguments: &str) -> Self {
        let arguments = arguments.split_whitespace().map(str::to_owned).collect();
        Self { folder: TempDir::new().unwrap(), arguments }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `mc` with further arguments.
    fn fly(&self, more: &[&str]) -> Output {
        let mut arguments = vec!["mc"];
        arguments.extend(self.arguments.iter().map(String::as_str));
        arguments.extend(more);
        host_sim(&arguments)
    }

    fn fly_shard(&self, number: usize, count: usize) -> PathBuf {
        let file = self.path(&format!("{number}-of-{count}.parquet"));
        let shard = format!("{number}/{count}");
        let output = self.fly(&["--shard", &shard, "--out", text(&file)]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        file
    }

    fn fly_shards(&self, count: usize) -> Vec<PathBuf> {
        (1..=count).map(|number| self.fly_shard(number, count)).collect()
    }
}

fn merge(files: &[PathBuf], more: &[&str]) -> Output {
    let mut arguments = vec!["merge"];
    arguments.extend(files.iter().map(|file| text(file)));
    arguments.extend(more);
    host_sim(&arguments)
}

/// Table, document and every file of the folder, CSV and Parquet of a merge.
fn results(campaign: &Campaign, files: &[PathBuf], name: &str) -> Vec<(String, Vec<u8>)> {
    let (folder, csv) = (campaign.path(name), campaign.path(&format!("{name}.csv")));
    let parquet = campaign.path(&format!("{name}.parquet"));
    let mut all = Vec::new();
    for (kind, more) in [
        ("table", vec![]),
        ("json", vec!["--json"]),
        ("folder", vec!["--out", text(&folder)]),
        ("csv", vec!["--out", text(&csv)]),
        ("parquet", vec!["--out", text(&parquet)]),
    ] {
        let output = merge(files, &more);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        all.push((kind.to_owned(), output.stdout));
    }
    for file in [csv, parquet] {
        all.push((file.extension().unwrap().to_string_lossy().into(), fs::read(&file).unwrap()));
    }
    add_files(&folder, &folder, &mut all);
    all.sort();
    all
}

fn add_files(root: &Path, folder: &Path, all: &mut Vec<(String, Vec<u8>)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            add_files(root, &path, all);
        } else {
            let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
            all.push((name, fs::read(&path).unwrap()));
        }
    }
}

fn without_times(stdout: &[u8]) -> Value {
    let mut report: Value = serde_json::from_slice(stdout).unwrap();
    for time in ["wall_s", "steps_per_s_per_core"] {
        assert!(report.as_object_mut().unwrap().remove(time).is_some(), "{time}");
    }
    report
}

fn without_speed(table: &[u8]) -> Vec<String> {
    let lines = String::from_utf8(table.to_vec()).unwrap();
    lines.lines().filter(|line| !line.starts_with("speed")).map(str::to_owned).collect()
}

#[test]
fn merged_report_is_that_of_one_process_for_any_number_of_shards() {
    let campaign = Campaign::new("cubesat-pyramid --runs 70 --seed 9 --estimator joint-ekf");
    let (one, csv) = (campaign.path("one.parquet"), campaign.path("one.csv"));
    let document = campaign.fly(&["--json", "--out", text(&one)]).stdout;
    let table = campaign.fly(&["--out", text(&csv)]).stdout;
    let expected = results(&campaign, std::slice::from_ref(&one), "merged-of-1");
    let found = |kind: &str| &expected.iter().find(|(name, _)| name == kind).unwrap().1;
    assert_eq!(without_times(found("json")), without_times(&document));
    assert_eq!(without_speed(found("table")), without_speed(&table));
    assert_eq!(*found("csv"), fs::read(&csv).unwrap());
    assert_eq!(*found("parquet"), fs::read(&one).unwrap());
    for name in ["report.html", "scenario/scenario.toml", "data/nees.csv", "runs.parquet"] {
        assert!(expected.iter().any(|(found, _)| found == name), "{name}");
    }
    for count in [1, 7, 64] {
        let mut files = campaign.fly_shards(count);
        // An order far from that of the runs.
        files.reverse();
        files.rotate_left(count / 3);
        let merged = results(&campaign, &files, &format!("merged-of-{count}-shards"));
        for (expected, found) in expected.iter().zip(&merged) {
            assert!(expected == found, "{} of {count} shards", expected.0);
        }
        assert_eq!(expected.len(), merged.len());
    }
}

#[test]
fn rows_have_the_drawn_values_and_survive_the_merge() {
    for arguments in [
        "random-spacecraft --runs 12 --estimator joint-ekf",
        "cubesat-pyramid-data-sheet --runs 4 --estimator joint-ekf --precision f64",
        "bellar-2019-campaign --runs 6 --estimator joint-ekf-published",
    ] {
        let campaign = Campaign::new(arguments);
        let csv = campaign.path("one.csv");
        let one = campaign.fly(&["--json", "--out", text(&csv)]);
        let files = campaign.fly_shards(3);
        let merged = campaign.path("merged.csv");
        let report = merge(&files, &["--json", "--out", text(&merged)]);
        assert_eq!(without_times(&report.stdout), without_times(&one.stdout));
        let rows = fs::read_to_string(&csv).unwrap();
        assert_eq!(rows, fs::read_to_string(&merged).unwrap());
        assert!(rows.lines().next().unwrap().contains(",drawn_"), "{rows}");
    }
}

#[test]
fn repeated_shard_is_the_same_file_and_counts_once() {
    let campaign = Campaign::new("cubesat-pyramid --runs 9 --estimator joint-ekf");
    let mut files = campaign.fly_shards(3);
    let expected = merge(&files, &["--json"]).stdout;
    let again = campaign.path("again.parquet");
    fs::copy(&files[1], &again).unwrap();
    campaign.fly_shard(2, 3);
    assert!(fs::read(&again).unwrap() == fs::read(&files[1]).unwrap());
    files.push(again.clone());
    assert_eq!(merge(&files, &["--json"]).stdout, expected);

    // One bit of another number.
    let mut bytes = fs::read(&files[1]).unwrap();
    bytes[40] ^= 1;
    fs::write(&again, bytes).unwrap();
    rejected(&merge(&files, &[]), &["again.parquet: shard 2 differs from that in ", "2-of-3"]);
}

#[test]
fn files_that_are_not_all_shards_of_one_campaign_are_refused() {
    let campaign = Campaign::new("cubesat-pyramid --runs 12 --estimator joint-ekf");
    let files = campaign.fly_shards(12);
    let few: Vec<PathBuf> = [&files[0], &files[2], &files[7], &files[6]].map(Clone::clone).into();
    rejected(&merge(&few, &[]), &["shards 2, 4 to 6, 9 to 12 of 12 are missing", "--shard I/12"]);

    for (more, property) in [
        ("cubesat-pyramid --runs 12 --estimator momentum-batch", "estimator is momentum-batch"),
        ("cubesat-pyramid --runs 12 --estimator joint-ekf --precision f64", "precision is f64"),
        ("cubesat-pyramid --runs 12 --estimator joint-ekf --seed 1", "seed is 1"),
        ("cubesat-pyramid --runs 13 --estimator joint-ekf", "number of runs is 13"),
        ("stsat3-spin-up --runs 12 --estimator joint-ekf", "scenario is stsat3-spin-up"),
    ] {
        let other = Campaign::new(more);
        let mut mixed = files[..11].to_vec();
        mixed.push(other.fly_shard(12, 12));
        rejected(&merge(&mixed, &[]), &["12-of-12.parquet: ", property, "11-of-12.parquet"]);
    }
    let other = Campaign::new("cubesat-pyramid --runs 12 --estimator joint-ekf");
    rejected(&merge(&[files[0].clone(), other.fly_shard(2, 6)], &[]), &["number of shards is 6"]);

    // A scenario of the same name with another number.
    let text_of = fs::read_to_string("scenarios/cubesat-pyramid.toml").unwrap();
    let changed = campaign.path("changed.toml");
    fs::write(&changed, text_of.replacen("duration_s = ", "duration_s = 1", 1)).unwrap();
    let other = Campaign::new(&format!("{} --runs 12 --estimator joint-ekf", changed.display()));
    let mut mixed = files[..11].to_vec();
    mixed.push(other.fly_shard(12, 12));
    rejected(&merge(&mixed, &[]), &["SHA-256 of the scenario"]);
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let campaign = Campaign::new("cubesat-pyramid --runs 4 --estimator joint-ekf");
    let files = campaign.fly_shards(2);
    let whole = fs::read(&files[0]).unwrap();
    let cut = campaign.path("cut.parquet");
    for length in [0, 3, whole.len() / 2, whole.len() - 1] {
        fs::write(&cut, &whole[..length]).unwrap();
        let mixed = [cut.clone(), files[1].clone()];
        rejected(&merge(&mixed, &[]), &["cut.parquet: not a complete Parquet file", "again"]);
    }
    let gone = campaign.path("gone.parquet");
    rejected(&merge(&[gone], &[]), &["gone.parquet: cannot be read"]);
    let faults = campaign.path("faults");
    let output = host_sim(&["faults", "--runs", "1", "--fault", "gap", "--out", text(&faults)]);
    if output.status.success() {
        rejected(&merge(&[faults.join("cells.parquet")], &[]), &["not written by mc"]);
    }
}

#[test]
fn bad_arguments_of_shards_are_rejected() {
    let campaign = Campaign::new("cubesat-pyramid --runs 4 --estimator joint-ekf");
    for shard in ["0/4", "5/4", "1", "x/2"] {
        rejected(&campaign.fly(&["--shard", shard, "--out", "a.parquet"]), &["--shard"]);
    }
    rejected(&campaign.fly(&["--shard", "1/2"]), &["--out"]);
    rejected(&campaign.fly(&["--shard", "1/2", "--out", "a.csv"]), &["FILE.parquet"]);
    rejected(&campaign.fly(&["--shard", "1/5", "--out", "a.parquet"]), &["at most 4 shards"]);
    rejected(&host_sim(&["merge"]), &["FILE"]);
}

#[cfg(unix)]
#[test]
fn killed_shard_leaves_no_file_and_flown_again_gives_the_same() {
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    let campaign = Campaign::new("cubesat-pyramid --runs 4000 --estimator joint-ekf");
    let out = campaign.path("killed.parquet");
    for signal in ["-KILL", "-INT"] {
        let mut arguments = vec!["mc"];
        arguments.extend(campaign.arguments.iter().map(String::as_str));
        arguments.extend(["--shard", "1/2", "--out", text(&out)]);
        let mut shard = std::process::Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(&arguments)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        // The temporary file exists once the flight has begun.
        let begun = Instant::now();
        let is_begun = || fs::read_dir(campaign.folder.path()).unwrap().next().is_some();
        while !is_begun() && begun.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(5));
        }
        let id = shard.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).output().unwrap().status.success());
        assert!(!shard.wait().unwrap().success(), "the shard was complete before {signal}");
        assert!(!out.exists());
        if signal == "-KILL" {
            let left = fs::read_dir(campaign.folder.path()).unwrap();
            left.for_each(|file| fs::remove_file(file.unwrap().path()).unwrap());
        }
    }
    assert_eq!(fs::read_dir(campaign.folder.path()).unwrap().count(), 0);

    let short = Campaign::new("cubesat-pyramid --runs 6 --estimator joint-ekf");
    let first = fs::read(short.fly_shard(1, 2)).unwrap();
    fs::remove_file(short.path("1-of-2.parquet")).unwrap();
    assert!(first == fs::read(short.fly_shard(1, 2)).unwrap());
}
