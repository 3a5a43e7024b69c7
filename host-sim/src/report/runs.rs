//! The runs of a campaign as CSV and Parquet, one row per run, in constant memory.
//!
//! A Parquet file has the [record](super::record) of its campaign as metadata: it is a shard that
//! [`shards`](super::shards) reads back. It is complete or absent: it has a temporary name until all its rows are written.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use super::files::{Folder, OutputError};
pub use super::frame::Cells;
use super::frame::{Frame, ParquetFile};
use super::json::Status;
use super::record::{CampaignRecord, RECORD_KEY};
use crate::campaign::{CampaignRun, Reference, Score, Verdict, over};
use crate::estimation::kind_named;
use crate::input::ELEMENT_NAMES;

/// Rows of a row group: 10 MB in memory.
const ROWS_AT_ONCE: usize = 16_384;

/// Result of one run, with the values that it drew.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRow {
    /// Result. Its index counts from the first run of the whole campaign.
    pub run: CampaignRun,
    /// Values by the names of [`Scenario::drawn_names`](crate::input::Scenario::drawn_names).
    pub drawn: Vec<Option<f64>>,
}

/// Destination of the runs of a campaign: a file, or the folder of a report. It is created before the first run, so
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
    file: NamedTempFile,
    is_parquet: bool,
}

/// Receiver of the rows of a campaign.
pub type Receive<'a> = dyn FnMut(&RunRow) -> Result<(), OutputError> + 'a;

/// The rows of a campaign in the order of their seeds, as often as they are asked for.
pub trait Rows {
    /// Calls `receive` for each row.
    ///
    /// # Errors
    /// Those of `receive`, and of reading the rows.
    fn each(&self, receive: &mut Receive<'_>) -> Result<(), OutputError>;

    /// Names of the values that a run draws.
    fn drawn_names(&self) -> &[String];
}

/// True for a name that ends in `.parquet`.
pub fn is_parquet(path: &Path) -> bool {
    ending(path).as_deref() == Some("parquet")
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

impl RunsOutput {
    /// Creates the file if the name ends in `.csv` or `.parquet`, else the folder.
    ///
    /// # Errors
    /// A path that cannot be written.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        if !matches!(ending(path).as_deref(), Some("csv" | "parquet")) {
            return Ok(Self::Folder(Folder::open(path, &[])?));
        }
        let failed = |reason| OutputError::new(path, reason);
        if path.is_dir() {
            return Err(failed(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = format!(".{name}.");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(".part");
        // Access as of any new file: the default is that of a secret.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder.unwrap_or(Path::new("."))).map_err(failed)?;
        Ok(Self::File(RunsFile { path: path.to_owned(), file, is_parquet: is_parquet(path) }))
    }
}

impl RunsOutput {
    /// Folder of the output.
    pub fn folder(&self) -> &Path {
        match self {
            Self::File(RunsFile { file, .. }) => file.path().parent().unwrap_or(Path::new(".")),
            Self::Folder(folder) => folder.path(),
        }
    }
}

impl RunsFile {
    /// Writes the rows and gives the file its name.
    ///
    /// # Errors
    /// A failure of the file system, or of reading the rows.
    pub fn write(self, rows: &dyn Rows, record: &CampaignRecord) -> Result<(), OutputError> {
        let Self { path, mut file, is_parquet } = self;
        let failed = |reason| OutputError::new(&path, reason);
        let out = BufWriter::new(file.as_file_mut());
        match is_parquet {
            true => write_parquet(out, &path, rows, record)?,
            false => write_csv(out, &path, rows)?,
        }
        file.as_file().sync_all().map_err(failed)?;
        file.persist(&path).map_err(|error| failed(error.error))?;
        Ok(())
    }
}

/// Writes the rows as CSV; `path` is the name in errors.
pub(super) fn write_csv<W: Write>(out: W, path: &Path, rows: &dyn Rows) -> Result<(), OutputError> {
    let failed = |reason| OutputError::new(path, reason);
    let mut out = csv::Writer::from_writer(out);
    frame(&[], rows.drawn_names()).write_csv_header(&mut out).map_err(failed)?;
    in_groups(rows, &mut |group| {
        frame(group, rows.drawn_names()).write_csv_rows(&mut out).map_err(failed)
    })?;
    out.flush().map_err(failed)
}

/// Writes the rows as Parquet with the record of their campaign; `path` is the name in errors.
pub(super) fn write_parquet<W: Write + Send>(
    out: W,
    path: &Path,
    rows: &dyn Rows,
    record: &CampaignRecord,
) -> Result<(), OutputError> {
    let mut file = RowWriter::create(out, path, rows.drawn_names().to_vec())?;
    rows.each(&mut |row| file.add(row))?;
    file.close(record).map(|_| ())
}

/// A Parquet file of rows, written row by row.
pub(super) struct RowWriter<W: Write + Send> {
    file: ParquetFile<W>,
    path: PathBuf,
    drawn_names: Vec<String>,
    /// Rows of the next row group.
    group: Vec<RunRow>,
}

impl<W: Write + Send> RowWriter<W> {
    /// Begins a file; `path` is its name in errors.
    pub(super) fn create(
        out: W,
        path: &Path,
        drawn_names: Vec<String>,
    ) -> Result<Self, OutputError> {
        let file = ParquetFile::create(out, &frame(&[], &drawn_names));
        let file = file.map_err(|reason| OutputError::new(path, reason))?;
        Ok(Self { file, path: path.to_owned(), drawn_names, group: Vec::new() })
    }

    /// Adds a row.
    pub(super) fn add(&mut self, row: &RunRow) -> Result<(), OutputError> {
        self.group.push(row.clone());
        if self.group.len() < ROWS_AT_ONCE { Ok(()) } else { self.write_group() }
    }

    fn write_group(&mut self) -> Result<(), OutputError> {
        let written = self.file.write(&frame(&self.group, &self.drawn_names));
        self.group.clear();
        written.map_err(|reason| OutputError::new(&self.path, reason))
    }

    /// Completes the file with the record of its campaign.
    pub(super) fn close(mut self, record: &CampaignRecord) -> Result<W, OutputError> {
        if !self.group.is_empty() {
            self.write_group()?;
        }
        let record = serde_json::to_string(record).map_err(OutputError::Json)?;
        let flushed = self.file.close(&[(RECORD_KEY, record)]).and_then(|mut out| {
            out.flush()?;
            Ok(out)
        });
        flushed.map_err(|reason| OutputError::new(&self.path, reason))
    }
}

/// The columns of the rows, as they are written.
pub fn columns(rows: &[RunRow], drawn_names: &[String]) -> Vec<(String, Cells)> {
    frame(rows, drawn_names).into_columns()
}

/// Calls `write` for each group of rows.
fn in_groups(
    rows: &dyn Rows,
    write: &mut dyn FnMut(&[RunRow]) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    let mut group = Vec::new();
    rows.each(&mut |row| {
        group.push(row.clone());
        if group.len() < ROWS_AT_ONCE {
            return Ok(());
        }
        write(&group)?;
        group.clear();
        Ok(())
    })?;
    if group.is_empty() { Ok(()) } else { write(&group) }
}

/// Quantity of a run with six elements, and the prefix of its columns.
type Elements = (&'static str, fn(&CampaignRun) -> [Option<f64>; 6]);

/// The quantities with six elements, in the order of the columns.
const ELEMENTS: [Elements; 7] = [
    ("", |run| run.score.inertia_kg_m2.map(Some)),
    ("sigma_", |run| run.score.sigma_kg_m2.map(Some)),
    ("error_", |run| run.score.error_kg_m2.map(Some)),
    ("sigma_random_", |run| run.score.sigma_random_kg_m2.map(Some)),
    ("truth_", |run| run.reference.truth_kg_m2.map(Some)),
    ("bound_", |run| run.reference.bound_kg_m2),
    ("joint_bound_", |run| run.reference.joint_bound_kg_m2),
];

/// Name of the column of an element.
fn element_column(quantity: &str, element: usize) -> String {
    format!("{quantity}{}_kg_m2", ELEMENT_NAMES[element])
}

/// Runs as a table, one row per run.
fn frame(rows: &[RunRow], drawn: &[String]) -> Frame {
    fn cells<T>(rows: &[RunRow], cell: impl Fn(&CampaignRun) -> Option<T>) -> Vec<Option<T>> {
        rows.iter().map(|row| cell(&row.run)).collect()
    }
    let mut frame = Frame::default();
    frame.add("run", Cells::Count(cells(rows, |run| Some(run.index))));
    frame.add("seed", Cells::Count(cells(rows, |run| Some(run.seed))));
    let status = |run: &CampaignRun| Some(Status::from(run.score.status).to_string());
    frame.add("status", Cells::Text(cells(rows, status)));
    for (quantity, values) in ELEMENTS {
        for i in 0..6 {
            let numbers = cells(rows, |run| values(run)[i]);
            frame.add(element_column(quantity, i), Cells::Number(numbers));
        }
    }
    for (i, name) in drawn.iter().enumerate() {
        let values = rows.iter().map(|row| row.drawn.get(i).copied().flatten()).collect();
        frame.add(name, Cells::Number(values));
    }
    let kind = |run: &CampaignRun| run.largest_systematic.map(str::to_owned);
    frame.add("largest_systematic", Cells::Text(cells(rows, kind)));
    frame.add("steps", Cells::Count(cells(rows, |run| Some(run.steps))));
    frame.add("nees", Cells::Number(cells(rows, |run| run.score.nees)));
    let is = |verdict| move |run: &CampaignRun| Some(run.score.verdict == verdict);
    frame.add("converged", Cells::Flag(cells(rows, is(Verdict::Converged))));
    frame.add("diverged", Cells::Flag(cells(rows, is(Verdict::Diverged))));
    frame.add("restarts", Cells::Count(cells(rows, |run| Some(run.restarts.into()))));
    frame.add("changes", Cells::Count(cells(rows, |run| Some(run.changes.into()))));
    frame.add("residuals_white", Cells::Flag(cells(rows, |run| run.residuals_white)));
    let is_shown = |run: &CampaignRun| Some(run.score.verdict != Verdict::Unobserved);
    frame.add("shown", Cells::Flag(cells(rows, is_shown)));
    frame.add("silent_lie", Cells::Flag(cells(rows, |run| Some(run.is_silent_lie()))));
    frame
}

/// Names of the columns of drawn values of a table.
pub(super) fn drawn_columns<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    names.filter(|name| name.starts_with("drawn_")).map(str::to_owned).collect()
}

/// The runs of a table that [`frame`] has built; none if a column is missing or a cell has no meaning.
pub(super) fn rows_of(frame: &Frame) -> Option<Vec<RunRow>> {
    let drawn = drawn_columns(frame.names());
    let numbers = |name: &str| match frame.column(name)? {
        Cells::Number(cells) => Some(cells.as_slice()),
        _ => None,
    };
    let elements = |(quantity, _): &Elements| {
        let columns = (0..6).map(|i| numbers(&element_column(quantity, i)));
        columns.collect::<Option<Vec<_>>>()
    };
    let elements: Vec<_> = ELEMENTS.iter().map(elements).collect::<Option<_>>()?;
    let drawn: Vec<_> = drawn.iter().map(|name| numbers(name)).collect::<Option<_>>()?;
    let row = |at: usize| {
        let given = |quantity: usize| std::array::from_fn(|i| elements[quantity][i][at]);
        Some(RunRow {
            run: Row { frame, at }.run(&given)?,
            drawn: drawn.iter().map(|cells| cells[at]).collect(),
        })
    };
    (0..frame.rows()).map(row).collect()
}

/// A row of a table; none for a column that is missing or of another type.
#[derive(Clone, Copy)]
struct Row<'a> {
    frame: &'a Frame,
    at: usize,
}

impl<'a> Row<'a> {
    fn count(self, name: &str) -> Option<u64> {
        match self.frame.column(name)? {
            Cells::Count(cells) => cells[self.at],
            _ => None,
        }
    }

    fn number(self, name: &str) -> Option<Option<f64>> {
        match self.frame.column(name)? {
            Cells::Number(cells) => Some(cells[self.at]),
            _ => None,
        }
    }

    fn text(self, name: &str) -> Option<Option<&'a str>> {
        match self.frame.column(name)? {
            Cells::Text(cells) => Some(cells[self.at].as_deref()),
            _ => None,
        }
    }

    fn flag(self, name: &str) -> Option<Option<bool>> {
        match self.frame.column(name)? {
            Cells::Flag(cells) => Some(cells[self.at]),
            _ => None,
        }
    }

    fn verdict(self) -> Option<Verdict> {
        Some(match (self.flag("shown")??, self.flag("diverged")??, self.flag("converged")??) {
            (false, ..) => Verdict::Unobserved,
            (true, true, _) => Verdict::Diverged,
            (true, false, true) => Verdict::Converged,
            (true, false, false) => Verdict::NotConverged,
        })
    }

    /// The run; `elements` are those of each quantity of [`ELEMENTS`].
    fn run(self, elements: &dyn Fn(usize) -> [Option<f64>; 6]) -> Option<CampaignRun> {
        let all = |quantity: usize| elements(quantity).map(|x| x.unwrap_or(f64::NAN));
        let [inertia, sigma, error, random, truth] = [0, 1, 2, 3, 4].map(all);
        let [bound_kg_m2, joint_bound_kg_m2] = [5, 6].map(elements);
        let largest_systematic = match self.text("largest_systematic")? {
            Some(name) => Some(kind_named(name)?),
            None => None,
        };
        Some(CampaignRun {
            index: self.count("run")?,
            seed: self.count("seed")?,
            reference: Reference { truth_kg_m2: truth, bound_kg_m2, joint_bound_kg_m2 },
            score: Score {
                status: Status::named(self.text("status")??)?.into(),
                inertia_kg_m2: inertia,
                sigma_kg_m2: sigma,
                sigma_random_kg_m2: random,
                error_kg_m2: error,
                error_over_bound: over(&error, &bound_kg_m2),
                error_over_joint_bound: over(&error, &joint_bound_kg_m2),
                nees: self.number("nees")?,
                verdict: self.verdict()?,
            },
            restarts: u32::try_from(self.count("restarts")?).ok()?,
            changes: u32::try_from(self.count("changes")?).ok()?,
            residuals_white: self.flag("residuals_white")?,
            largest_systematic,
            steps: self.count("steps")?,
            estimator_time: Duration::ZERO,
        })
    }
}

#[cfg(test)]
mod tests {
    use fsw_core::Status;

    use super::*;

    fn runs() -> Vec<RunRow> {
        let bound_kg_m2 = [Some(0.1), Some(0.1), Some(0.1), None, None, Some(0.01)];
        let error_kg_m2 = [-1e-9; 6];
        let good = CampaignRun {
            index: 0,
            seed: 7,
            reference: Reference {
                truth_kg_m2: [1.0, 2.0, 3.0, 0.1, 0.2, 0.3],
                bound_kg_m2,
                joint_bound_kg_m2: [None; 6],
            },
            score: Score {
                status: Status::Converged,
                inertia_kg_m2: [1.0, 2.0, 3.0, 0.1, 0.2, 0.3],
                sigma_kg_m2: [0.5; 6],
                sigma_random_kg_m2: [0.25; 6],
                error_kg_m2,
                error_over_bound: over(&error_kg_m2, &bound_kg_m2),
                error_over_joint_bound: [None; 6],
                nees: Some(5.5),
                verdict: Verdict::Converged,
            },
            restarts: 0,
            changes: 2,
            residuals_white: None,
            largest_systematic: Some("wheel axis"),
            steps: 600,
            estimator_time: Duration::ZERO,
        };
        let mut bad = CampaignRun { index: 1, seed: u64::MAX, ..good };
        bad.score.status = Status::Diverged;
        bad.score.verdict = Verdict::Diverged;
        bad.score.nees = None;
        bad.residuals_white = Some(false);
        bad.largest_systematic = None;
        vec![
            RunRow { run: good, drawn: vec![Some(0.125), None] },
            RunRow { run: bad, drawn: vec![Some(-0.125), Some(1e-300)] },
        ]
    }

    fn drawn() -> [String; 2] {
        ["drawn_gyro_scale_x", "drawn_wheel_4_tilt_1_rad"].map(str::to_owned)
    }

    #[test]
    fn every_row_has_as_many_cells_as_the_header() {
        let mut bytes = Vec::new();
        frame(&runs(), &drawn()).write_csv(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("run,seed,status,jxx_kg_m2,"), "{}", lines[0]);
        let last = ",restarts,changes,residuals_white,shown,silent_lie";
        assert!(lines[0].ends_with(last), "{}", lines[0]);
        assert!(lines[1].starts_with("0,7,converged,1.0,2.0,"), "{}", lines[1]);
        let last = ",0.125,,wheel axis,600,5.5,true,false,0,2,,true,false";
        assert!(lines[1].ends_with(last), "{}", lines[1]);
        let last = ",-0.125,1e-300,,600,,false,true,0,2,false,true,false";
        assert!(lines[2].ends_with(last), "{}", lines[2]);
        for line in &lines {
            assert_eq!(line.split(',').count(), 3 + 7 * 6 + 2 + 10, "{line}");
        }
    }

    #[test]
    fn runs_read_back_from_their_table() {
        assert_eq!(rows_of(&frame(&runs(), &drawn())), Some(runs()));
        let mut not_finite = runs();
        not_finite[1].run.score.error_kg_m2 = [f64::NAN; 6];
        let read = rows_of(&frame(&not_finite, &drawn())).unwrap();
        assert!(read[1].run.score.error_kg_m2.iter().all(|error| error.is_nan()));
        assert_eq!(rows_of(&Frame::default()), None);
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
