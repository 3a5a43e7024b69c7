//! Linker scripts for the chip (target OS `none`): cortex-m-rt's, defmt's, the tests' of embedded-test, and the board's
//! `memory.x` at the root of the workspace. Host builds need none.

use std::{env, path::Path};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // A condition in the code that embedded-test generates.
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    println!("cargo:rustc-link-search={}", root.display());
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo:rustc-link-arg-bin=board-tests=-Tembedded-test.x");
}
