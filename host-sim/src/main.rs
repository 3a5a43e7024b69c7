//! Program `host-sim`. Usage: `host-sim --help`; data flow: the crate page of the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
