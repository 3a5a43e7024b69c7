//! Fuzzing on the stable toolchain: random input to everything that reads what others wrote.
//!
//! A case follows from the target and its number alone, so that a finding is reproduced by that number. Inputs are
//! structured: numbers near what a target accepts, extreme ones, and mutated files and frames; random bytes alone
//! do not pass the first check. There is no coverage feedback (cargo-fuzz requires nightly).
//!
//! | target | input | checked beside the absence of panics and overflows |
//! |---|---|---|
//! | `step` | configuration and samples of an estimator that flies | finite numbers, symmetric covariance, nothing converged that is not physical |
//! | `checkpoint` | words of a checkpoint, changed or not | as `step`, for each state that is accepted |
//! | `uplink` | bytes and mutated tagged frames | nothing obeyed but what was sent with a right tag |
//! | `downlink` | bytes and mutated telemetry | – |
//! | `log` | mutated CSV log | finite numbers, increasing time |
//! | `craft` | mutated craft file | – |
//! | `scenario` | mutated scenario | – |

mod checkpoint;
mod link;
mod numbers;
mod readers;
mod step;
mod text;

use std::panic::{AssertUnwindSafe, catch_unwind};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub use numbers::Numbers;

/// Result of a case: executions of the function under test, or the finding.
pub type Executed = Result<u64, String>;

/// Function under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// `step` of the estimators that fly.
    Step,
    /// Restoration of a checkpoint.
    Checkpoint,
    /// Reader of telecommands.
    Uplink,
    /// Reader of telemetry.
    Downlink,
    /// Reader of logs.
    Log,
    /// Reader of craft files.
    Craft,
    /// Reader of scenarios.
    Scenario,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 7] = [
        Self::Step,
        Self::Checkpoint,
        Self::Uplink,
        Self::Downlink,
        Self::Log,
        Self::Craft,
        Self::Scenario,
    ];

    /// Executes a case. A panic is a finding, with the input where it is text.
    ///
    /// # Errors
    /// The finding.
    pub fn execute(self, case: u64) -> Executed {
        let run = || {
            let mut random = Pcg64::seed_from_u64(case ^ ((self as u64) << 56));
            match self {
                Self::Step => step::execute(&mut random),
                Self::Checkpoint => checkpoint::execute(&mut random),
                Self::Uplink => link::uplink(&mut random),
                Self::Downlink => link::downlink(&mut random),
                Self::Log => readers::log(&mut random),
                Self::Craft => readers::craft(&mut random),
                Self::Scenario => readers::scenario(&mut random),
            }
        };
        catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| Err("a panic".into()))
    }
}

/// True once in `of` draws.
fn once_in(random: &mut Pcg64, of: u32) -> bool {
    random.random_range(0..of) == 0
}

/// One of these.
fn one_of<T: Copy>(random: &mut Pcg64, of: &[T]) -> T {
    of[random.random_range(0..of.len())]
}
