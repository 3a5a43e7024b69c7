//! `cargo target SUBCOMMAND [ARGUMENTS]`: cargo for the Cortex-M, with the toolchain found.

use anyhow::{Context, Result};
use std::process::ExitCode;
use target_tools::command;
use target_tools::toolchain::{self, Toolchain};

fn main() -> ExitCode {
    command::exit_code("cargo target", run())
}

fn run() -> Result<bool> {
    let mut arguments = std::env::args().skip(1);
    let subcommand = arguments
        .next()
        .context("missing subcommand, for example: cargo target build -p fsw-core")?;
    toolchain::run(Toolchain::find()?.cargo(&subcommand)?.args(arguments))?;
    Ok(true)
}
