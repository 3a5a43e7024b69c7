//! Exit code of the cargo aliases.

use anyhow::Result;
use std::process::ExitCode;

/// Success for `true`, failure for `false`. An error is printed on standard error after the name of
/// the command, and is a failure.
pub fn exit_code(command: &str, result: Result<bool>) -> ExitCode {
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{command}: {error:#}");
            ExitCode::FAILURE
        }
    }
}
