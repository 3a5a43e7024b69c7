//! A folder in which the commands of a page are executed: the root folder by links, so that what
//! they write stays out of the repository.

use std::fs;
use std::os::unix::fs::symlink;

use tempfile::TempDir;
use tests::program::repository;

use super::command::{Command, with_few_runs};

pub struct Folder(TempDir);

impl Folder {
    /// Links to each entry of the root folder.
    pub fn like_the_repository() -> Self {
        let folder = TempDir::new().unwrap();
        for entry in fs::read_dir(repository()).unwrap() {
            let entry = entry.unwrap();
            symlink(entry.path(), folder.path().join(entry.file_name())).unwrap();
        }
        Self(folder)
    }

    /// Executes a command of a page.
    pub fn run(&self, command: &Command) -> Result<(), String> {
        match command {
            Command::Copy { from, to } => {
                let path = |name: &str| self.0.path().join(name);
                fs::copy(path(from), path(to)).map(|_| ()).map_err(|why| why.to_string())
            }
            Command::HostSim(arguments) => {
                let output = super::host_sim()
                    .command()
                    .args(with_few_runs(arguments))
                    .current_dir(self.0.path())
                    .output()
                    .unwrap();
                let errors = || String::from_utf8_lossy(&output.stderr).into_owned();
                if output.status.success() { Ok(()) } else { Err(errors()) }
            }
        }
    }
}
