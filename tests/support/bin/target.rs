//! `cargo target SUBCOMMAND [ARGUMENTS]`: cargo for the Cortex-M, with whichever toolchain can.

use anyhow::{Context, Result};
use support::toolchain::{self, Toolchain};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let subcommand =
        arguments.next().context("say what to do, for example: cargo target build -p fsw-core")?;
    toolchain::run(Toolchain::find()?.cargo(&subcommand)?.args(arguments))
}
