//! `command`: a telecommand as the bytes that go over the serial line.

use std::io::{self, IsTerminal, Write};
#[cfg(unix)]
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum, value_parser};
use fsw_core::Prior;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::Command;
use fsw_target::link::frame::Frame;
use fsw_target::link::packet::SequenceCount;
use fsw_target::link::wire::Coded;

use super::Failure;
use crate::input::Craft;
use crate::report::packet::hex;

#[derive(Debug, Args)]
#[command(arg_required_else_help = false)]
pub struct Arguments {
    #[command(subcommand)]
    command: Asked,
    /// Sequence count of the command, which must be 1 to 8191 ahead of that of the last accepted one,
    /// modulo 16384: see the computer's status. Left out: a start_sequence goes before the command, so
    /// that it is accepted whatever was sent before.
    #[arg(long, value_name = "N", global = true, value_parser = value_parser!(u16).range(..16_384))]
    sequence: Option<u16>,
}

/// What the flight computer is asked to do.
#[derive(Debug, Subcommand)]
enum Asked {
    /// Do nothing; that it was accepted shows in the next status.
    Ping,
    /// Count from this command's sequence count on, whatever it is.
    StartSequence,
    /// Start the selected estimator afresh; the prior stays.
    Reset,
    /// Believe this of the inertia beforehand, and start the selected estimator afresh with it.
    SetPrior(PriorArguments),
    /// Begin a window with the next sample.
    OpenWindow,
    /// End the window that is open.
    CloseWindow,
    /// Step this estimator from now on, from a fresh start.
    Select {
        /// Which.
        estimator: SelectedEstimator,
    },
    /// Write the estimator's state to flash.
    SaveCheckpoint,
    /// Send the estimator's state.
    DumpCheckpoint,
    /// Send reports so often.
    SetTelemetryPeriod {
        /// Milliseconds between two reports of a kind, 50 to 3600000.
        #[arg(value_name = "MS", allow_negative_numbers = true)]
        ms: u32,
    },
    /// The external torque that acts from now on, body axes; each within 100 N m.
    SetTorque {
        /// About x, N m.
        #[arg(allow_hyphen_values = true)]
        x_n_m: f32,
        /// About y, N m.
        #[arg(allow_hyphen_values = true)]
        y_n_m: f32,
        /// About z, N m.
        #[arg(allow_hyphen_values = true)]
        z_n_m: f32,
    },
}

/// From a craft file, or number by number.
#[derive(Debug, Args)]
struct PriorArguments {
    /// A craft file with a [prior].
    #[arg(long, value_name = "CRAFT.toml", conflicts_with_all = ["inertia_kg_m2", "sigma_kg_m2"], required_unless_present_all = ["inertia_kg_m2", "sigma_kg_m2"])]
    craft: Option<PathBuf>,
    /// jxx jyy jzz jxy jxz jyz, kg m².
    #[arg(long = "inertia", value_names = ["JXX", "JYY", "JZZ", "JXY", "JXZ", "JYZ"], allow_hyphen_values = true, requires = "sigma_kg_m2")]
    inertia_kg_m2: Vec<f32>,
    /// One sigma of each, kg m².
    #[arg(long = "sigma", value_names = ["JXX", "JYY", "JZZ", "JXY", "JXZ", "JYZ"], allow_hyphen_values = true, requires = "inertia_kg_m2")]
    sigma_kg_m2: Vec<f32>,
}

/// The estimators in the flight image.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SelectedEstimator {
    Window,
    JointEkf,
    EkfSgfRls,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let command = arguments.command.command()?;
    command.check().map_err(Failure::RefusedCommand)?;
    let line = match arguments.sequence {
        Some(count) => framed(&command, count),
        None if command == Command::StartSequence => framed(&command, 0),
        None => [framed(&Command::StartSequence, 0), framed(&command, 1)].concat(),
    };

    eprintln!("note: {}, {} bytes: {}", command.function().code().1, line.len(), hex(&line));
    let mut out = io::stdout();
    if is_terminal_of_the_user() {
        eprintln!("note: a terminal shows no bytes; send them on, as in `> /dev/ttyUSB0`");
        return Ok(());
    }
    out.write_all(&line).and_then(|()| out.flush()).map_err(Failure::Print)
}

/// Whether the command's bytes would go to a screen. A serial port is a terminal as well: it is told apart
/// by not being the one that messages go to, or keys come from.
fn is_terminal_of_the_user() -> bool {
    let is_users = [("stderr", io::stderr().is_terminal()), ("stdin", io::stdin().is_terminal())]
        .into_iter()
        .any(|(name, is_terminal)| is_terminal && device(name) == device("stdout"));
    io::stdout().is_terminal() && is_users
}

/// Which device a standard stream is; none where that can't be told.
fn device(stream: &str) -> Option<u64> {
    #[cfg(unix)]
    return Path::new("/dev").join(stream).metadata().ok().map(|file| file.rdev());
    #[cfg(not(unix))]
    return None;
}

fn framed(command: &Command, sequence_count: u16) -> Vec<u8> {
    let packet = command.packet(SequenceCount::new(sequence_count));
    let frame = packet.and_then(|packet| Frame::of(packet.bytes()));
    frame.map(|frame| frame.bytes().to_vec()).unwrap_or_default()
}

impl Asked {
    fn command(&self) -> Result<Command, Failure> {
        Ok(match self {
            Self::Ping => Command::Ping,
            Self::StartSequence => Command::StartSequence,
            Self::Reset => Command::Reset,
            Self::SetPrior(prior) => Command::SetPrior(prior.prior()?),
            Self::OpenWindow => Command::OpenWindow,
            Self::CloseWindow => Command::CloseWindow,
            Self::Select { estimator } => Command::Select(match estimator {
                SelectedEstimator::Window => EstimatorId::Window,
                SelectedEstimator::JointEkf => EstimatorId::JointEkf,
                SelectedEstimator::EkfSgfRls => EstimatorId::EkfSgfRls,
            }),
            Self::SaveCheckpoint => Command::SaveCheckpoint,
            Self::DumpCheckpoint => Command::DumpCheckpoint,
            Self::SetTelemetryPeriod { ms } => Command::SetTelemetryPeriod { ms: *ms },
            Self::SetTorque { x_n_m, y_n_m, z_n_m } => Command::SetTorque([*x_n_m, *y_n_m, *z_n_m]),
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

/// As many numbers as the command line was checked for.
fn array<const N: usize>(numbers: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(f32::NAN))
}
