//! `cargo board [IMAGE]`: builds an image of fsw-target, flashes it by probe-rs and prints its log.

use anyhow::{Result, bail};
use std::process::{Command, ExitCode};
use target_tools::{firmware, toolchain};

/// The image that is flashed when none is named.
const DEFAULT_IMAGE: &str = "flight";

/// The board's chip, as probe-rs names it.
const CHIP: &str = "STM32F405RGTx";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo board: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let mut images = std::env::args().skip(1);
    let image = images.next().unwrap_or_else(|| DEFAULT_IMAGE.into());
    if image.starts_with('-') || images.next().is_some() {
        bail!("usage: cargo board [IMAGE]");
    }
    if Command::new("probe-rs").arg("--version").output().is_err() {
        bail!("no probe-rs: install it (cargo install probe-rs-tools)");
    }
    let elf = firmware::build(&image)?;
    toolchain::run(Command::new("probe-rs").args(["run", "--chip", CHIP]).arg(elf))
}
