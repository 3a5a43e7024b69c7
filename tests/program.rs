//! The program `host-sim`, as a test or the program `accuracy` runs it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

/// Root folder of the repository.
pub fn repository() -> &'static Path {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests)
}

/// `cargo` in the root folder.
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(repository());
    command
}

/// Ways to run `host-sim`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HostSim {
    /// As the pages show it: `cargo run --release -p host-sim --`.
    ByCargo,
    /// A program that is built already.
    Built(PathBuf),
}

impl HostSim {
    /// The command, arguments to follow.
    pub fn command(&self) -> Command {
        match self {
            Self::ByCargo => {
                let mut command = cargo();
                command.args(["run", "--quiet", "--release", "-p", "host-sim", "--"]);
                command
            }
            Self::Built(program) => Command::new(program),
        }
    }

    /// Standard output for these arguments.
    ///
    /// # Errors
    /// The program cannot be started, or reports a failure.
    pub fn output<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Result<String> {
        let output = self.command().args(arguments).output().context("host-sim does not start")?;
        if !output.status.success() {
            bail!("host-sim failed: {}", String::from_utf8_lossy(&output.stderr));
        }
        Ok(String::from_utf8(output.stdout)?)
    }
}
