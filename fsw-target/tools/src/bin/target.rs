//! `cargo target SUBCOMMAND [ARGUMENTS]`: cargo for the Cortex-M, with whichever toolchain can.

use anyhow::{Context, Result};
use std::process::ExitCode;
use target_tools::toolchain::{self, Toolchain};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo target: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let subcommand =
        arguments.next().context("say what to do, for example: cargo target build -p fsw-core")?;
    toolchain::run(Toolchain::find()?.cargo(&subcommand)?.args(arguments))
}
