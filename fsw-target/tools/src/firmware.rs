//! A firmware image, from source to ELF file.

use crate::toolchain::Toolchain;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Cargo feature of the board that the images are built for.
pub const BOARD: &str = "stm32f405";

/// The folder of the workspace's Cargo.toml.
pub fn workspace_root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).into()
}

/// Builds the image `bin` of fsw-target as it is flashed, and returns its ELF file.
pub fn build(bin: &str) -> Result<PathBuf> {
    build_with(bin, &[])
}

/// The same with more arguments to cargo, as for features.
pub fn build_with(bin: &str, arguments: &[&str]) -> Result<PathBuf> {
    build_of("fsw-target", bin, arguments)
}

/// The same for an image of any package.
pub fn build_of(package: &str, bin: &str, arguments: &[&str]) -> Result<PathBuf> {
    let output = Toolchain::find()?
        .cargo("build")?
        .args(["--package", package, "--bin", bin, "--profile", "firmware"])
        .args(["--message-format", "json-render-diagnostics"])
        .args(arguments)
        .current_dir(workspace_root())
        .stderr(Stdio::inherit())
        .output()
        .context("could not start cargo for the firmware")?;
    if !output.status.success() {
        bail!("the firmware image {bin} did not build");
    }
    executable(&String::from_utf8_lossy(&output.stdout))
        .with_context(|| format!("cargo built no firmware image {bin}"))
}

/// The file that cargo says it linked: the build messages name it, wherever the target folder is.
fn executable(messages: &str) -> Option<PathBuf> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_found_among_other_messages() {
        let messages = concat!(
            "{\"reason\":\"compiler-artifact\",\"executable\":null}\n",
            "not a message\n",
            "{\"reason\":\"compiler-artifact\",\"executable\":\"some/where/replay\"}\n",
            "{\"reason\":\"build-finished\",\"success\":true}\n",
        );
        assert_eq!(executable(messages), Some("some/where/replay".into()));
        assert_eq!(executable(""), None);
    }
}
