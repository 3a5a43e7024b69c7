//! Output folder of a flight.
//!
//! | file | content |
//! |---|---|
//! | `report.md` | table, plots, command line |
//! | `result.json` | the document of `--json` |
//! | `history.csv` | estimate over time |
//! | `events.csv` | time and outcome of each sample that was rejected or reset the estimator |
//! | `log.csv`, `craft.toml` | simulated log and its craft, ready for `replay`; simulated flights only |
//! | `rates.svg`, `innovations.svg`, `inertia.svg` | plots |
//! | `accelerations.svg` | if the estimator differentiates the rate |
//! | `rate-errors.svg`, `wheel-speeds.svg`, `control-torque.svg`, `attitude.svg` | simulated flights only: these need the truth |

use std::path::Path;

use serde::Serialize;

use super::files::{OutputError, create_folder, stream, write_json, write_text};
use super::history::{HistoryRow, write_events, write_history};
use super::plots::{PlotError, flight};
use crate::input::Craft;
use crate::input::log::{LogRow, write_log};
use crate::truth::Flight;

/// Content of the folder.
pub struct ReportFolder<'a, R> {
    /// Heading of `report.md`.
    pub title: &'a str,
    /// Command line that reproduces the report.
    pub command: &'a str,
    /// Table, as on the terminal.
    pub table: &'a str,
    /// Result, as a [`ReplayReport`](super::ReplayReport) or a [`RunReport`](super::RunReport).
    pub result: &'a R,
    /// Estimate over time.
    pub history: &'a [HistoryRow],
    /// Notes to the user, one sentence each.
    pub notes: &'a [String],
    /// Source of the log, if it was simulated.
    pub simulated: Option<Simulated<'a>>,
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
}

/// A plot of the folder.
struct Plot {
    file: &'static str,
    caption: &'static str,
    svg: String,
}

impl<R: Serialize> ReportFolder<'_, R> {
    /// Writes all files into `folder`, which is created if it does not exist. Existing files are
    /// overwritten.
    ///
    /// # Errors
    /// A path that cannot be written, or a plot that cannot be drawn.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        create_folder(folder)?;
        write_json(&folder.join("result.json"), self.result)?;
        let plots = self.plots()?;
        for plot in &plots {
            write_text(&folder.join(plot.file), &plot.svg)?;
        }
        stream(&folder.join("history.csv"), |out| write_history(out, self.history))?;
        stream(&folder.join("events.csv"), |out| write_events(out, self.history))?;
        if let Some(Simulated { log, craft, .. }) = self.simulated {
            stream(&folder.join("log.csv"), |out| write_log(out, log))?;
            write_text(&folder.join("craft.toml"), &craft.to_toml())?;
        }
        write_text(&folder.join("report.md"), &self.markdown(&plots))
    }

    /// All plots for which there are data.
    fn plots(&self) -> Result<Vec<Plot>, PlotError> {
        let history = self.history;
        let title = |quantity: &str| format!("{quantity}: {}", self.title);
        let truth = self.simulated.map(|simulated| simulated.flight.instants.as_slice());
        let inertia = title("Inertia (vertical scale of the last three quarters)");
        let mut plots = vec![
            Plot {
                file: "inertia.svg",
                caption: "Inertia over time",
                svg: flight::inertia(&inertia, history, truth, &flight::ALL_ELEMENTS)?,
            },
            Plot {
                file: "rates.svg",
                caption: "Body rate over time",
                svg: flight::rates(&title("Body rate"), history)?,
            },
            Plot {
                file: "innovations.svg",
                caption: "Rate innovation over time",
                svg: flight::innovations(&title("Rate innovation"), history)?,
            },
        ];
        if history.iter().any(|row| row.acceleration.is_some()) {
            let svg = flight::accelerations(&title("Angular acceleration"), history, truth)?;
            let caption = "Angular acceleration over time";
            plots.push(Plot { file: "accelerations.svg", caption, svg });
        }
        if let Some(simulated) = self.simulated {
            plots.extend(self.plots_of_truth(simulated)?);
        }
        Ok(plots)
    }

    /// Plots that need the truth.
    fn plots_of_truth(&self, simulated: Simulated<'_>) -> Result<Vec<Plot>, PlotError> {
        let truth = simulated.flight.instants.as_slice();
        let title = |quantity: &str| format!("{quantity}: {}", self.title);
        let mut plots = vec![Plot {
            file: "rate-errors.svg",
            caption: "Rate error over time",
            svg: flight::rate_errors(&title("Rate error"), self.history, truth)?,
        }];
        if let Some(svg) = flight::wheel_speeds(&title("Wheel speeds"), truth) {
            let caption = "Wheel speeds over time";
            plots.push(Plot { file: "wheel-speeds.svg", caption, svg: svg? });
        }
        let torque = title("Torque of the wheels on the body");
        if let Some(svg) = flight::control_torque(&torque, truth, &simulated.craft.wheels) {
            let caption = "Torque of the wheels over time";
            plots.push(Plot { file: "control-torque.svg", caption, svg: svg? });
        }
        plots.push(Plot {
            file: "attitude.svg",
            caption: "Attitude over time",
            svg: flight::euler_angles(&title("Attitude"), truth)?,
        });
        Ok(plots)
    }

    /// Text of `report.md`.
    fn markdown(&self, plots: &[Plot]) -> String {
        let pictures: String =
            plots.iter().map(|plot| format!("![{}]({})\n\n", plot.caption, plot.file)).collect();
        let Self { title, command, table, .. } = self;
        let notes: String = self.notes.iter().map(|note| format!("- {note}\n")).collect();
        let notes = if notes.is_empty() { notes } else { notes + "\n" };
        let log = if self.simulated.is_some() {
            ", the simulated log in [log.csv](log.csv) with its [craft.toml](craft.toml)"
        } else {
            ""
        };
        format!(
            "# {title}\n\n\
             ```text\n{}\n```\n\n\
             {notes}\
             The result as numbers is in [result.json](result.json), the estimate over time in \
             [history.csv](history.csv), rejected samples and resets in \
             [events.csv](events.csv){log}.\n\n\
             {pictures}\
             Created by host-sim {}:\n\n\
             ```sh\n{command}\n```\n",
            table.trim_end(),
            env!("CARGO_PKG_VERSION"),
        )
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

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
            notes: &["the gyro noise is estimated".to_owned()],
            simulated: Some(Simulated {
                log: &log.unwrap().rows,
                craft: &scenario.craft(),
                flight: &Flight::simulate(&scenario).unwrap(),
            }),
        };
        report.write(folder)
    }

    #[test]
    fn folder_has_every_file_and_may_exist() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("some/where");
        write(&folder).unwrap();
        write(&folder).unwrap();
        let markdown = fs::read_to_string(folder.join("report.md")).unwrap();
        assert!(markdown.contains("host-sim run stsat3-spin-up --seed 7"));
        assert!(markdown.contains("error/bound"));
        assert!(markdown.contains("\n- the gyro noise is estimated\n"));
        for name in [
            "result.json",
            "history.csv",
            "events.csv",
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
    fn error_names_a_file_with_the_name_of_the_folder() {
        let parent = tempfile::tempdir().unwrap();
        let obstacle = parent.path().join("report");
        fs::write(&obstacle, "").unwrap();
        let message = write(&obstacle).unwrap_err().to_string();
        assert!(message.starts_with(&obstacle.display().to_string()), "{message}");
        assert!(message.contains("cannot be written"), "{message}");
    }
}
