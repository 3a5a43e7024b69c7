//! Folder of a report: its files, a list of them, and the errors of writing.
//!
//! The list, [`LIST`], is what a later report in the same folder removes first. Files that no report has written stay.

use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::shards::ShardError;
use crate::input::scenario::SourceFile;

/// Name of the list of the files of a report, one path a line.
const LIST: &str = "files.txt";

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
    /// The rows of a campaign cannot be read.
    #[error(transparent)]
    Shard(#[from] ShardError),
    /// The result cannot be written as JSON.
    #[error("the result cannot be written as JSON: {0}")]
    Json(serde_json::Error),
}

impl OutputError {
    /// Error of the operating system for a path.
    pub fn new(path: &Path, reason: io::Error) -> Self {
        Self::Unwritable { path: path.display().to_string(), reason }
    }
}

/// A folder that holds one report.
pub struct Folder {
    path: PathBuf,
    list: fs::File,
}

impl Folder {
    /// Creates the folder with its parents, or removes the files of an earlier report from it, except `inputs`: a log
    /// of a report may be replayed into the same folder.
    ///
    /// # Errors
    /// A path that cannot be written, or a file that cannot be removed.
    pub fn open(path: &Path, inputs: &[&Path]) -> Result<Self, OutputError> {
        fs::create_dir_all(path).map_err(|reason| OutputError::new(path, reason))?;
        let list = path.join(LIST);
        let earlier = match fs::read_to_string(&list) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(reason) => return Err(OutputError::new(&list, reason)),
        };
        let is_inside = |name: &&str| {
            let mut parts = Path::new(name).components();
            !name.is_empty() && parts.all(|part| matches!(part, Component::Normal(_)))
        };
        for name in earlier.lines().filter(is_inside) {
            let file = path.join(name);
            if inputs.iter().any(|input| is_same(input, &file)) {
                continue;
            }
            match fs::remove_file(&file) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(OutputError::new(&file, error));
                }
                _ => {}
            }
            // A folder that is not empty stays.
            if let Some(parent) = file.parent().filter(|parent| *parent != path) {
                let _ = fs::remove_dir(parent);
            }
        }
        let file = fs::File::create(&list).map_err(|reason| OutputError::new(&list, reason))?;
        let mut folder = Self { path: path.to_owned(), list: file };
        folder.note(LIST)?;
        Ok(folder)
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a file to the list before it is written, so that an interrupted report leaves nothing unlisted.
    fn note(&mut self, name: &str) -> Result<(), OutputError> {
        writeln!(self.list, "{name}").map_err(|reason| OutputError::new(&self.path, reason))
    }

    /// Writes a text file; `name` may have folders.
    ///
    /// # Errors
    /// Here and below: a path that cannot be written.
    pub fn text(&mut self, name: &str, text: &str) -> Result<(), OutputError> {
        self.stream(name, |mut out| out.write_all(text.as_bytes()))
    }

    /// Writes a value as JSON.
    pub fn json(&mut self, name: &str, value: &impl Serialize) -> Result<(), OutputError> {
        let json = serde_json::to_string_pretty(value).map_err(OutputError::Json)?;
        self.text(name, &(json + "\n"))
    }

    /// Writes the files of a scenario into a folder of their own.
    pub fn sources(&mut self, files: &[SourceFile]) -> Result<(), OutputError> {
        files.iter().try_for_each(|file| self.text(&format!("scenario/{}", file.name), &file.text))
    }

    /// Writes a file in parts, without building its content in memory.
    pub fn stream(
        &mut self,
        name: &str,
        write: impl FnOnce(io::BufWriter<fs::File>) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        self.rows(name, |out, path| write(out).map_err(|reason| OutputError::new(path, reason)))
    }

    /// The same, where reading of what is written may fail as well. `write` receives the path for its errors.
    pub fn rows(
        &mut self,
        name: &str,
        write: impl FnOnce(io::BufWriter<fs::File>, &Path) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        self.note(name)?;
        let path = self.path.join(name);
        let parent = path.parent().unwrap_or(&self.path);
        let file = fs::create_dir_all(parent).and_then(|()| fs::File::create(&path));
        let file = file.map_err(|reason| OutputError::new(&path, reason))?;
        write(io::BufWriter::new(file), &path)
    }
}

/// True for two paths of one existing file.
fn is_same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_report_removes_the_files_of_the_earlier_one_alone() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("some/where");
        let mut folder = Folder::open(&path, &[]).unwrap();
        folder.text("report.html", "a").unwrap();
        folder.text("log.csv", "a").unwrap();
        folder.text("data/rates.csv", "a").unwrap();
        folder.text("data/kept/x.csv", "a").unwrap();
        fs::write(path.join("mine.txt"), "b").unwrap();
        fs::write(path.join("data/kept/mine.txt"), "b").unwrap();
        let input = path.join("log.csv");
        Folder::open(&path, &[&input]).unwrap().text("report.html", "c").unwrap();
        assert!(input.exists());
        assert_eq!(fs::read_to_string(path.join("report.html")).unwrap(), "c");
        assert!(!path.join("data/rates.csv").exists() && !path.join("data/kept/x.csv").exists());
        assert!(path.join("mine.txt").exists() && path.join("data/kept/mine.txt").exists());
        assert_eq!(fs::read_to_string(path.join(LIST)).unwrap(), "files.txt\nreport.html\n");
    }

    #[test]
    fn list_with_a_path_outside_removes_nothing_there() {
        let parent = tempfile::tempdir().unwrap();
        let (path, outside) = (parent.path().join("report"), parent.path().join("outside"));
        fs::create_dir(&path).unwrap();
        fs::write(&outside, "b").unwrap();
        fs::write(path.join(LIST), format!("../outside\n{}\n", outside.display())).unwrap();
        Folder::open(&path, &[]).unwrap();
        assert!(outside.exists());
    }

    #[test]
    fn error_names_a_file_with_the_name_of_the_folder() {
        let parent = tempfile::tempdir().unwrap();
        let obstacle = parent.path().join("report");
        fs::write(&obstacle, "").unwrap();
        let message = Folder::open(&obstacle, &[]).err().unwrap().to_string();
        assert!(message.starts_with(&obstacle.display().to_string()), "{message}");
        assert!(message.contains("cannot be written"), "{message}");
    }
}
