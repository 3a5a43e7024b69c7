//! `init`: files to start from.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::Failure;
use crate::input::{guess, log_file};
use crate::report::OutputError;

const SCENARIO: &str = include_str!("../../templates/scenario.toml");
const CRAFT: &str = include_str!("../../templates/craft.toml");

#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for a commented scenario and craft file
    #[arg(value_name = "DIR", required_unless_present = "from", conflicts_with = "from")]
    folder: Option<PathBuf>,
    /// Log from which a craft file is drafted; - for standard input
    #[arg(long, value_name = "LOG")]
    from: Option<PathBuf>,
    /// File for the draft; without it, the draft is printed
    #[arg(long, value_name = "CRAFT.toml", requires = "from")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match arguments {
        Arguments { from: Some(log), out, .. } => draft(log, out.as_deref()),
        Arguments { folder: Some(folder), .. } => start(folder),
        _ => Ok(()),
    }
}

fn draft(log: &Path, out: Option<&Path>) -> Result<(), Failure> {
    let source = log_file::read(log, &Default::default())?;
    let file = source.file().to_owned();
    let name = log.file_name().unwrap_or(log.as_os_str()).to_string_lossy().into_owned();
    let text = guess::draft(&name, &source)
        .map_err(|error| Failure::NoDraft { file: file.clone(), error })?;
    let Some(out) = out else { return super::print_text(&text) };
    write_new(out, &text)?;
    let to_do =
        text.lines().filter(|line| line.contains("# CONFIRM") || line.contains("# FILL IN"));
    eprintln!("note: {}: {} lines to confirm or fill in, then:", out.display(), to_do.count());
    eprintln!("  host-sim replay --craft {} {file}", out.display());
    Ok(())
}

fn start(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| OutputError::new(folder, error))?;
    for (name, text) in [("scenario.toml", SCENARIO), ("craft.toml", CRAFT)] {
        write_new(&folder.join(name), text)?;
    }
    eprintln!("note: {}: scenario.toml and craft.toml, then:", folder.display());
    eprintln!("  host-sim run {}", folder.join("scenario.toml").display());
    Ok(())
}

/// Writes a file that does not exist yet.
fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => Failure::Exists { file: path.display().to_string() },
        _ => OutputError::new(path, error).into(),
    })
}
