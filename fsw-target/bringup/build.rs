//! Linker scripts for the chip (target OS `none`), and that of embedded-test for the image `board-tests`. Host builds need
//! none.

#[path = "../build/link.rs"]
mod link;

use std::{env, path::Path};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../build/link.rs");
    // A condition in the code that embedded-test generates.
    println!("cargo:rustc-check-cfg=cfg(rust_analyzer)");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        link::add_scripts(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
        println!("cargo:rustc-link-arg-bin=board-tests=-Tembedded-test.x");
    }
}
