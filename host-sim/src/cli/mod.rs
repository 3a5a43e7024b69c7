//! The command line: one file for each verb, and what they share.
//!
//! Results go to stdout; errors and notes to stderr. Exit code 0: done; 1: a run that could not
//! finish; 2: bad input.

mod campaign;
mod command;
mod crlb;
mod estimate;
mod mc;
#[cfg(unix)]
mod pil;
mod replay;
mod run;
mod tables;
mod telemetry;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use fsw_target::link::command::CommandError;
use serde::Serialize;
use thiserror::Error;

use crate::campaign::RunFailed;
use crate::estimation::{EstimatorName, Precision, SetUpError};
use crate::input::InputError;
use crate::papers::PapersFailed;
use crate::report::OutputError;
use crate::truth::IntegrationFailed;

/// Simulate a spacecraft or replay its log, and estimate its inertia tensor with the flight core.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = false)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Simulate one flight, estimate, and set the estimate beside the truth and the bound.
    Run(run::Arguments),
    /// Many flights that differ in gyro noise, and in what the scenario disperses: RMS error and bias
    /// beside the bound, and NEES.
    ///
    /// A run has converged if it says so and each error is within 20 bounds. It has diverged, and is
    /// left out of the figures, if it says so, or if an error isn't finite, or is beyond 20 bounds and
    /// five of the estimator's own sigmas: far off, and sure of it. Where runs have different truths,
    /// the table shows their mean and the RMS of their bounds, and each run is measured with its own.
    ///
    /// Where each run draws its own spacecraft (`mc random-spacecraft`), those whose motion leaves the
    /// bound of an element above a tenth of the mean moment are counted, and left out of the figures.
    ///
    /// A change is found in a run where the estimator dropped what it knew before, at least once, since
    /// new data contradicted it. Residuals aren't white where they don't look like the gyro's noise at
    /// the end of a run; not every estimator tests that.
    ///
    /// Where the inertia changes in flight, the truth is that at the end, and the bound is of what follows
    /// the last sudden change.
    ///
    /// Ctrl-C ends it early, and what is complete by then is its result. All cores are used, or
    /// as many as the environment variable RAYON_NUM_THREADS says: the numbers are the same.
    Mc(mc::Arguments),
    /// The tables of five papers: published, reproduced, and what is possible.
    ///
    /// Ctrl-C ends it early, and what is complete by then is its result. All cores are used; the
    /// numbers are the same on any number of them.
    Tables(tables::Arguments),
    /// Estimate from a recorded log.
    Replay(replay::Arguments),
    /// The Cramér-Rao bound of a scenario: what no unbiased estimator can beat.
    Crlb(crlb::Arguments),
    /// What a flight computer says on its serial line: one line for each telemetry packet.
    ///
    /// A port must be set to raw first: stty -F /dev/ttyUSB0 115200 raw -echo. What is damaged or
    /// missing is noted on stderr; in text, counts of zero are left out. With --json each line is a
    /// document of its own.
    Telemetry(telemetry::Arguments),
    /// A telecommand, as the bytes that go to a flight computer's serial port: on stdout.
    ///
    /// As in: host-sim command reset > /dev/ttyUSB0, with the port set to raw first: stty -F
    /// /dev/ttyUSB0 115200 raw -echo.
    Command(command::Arguments),
    /// Fly the firmware itself, in QEMU, with simulated sensors, and compare with the host bit by bit.
    ///
    /// The firmware asks for its gyro and wheels on a serial port, and a model of the chip answers, register
    /// by register: driver, conversion and estimator are those of the flight image, on its processor. The
    /// same software flies on the host at the same time. What both know is compared after each sample, to
    /// the last bit; the first difference ends the flight, with its sample and element.
    ///
    /// Needs QEMU and a compiler for the Cortex-M, and says what to install where they are missing.
    #[cfg(unix)]
    Pil(pil::Arguments),
}

/// How to estimate: the same for every verb that does.
#[derive(Clone, Copy, Debug, Args)]
struct Method {
    /// The estimator: our own, the nine-state filter, or one of the published ones to compare with.
    #[arg(long, value_enum, default_value_t = EstimatorName::Window)]
    estimator: EstimatorName,
    /// The arithmetic: f32 is what flies.
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    precision: Precision,
}

/// How to estimate one flight, and where results go.
#[derive(Debug, Args)]
struct Options {
    #[command(flatten)]
    method: Method,
    /// Write the time history, plots and a report into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
}

/// Why a verb did not finish.
#[derive(Debug, Error)]
enum Failure {
    #[error(transparent)]
    Input(#[from] InputError),
    #[error(transparent)]
    SetUp(#[from] SetUpError),
    #[error(
        "{file}: the gyro's noise can't be measured from this log ({why}); give it as gyro.noise_rad_s in the craft file"
    )]
    NoNoise { file: String, why: &'static str },
    #[error(
        "{file}: no telemetry packet in {bytes} bytes; give the raw bytes of the line, and check the baud rate"
    )]
    NoTelemetry { file: String, bytes: u64 },
    #[error("{0}; the computer would refuse it")]
    RefusedCommand(CommandError),
    #[error("{file}: has no [prior]; add one, or give --inertia and --sigma")]
    NoPrior { file: String },
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
    #[error(transparent)]
    Run(#[from] RunFailed),
    #[error("stopped before the first run was complete; there is no result")]
    Interrupted,
    #[error(transparent)]
    Papers(#[from] PapersFailed),
    #[cfg(unix)]
    #[error(transparent)]
    Pil(#[from] crate::pil::PilFailed),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error("the result can't be printed: {0}")]
    Print(io::Error),
    #[error("the result can't be written as JSON: {0}")]
    Json(serde_json::Error),
}

impl Failure {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_)
            | Self::SetUp(_)
            | Self::Run(RunFailed::SetUp(_))
            | Self::NoNoise { .. }
            | Self::NoTelemetry { .. }
            | Self::RefusedCommand(_)
            | Self::NoPrior { .. } => MISUSE,
            #[cfg(unix)]
            Self::Pil(crate::pil::PilFailed::NotFlown(_)) => MISUSE,
            #[cfg(unix)]
            Self::Pil(_) => 1,
            Self::Integration(_)
            | Self::Run(RunFailed::Integration(_))
            | Self::Interrupted
            | Self::Papers(_)
            | Self::Output(_)
            | Self::Print(_)
            | Self::Json(_) => 1,
        }
    }
}

/// Exit code of bad input.
const MISUSE: u8 = 2;

/// Runs the program with the process's own arguments.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(misuse) if misuse.use_stderr() => {
            eprintln!("{}", in_two_lines(&misuse.render().to_string()));
            return ExitCode::from(MISUSE);
        }
        Err(help_or_version) => help_or_version.exit(),
    };
    let result = match cli.verb {
        Verb::Run(arguments) => run::run(&arguments),
        Verb::Mc(arguments) => mc::run(&arguments),
        Verb::Tables(arguments) => tables::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
        Verb::Crlb(arguments) => crlb::run(&arguments),
        Verb::Telemetry(arguments) => telemetry::run(&arguments),
        Verb::Command(arguments) => command::run(&arguments),
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

/// What is wrong with the command line, and then what to do. Clap says it in paragraphs of several
/// lines.
fn in_two_lines(message: &str) -> String {
    let lines = |paragraph: &str| paragraph.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let mut paragraphs = message.trim().split("\n\n").map(lines);
    let what = paragraphs.next().unwrap_or_default();
    let to_do: Vec<String> = paragraphs.collect();
    format!("{what}\n  {}", to_do.join(". "))
}

/// Prints a table, or its report as one JSON document.
fn print(json: bool, report: &impl Serialize, table: &str) -> Result<(), Failure> {
    let text = if json {
        serde_json::to_string_pretty(report).map_err(Failure::Json)? + "\n"
    } else {
        table.to_owned()
    };
    match io::stdout().write_all(text.as_bytes()) {
        // A reader such as `head` that has seen enough isn't a failure.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Failure::Print),
    }
}

/// The command line as it was given, for the report that says how it was made.
fn command_line() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("cargo run --release -p host-sim -- {}", arguments.join(" "))
}
