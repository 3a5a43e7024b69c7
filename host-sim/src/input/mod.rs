//! Input files: scenarios, craft files and recorded logs.
//!
//! Every value is checked while its file and line are known. Past this module numbers are finite,
//! axes are unit vectors, inertia tensors are physical and time stamps increase; no other part of
//! the simulator repeats these checks. Quantities are `f64` in SI units, vectors in body axes.
//!
//! ```text
//! SCENARIO.toml ── scenario ──────> scenario::Scenario
//! CRAFT.toml ───── flight-input ──> craft::Craft
//! LOG.csv ──────── log_file ──────> log::RecordedLog
//! ```
//!
//! Craft files and logs are read by the crate `flight-input`, which the firmware's build script uses
//! too. A rejected file is an [`InputError`]: one or two lines with the file, the line and the key or
//! column, the fault and the remedy. [`log_file`] opens CSV, gzip, Parquet and JSON files. [`keys`] lists all keys and
//! columns. [`units`] names units of a log that are probably not SI.

pub mod guess;
pub mod interpolated;
mod json_log;
pub mod keys;
pub mod log_file;
pub mod plausible;
pub mod scenario;
pub mod units;

pub use flight_input::{Craft, ELEMENT_NAMES, InputError, RecordedLog, craft, error, log};
pub use scenario::Scenario;
