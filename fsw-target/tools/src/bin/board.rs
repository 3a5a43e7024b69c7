//! `cargo board [IMAGE] [ARGUMENTS]`: builds an image, flashes it with probe-rs, prints its log. Further arguments are
//! those of `probe-rs run`: for `board-tests`, names of tests and `--include-ignored`.

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
    let mut arguments = std::env::args().skip(1);
    let image = arguments.next().unwrap_or_else(|| DEFAULT_IMAGE.into());
    if image.starts_with('-') {
        bail!("usage: cargo board [IMAGE] [ARGUMENTS of probe-rs run]");
    }
    if Command::new("probe-rs").arg("--version").output().is_err() {
        bail!("cannot start probe-rs: install it (cargo install probe-rs-tools)");
    }
    let elf = firmware::build(&image)?;
    toolchain::run(
        Command::new("probe-rs").args(["run", "--chip", CHIP]).arg(elf).args(arguments),
    )?;
    Ok(true)
}
