//! Files and folders of a report, and the errors of writing them.

use std::fs;
use std::io;
use std::path::Path;

use thiserror::Error;

use super::plots::PlotError;

/// A report could not be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// A file or a folder cannot be written.
    #[error(
        "{path}: cannot be written: {reason}; give another path, or check permissions and space"
    )]
    Unwritable {
        /// Path of the file or folder.
        path: String,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The result cannot be written as JSON.
    #[error("the result cannot be written as JSON: {0}")]
    Json(serde_json::Error),
    /// A plot cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

impl OutputError {
    /// Error of the operating system for a path.
    pub fn new(path: &Path, reason: io::Error) -> Self {
        Self::Unwritable { path: path.display().to_string(), reason }
    }
}

/// Error of the operating system for a path.
pub(super) fn unwritable(path: &Path, reason: io::Error) -> OutputError {
    OutputError::new(path, reason)
}

/// Creates a folder with its parents, unless it exists.
pub(super) fn create_folder(folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(|reason| unwritable(folder, reason))
}

/// Writes a text file, overwriting one that exists.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    fs::write(path, text).map_err(|reason| unwritable(path, reason))
}

/// Writes a value as JSON.
pub(super) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), OutputError> {
    let json = serde_json::to_string_pretty(value).map_err(OutputError::Json)?;
    write_text(path, &(json + "\n"))
}

/// Writes a file in parts, without building its content in memory.
pub(super) fn stream(
    path: &Path,
    write: impl FnOnce(io::BufWriter<fs::File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    fs::File::create(path)
        .and_then(|file| write(io::BufWriter::new(file)))
        .map_err(|reason| unwritable(path, reason))
}
