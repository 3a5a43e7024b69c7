//! `cargo qemu [IMAGE]`: builds an image of fsw-target, runs it in QEMU, prints its log and exits
//! with its status.

use anyhow::{Result, bail};
use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;
use target_tools::board::{Board, STM32F405};
use target_tools::{command, firmware, qemu};

/// Default image.
const DEFAULT_IMAGE: &str = "replay";

/// Time limit of a run.
const LIMIT: Duration = Duration::from_secs(300);

fn main() -> ExitCode {
    command::exit_code("cargo qemu", run())
}

/// Runs the image. Returns whether it reported success.
fn run() -> Result<bool> {
    let (board, machine, image) = arguments()?;
    let elf = firmware::build_for(&board, &image)?;
    let mut out = std::io::stdout();
    let run = qemu::run(&elf, &machine, LIMIT, |line| {
        // A closed pipe (`cargo qemu | head`) does not end the run.
        let _ = writeln!(out, "{line}");
    })?;
    Ok(run.success)
}

/// Parses `[--machine MACHINE] [--board BOARD] [IMAGE]`. The machine is that of the board unless one follows it.
fn arguments() -> Result<(Board, String, String)> {
    let mut board = STM32F405;
    let mut machine = board.machine.to_string();
    let mut image = DEFAULT_IMAGE.to_string();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--machine" => match arguments.next() {
                Some(name) => machine = name,
                None => {
                    bail!("--machine needs the name of a QEMU machine, such as {}", qemu::MACHINE)
                }
            },
            "--board" => {
                board = Board::of_name(&arguments.next().unwrap_or_default())?;
                machine = board.machine.into();
            }
            name if !name.starts_with('-') => image = name.into(),
            other => {
                bail!(
                    "unknown argument {other}; usage: cargo qemu [--board BOARD] [--machine MACHINE] [IMAGE]"
                )
            }
        }
    }
    Ok((board, machine, image))
}
