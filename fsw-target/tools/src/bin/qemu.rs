//! `cargo qemu [IMAGE]`: builds an image of fsw-target as it is flashed, runs it in QEMU, prints
//! its log and exits with its status.

use anyhow::{Result, bail};
use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;
use target_tools::{firmware, qemu};

/// The image that is run when none is named.
const DEFAULT_IMAGE: &str = "replay";

/// No image of this project runs longer than that in QEMU.
const LIMIT: Duration = Duration::from_secs(300);

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo qemu: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Whether the image reported success.
fn run() -> Result<bool> {
    let (machine, image) = arguments()?;
    let elf = firmware::build(&image)?;
    let mut out = std::io::stdout();
    let run = qemu::run(&elf, &machine, LIMIT, |line| {
        // A reader that has seen enough (`cargo qemu | head`) doesn't end the run.
        let _ = writeln!(out, "{line}");
    })?;
    Ok(run.success)
}

/// `[--machine MACHINE] [IMAGE]`.
fn arguments() -> Result<(String, String)> {
    let mut machine = qemu::MACHINE.to_string();
    let mut image = DEFAULT_IMAGE.to_string();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--machine" => match arguments.next() {
                Some(name) => machine = name,
                None => bail!("--machine needs the name of a QEMU machine"),
            },
            name if !name.starts_with('-') => image = name.into(),
            other => bail!("unknown argument {other}; usage: cargo qemu [IMAGE]"),
        }
    }
    Ok((machine, image))
}
