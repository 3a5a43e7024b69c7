//! `cargo board [IMAGE]`: builds an image of fsw-target, flashes it with probe-rs, prints its log.

use anyhow::{Result, bail};
use std::process::{Command, ExitCode};
use target_tools::{command, firmware, toolchain};

/// Default image.
const DEFAULT_IMAGE: &str = "flight";

/// Chip of the board, by its name in probe-rs.
const CHIP: &str = "STM32F405RGTx";

fn main() -> ExitCode {
    command::exit_code("cargo board", run())
}

fn run() -> Result<bool> {
    let mut images = std::env::args().skip(1);
    let image = images.next().unwrap_or_else(|| DEFAULT_IMAGE.into());
    if image.starts_with('-') || images.next().is_some() {
        bail!("usage: cargo board [IMAGE]");
    }
    if Command::new("probe-rs").arg("--version").output().is_err() {
        bail!("cannot start probe-rs: install it (cargo install probe-rs-tools)");
    }
    let elf = firmware::build(&image)?;
    toolchain::run(Command::new("probe-rs").args(["run", "--chip", CHIP]).arg(elf))?;
    Ok(true)
}
