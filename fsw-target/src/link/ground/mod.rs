//! Files for ground systems: `ground/link.xml`, the packets and telecommands as XTCE 1.2 (CCSDS 660.0-B-2), and
//! `ground/samples.jsonl`, packets with their values for other readers.
//!
//! Both are generated from the types of the link and compared with the committed files. To write them anew:
//! `UPDATE_GROUND=1 cargo test -p fsw-target --lib ground`.

extern crate std;
mod arguments;
mod fields;
mod inventory;
mod samples;
mod xtce;

use std::path::Path;
use std::string::String;
use std::{fs, println};

/// Compares a file of `ground/` with its generated text, or writes it where `UPDATE_GROUND` is set.
fn assert_current(name: &str, generated: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("ground").join(name);
    if std::env::var_os("UPDATE_GROUND").is_some() {
        fs::write(&path, generated).unwrap();
    }
    let committed = fs::read_to_string(&path).unwrap_or_else(|_| String::new());
    let same = committed.lines().zip(generated.lines()).take_while(|(a, b)| a == b).count();
    if committed != generated {
        println!("expected in line {}: {:?}", same + 1, generated.lines().nth(same));
        println!("committed:           {:?}", committed.lines().nth(same));
        panic!(
            "ground/{name} differs from the types: run UPDATE_GROUND=1 cargo test -p fsw-target --lib ground"
        );
    }
}

#[test]
fn xtce_matches_the_types() {
    assert_current("link.xml", &xtce::document());
}

#[test]
fn samples_match_the_types() {
    assert_current("samples.jsonl", &samples::lines());
}
