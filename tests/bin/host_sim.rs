//! `host-sim`, built with the tests of this package, which cannot name the program of another.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
