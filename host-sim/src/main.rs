//! `host-sim`.

fn main() {}
