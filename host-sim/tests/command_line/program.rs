//! The program, its output, and input files with valid content.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// Runs the program with these arguments.
pub fn host_sim(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim")).args(arguments).output().unwrap()
}

/// Document on stdout of a successful run.
pub fn json(arguments: &[&str]) -> Value {
    let output = host_sim(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Checks a rejection: exit code 2, empty stdout, one or two lines on stderr with each text of
/// `named`.
pub fn rejected(output: &Output, named: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert!((1..=2).contains(&message.lines().count()), "{message}");
    for name in named {
        assert!(message.contains(name), "{name:?} is missing from {message:?}");
    }
}

/// A craft with one wheel.
pub const CRAFT: &str = "[[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1e-3\n\
                     [gyro]\nnoise_rad_s = 1e-4\n";
/// Heading of a log of that craft.
pub const HEADER: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,wheel_1_rad_s\n";
/// Rows of a log of that craft.
pub const ROWS: &str = "0,0.1,0.2,0.3,100\n0.1,0.1,0.2,0.3,101\n0.2,0.1,0.2,0.3,102\n";

/// A spacecraft without wheels and torque.
pub const SCENARIO: &str = "name = \"free\"\nduration_s = 10.0\n[spacecraft]\n\
                        inertia_kg_m2 = [1, 1.1, 1.2, 0, 0, 0]\nrate_rad_s = [0.1, 0.2, 0.3]\n\
                        [gyro]\nrate_hz = 10.0\nnoise_rad_s = 1e-4\n";

/// A temporary folder of input files.
pub struct Files {
    /// Folder.
    pub folder: TempDir,
}

impl Files {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    /// Writes a file.
    pub fn file(&self, name: &str, content: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        fs::write(&path, content).unwrap();
        path
    }

    /// Replays a log with a craft.
    pub fn replay(&self, craft: &str, log: &str) -> Output {
        let (craft, log) = (self.file("craft.toml", craft), self.file("log.csv", log));
        host_sim(&["replay", "--craft", text(&craft), text(&log)])
    }

    /// Runs a scenario.
    pub fn run(&self, scenario: &str) -> Output {
        host_sim(&["run", text(&self.file("scenario.toml", scenario))])
    }
}
