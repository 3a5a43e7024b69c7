//! The command line: one file per verb, which parses, calls the library and prints. [`verbs`] has those that other
//! programs call.
//!
//! Results go to stdout; errors and notes go to stderr. Exit code 0: complete; 1: a run that could
//! not finish; 2: bad input; 3: a result of a kind of `--fail-on`. Colours appear on a terminal only, and
//! not with `NO_COLOR`.

mod command;
mod crlb;
mod design;
mod diagnose;
mod estimate;
mod failure;
mod faults;
mod flight_estimator;
mod init;
mod key;
mod list;
mod manual;
mod mc;
mod merge;
mod notes;
#[cfg(unix)]
mod pil;
mod progress;
mod replay;
mod run;
mod tables;
mod telemetry;
pub mod verbs;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use anstyle::{AnsiColor, Effects, Style};
use clap::{Args, Parser, Subcommand};
use serde::Serialize;

use crate::estimation::Method;
use failure::{BAD_INPUT, Failure};

/// First steps, below the list of verbs.
const FIRST_STEPS: &str = "\
First steps:
  host-sim run                                      a simulated flight
  host-sim init my-craft                            a scenario and a craft file to edit
  host-sim init --from log.csv --out craft.toml     a craft file drafted from a log
  host-sim replay --craft craft.toml log.csv        the inertia from the log";

/// Simulate a spacecraft or replay its log, and estimate its inertia tensor with the flight core
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = false, after_help = FIRST_STEPS)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Simulate one flight, estimate, and compare with the truth and the Cramér-Rao bound
    #[command(
        after_help = "Examples:\n  host-sim run\n  host-sim run my.toml --out report\n  host-sim run cubesat-pyramid --estimator joint-ekf --json"
    )]
    Run(run::Arguments),
    /// Monte Carlo campaign: RMS error and bias compared with the bound, and NEES
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
    #[command(
        after_help = "Examples:\n  host-sim mc cubesat-pyramid --runs 1000\n  host-sim mc my.toml --runs 1000 --out report\n  host-sim mc my.toml --runs 1000 --out runs.parquet\n  host-sim mc my.toml --runs 1000 --shard 3/64 --out 3.parquet"
    )]
    Mc(mc::Arguments),
    /// Report of a campaign that was flown in shards: see mc --shard
    ///
    /// The report is that of one process, without its duration, and the same whatever the number of shards
    /// and the order of the files. A shard given twice counts once; it is refused if the two files differ.
    #[command(
        after_help = "Examples:\n  host-sim merge shards/*.parquet\n  host-sim merge shards/*.parquet --out report"
    )]
    Merge(merge::Arguments),
    /// Fault matrix: every fault, every estimator, both precisions, compared with the clean flight
    ///
    /// Each run flies without a fault and then with each fault, with the same noise. A cell counts runs
    /// without panic and with finite numbers, detections and their median time, silent lies, recoveries,
    /// and compares the final error with the bound and with the clean flight.
    ///
    /// Ctrl-C stops the matrix; the result is of the completed runs. All cores are used, or the number in
    /// the environment variable RAYON_NUM_THREADS; the result is the same.
    #[command(
        after_help = "Examples:\n  host-sim faults --runs 20\n  host-sim faults my.toml --out report"
    )]
    Faults(faults::Arguments),
    /// Tables of five papers: published, reproduced, and the bound
    ///
    /// Ctrl-C stops the runs; the result is of the completed ones. All cores are used; the result is
    /// the same on any number of cores.
    #[command(after_help = "Example:\n  host-sim tables --runs 1000 --out papers")]
    Tables(tables::Arguments),
    /// Estimate from a recorded log
    #[command(
        after_help = "Examples:\n  host-sim replay --craft craft.toml log.csv --out report\n  host-sim replay --craft craft.toml logs --fail-on diverged,partial\n  zcat log.csv.gz | host-sim replay --craft craft.toml -\n  host-sim replay --craft craft.toml logs --estimator window --estimator joint-ekf --json"
    )]
    Replay(replay::Arguments),
    /// Files to start from: a scenario and a craft file, or a craft file drafted from a log
    ///
    /// The draft of `--from` maps the columns of the log by their names, units and increments; each line
    /// says why. Lines marked CONFIRM are guesses, lines marked FILL IN are what no log shows.
    #[command(
        after_help = "Examples:\n  host-sim init --from log.csv --out craft.toml\n  host-sim init my-craft"
    )]
    Init(init::Arguments),
    /// Built-in scenarios and estimators, one line each
    #[command(after_help = "Examples:\n  host-sim list\n  host-sim list --json")]
    List(list::Arguments),
    /// Causes that explain the residuals of a log, ranked
    ///
    /// Candidates are errors of gyro, wheels and torque, and mistakes of log and craft file: a wheel's sign, gyro axes
    /// permuted, units, columns late by rows. Each is fitted to the whole log; the share of the excess of chi-square
    /// that it accounts for is printed, with the line that states or corrects it. Causes that the log does not
    /// distinguish are named together.
    #[command(after_help = "Example:\n  host-sim diagnose --craft craft.toml log.csv")]
    Diagnose(diagnose::Arguments),
    /// Cramér-Rao bound of a scenario: the smallest sigma of any unbiased estimator
    #[command(after_help = "Example:\n  host-sim crlb microsat-slew")]
    Crlb(crlb::Arguments),
    /// Manoeuvre for the estimation of the inertia, within limits of wheels and pointing
    ///
    /// Minimises the expected sigma of the inertia over the torque of the wheels. Each wheel needs
    /// max_torque_n_m and max_speed_rad_s. Limits hold for every inertia within two sigma of the [prior]; the
    /// body starts and ends at rest in the same attitude. The table compares the design with standard
    /// manoeuvres within the same limits.
    ///
    /// Ctrl-C ends the search with the best manoeuvre so far. All cores are used, or the number in the
    /// environment variable RAYON_NUM_THREADS; the result is the same.
    #[command(
        after_help = "Examples:\n  host-sim design craft.toml --rate-hz 50 --excursion 2 --out manoeuvre\n  host-sim design my.toml --excursion 20 --keep-out 0,0,1:1,0,0.2:30\n  host-sim design my.toml --trade excursion --range 0.05..20"
    )]
    Design(design::Arguments),
    /// Telemetry packets of a flight computer's serial line, one line each
    ///
    /// Set the port to raw mode first: stty -F /dev/ttyUSB0 115200 raw -echo. Damaged and missing
    /// packets are noted on stderr. The text leaves out counts of zero; with --json each line is one
    /// document with every field.
    #[command(after_help = "Example:\n  host-sim telemetry /dev/ttyUSB0")]
    Telemetry(telemetry::Arguments),
    /// Telecommand for a flight computer, as bytes on stdout
    ///
    /// Set the port to raw mode first: stty -F /dev/ttyUSB0 115200 raw -echo.
    #[command(after_help = "Example:\n  host-sim command reset > /dev/ttyUSB0")]
    Command(command::Arguments),
    /// Key of a slot from the master key of a flight image, for command and telemetry
    ///
    /// The master key stays where the keys are managed; a ground station has the key of its slot.
    #[command(after_help = "Example:\n  host-sim derive-key master.key --slot 1 > slot1.key")]
    DeriveKey(key::Arguments),
    /// Processor in the loop: the firmware in QEMU with simulated sensors, compared with the host
    ///
    /// The firmware reads gyro and wheels over a serial port from models at register level. Driver,
    /// conversion and estimator are those of the flight image, on its processor. The same software
    /// runs on the host. Both states are compared bit by bit after each sample; the first difference
    /// ends the flight with its sample and element.
    ///
    /// Requires QEMU and a compiler for the Cortex-M; an error names the package to install.
    #[cfg(unix)]
    #[command(after_help = "Example:\n  host-sim pil stsat3-spin-up --estimator window")]
    Pil(pil::Arguments),
    /// Completions of the command line for a shell, on stdout
    #[command(
        after_help = "Example:\n  host-sim completions bash > ~/.local/share/bash-completion/completions/host-sim"
    )]
    Completions(manual::CompletionsArguments),
    /// Manual pages, one for each verb, into a folder
    #[command(after_help = "Example:\n  host-sim man ~/.local/share/man/man1")]
    Man(manual::ManArguments),
}

/// Options of the verbs that estimate from one log.
#[derive(Debug, Args)]
struct Options {
    #[command(flatten)]
    method: Method,
    /// Write a report for the browser, time history and plot data into this folder
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
        Verb::Merge(arguments) => merge::run(&arguments),
        Verb::Faults(arguments) => faults::run(&arguments),
        Verb::Tables(arguments) => tables::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
        Verb::Init(arguments) => init::run(&arguments),
        Verb::List(arguments) => list::run(&arguments),
        Verb::Completions(arguments) => manual::completions(&arguments),
        Verb::Man(arguments) => manual::man(&arguments),
        Verb::Diagnose(arguments) => diagnose::run(&arguments),
        Verb::Crlb(arguments) => crlb::run(&arguments),
        Verb::Design(arguments) => design::run(&arguments),
        Verb::Telemetry(arguments) => telemetry::run(&arguments),
        Verb::Command(arguments) => command::run(&arguments),
        Verb::DeriveKey(arguments) => key::run(&arguments),
        #[cfg(unix)]
        Verb::Pil(arguments) => pil::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            anstream::eprintln!("{RED}error{RED:#}: {failure}");
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
    if json {
        return print_text(&(serde_json::to_string_pretty(report).map_err(Failure::Json)? + "\n"));
    }
    print_text(&coloured(table))
}

/// Prints a line.
fn print_line(text: &str) -> Result<(), Failure> {
    print_text(&format!("{text}\n"))
}

/// Prints a text to stdout.
fn print_text(text: &str) -> Result<(), Failure> {
    match anstream::stdout().write_all(text.as_bytes()) {
        // A closed pipe, as with `head`, is not an error.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Failure::Print),
    }
}

/// Style of an error.
const RED: Style = AnsiColor::Red.on_default().effects(Effects::BOLD);

/// A table with coloured statuses. The stream removes the colours unless it is a terminal.
fn coloured(table: &str) -> String {
    let styles = [
        ("converged", AnsiColor::Green),
        ("partial", AnsiColor::Yellow),
        ("unobservable", AnsiColor::Yellow),
        ("diverged", AnsiColor::Red),
        ("failed", AnsiColor::Red),
    ];
    let line = |line: &str| {
        // A status is a word of its own: of the line `status`, or of a row of several logs.
        let style = styles
            .iter()
            .find(|(word, _)| line.split_whitespace().any(|w| w.trim_end_matches(':') == *word));
        match style {
            Some((word, colour)) => {
                let style = Style::new().fg_color(Some((*colour).into()));
                line.replacen(word, &format!("{style}{word}{style:#}"), 1)
            }
            _ => line.to_owned(),
        }
    };
    table.split_inclusive('\n').map(line).collect()
}

/// Command line of this process, for the report.
fn command_line() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("cargo run --release -p host-sim -- {}", arguments.join(" "))
}
