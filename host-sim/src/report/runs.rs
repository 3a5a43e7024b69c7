//! The runs of a campaign as CSV, one row per run.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::files::{OutputError, unwritable};
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

/// File of the runs. It is created before the first run, so that a wrong path fails at once.
pub struct RunsFile {
    path: PathBuf,
    file: File,
}

impl RunsFile {
    /// Creates the file, or empties an existing one.
    ///
    /// # Errors
    /// A path that cannot be written.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(|reason| unwritable(path, reason))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Writes the runs.
    ///
    /// # Errors
    /// A failure of the file system.
    pub fn write(self, rows: impl IntoIterator<Item = RunRow>) -> Result<(), OutputError> {
        write_runs(self.file, rows).map_err(|reason| unwritable(&self.path, reason))
    }
}

/// Writes runs as CSV. A missing value is an empty cell. Numbers have the fewest digits that read
/// back as the same `f64`.
fn write_runs<W: io::Write>(out: W, rows: impl IntoIterator<Item = RunRow>) -> io::Result<()> {
    let mut out = csv::Writer::from_writer(out);
    out.write_record(header())?;
    for row in rows {
        let numbers = [row.inertia_kg_m2, row.sigma_kg_m2, row.error_kg_m2].concat();
        let mut cells = vec![row.run.to_string(), row.seed.to_string(), row.status.to_string()];
        cells.extend(numbers.iter().map(|x| format!("{x:?}")));
        cells.push(row.nees.map_or(String::new(), |x| format!("{x:?}")));
        cells.extend([row.converged.to_string(), row.diverged.to_string()]);
        cells.extend([row.restarts.to_string(), row.changes.to_string()]);
        cells.push(row.residuals_white.map_or(String::new(), |white| white.to_string()));
        cells.extend([row.shown.to_string(), row.silent_lie.to_string()]);
        out.write_record(&cells)?;
    }
    out.flush()
}

fn header() -> Vec<String> {
    let mut names = ["run", "seed", "status"].map(str::to_owned).to_vec();
    for quantity in ["", "sigma_", "error_"] {
        names.extend(ELEMENT_NAMES.map(|element| format!("{quantity}{element}_kg_m2")));
    }
    names.extend(["nees", "converged", "diverged"].map(str::to_owned));
    names.extend(
        ["restarts", "changes", "residuals_white", "shown", "silent_lie"].map(str::to_owned),
    );
    names
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
        write_runs(&mut bytes, [good, bad]).unwrap();
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
        let message = RunsFile::create(folder.path()).err().unwrap().to_string();
        assert!(message.starts_with(&folder.path().display().to_string()), "{message}");
    }
}
