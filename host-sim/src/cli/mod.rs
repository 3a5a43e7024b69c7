//! The command line: one file per verb, which parses, calls the library and prints.
//!
//! Results go to stdout; errors and notes go to stderr. Exit code 0: complete; 1: a run that could
//! not finish; 2: bad input.

mod command;
mod crlb;
mod diagnose;
mod estimate;
mod failure;
mod flight_estimator;
mod key;
mod mc;
mod notes;
#[cfg(unix)]
mod pil;
mod progress;
mod replay;
mod run;
mod tables;
mod telemetry;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use serde::Serialize;

use crate::estimation::Method;
use failure::{BAD_INPUT, Failure};

/// Simulate a spacecraft or replay its log, and estimate its inertia tensor with the flight core
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = false)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Simulate one flight, estimate, and compare with the truth and the Cramér-Rao bound
    ///
    /// Example: host-sim run stsat3-spin-up --out report
    Run(run::Arguments),
    /// Monte Carlo campaign: RMS error and bias compared with the bound, and NEES
    ///
    /// Example: host-sim mc cubesat-pyramid --runs 1000 --out runs.csv
    ///
    /// Runs differ in gyro noise and in the dispersion of the scenario. A run has converged if the
    /// estimator reports so and each error is within 20 bounds. It has diverged if the estimator
    /// reports so, if an error is not finite, or if an error exceeds both 20 bounds and 5 of the
    /// estimator's own sigmas. Diverged runs are counted and left out of the figures. If runs have
    /// different truths, each is compared with its own; the table has the mean of the truths and the
    /// RMS of the bounds.
    ///
    /// If each run draws its own spacecraft (mc random-spacecraft), runs in which the bound of any
    /// element exceeds a tenth of the mean moment are counted as unobserved, and excluded from the
    /// figures.
    ///
    /// A run counts as changed if the estimator discarded its knowledge at least once because new
    /// data contradicted it. Residuals are not white if they differ from the gyro noise at the end
    /// of the run; not every estimator tests this. A run is a silent lie if the estimator reports
    /// convergence, the residuals are not found non-white, and an error exceeds 5 of its sigmas.
    ///
    /// If the inertia changes in flight, the truth is at the end of the flight, and the bound is of
    /// the data after the last sudden change.
    ///
    /// Ctrl-C stops the campaign; the result is of the completed runs. All cores are used, or the
    /// number in the environment variable RAYON_NUM_THREADS; the result is the same.
    Mc(mc::Arguments),
    /// Tables of five papers: published, reproduced, and the bound
    ///
    /// Example: host-sim tables --runs 1000 --out papers
    ///
    /// Ctrl-C stops the runs; the result is of the completed ones. All cores are used; the result is
    /// the same on any number of cores.
    Tables(tables::Arguments),
    /// Estimate from a recorded log
    ///
    /// Example: host-sim replay --craft craft.toml log.csv --out report
    Replay(replay::Arguments),
    /// Causes that explain the residuals of a log, ranked
    ///
    /// Example: host-sim diagnose --craft craft.toml log.csv
    ///
    /// Candidates are errors of gyro, wheels and torque, and mistakes of log and craft file: a wheel's sign, gyro axes
    /// permuted, units, columns late by rows. Each is fitted to the whole log; the share of the excess of chi-square
    /// that it accounts for is printed, with the line that states or corrects it. Causes that the log does not
    /// distinguish are named together.
    Diagnose(diagnose::Arguments),
    /// Cramér-Rao bound of a scenario: the smallest sigma of any unbiased estimator
    ///
    /// Example: host-sim crlb microsat-slew
    Crlb(crlb::Arguments),
    /// Telemetry packets of a flight computer's serial line, one line each
    ///
    /// Example: host-sim telemetry /dev/ttyUSB0
    ///
    /// Set the port to raw mode first: stty -F /dev/ttyUSB0 115200 raw -echo. Damaged and missing
    /// packets are noted on stderr. The text leaves out counts of zero; with --json each line is one
    /// document with every field.
    Telemetry(telemetry::Arguments),
    /// Telecommand for a flight computer, as bytes on stdout
    ///
    /// Example: host-sim command reset > /dev/ttyUSB0
    ///
    /// Set the port to raw mode first: stty -F /dev/ttyUSB0 115200 raw -echo.
    Command(command::Arguments),
    /// Key of a slot from the master key of a flight image, for command and telemetry
    ///
    /// Example: host-sim derive-key master.key --slot 1 > slot1.key
    ///
    /// The master key stays where the keys are managed; a ground station has the key of its slot.
    DeriveKey(key::Arguments),
    /// Processor in the loop: the firmware in QEMU with simulated sensors, compared with the host
    ///
    /// Example: host-sim pil stsat3-spin-up --estimator window
    ///
    /// The firmware reads gyro and wheels over a serial port from models at register level. Driver,
    /// conversion and estimator are those of the flight image, on its processor. The same software
    /// runs on the host. Both states are compared bit by bit after each sample; the first difference
    /// ends the flight with its sample and element.
    ///
    /// Requires QEMU and a compiler for the Cortex-M; an error names the package to install.
    #[cfg(unix)]
    Pil(pil::Arguments),
}

/// Options of the verbs that estimate from one log.
#[derive(Debug, Args)]
struct Options {
    #[command(flatten)]
    method: Method,
    /// Write time history, plots and a report into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(misuse) if misuse.use_stderr() => {
            eprintln!("{}", in_two_lines(&misuse.render().to_string()));
            return ExitCode::from(BAD_INPUT);
        }
        Err(help_or_version) => help_or_version.exit(),
    };
    let result = match cli.verb {
        Verb::Run(arguments) => run::run(&arguments),
        Verb::Mc(arguments) => mc::run(&arguments),
        Verb::Tables(arguments) => tables::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
        Verb::Diagnose(arguments) => diagnose::run(&arguments),
        Verb::Crlb(arguments) => crlb::run(&arguments),
        Verb::Telemetry(arguments) => telemetry::run(&arguments),
        Verb::Command(arguments) => command::run(&arguments),
        Verb::DeriveKey(arguments) => key::run(&arguments),
        #[cfg(unix)]
        Verb::Pil(arguments) => pil::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Message of clap, which has paragraphs of several lines, in two lines: error, remedy.
fn in_two_lines(message: &str) -> String {
    let lines = |paragraph: &str| paragraph.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let mut paragraphs = message.trim().split("\n\n").map(lines);
    let error = paragraphs.next().unwrap_or_default();
    let remedy: Vec<String> = paragraphs.collect();
    format!("{error}\n  {}", remedy.join(". "))
}

/// Prints a table, or its report as one JSON document.
fn print(json: bool, report: &impl Serialize, table: &str) -> Result<(), Failure> {
    let text = if json {
        serde_json::to_string_pretty(report).map_err(Failure::Json)? + "\n"
    } else {
        table.to_owned()
    };
    write_out(&text)
}

/// Prints a line.
fn print_line(text: &str) -> Result<(), Failure> {
    write_out(&format!("{text}\n"))
}

fn write_out(text: &str) -> Result<(), Failure> {
    match io::stdout().write_all(text.as_bytes()) {
        // A closed pipe, as with `head`, is not an error.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Failure::Print),
    }
}

/// Command line of this process, for the report.
fn command_line() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("cargo run --release -p host-sim -- {}", arguments.join(" "))
}
