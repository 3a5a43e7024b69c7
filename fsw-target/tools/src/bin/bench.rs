//! `cargo bench-target`: what each step of the estimators costs on the target, in instructions,
//! beside the budgets. Exit code 1 where one is exceeded, 2 where nothing could be counted.

use std::io::Write;
use std::process::ExitCode;
use target_tools::bench;

fn main() -> ExitCode {
    match bench::run() {
        Ok(table) => {
            // A reader that has seen enough (`cargo bench-target | head`) is no error.
            let _ = writeln!(std::io::stdout(), "{table}");
            if table.is_kept() { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(error) => {
            eprintln!("cargo bench-target: {error:#}");
            ExitCode::from(2)
        }
    }
}
