//! The programs of this workspace, as a test or another program runs them.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use anyhow::{Context, Result, bail};

/// Root folder of the repository.
pub fn repository() -> &'static Path {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests)
}

/// Output of cargo in the root folder.
///
/// # Errors
/// Cargo cannot be started.
pub fn cargo<S: AsRef<OsStr>>(arguments: &[S]) -> Result<Output> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(arguments).current_dir(repository());
    command.output().context("cargo cannot be started")
}

/// Path of the program `host-sim`, built in the profile of the caller and once in a process.
///
/// # Errors
/// The build fails.
pub fn host_sim() -> Result<&'static Path> {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    if let Some(program) = PROGRAM.get() {
        return Ok(program);
    }
    let program = build_host_sim()?;
    Ok(PROGRAM.get_or_init(|| program))
}

fn build_host_sim() -> Result<PathBuf> {
    let caller = std::env::current_exe()?;
    // Programs are in the profile's folder, tests in its folder `deps`.
    let folder = caller.parent().context("the program is in no folder")?;
    let folder = if folder.ends_with("deps") { folder.parent().unwrap_or(folder) } else { folder };
    let profile = match folder.file_name().and_then(OsStr::to_str) {
        Some("debug") => "dev",
        Some(name) => name,
        None => bail!("{} is not a folder of cargo's", folder.display()),
    };
    let built = cargo(&["build", "--quiet", "--package", "host-sim", "--profile", profile])?;
    if !built.status.success() {
        bail!("host-sim is not built: {}", String::from_utf8_lossy(&built.stderr));
    }
    Ok(folder.join("host-sim"))
}

/// Standard output of `host-sim` with these arguments.
///
/// # Errors
/// The program cannot be built, or reports a failure.
pub fn host_sim_output<S: AsRef<OsStr>>(arguments: &[S]) -> Result<String> {
    let output = Command::new(host_sim()?).args(arguments).output()?;
    if !output.status.success() {
        bail!("host-sim failed: {}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(String::from_utf8(output.stdout)?)
}
