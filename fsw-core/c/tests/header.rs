//! The committed header is the generated one.
//!
//! To write it: `FSW_WRITE_HEADER=1 cargo test -p fsw-core-c --test header`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use std::path::Path;

#[test]
fn header_is_the_generated_one() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml")).unwrap();
    let mut generated = Vec::new();
    cbindgen::generate_with_config(package, config).unwrap().write(&mut generated);
    let generated = String::from_utf8(generated).unwrap();
    let path = package.join("include/fsw_core.h");
    if std::env::var_os("FSW_WRITE_HEADER").is_some() {
        std::fs::write(&path, &generated).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let differing = committed.lines().zip(generated.lines()).position(|(old, new)| old != new);
    assert!(
        committed == generated,
        "include/fsw_core.h differs from the generated header, first in line {}. Write it by: \
         FSW_WRITE_HEADER=1 cargo test -p fsw-core-c --test header",
        differing.unwrap_or(committed.lines().count().min(generated.lines().count())) + 1
    );
}
