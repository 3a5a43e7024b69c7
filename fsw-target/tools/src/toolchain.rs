//! Compiler for the Cortex-M: the ambient toolchain if it has the target, otherwise Debian's.
//!
//! Debian packages a recent rustc for its browsers (rustc-web, in /usr/bin) without the bare-metal
//! target, but with the source of the library (rust-web-src). `core` is then built from source, which
//! a stable compiler permits with `RUSTC_BOOTSTRAP`.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

/// Target of the flight computer: Cortex-M4F, hardware floating point.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Compiler, cargo and linker of Debian's packages.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_LINKER: &str = "/usr/bin/ld.lld";

/// A toolchain that can build for the Cortex-M.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Toolchain {
    /// `cargo` and `rustc` of the environment, with the target installed.
    Ambient,
    /// Debian's toolchain, which builds `core` from source.
    Debian,
}

impl Toolchain {
    /// The first toolchain found for [`TARGET`].
    ///
    /// # Errors
    /// No toolchain. The message names the packages to install.
    pub fn find() -> Result<Self> {
        Self::find_for(TARGET)
    }

    /// As [`find`](Self::find), for `target`.
    ///
    /// # Errors
    /// As there.
    pub fn find_for(target: &str) -> Result<Self> {
        let ambient = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
        if sysroot(&ambient).is_some_and(|root| has(&root, &format!("rustlib/{target}/lib"))) {
            return Ok(Self::Ambient);
        }
        if sysroot(DEBIAN_RUSTC).is_some_and(|root| has(&root, "rustlib/src/rust/library/core")) {
            return Ok(Self::Debian);
        }
        bail!(
            "no compiler for {target}: run `rustup target add {target}`, or on Debian \
             `apt-get install rustc-web cargo-web rust-web-src lld`"
        )
    }

    /// `cargo SUBCOMMAND` for [`TARGET`], to run in the workspace's root folder.
    pub fn cargo(self, subcommand: &str) -> Result<Command> {
        self.cargo_for(TARGET, subcommand)
    }

    /// `cargo SUBCOMMAND` for `target`, to run in the workspace's root folder.
    pub fn cargo_for(self, target: &str, subcommand: &str) -> Result<Command> {
        let mut cargo = match self {
            Self::Ambient => {
                let mut cargo = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
                cargo.arg(subcommand);
                cargo
            }
            Self::Debian => debian_cargo(target, subcommand)?,
        };
        cargo.args(["--target", target]);
        Ok(cargo)
    }
}

fn debian_cargo(target: &str, subcommand: &str) -> Result<Command> {
    if !Path::new(DEBIAN_LINKER).exists() {
        bail!("no linker for {target}: run `apt-get install lld`");
    }
    let linker = target.to_uppercase().replace(['-', '.'], "_");
    let mut cargo = Command::new(DEBIAN_CARGO);
    cargo
        .args([subcommand, "-Zbuild-std=core", "-Zbuild-std-features=compiler-builtins-mem"])
        // Permits a stable compiler to build its own library.
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTC", DEBIAN_RUSTC)
        // Debian's compiler has no linker for bare metal.
        .env(format!("CARGO_TARGET_{linker}_LINKER"), DEBIAN_LINKER);
    // Variables of the calling cargo's toolchain.
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

/// Runs `command` to its end.
///
/// # Errors
/// The command does not start, or fails.
pub fn run(command: &mut Command) -> Result<()> {
    let status =
        command.status().with_context(|| format!("cannot start {:?}", command.get_program()))?;
    if !status.success() {
        bail!("{:?} failed: {status}", command.get_program());
    }
    Ok(())
}
