//! Failures of the verbs, and their exit codes.

use std::io;

use fsw_target::link::command::CommandError;
use thiserror::Error;

use crate::campaign::{RunFailed, Shard};
use crate::estimation::SetUpError;
use crate::input::InputError;
use crate::input::guess::NothingFound;
use crate::manoeuvre::{DesignError, SubjectError};
use crate::papers::PapersFailed;
use crate::report::OutputError;
use crate::report::shards::ShardError;
use crate::truth::IntegrationFailed;

/// Exit code of bad input.
pub(super) const BAD_INPUT: u8 = 2;
/// Exit code of a result of a kind of `--fail-on`.
const OF_KIND: u8 = 3;
/// Exit code of a run that could not finish.
const UNFINISHED: u8 = 1;

/// Reason why a verb did not finish. The message says where, what, and what to do.
#[derive(Debug, Error)]
pub(super) enum Failure {
    #[error(transparent)]
    Input(#[from] InputError),
    #[error("{source_name}: {error}")]
    SetUp { source_name: String, error: SetUpError },
    #[error(
        "{file}: no telemetry packet in {bytes} bytes; give the raw bytes of the line, and check the \
         baud rate"
    )]
    NoTelemetry { file: String, bytes: u64 },
    #[error("{found} of {results} results, as --fail-on asks for")]
    OfKind { found: String, results: usize },
    #[error("{failed} of {of} results are missing: see the errors above")]
    SomeLogs { failed: usize, of: usize, exit_code: u8 },
    #[error("{file}: {error}")]
    NoDraft { file: String, error: NothingFound },
    #[error("{file}: exists already; give another name, or remove it")]
    Exists { file: String },
    #[error("{file}: {rows} rows are too few for a diagnosis; it takes 24")]
    TooShort { file: String, rows: usize },
    #[error("{0}; the flight computer would reject it")]
    InvalidCommand(CommandError),
    #[error("{file}: no [prior]; add one, or give --inertia and --sigma")]
    NoPrior { file: String },
    #[error("{file}: the key cannot be read: {error}")]
    UnreadableKey { file: String, error: io::Error },
    #[error("{file}: not a key; write 32 hexadecimal digits, as openssl rand -hex 16 prints")]
    NoKey { file: String },
    #[error("--fault: no fault has \"{wanted}\" in its name; the faults are: {names}")]
    NoFault { wanted: String, names: String },
    #[error("{scenario}: {error}")]
    Design { scenario: String, error: DesignError },
    #[error(transparent)]
    Subject(#[from] SubjectError),
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
    #[error("{scenario}: {error}")]
    Campaign { scenario: String, error: RunFailed },
    #[error("--shard {shard}: the rows are written to a Parquet file; add --out FILE.parquet")]
    ShardWithoutFile { shard: Shard },
    #[error("--shard {shard}: {runs} runs have at most {runs} shards; lower N or raise --runs")]
    SurplusShards { shard: Shard, runs: u64 },
    #[error("shard {shard}: stopped before its last run; nothing is written: fly it again")]
    ShardInterrupted { shard: Shard },
    #[error(transparent)]
    Shards(#[from] ShardError),
    #[error("stopped before the first run was complete; there is no result")]
    Interrupted,
    #[error(transparent)]
    Papers(#[from] PapersFailed),
    #[cfg(unix)]
    #[error(transparent)]
    Pil(#[from] crate::pil::PilFailed),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error("the result cannot be printed: {0}")]
    Print(io::Error),
    #[error("the result cannot be written as JSON: {0}")]
    Json(serde_json::Error),
}

impl Failure {
    pub(super) fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_)
            | Self::SetUp { .. }
            | Self::Campaign { error: RunFailed::SetUp(_), .. }
            | Self::NoTelemetry { .. }
            | Self::TooShort { .. }
            | Self::InvalidCommand(_)
            | Self::NoPrior { .. }
            | Self::NoFault { .. }
            | Self::UnreadableKey { .. }
            | Self::NoKey { .. }
            | Self::NoDraft { .. }
            | Self::Subject(_)
            | Self::ShardWithoutFile { .. }
            | Self::SurplusShards { .. }
            | Self::Shards(_)
            | Self::Output(OutputError::Shard(_))
            | Self::Exists { .. } => BAD_INPUT,
            Self::Design { error, .. } if error.is_of_input() => BAD_INPUT,
            Self::OfKind { .. } => OF_KIND,
            Self::SomeLogs { exit_code, .. } => *exit_code,
            #[cfg(unix)]
            Self::Pil(crate::pil::PilFailed::NotFlown(_)) => BAD_INPUT,
            #[cfg(unix)]
            Self::Pil(_) => UNFINISHED,
            Self::Integration(_)
            | Self::Campaign { error: RunFailed::Integration(_), .. }
            | Self::Interrupted
            | Self::ShardInterrupted { .. }
            | Self::Design { .. }
            | Self::Papers(_)
            | Self::Output(_)
            | Self::Print(_)
            | Self::Json(_) => UNFINISHED,
        }
    }
}
