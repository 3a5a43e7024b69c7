//! A compiler for the Cortex-M: the ambient toolchain if it has the target, else Debian's.
//!
//! Debian packages a recent rustc for its browsers (rustc-web, in /usr/bin) without the bare-metal
//! target, but with the library's source (rust-web-src): `core` is then built from source, which
//! stable compilers only do when told that they may.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

/// The target of the flight computer: Cortex-M4F, hardware floating point.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Where Debian's packages put compiler, cargo and linker.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_LINKER: &str = "/usr/bin/ld.lld";

/// What to do about it when no compiler is there.
const HOW_TO_INSTALL: &str = "no compiler for thumbv7em-none-eabihf: run \
    `rustup target add thumbv7em-none-eabihf`, or on Debian \
    `apt-get install rustc-web cargo-web rust-web-src lld`";

/// A toolchain that can build for [`TARGET`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Toolchain {
    /// The one that `cargo` and `rustc` stand for here; it has the target installed.
    Ambient,
    /// Debian's, which builds `core` from source.
    Debian,
}

impl Toolchain {
    /// The first that is there, or what to install.
    pub fn find() -> Result<Self> {
        let ambient = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
        if sysroot(&ambient).is_some_and(|root| has(&root, &format!("rustlib/{TARGET}/lib"))) {
            return Ok(Self::Ambient);
        }
        if sysroot(DEBIAN_RUSTC).is_some_and(|root| has(&root, "rustlib/src/rust/library/core")) {
            return Ok(Self::Debian);
        }
        bail!(HOW_TO_INSTALL)
    }

    /// `cargo SUBCOMMAND` for [`TARGET`], to be run at the root of the workspace.
    pub fn cargo(self, subcommand: &str) -> Result<Command> {
        let mut cargo = match self {
            Self::Ambient => {
                let mut cargo = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
                cargo.arg(subcommand);
                cargo
            }
            Self::Debian => debian_cargo(subcommand)?,
        };
        cargo.args(["--target", TARGET]);
        Ok(cargo)
    }
}

fn debian_cargo(subcommand: &str) -> Result<Command> {
    if !Path::new(DEBIAN_LINKER).exists() {
        bail!("no linker for {TARGET}: run `apt-get install lld`");
    }
    let mut cargo = Command::new(DEBIAN_CARGO);
    cargo
        .args([subcommand, "-Zbuild-std=core", "-Zbuild-std-features=compiler-builtins-mem"])
        // Lets a stable compiler build its own library.
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTC", DEBIAN_RUSTC)
        // Debian's compiler brings no linker for bare metal.
        .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", DEBIAN_LINKER);
    // Set by the cargo that runs this program, for its own toolchain.
    for variable in ["RUSTUP_TOOLCHAIN", "CARGO", "RUSTDOC", "LD_LIBRARY_PATH"] {
        cargo.env_remove(variable);
    }
    Ok(cargo)
}

fn has(sysroot: &Path, folder: &str) -> bool {
    sysroot.join("lib").join(folder).is_dir()
}

fn sysroot(rustc: &str) -> Option<std::path::PathBuf> {
    let output = Command::new(rustc).args(["--print", "sysroot"]).output().ok()?;
    let path = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| path.trim().into())
}

/// Runs `command` to its end; an error if it can't be started or fails.
pub fn run(command: &mut Command) -> Result<()> {
    let status =
        command.status().with_context(|| format!("could not start {:?}", command.get_program()))?;
    if !status.success() {
        bail!("{:?} failed: {status}", command.get_program());
    }
    Ok(())
}
