//! `host-sim`: see `host-sim --help`, and the crate's page for the way of the data.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
