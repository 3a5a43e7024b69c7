//! `cargo bench-target`: what each step of the estimators costs on the target, in instructions,
//! beside the budgets. Exit code 1 where one is exceeded, 2 where nothing could be counted.

use std::io::Write;
use std::process::ExitCode;
use target_tools::bench;

fn main() -> ExitCode {
    let mut out = std::io::stdout();
    // A reader that has seen enough (`cargo bench-target | head`) doesn't end the run.
    match bench::run(|line| drop(writeln!(out, "{line}"))) {
        Ok(table) => {
            let _ = writeln!(std::io::stdout(), "{table}");
            if table.exceeded().is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(error) => {
            eprintln!("cargo bench-target: {error:#}");
            ExitCode::from(2)
        }
    }
}
