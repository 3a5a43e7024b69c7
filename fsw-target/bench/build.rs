//! Linker scripts for the chip (target OS `none`). Host builds need none.

#[path = "../build/link.rs"]
mod link;

use std::{env, path::Path};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../build/link.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        link::add_scripts(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    }
}
