//! Prepares what the compiler and the linker need beyond the sources:
//!
//! 1. For the chip (target OS `none`): the linker scripts of cortex-m-rt and defmt, and where the
//!    board's `memory.x` is. Host builds of the workspace need neither.
//! 2. For both: the spacecraft that the flight image is built for, and each recorded flight, as
//!    constants, so that host and target fly the same bits and the target needs no parser.
//! 3. For both: a fingerprint of the sources, by which they see whether they are of the same.

#[path = "build/craft.rs"]
mod craft;
#[path = "build/flight_table.rs"]
mod flight_table;
#[path = "build/sources.rs"]
mod sources;

use std::{env, error::Error, fs, path::Path, process::ExitCode};

/// Wheels that the flight image has room for, as `craft::WHEELS` says.
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
    let package_var = env::var("CARGO_MANIFEST_DIR")?;
    let package = Path::new(&package_var);
    let out_var = env::var("OUT_DIR")?;

    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        link_for_the_chip(package)?;
    }

    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=build");
    let flown = package.join("craft.toml");
    println!("cargo:rerun-if-changed={}", flown.display());
    let source = craft::Craft::load(&flown)?
        .to_source(WHEELS)
        .map_err(|e| format!("{}: {e}", flown.display()))?;
    fs::write(Path::new(&out_var).join("craft.rs"), source)?;
    fs::write(Path::new(&out_var).join("sources.rs"), sources::fingerprint(package)?)?;
    for flight in FLIGHTS {
        let log = package.join(format!("flights/{flight}.csv"));
        let craft = package.join(format!("flights/{flight}.craft.toml"));
        println!("cargo:rerun-if-changed={}", log.display());
        println!("cargo:rerun-if-changed={}", craft.display());
        let table = flight_table::generate(&log, &craft)?;
        fs::write(Path::new(&out_var).join(format!("{flight}.rs")), table)?;
    }
    Ok(())
}

/// `memory.x` is at the root of the workspace, beside the first Cargo.toml that a porter opens.
fn link_for_the_chip(package: &Path) -> Result<(), Box<dyn Error>> {
    let root = package.parent().ok_or("fsw-target has no parent folder")?;
    println!("cargo:rustc-link-search={}", root.display());
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    Ok(())
}
