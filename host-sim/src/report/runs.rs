//! The runs of a campaign as CSV and Parquet, one row per run.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use super::files::{Folder, OutputError};
use super::frame::{Cells, Frame};
use super::json::Status;
use crate::input::ELEMENT_NAMES;

/// Result of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRow {
    /// Index of the run, from zero.
    pub run: u64,
    /// Seed of the gyro noise.
    pub seed: u64,
    /// Status of the estimate.
    pub status: Status,
    /// Estimated elements, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// Estimated minus true, kg m².
    pub error_kg_m2: [f64; 6],
    /// Normalised estimation error squared, six degrees of freedom. None if the covariance is not
    /// positive definite.
    pub nees: Option<f64>,
    /// True if the run counts as converged.
    pub converged: bool,
    /// True if the run counts as diverged, by its status or by its error.
    pub diverged: bool,
    /// Number of resets of the estimator.
    pub restarts: u32,
    /// Number of times that the earlier estimate was discarded because new data contradicted it.
    pub changes: u32,
    /// Result of the test of the last residuals for white noise. None if not tested.
    pub residuals_white: Option<bool>,
    /// True if the motion observes all six elements. Always true unless each run has its own
    /// spacecraft.
    pub shown: bool,
    /// True if the run counts as a silent lie: see
    /// [`CampaignRun::is_silent_lie`](crate::campaign::CampaignRun::is_silent_lie).
    pub silent_lie: bool,
}

/// Where the runs of a campaign are written: a file, or the folder of a report. It is created before the first run, so
/// that a wrong path fails at once.
pub enum RunsOutput {
    /// One row per run, by the ending of the name.
    File(RunsFile),
    /// A report, with the runs as CSV and Parquet.
    Folder(Folder),
}

/// A file of runs.
pub struct RunsFile {
    path: PathBuf,
    file: File,
    is_parquet: bool,
}

impl RunsOutput {
    /// Creates the file if the name ends in `.csv` or `.parquet`, else the folder.
    ///
    /// # Errors
    /// A path that cannot be written.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let is_parquet = match ending.as_deref() {
            Some("csv") => false,
            Some("parquet") => true,
            _ => return Ok(Self::Folder(Folder::open(path, &[])?)),
        };
        let file = File::create(path).map_err(|reason| OutputError::new(path, reason))?;
        Ok(Self::File(RunsFile { path: path.to_owned(), file, is_parquet }))
    }
}

impl RunsFile {
    /// Writes the runs.
    ///
    /// # Errors
    /// A failure of the file system.
    pub fn write(self, rows: &[RunRow]) -> Result<(), OutputError> {
        let (frame, out) = (frame(rows), BufWriter::new(self.file));
        let written = if self.is_parquet { frame.write_parquet(out) } else { frame.write_csv(out) };
        written.map_err(|reason| OutputError::new(&self.path, reason))
    }
}

/// Runs as a table, one row per run.
pub(super) fn frame(rows: &[RunRow]) -> Frame {
    fn cells<T>(rows: &[RunRow], cell: impl Fn(&RunRow) -> Option<T>) -> Vec<Option<T>> {
        rows.iter().map(cell).collect()
    }
    let mut frame = Frame::default();
    frame.add("run", Cells::Count(cells(rows, |row| Some(row.run))));
    frame.add("seed", Cells::Count(cells(rows, |row| Some(row.seed))));
    frame.add("status", Cells::Text(cells(rows, |row| Some(row.status.to_string()))));
    type Elements = fn(&RunRow) -> &[f64; 6];
    let quantities: [(&str, Elements); 3] = [
        ("", |row| &row.inertia_kg_m2),
        ("sigma_", |row| &row.sigma_kg_m2),
        ("error_", |row| &row.error_kg_m2),
    ];
    for (quantity, values) in quantities {
        for (i, element) in ELEMENT_NAMES.iter().enumerate() {
            let numbers = cells(rows, |row| Some(values(row)[i]));
            frame.add(format!("{quantity}{element}_kg_m2"), Cells::Number(numbers));
        }
    }
    frame.add("nees", Cells::Number(cells(rows, |row| row.nees)));
    frame.add("converged", Cells::Flag(cells(rows, |row| Some(row.converged))));
    frame.add("diverged", Cells::Flag(cells(rows, |row| Some(row.diverged))));
    frame.add("restarts", Cells::Count(cells(rows, |row| Some(row.restarts.into()))));
    frame.add("changes", Cells::Count(cells(rows, |row| Some(row.changes.into()))));
    frame.add("residuals_white", Cells::Flag(cells(rows, |row| row.residuals_white)));
    frame.add("shown", Cells::Flag(cells(rows, |row| Some(row.shown))));
    frame.add("silent_lie", Cells::Flag(cells(rows, |row| Some(row.silent_lie))));
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_as_many_cells_as_the_header() {
        let good = RunRow {
            run: 0,
            seed: 7,
            status: Status::Converged,
            inertia_kg_m2: [1.0, 2.0, 3.0, 0.1, 0.2, 0.3],
            sigma_kg_m2: [0.5; 6],
            error_kg_m2: [-1e-9; 6],
            nees: Some(5.5),
            converged: true,
            diverged: false,
            restarts: 0,
            changes: 2,
            residuals_white: None,
            shown: true,
            silent_lie: false,
        };
        let bad = RunRow {
            run: 1,
            seed: 8,
            status: Status::Diverged,
            error_kg_m2: [f64::NAN; 6],
            nees: None,
            converged: false,
            diverged: true,
            residuals_white: Some(false),
            ..good.clone()
        };
        let mut bytes = Vec::new();
        frame(&[good, bad]).write_csv(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("run,seed,status,jxx_kg_m2,"), "{}", lines[0]);
        assert!(
            lines[0].ends_with(",restarts,changes,residuals_white,shown,silent_lie"),
            "{}",
            lines[0]
        );
        assert!(lines[1].starts_with("0,7,converged,1.0,2.0,"), "{}", lines[1]);
        assert!(lines[1].ends_with(",-1e-9,5.5,true,false,0,2,,true,false"), "{}", lines[1]);
        assert!(lines[2].ends_with(",NaN,,false,true,0,2,false,true,false"), "{}", lines[2]);
        for line in &lines {
            assert_eq!(line.split(',').count(), 29, "{line}");
        }
    }

    #[test]
    fn error_names_a_file_that_cannot_be_created() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("no/runs.csv");
        let message = RunsOutput::create(&path).err().unwrap().to_string();
        assert!(message.starts_with(&path.display().to_string()), "{message}");
    }

    #[test]
    fn ending_of_the_name_selects_file_or_folder() {
        let folder = tempfile::tempdir().unwrap();
        let create = |name: &str| RunsOutput::create(&folder.path().join(name)).unwrap();
        assert!(matches!(create("a.csv"), RunsOutput::File(RunsFile { is_parquet: false, .. })));
        assert!(matches!(create("a.PARQUET"), RunsOutput::File(RunsFile { is_parquet: true, .. })));
        assert!(matches!(create("a"), RunsOutput::Folder(_)));
    }
}
