//! The folder of a report: everything about one run, for reading and for other programs.
//!
//! | file | what |
//! |---|---|
//! | `report.md` | the table, the plots, how it was run |
//! | `result.json` | the same document as `--json` prints |
//! | `history.csv` | the estimate over time |
//! | `log.csv`, `craft.toml` | the simulated log and its craft, ready for `replay`; not for a recorded one |
//! | `rates.svg`, `innovations.svg`, `inertia.svg` | plots |

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::history::{HistoryRow, write_history};
use super::plots::{self, PlotError};
use crate::input::Craft;
use crate::input::log::{LogRow, write_log};

/// A report could not be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// A file or the folder itself.
    #[error(
        "{path}: cannot be written: {reason}; give another path, or check permissions and space"
    )]
    Unwritable {
        /// Which one.
        path: String,
        /// What the operating system says.
        reason: io::Error,
    },
    /// The result as JSON.
    #[error("the result cannot be written as JSON: {0}")]
    Json(serde_json::Error),
    /// A plot.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// What goes into the folder.
pub struct ReportFolder<'a, R> {
    /// Heading of `report.md`.
    pub title: &'a str,
    /// The command line that makes this report again.
    pub command: &'a str,
    /// The table as on the terminal.
    pub table: &'a str,
    /// The result: a [`ReplayReport`](super::ReplayReport) or a [`RunReport`](super::RunReport).
    pub result: &'a R,
    /// The estimate over time.
    pub history: &'a [HistoryRow],
    /// The true elements of the inertia tensor, kg m², if they are known.
    pub truth_kg_m2: Option<[f64; 6]>,
    /// The log and its craft, if they were simulated: `replay` reads them.
    pub simulated: Option<(&'a [LogRow], &'a Craft)>,
}

impl<R: Serialize> ReportFolder<'_, R> {
    /// Writes all files into `folder`, which is made if need be. Files of an earlier report are
    /// overwritten.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        fs::create_dir_all(folder).map_err(|reason| unwritable(folder, reason))?;
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|reason| unwritable(&path, reason))
        };

        let json = serde_json::to_string_pretty(self.result).map_err(OutputError::Json)?;
        write("result.json", &(json + "\n"))?;
        write("rates.svg", &plots::rates(self.history)?)?;
        write("innovations.svg", &plots::innovations(self.history)?)?;
        write("inertia.svg", &plots::inertia(self.history, self.truth_kg_m2.as_ref())?)?;
        stream(folder.join("history.csv"), |out| write_history(out, self.history))?;
        if let Some((log, craft)) = self.simulated {
            stream(folder.join("log.csv"), |out| write_log(out, log))?;
            write("craft.toml", &craft.to_toml())?;
        }
        write("report.md", &self.markdown())
    }

    fn markdown(&self) -> String {
        let Self { title, command, table, .. } = self;
        let log = if self.simulated.is_some() {
            ", the simulated log in [log.csv](log.csv) with its [craft.toml](craft.toml)"
        } else {
            ""
        };
        format!(
            "# {title}\n\n\
             ```text\n{}\n```\n\n\
             The same as numbers is in [result.json](result.json), the estimate over time in \
             [history.csv](history.csv){log}.\n\n\
             ![Inertia over time](inertia.svg)\n\n\
             ![Body rate over time](rates.svg)\n\n\
             ![Rate innovation over time](innovations.svg)\n\n\
             Made by host-sim {}:\n\n\
             ```sh\n{command}\n```\n",
            table.trim_end(),
            env!("CARGO_PKG_VERSION"),
        )
    }
}

/// Writes a file that may be too long to build in memory first.
fn stream(
    path: PathBuf,
    write: impl FnOnce(io::BufWriter<fs::File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    fs::File::create(&path)
        .and_then(|file| write(io::BufWriter::new(file)))
        .map_err(|reason| unwritable(&path, reason))
}

pub(super) fn unwritable(path: &Path, reason: io::Error) -> OutputError {
    OutputError::Unwritable { path: path.display().to_string(), reason }
}

#[cfg(test)]
mod tests {
    use super::super::json::examples;
    use super::super::table;
    use super::*;
    use crate::input::RecordedLog;

    fn write(folder: &Path) -> Result<(), OutputError> {
        let result = examples::run();
        let log = RecordedLog::decode(
            "log.csv",
            b"t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n0,1,2,3\n",
            0,
        );
        let report = ReportFolder {
            title: "stsat3-spin-up",
            command: "host-sim run stsat3-spin-up --seed 7 --out report",
            table: &table::run(&result),
            result: &result,
            history: &[],
            truth_kg_m2: Some(examples::TRUTH),
            simulated: Some((&log.unwrap().rows, &Craft::default())),
        };
        report.write(folder)
    }

    #[test]
    fn folder_holds_every_file_and_may_exist() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("some/where");
        write(&folder).unwrap();
        write(&folder).unwrap();
        let markdown = fs::read_to_string(folder.join("report.md")).unwrap();
        assert!(markdown.contains("host-sim run stsat3-spin-up --seed 7"));
        assert!(markdown.contains("error/bound"));
        for name in
            ["result.json", "history.csv", "log.csv", "rates.svg", "innovations.svg", "inertia.svg"]
        {
            assert!(markdown.contains(&format!("({name})")), "{name}");
            assert!(fs::metadata(folder.join(name)).unwrap().len() > 0, "{name}");
        }
        let result = fs::read_to_string(folder.join("result.json")).unwrap();
        let result: serde_json::Value = serde_json::from_str(&result).unwrap();
        assert_eq!(result["seed"], 7);
    }

    #[test]
    fn file_in_the_way_is_named() {
        let parent = tempfile::tempdir().unwrap();
        let in_the_way = parent.path().join("report");
        fs::write(&in_the_way, "").unwrap();
        let message = write(&in_the_way).unwrap_err().to_string();
        assert!(message.starts_with(&in_the_way.display().to_string()), "{message}");
        assert!(message.contains("cannot be written"), "{message}");
    }
}
