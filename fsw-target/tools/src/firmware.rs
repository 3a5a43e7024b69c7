//! Build of firmware images: from source to ELF file.

use crate::board::{Board, STM32F405};
use crate::toolchain::Toolchain;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Mutex, PoisonError};

/// Board of the images, by its cargo feature.
pub const BOARD: &str = STM32F405.feature;

/// Root folder of the workspace.
pub fn workspace_root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).into()
}

/// Package of an image, by its name.
fn package_of(bin: &str) -> &'static str {
    match bin {
        "bringup" | "board-tests" => "fsw-bringup",
        _ => "fsw-target",
    }
}

/// Builds the image `bin` with the profile `firmware`. Returns its ELF file.
pub fn build(bin: &str) -> Result<PathBuf> {
    build_for(&STM32F405, bin)
}

/// As [`build`], with further arguments to cargo, such as features.
pub fn build_with(bin: &str, arguments: &[&str]) -> Result<PathBuf> {
    build_of("fsw-target", bin, arguments)
}

/// Builds the image `bin` for a board, with all estimators. Returns a file of its own: boards with the same
/// target share that of cargo, and the build for one replaces the image of the other.
pub fn build_for(board: &Board, bin: &str) -> Result<PathBuf> {
    /// From the build to the copy.
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let features = board.features();
    let arguments: &[&str] = match *board {
        STM32F405 => &[],
        _ => &["--no-default-features", "--features", &features],
    };
    let of_cargo = build_on(board.target, package_of(bin), bin, arguments)?;
    let own = of_board(&of_cargo, board);
    // Renamed as a whole: a program that starts the image meanwhile reads the old one or the new one.
    let unfinished = own.with_extension(std::process::id().to_string());
    std::fs::copy(&of_cargo, &unfinished)
        .and_then(|_| std::fs::rename(&unfinished, &own))
        .with_context(|| format!("cannot write the image {}", own.display()))?;
    Ok(own)
}

/// File of an image for a board, beside that of cargo.
fn of_board(of_cargo: &Path, board: &Board) -> PathBuf {
    let bin = of_cargo.file_name().unwrap_or_default().to_string_lossy();
    of_cargo.with_file_name(format!("{bin}-{}", board.feature))
}

/// As [`build_with`], for an image of any package.
pub fn build_of(package: &str, bin: &str, arguments: &[&str]) -> Result<PathBuf> {
    build_on(STM32F405.target, package, bin, arguments)
}

fn build_on(target: &str, package: &str, bin: &str, arguments: &[&str]) -> Result<PathBuf> {
    let output = Toolchain::find_for(target)?
        .cargo_for(target, "build")?
        .args(["--package", package, "--bin", bin, "--profile", "firmware"])
        .args(["--message-format", "json-render-diagnostics"])
        .args(arguments)
        .current_dir(workspace_root())
        .stderr(Stdio::inherit())
        .output()
        .context("cargo for the firmware did not start")?;
    if !output.status.success() {
        bail!("build of the firmware image {bin} failed, see the messages above");
    }
    executable(&String::from_utf8_lossy(&output.stdout))
        .with_context(|| format!("cargo reported no executable for the firmware image {bin}"))
}

/// Executable named in cargo's build messages, independent of the target folder.
fn executable(messages: &str) -> Option<PathBuf> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::BOARDS;

    #[test]
    fn boards_of_one_target_have_files_of_their_own() {
        let files = BOARDS.map(|board| of_board(Path::new("firmware/pil"), &board));
        assert_eq!(files[0], Path::new("firmware/pil-stm32f405"));
        assert!(files[0] != files[1] && files[1] != files[2]);
    }

    #[test]
    fn executable_is_found_among_other_messages() {
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
