//! The rows of a campaign in Parquet files: those of its shards, and the temporary one of a campaign that is being flown.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read};
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use tempfile::NamedTempFile;
use thiserror::Error;

use super::files::OutputError;
use super::frame::Frame;
use super::record::{CampaignRecord, RECORD_KEY};
use super::runs::{Receive, RowWriter, Rows, RunRow, drawn_columns, rows_of};

/// Most shards that an error names.
const MOST_NAMED: usize = 8;

/// Reason why files are not the shards of one campaign.
#[derive(Debug, Error)]
pub enum ShardError {
    /// The file cannot be opened.
    #[error("{file}: cannot be read: {reason}; check the path")]
    Unreadable {
        /// Path.
        file: String,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The file is no Parquet file, or it is cut or damaged.
    #[error("{file}: not a complete Parquet file ({reason}); fly the shard again")]
    Damaged {
        /// Path.
        file: String,
        /// The fault.
        reason: String,
    },
    /// A Parquet file without a record that this version reads.
    #[error(
        "{file}: not written by mc of this version ({reason}); merge files of mc --out FILE.parquet"
    )]
    Foreign {
        /// Path.
        file: String,
        /// The fault.
        reason: String,
    },
    /// Files of two campaigns.
    #[error(
        "{file}: {property} is {found}, but {expected} in {other}; merge files of one campaign"
    )]
    Different {
        /// Path.
        file: String,
        /// Property in which they differ.
        property: String,
        /// Its value.
        found: String,
        /// Value in the other file.
        expected: String,
        /// The other file.
        other: String,
    },
    /// One shard in two files of different content.
    #[error("{file}: shard {shard} differs from that in {other}; remove the one that is wrong")]
    Conflict {
        /// Path.
        file: String,
        /// Number of the shard.
        shard: u64,
        /// The other file.
        other: String,
    },
    /// Shards without a file.
    #[error("shards {missing} of {count} are missing; fly them with --shard I/{count}")]
    Missing {
        /// Their numbers.
        missing: String,
        /// Number of shards.
        count: u64,
    },
}

/// All shards of a campaign, in their order.
#[derive(Debug)]
pub struct Shards {
    files: Vec<Shard>,
    /// Record of the campaign in one file.
    record: CampaignRecord,
    drawn_names: Vec<String>,
}

/// File of one shard.
#[derive(Debug)]
struct Shard {
    path: PathBuf,
    record: CampaignRecord,
}

impl Shards {
    /// The shards in these files, in any order. A file given twice, or two files of the same content, count once.
    ///
    /// # Errors
    /// See [`ShardError`].
    pub fn open(paths: &[PathBuf]) -> Result<Self, ShardError> {
        let mut files =
            paths.iter().map(|path| Shard::open(path)).collect::<Result<Vec<_>, _>>()?;
        files.sort_by_key(|file| file.record.shard);
        for pair in files.windows(2) {
            let [first, second] = pair else { continue };
            first.check_campaign(second)?;
            if first.record.shard == second.record.shard && !first.is_equal(second)? {
                let (file, other) = (second.name(), first.name());
                return Err(ShardError::Conflict { file, shard: first.record.shard, other });
            }
        }
        files.dedup_by_key(|file| file.record.shard);
        let missing = || ShardError::Missing { missing: "all".to_owned(), count: 1 };
        let first = files.first().ok_or_else(missing)?;
        let (record, drawn_names) = (first.record.whole(), first.drawn_names()?);
        check_complete(&files, first.record.shards)?;
        Ok(Self { files, record, drawn_names })
    }

    /// Record of the campaign in one file.
    pub fn record(&self) -> &CampaignRecord {
        &self.record
    }
}

/// The rows of a campaign that is being flown, in a temporary file: memory is independent of the number of runs. The file is
/// removed with this value; a process that is killed leaves it, as `.rows.….part`.
pub struct Spool {
    file: NamedTempFile,
    writer: RowWriter<BufWriter<File>>,
}

impl Spool {
    /// An empty spool in this folder, where the output is going to need the space anyway.
    ///
    /// # Errors
    /// Here and below: a folder that cannot be written.
    pub fn create(folder: &Path, drawn_names: Vec<String>) -> Result<Self, OutputError> {
        let failed = |reason| OutputError::new(folder, reason);
        let file = tempfile::Builder::new().prefix(".rows.").suffix(".part").tempfile_in(folder);
        let file = file.map_err(failed)?;
        let out = BufWriter::new(file.reopen().map_err(failed)?);
        let writer = RowWriter::create(out, file.path(), drawn_names)?;
        Ok(Self { file, writer })
    }

    /// Adds a row.
    pub fn add(&mut self, row: &RunRow) -> Result<(), OutputError> {
        self.writer.add(row)
    }

    /// The rows, which are those of `record`.
    pub fn complete(self, record: &CampaignRecord) -> Result<Spooled, OutputError> {
        self.writer.close(record)?;
        let shard = Shard::open(self.file.path())?;
        let drawn_names = shard.drawn_names()?;
        Ok(Spooled { shard, drawn_names, _file: self.file })
    }
}

/// Rows read back from a spool.
pub struct Spooled {
    shard: Shard,
    drawn_names: Vec<String>,
    /// Removes the file with this value.
    _file: NamedTempFile,
}

impl Rows for Spooled {
    fn each(&self, receive: &mut Receive<'_>) -> Result<(), OutputError> {
        self.shard.each(receive)
    }

    fn drawn_names(&self) -> &[String] {
        &self.drawn_names
    }
}

impl Rows for Shards {
    fn each(&self, receive: &mut Receive<'_>) -> Result<(), OutputError> {
        self.files.iter().try_for_each(|file| file.each(receive))
    }

    fn drawn_names(&self) -> &[String] {
        &self.drawn_names
    }
}

/// Checks that every shard is there.
fn check_complete(files: &[Shard], count: u64) -> Result<(), ShardError> {
    let mut next = 1;
    let mut ranges: Vec<[u64; 2]> = Vec::new();
    for present in files.iter().map(|file| file.record.shard).chain([count + 1]) {
        if present > next {
            ranges.push([next, present - 1]);
        }
        next = present + 1;
    }
    if ranges.is_empty() {
        return Ok(());
    }
    let named = |[from, to]: &[u64; 2]| match from == to {
        true => from.to_string(),
        false => format!("{from} to {to}"),
    };
    let mut names: Vec<String> = ranges.iter().take(MOST_NAMED).map(named).collect();
    if ranges.len() > MOST_NAMED {
        names.push("others".to_owned());
    }
    Err(ShardError::Missing { missing: names.join(", "), count })
}

impl Shard {
    fn open(path: &Path) -> Result<Self, ShardError> {
        let file = path.display().to_string();
        let foreign =
            |reason: &str| ShardError::Foreign { file: file.clone(), reason: reason.to_owned() };
        let reader = reader(path)?;
        let metadata = reader.metadata().file_metadata();
        let entries = metadata.key_value_metadata().into_iter().flatten();
        let mut records = entries.filter(|entry| entry.key == RECORD_KEY);
        let text = records.next().and_then(|entry| entry.value.as_deref());
        let text = text.ok_or_else(|| foreign("no record of a campaign"))?;
        let record: CampaignRecord =
            serde_json::from_str(text).map_err(|error| foreign(&error.to_string()))?;
        if !record.is_readable() {
            return Err(foreign(&format!("format {}", record.format)));
        }
        let is_shard = record.shard().is_some() && record.shards <= record.runs;
        let range = is_shard.then(|| record.indices()).ok_or_else(|| foreign("no shard"))?;
        let (rows, expected) = (metadata.num_rows(), range.end - range.start);
        if u64::try_from(rows) != Ok(expected) {
            let reason = format!("{rows} of {expected} rows");
            return Err(ShardError::Damaged { file, reason });
        }
        Ok(Self { path: path.to_owned(), record })
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn damaged(&self, reason: impl ToString) -> ShardError {
        ShardError::Damaged { file: self.name(), reason: reason.to_string() }
    }

    fn check_campaign(&self, other: &Self) -> Result<(), ShardError> {
        let Some([property, expected, found]) = self.record.difference(&other.record) else {
            return Ok(());
        };
        let (file, other) = (other.name(), self.name());
        Err(ShardError::Different { file, property, found, expected, other })
    }

    /// Compares the bytes of two files.
    fn is_equal(&self, other: &Self) -> Result<bool, ShardError> {
        let bytes = |shard: &Self| {
            let failed = |reason| ShardError::Unreadable { file: shard.name(), reason };
            Ok(BufReader::new(File::open(&shard.path).map_err(failed)?))
        };
        let (mut here, mut there) = (bytes(self)?, bytes(other)?);
        let failed = |reason| ShardError::Unreadable { file: self.name(), reason };
        is_same(&mut here, &mut there).map_err(failed)
    }

    fn drawn_names(&self) -> Result<Vec<String>, ShardError> {
        let reader = reader(&self.path)?;
        let schema = reader.metadata().file_metadata().schema_descr_ptr();
        Ok(drawn_columns(schema.columns().iter().map(|column| column.name())))
    }

    /// Calls `receive` for each row; one row group is in memory at a time.
    fn each(&self, receive: &mut Receive<'_>) -> Result<(), OutputError> {
        let reader = reader(&self.path)?;
        let mut indices = self.record.indices();
        for group in 0..reader.num_row_groups() {
            let frame = reader.get_row_group(group).and_then(|group| Frame::read(group.as_ref()));
            let frame = frame.map_err(|error| self.damaged(error))?;
            let rows = rows_of(&frame).ok_or_else(|| self.damaged("a column is missing"))?;
            for row in &rows {
                let index = indices.next();
                let seed = index.map(|index| self.record.seed.wrapping_add(index));
                if (Some(row.run.index), Some(row.run.seed)) != (index, seed) {
                    return Err(self.damaged("a run of another shard").into());
                }
                receive(row)?;
            }
        }
        Ok(())
    }
}

fn reader(path: &Path) -> Result<SerializedFileReader<File>, ShardError> {
    let file = || path.display().to_string();
    let opened = File::open(path);
    let opened = opened.map_err(|reason| ShardError::Unreadable { file: file(), reason })?;
    let damaged =
        |error: ParquetError| ShardError::Damaged { file: file(), reason: error.to_string() };
    SerializedFileReader::new(opened).map_err(damaged)
}

/// True for equal content up to the ends.
fn is_same(here: &mut impl Read, there: &mut impl Read) -> io::Result<bool> {
    let mut blocks = [[0; 1 << 16]; 2];
    loop {
        let [a, b] = &mut blocks;
        let (read_here, read_there) = (fill(here, a)?, fill(there, b)?);
        if a[..read_here] != b[..read_there] {
            return Ok(false);
        }
        if read_here == 0 {
            return Ok(true);
        }
    }
}

/// Reads until the block is full or the file ends.
fn fill(from: &mut impl Read, block: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < block.len() {
        match from.read(&mut block[filled..])? {
            0 => break,
            read => filled += read,
        }
    }
    Ok(filled)
}
