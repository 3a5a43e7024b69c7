//! Linker scripts of every image: cortex-m-rt's, defmt's, and `memory.x` at the root of the workspace, which includes the
//! board's.

use std::path::Path;

/// Adds the scripts to the images of the package. `root`: folder of the workspace.
pub fn add_scripts(root: &Path) {
    println!("cargo:rustc-link-search={}", root.display());
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
}
