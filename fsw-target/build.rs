//! Inputs of the compiler and the linker beyond the sources:
//!
//! 1. For the chip (target OS `none`): the choice of the board with its memory, and the linker scripts of cortex-m-rt and
//!    defmt. Host builds need neither.
//! 2. The spacecraft of the flight image and each recorded flight, as constants: host and target fly
//!    the same bits, and the target needs no parser.
//! 3. The master key of telecommands, if the environment names one.
//! 4. A fingerprint of the sources, by which host and target detect a difference between them.
//!
//! Craft files and logs are read by `flight-input`, as in `host-sim replay`.

#[path = "build/board.rs"]
mod board;
#[path = "build/craft.rs"]
mod craft;
#[path = "build/flight_table.rs"]
mod flight_table;
#[path = "build/key.rs"]
mod key;
#[path = "build/link.rs"]
mod link;
#[path = "build/sources.rs"]
mod sources;

use flight_input::{Craft, RecordedLog};
use std::path::{Path, PathBuf};
use std::{env, error::Error, fs, process::ExitCode};

/// Wheels of the flight image: `fsw_steps::WHEELS`, to which the compiler compares the constant.
const WHEELS: usize = 4;

/// File stems in `flights/`, each with a log (`.csv`) and its craft (`.craft.toml`).
const FLIGHTS: [&str; 1] = ["cubesat_pyramid"];

fn main() -> ExitCode {
    let Err(error) = prepare() else { return ExitCode::SUCCESS };
    for line in error.to_string().lines() {
        println!("cargo::error={line}");
    }
    ExitCode::FAILURE
}

fn prepare() -> Result<(), Box<dyn Error>> {
    let package = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?);
    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        link_for_the_chip(&package, &out)?;
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=build");

    let (_, craft) = read_craft(&package.join("craft.toml"), Some(WHEELS))?;
    fs::write(out.join("craft.rs"), craft)?;
    fs::write(out.join("key.rs"), key::source()?)?;
    fs::write(out.join("sources.rs"), sources::fingerprint(&package)?)?;
    for flight in FLIGHTS {
        let path = package.join(format!("flights/{flight}.craft.toml"));
        let (wheels, craft) = read_craft(&path, None)?;
        let path = package.join(format!("flights/{flight}.csv"));
        let rows = RecordedLog::load(watch(&path), wheels)?.rows;
        let table = flight_table::source(&rows, wheels)?;
        fs::write(out.join(format!("{flight}.rs")), craft + &table)?;
    }
    Ok(())
}

/// The number of wheels of a craft file and its constant, with `capacity` wheels or for those of
/// the file.
fn read_craft(path: &Path, capacity: Option<usize>) -> Result<(usize, String), Box<dyn Error>> {
    let craft = Craft::load(watch(path))?;
    let wheels = craft.wheels.len();
    let source = craft::source(&craft, capacity.unwrap_or(wheels))
        .map_err(|why| format!("{}: {why}", path.display()))?;
    Ok((wheels, source))
}

/// Repeats the build when the file changes.
fn watch(path: &Path) -> &Path {
    println!("cargo:rerun-if-changed={}", path.display());
    path
}

/// Linker scripts; `memory.x` in the root of the workspace includes that of the board.
fn link_for_the_chip(package: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    let variable = |feature: &str| feature.to_uppercase().replace('-', "_");
    let is_selected =
        |feature: &str| env::var_os(format!("CARGO_FEATURE_{}", variable(feature))).is_some();
    let board = board::choose(is_selected, &env::var("TARGET")?)?;
    board::write_scripts(&board, package, out)?;
    let root = package.parent().ok_or("fsw-target has no parent folder")?;
    link::add_scripts(root);
    Ok(())
}
