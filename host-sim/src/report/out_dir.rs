//! Output folder of a flight.
//!
//! | file | content |
//! |---|---|
//! | `report.html` | verdict, tables and plots |
//! | `result.json` | the document of `--json` |
//! | `history.csv` | estimate over time |
//! | `events.csv` | time and outcome of each sample that was rejected or reset the estimator |
//! | `data/….csv` | the points of each plot |
//! | `log.csv`, `craft.toml` | simulated log and its craft, ready for `replay`; simulated flights only |
//! | `scenario/` | the scenario that was flown, with its tables; simulated flights only |
//! | `files.txt` | list of these files, which a later report in the folder replaces |

use std::path::Path;

use super::files::{Folder, OutputError};
use super::history::{HistoryRow, write_events, write_history};
use super::json::{PilReport, ReplayReport, RunReport};
use super::page;
use crate::input::Craft;
use crate::input::log::{LogRow, write_log};
use crate::input::scenario::SourceFile;
use crate::truth::Flight;

/// Content of the folder.
pub struct ReportFolder<'a> {
    /// Heading of the page.
    pub title: &'a str,
    /// Command line that reproduces the report.
    pub command: &'a str,
    /// Result.
    pub result: FlightResult<'a>,
    /// Estimate over time.
    pub history: &'a [HistoryRow],
    /// Files that were read, which stay if they are in the folder.
    pub inputs: &'a [&'a Path],
    /// Source of the log, if it was simulated.
    pub simulated: Option<Simulated<'a>>,
}

/// Result of a recorded log, or of a simulated flight.
#[derive(Clone, Copy)]
pub enum FlightResult<'a> {
    /// Of a recorded log.
    Replay(&'a ReplayReport),
    /// Of a simulated flight.
    Run(&'a RunReport),
    /// Of the firmware with simulated sensors.
    Pil(&'a PilReport),
}

/// A simulated log with its craft, as `replay` reads them, and its truth.
#[derive(Clone, Copy)]
pub struct Simulated<'a> {
    /// Log.
    pub log: &'a [LogRow],
    /// Craft.
    pub craft: &'a Craft,
    /// True motion at each sample.
    pub flight: &'a Flight,
    /// The scenario as it was read.
    pub scenario: &'a [SourceFile],
}

/// Files beside the page; the last three of simulated flights only.
const FILES: [(&str, &str); 6] = [
    ("result.json", "the result as numbers"),
    ("history.csv", "the estimate after each sample"),
    ("events.csv", "rejected samples and resets"),
    ("log.csv", "the simulated log, ready for replay"),
    ("craft.toml", "its craft file"),
    ("scenario/scenario.toml", "the scenario that was flown"),
];

impl ReportFolder<'_> {
    /// Writes all files into `folder`, which is created if it does not exist; files of an earlier report are removed.
    ///
    /// # Errors
    /// A path that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let mut folder = Folder::open(folder, self.inputs)?;
        let (report, run) = match self.result {
            FlightResult::Replay(report) => (report, None),
            FlightResult::Run(run) => (&run.estimate, Some(run)),
            FlightResult::Pil(PilReport { run, .. }) => (&run.estimate, Some(run)),
        };
        let (page, figures) = page::flight(&page::Flown {
            title: self.title,
            command: self.command,
            report,
            run,
            history: self.history,
            simulated: self.simulated,
            files: if self.simulated.is_some() { &FILES } else { &FILES[..3] },
        });
        folder.text("report.html", &page)?;
        match self.result {
            FlightResult::Replay(report) => folder.json("result.json", report)?,
            FlightResult::Run(run) => folder.json("result.json", run)?,
            FlightResult::Pil(pil) => folder.json("result.json", pil)?,
        }
        folder.stream("history.csv", |out| write_history(out, self.history))?;
        folder.stream("events.csv", |out| write_events(out, self.history))?;
        for figure in &figures {
            folder.stream(&format!("{}.csv", figure.name), |out| figure.write_csv(out))?;
        }
        if let Some(Simulated { log, craft, scenario, .. }) = self.simulated {
            folder.stream("log.csv", |out| write_log(out, log))?;
            folder.text("craft.toml", &craft.to_toml())?;
            folder.sources(scenario)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::json::examples;
    use super::*;
    use crate::input::{RecordedLog, Scenario, scenario};

    #[test]
    fn folder_has_every_file_that_the_page_names() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("some/where");
        let result = examples::run();
        let log = RecordedLog::decode(
            "log.csv",
            b"t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n0,1,2,3\n",
            0,
        );
        let flown = Scenario::load("cubesat-pyramid").unwrap();
        let report = ReportFolder {
            title: "stsat3-spin-up",
            command: "host-sim run stsat3-spin-up --seed 7 --out report",
            result: FlightResult::Run(&result),
            history: &[],
            inputs: &[],
            simulated: Some(Simulated {
                log: &log.unwrap().rows,
                craft: &flown.craft(),
                flight: &Flight::simulate(&flown).unwrap(),
                scenario: &scenario::sources("cubesat-pyramid").unwrap(),
            }),
        };
        report.write(&folder).unwrap();
        report.write(&folder).unwrap();
        let html = fs::read_to_string(folder.join("report.html")).unwrap();
        assert!(html.contains("host-sim run stsat3-spin-up --seed 7"));
        let links: Vec<&str> =
            html.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(links.contains(&"data/attitude.csv") && links.contains(&"scenario/scenario.toml"));
        for link in links {
            assert!(fs::metadata(folder.join(link)).unwrap().len() > 0, "{link}");
        }
        let result = fs::read_to_string(folder.join("result.json")).unwrap();
        let result: serde_json::Value = serde_json::from_str(&result).unwrap();
        assert_eq!(result["seed"], 7);
        let copy = fs::read_to_string(folder.join("scenario/scenario.toml")).unwrap();
        assert!(copy.contains("name = \"cubesat-pyramid\""));
    }
}
