//! A fingerprint of the sources of the flight computer, equal on target and host.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of `src` outside the fingerprint: core and board, which the host does not compile, and the
/// images.
const LEFT_OUT: [&str; 3] = ["arch", "board", "bin"];

/// The constant `SOURCES`. `package` is the folder of this crate.
pub fn fingerprint(package: &Path) -> Result<String, Box<dyn Error>> {
    let root = package.parent().ok_or("fsw-target has no parent folder")?;
    let mut places = vec![root.join("Cargo.lock"), root.join("fsw-core/src")];
    places.extend(["roster/src", "steps/src", "tags/src"].map(|folder| package.join(folder)));
    for entry in fs::read_dir(package.join("src"))? {
        let entry = entry?;
        if !LEFT_OUT.iter().any(|name| entry.file_name() == *name) {
            places.push(entry.path());
        }
    }
    let mut files = Vec::new();
    for place in places {
        println!("cargo:rerun-if-changed={}", place.display());
        collect(place, &mut files)?;
    }
    // Sorted by the name within the workspace: independent of the machine.
    let mut named = Vec::new();
    for file in files {
        let name = file.strip_prefix(root)?.to_string_lossy().replace('\\', "/");
        named.push((name, fs::read(&file)?));
    }
    named.sort();
    let mut hash = Fnv::new();
    for (name, content) in &named {
        hash.add(name.as_bytes());
        hash.add(&(content.len() as u64).to_be_bytes());
        hash.add(content);
    }
    Ok(format!(
        "/// Fingerprint of the sources: fsw-core, this crate without core, board and images, and the\n\
         /// versions of all crates.\n\
         pub const SOURCES: u64 = {:#x};\n",
        hash.0
    ))
}

/// A file, or all files below a folder.
fn collect(place: PathBuf, files: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    if !place.is_dir() {
        files.push(place);
        return Ok(());
    }
    for entry in fs::read_dir(place)? {
        collect(entry?.path(), files)?;
    }
    Ok(())
}

/// FNV-1a, 64 bits.
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
