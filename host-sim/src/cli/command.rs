//! `command`: a telecommand as the bytes of its frame, for the serial line.

use std::io::{self, IsTerminal, Write};
#[cfg(unix)]
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum, value_parser};
use fsw_core::Prior;
use fsw_target::link::Command;
use fsw_target::link::authentication::Key;
use fsw_target::link::frame::Frame;
use fsw_target::link::packet::{Packet, SequenceCount};
use fsw_target::link::wire::Coded;

use super::flight_estimator::FlightEstimator;
use super::{Failure, key};
use crate::input::Craft;
use crate::report::packet::hex;

#[derive(Debug, Args)]
#[command(arg_required_else_help = false)]
pub struct Arguments {
    #[command(subcommand)]
    telecommand: Telecommand,
    /// Sequence count of the telecommand, 1 to 8191 ahead of the last accepted one modulo 16384;
    /// without it, a start_sequence precedes the telecommand, so that any count is accepted
    ///
    /// The computer's status has the sequence count of the last accepted telecommand.
    #[arg(long, value_name = "N", global = true, value_parser = value_parser!(u16).range(..16_384))]
    sequence: Option<u16>,
    #[command(flatten)]
    tag: TagArguments,
}

/// Tag of the telecommand, for a flight image with a key.
#[derive(Debug, Args)]
struct TagArguments {
    /// File with the key of the slot: tag the telecommand (see derive-key)
    #[arg(
        long,
        value_name = "FILE",
        global = true,
        requires = "counter",
        conflicts_with = "sequence"
    )]
    key: Option<PathBuf>,
    /// Counter of the telecommand: 1 to 1048576 ahead of the last accepted one of the slot, which the
    /// computer's status reports as key_counters
    #[arg(long, value_name = "N", global = true, requires = "key", value_parser = value_parser!(u32).range(1..))]
    counter: Option<u32>,
    /// Key slot: 0 changes keys, 1 and 2 carry telecommands [default: 1]
    #[arg(long, value_name = "N", global = true, requires = "key", value_parser = value_parser!(u8).range(..=2))]
    slot: Option<u8>,
}

#[derive(Debug, Subcommand)]
enum Telecommand {
    /// No action; the next status shows its acceptance
    Ping,
    /// Accept the sequence count of this telecommand as the last one
    StartSequence,
    /// Restart the selected estimator with its prior
    Reset,
    /// Set the prior of the inertia, and restart the selected estimator with it
    SetPrior(PriorArguments),
    /// Open a window with the next sample
    OpenWindow,
    /// Close the open window
    CloseWindow,
    /// Select the estimator for the following samples, and restart it
    Select {
        /// Estimator of the flight image
        estimator: FlightEstimator,
    },
    /// Write the state of the estimator to flash
    SaveCheckpoint,
    /// Send the state of the estimator
    DumpCheckpoint,
    /// Set the period of the telemetry reports
    SetTelemetryPeriod {
        /// Time between two reports of a kind, ms, 50 to 3600000
        #[arg(value_name = "MS", allow_negative_numbers = true)]
        ms: u32,
    },
    /// Set the external torque from now on, body axes, each component within ±100 N m
    SetTorque {
        /// About x, N m
        #[arg(allow_hyphen_values = true)]
        x_n_m: f32,
        /// About y, N m
        #[arg(allow_hyphen_values = true)]
        y_n_m: f32,
        /// About z, N m
        #[arg(allow_hyphen_values = true)]
        z_n_m: f32,
    },
    /// Give a key slot its next key; accepted in slot 0 only
    ///
    /// Its generation is the counter of this telecommand: derive-key --generation COUNTER.
    ChangeKey {
        /// Key slot, 1 or 2
        #[arg(value_name = "SLOT")]
        target: u8,
    },
    /// Tag telemetry with the key of this telecommand's slot, or send it without a tag
    TagTelemetry {
        /// on or off
        switch: Switch,
    },
    /// Reset the computer; the state since the last checkpoint is lost
    Reboot,
    /// Assume the speed of a wheel whose sensor has failed, or use its sensor again
    AssumeWheelSpeed {
        /// Wheel, 1 to 4
        wheel: u8,
        /// Speed about its axis, rad/s, within ±2000; without it, that of its sensor
        #[arg(allow_hyphen_values = true)]
        speed_rad_s: Option<f32>,
    },
    /// Any telecommand by its user data, as in the telecommands.csv of design
    UserData {
        /// Function code and arguments, two hexadecimal digits a byte
        #[arg(value_parser = user_data)]
        hex: Command,
    },
    /// Start the manoeuvre of the committed table
    StartManoeuvre {
        /// On-board time, µs, 10 s ahead or more: meanwhile the rate at rest is averaged; or now, for the next sample
        #[arg(value_name = "AT_US", value_parser = start_time)]
        at_us: u64,
    },
    /// Abort the manoeuvre; the wheels return to their speeds at its start
    AbortManoeuvre,
}

/// On-board time, µs; zero, which has passed, for `now`.
fn start_time(text: &str) -> Result<u64, String> {
    match text {
        "now" => Ok(0),
        _ => text.parse().map_err(|_| "give the on-board time, µs, or now".to_owned()),
    }
}

/// A telecommand from the hexadecimal digits of its user data.
fn user_data(text: &str) -> Result<Command, String> {
    let digits = text.as_bytes().chunks(2).map(|pair| {
        let pair = std::str::from_utf8(pair).ok().filter(|pair| pair.len() == 2)?;
        u8::from_str_radix(pair, 16).ok()
    });
    let bytes: Option<Vec<u8>> = digits.collect();
    let bytes = bytes.ok_or("give two hexadecimal digits a byte, as 0b3a83126f…")?;
    Command::decode(&bytes).map_err(|why| format!("no telecommand: {why}"))
}

/// A switch.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Switch {
    On,
    Off,
}

/// A prior from a craft file, or from numbers.
#[derive(Debug, Args)]
struct PriorArguments {
    /// Craft file with a [prior]
    #[arg(long, value_name = "CRAFT.toml", conflicts_with_all = ["inertia_kg_m2", "sigma_kg_m2"], required_unless_present_all = ["inertia_kg_m2", "sigma_kg_m2"])]
    craft: Option<PathBuf>,
    /// Elements jxx jyy jzz jxy jxz jyz, kg m²
    #[arg(long = "inertia", value_names = ["JXX", "JYY", "JZZ", "JXY", "JXZ", "JYZ"], allow_hyphen_values = true, requires = "sigma_kg_m2")]
    inertia_kg_m2: Vec<f32>,
    /// One sigma of each element, kg m²
    #[arg(long = "sigma", value_names = ["JXX", "JYY", "JZZ", "JXY", "JXZ", "JYZ"], allow_hyphen_values = true, requires = "inertia_kg_m2")]
    sigma_kg_m2: Vec<f32>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let command = arguments.telecommand.command()?;
    command.check().map_err(Failure::InvalidCommand)?;
    let line = match (arguments.tag.signer()?, arguments.sequence) {
        (Some((key, slot, counter)), _) => framed(command.tagged_packet(&key, slot, counter)),
        (None, Some(count)) => plain(&command, count),
        (None, None) if command == Command::StartSequence => plain(&command, 0),
        (None, None) => [plain(&Command::StartSequence, 0), plain(&command, 1)].concat(),
    };

    eprintln!("note: {}, {} bytes: {}", command.function().code().1, line.len(), hex(&line));
    if stdout_is_the_users_terminal() {
        eprintln!(
            "note: the bytes are not printed to a terminal; redirect stdout, as in > /dev/ttyUSB0"
        );
        return Ok(());
    }
    let mut out = io::stdout();
    out.write_all(&line).and_then(|()| out.flush()).map_err(Failure::Print)
}

/// Standard output is the terminal of the user rather than a serial port, which is a terminal as
/// well: the user's terminal is also stderr or stdin.
fn stdout_is_the_users_terminal() -> bool {
    let is_users = [("stderr", io::stderr().is_terminal()), ("stdin", io::stdin().is_terminal())]
        .into_iter()
        .any(|(name, is_terminal)| is_terminal && device(name) == device("stdout"));
    io::stdout().is_terminal() && is_users
}

/// Device number of a standard stream; none where the system has no such number.
fn device(stream: &str) -> Option<u64> {
    #[cfg(unix)]
    return Path::new("/dev").join(stream).metadata().ok().map(|file| file.rdev());
    #[cfg(not(unix))]
    return None;
}

fn plain(command: &Command, sequence_count: u16) -> Vec<u8> {
    framed(command.packet(SequenceCount::new(sequence_count)))
}

/// Frame of a packet. Every telecommand has one.
fn framed(packet: Option<Packet>) -> Vec<u8> {
    let frame = packet.and_then(|packet| Frame::of(packet.bytes()));
    frame.map(|frame| frame.bytes().to_vec()).unwrap_or_default()
}

impl TagArguments {
    /// Key, slot and counter of the tag; none for a telecommand without a tag.
    fn signer(&self) -> Result<Option<(Key, u8, u32)>, Failure> {
        let (Some(file), Some(counter)) = (&self.key, self.counter) else { return Ok(None) };
        Ok(Some((key::read(file)?, self.slot.unwrap_or(1), counter)))
    }
}

impl Telecommand {
    fn command(&self) -> Result<Command, Failure> {
        Ok(match self {
            Self::Ping => Command::Ping,
            Self::StartSequence => Command::StartSequence,
            Self::Reset => Command::Reset,
            Self::SetPrior(prior) => Command::SetPrior(prior.prior()?),
            Self::OpenWindow => Command::OpenWindow,
            Self::CloseWindow => Command::CloseWindow,
            Self::Select { estimator } => Command::Select(estimator.id),
            Self::SaveCheckpoint => Command::SaveCheckpoint,
            Self::DumpCheckpoint => Command::DumpCheckpoint,
            Self::SetTelemetryPeriod { ms } => Command::SetTelemetryPeriod { ms: *ms },
            Self::SetTorque { x_n_m, y_n_m, z_n_m } => Command::SetTorque([*x_n_m, *y_n_m, *z_n_m]),
            Self::ChangeKey { target } => Command::ChangeKey { slot: *target },
            Self::TagTelemetry { switch } => Command::TagTelemetry(matches!(switch, Switch::On)),
            Self::Reboot => Command::Reboot,
            Self::AssumeWheelSpeed { wheel, speed_rad_s } => {
                Command::AssumeWheelSpeed { wheel: *wheel, speed_rad_s: *speed_rad_s }
            }
            Self::UserData { hex } => *hex,
            Self::StartManoeuvre { at_us } => Command::StartManoeuvre { at_us: *at_us },
            Self::AbortManoeuvre => Command::AbortManoeuvre,
        })
    }
}

impl PriorArguments {
    fn prior(&self) -> Result<Prior<f32>, Failure> {
        let Some(file) = &self.craft else {
            let (inertia, sigma) = (&self.inertia_kg_m2, &self.sigma_kg_m2);
            return Ok(Prior { inertia_kg_m2: array(inertia), sigma_kg_m2: array(sigma) });
        };
        let prior = Craft::load(file)?.prior;
        let prior = prior.ok_or_else(|| Failure::NoPrior { file: file.display().to_string() })?;
        let single = |numbers: [f64; 6]| numbers.map(|number| number as f32);
        Ok(Prior {
            inertia_kg_m2: single(prior.inertia_kg_m2),
            sigma_kg_m2: single(prior.sigma_kg_m2),
        })
    }
}

/// The numbers of an option whose count clap has checked.
fn array<const N: usize>(numbers: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(f32::NAN))
}
