//! `cargo bench-target`: instructions of each estimator step on the target, compared with the budgets.
//! Exit code 1 if a budget is exceeded, 2 if nothing could be counted.

use std::io::Write;
use std::process::ExitCode;
use target_tools::bench;

fn main() -> ExitCode {
    match bench::run() {
        Ok(table) => {
            // A closed pipe (`cargo bench-target | head`) is not an error.
            let _ = writeln!(std::io::stdout(), "{table}");
            if table.is_kept() { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(error) => {
            eprintln!("cargo bench-target: {error:#}");
            ExitCode::from(2)
        }
    }
}
