//! Writes `docs/keys.md`, the reference of keys and columns, from the readers.

fn main() -> std::io::Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/keys.md");
    std::fs::write(path, host_sim::input::keys::page())
}
