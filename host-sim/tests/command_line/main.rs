//! Command line of `host-sim`: verbs, exit codes, error messages.
//!
//! ```text
//! program    the program, its output, files with valid content
//! run        run, crlb          mc         campaigns        replay    recorded logs
//! bad_input  rejected files and arguments                   tables    published tables
//! logs       logs with faults, other notations and units
//! faults     matrix of faults and estimators
//! diagnose   explanations of residuals, systematic errors         design    designed manoeuvres
//! command    telecommands       telemetry  packets of the serial line
//! ```

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

mod bad_input;
mod command;
mod design;
mod diagnose;
mod faults;
mod logs;
mod mc;
mod program;
mod replay;
mod run;
mod shards;
mod tables;
mod telemetry;
