//! The folder of a report: everything about one run, for reading and for other programs.
//!
//! | file | what |
//! |---|---|
//! | `report.md` | the table, the plots, how it was run |
//! | `result.json` | the same document as `--json` prints |
//! | `history.csv` | the estimate over time |
//! | `log.csv`, `craft.toml` | the simulated log and its craft, ready for `replay`; not for a recorded one |
//! | `rates.svg`, `innovations.svg`, `inertia.svg` | plots |
//! | `accelerations.svg` | where the estimator differentiates the rate |
//! | `rate-errors.svg`, `wheel-speeds.svg`, `control-torque.svg`, `attitude.svg` | not for a recorded log, whose truth nobody knows |

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::history::{HistoryRow, write_history};
use super::plots::{PlotError, flight};
use crate::input::Craft;
use crate::input::log::{LogRow, write_log};
use crate::truth::Flight;

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
    /// Where the log comes from, if it was simulated.
    pub simulated: Option<Simulated<'a>>,
}

/// A simulated log: `replay` reads it, with its craft.
#[derive(Clone, Copy)]
pub struct Simulated<'a> {
    /// The log.
    pub log: &'a [LogRow],
    /// Its craft.
    pub craft: &'a Craft,
    /// What really happened, sample by sample.
    pub flight: &'a Flight,
}

/// A plot in the folder.
struct Plot {
    file: &'static str,
    what: &'static str,
    svg: String,
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
        let plots = self.plots()?;
        for plot in &plots {
            write(plot.file, &plot.svg)?;
        }
        stream(folder.join("history.csv"), |out| write_history(out, self.history))?;
        if let Some(Simulated { log, craft, .. }) = self.simulated {
            stream(folder.join("log.csv"), |out| write_log(out, log))?;
            write("craft.toml", &craft.to_toml())?;
        }
        write("report.md", &self.markdown(&plots))
    }

    /// All that can be drawn of this flight.
    fn plots(&self) -> Result<Vec<Plot>, PlotError> {
        let history = self.history;
        let titled = |what: &str| format!("{what}: {}", self.title);
        let settled = titled("Inertia (the scale fits the last three quarters of the time)");
        let mut plots = Vec::new();
        let mut add = |file, what, svg: String| plots.push(Plot { file, what, svg });

        let truth = self.simulated.map(|simulated| simulated.flight.instants.as_slice());
        let inertia = flight::inertia(&settled, history, truth, &flight::ALL_ELEMENTS)?;
        add("inertia.svg", "Inertia over time", inertia);
        add("rates.svg", "Body rate over time", flight::rates(&titled("Body rate"), history)?);
        let innovations = flight::innovations(&titled("Rate innovation"), history)?;
        add("innovations.svg", "Rate innovation over time", innovations);
        if history.iter().any(|row| row.acceleration.is_some()) {
            let svg = flight::accelerations(&titled("Angular acceleration"), history, truth)?;
            add("accelerations.svg", "Angular acceleration over time", svg);
        }
        if let Some(Simulated { craft, .. }) = self.simulated
            && let Some(truth) = truth
        {
            let errors = flight::rate_errors(&titled("Rate error"), history, truth)?;
            add("rate-errors.svg", "Rate error over time", errors);
            if let Some(speeds) = flight::wheel_speeds(&titled("Wheel speeds"), truth) {
                add("wheel-speeds.svg", "Wheel speeds over time", speeds?);
            }
            let title = titled("Torque of the wheels on the body");
            if let Some(torque) = flight::control_torque(&title, truth, &craft.wheels) {
                add("control-torque.svg", "Torque of the wheels over time", torque?);
            }
            let attitude = flight::euler_angles(&titled("Attitude"), truth)?;
            add("attitude.svg", "Attitude over time", attitude);
        }
        Ok(plots)
    }

    fn markdown(&self, plots: &[Plot]) -> String {
        let pictures: String =
            plots.iter().map(|plot| format!("![{}]({})\n\n", plot.what, plot.file)).collect();
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
             {pictures}\
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
    use crate::input::{RecordedLog, Scenario};

    fn write(folder: &Path) -> Result<(), OutputError> {
        let result = examples::run();
        let log = RecordedLog::decode(
            "log.csv",
            b"t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n0,1,2,3\n",
            0,
        );
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let report = ReportFolder {
            title: "stsat3-spin-up",
            command: "host-sim run stsat3-spin-up --seed 7 --out report",
            table: &table::run(&result),
            result: &result,
            history: &[],
            simulated: Some(Simulated {
                log: &log.unwrap().rows,
                craft: &scenario.craft(),
                flight: &Flight::simulate(&scenario).unwrap(),
            }),
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
        for name in [
            "result.json",
            "history.csv",
            "log.csv",
            "rates.svg",
            "innovations.svg",
            "inertia.svg",
            "rate-errors.svg",
            "wheel-speeds.svg",
            "control-torque.svg",
            "attitude.svg",
        ] {
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
