//! What comes from outside: scenario and craft files, and recorded logs.
//!
//! Everything is checked here, once, while the file and the line are still known. Past this module
//! numbers are finite, axes are unit vectors, inertia tensors are physical and time runs forward, so
//! no other part of the simulator asks again. All quantities are `f64` in SI units, in body axes.
//!
//! ```text
//! SCENARIO.toml ─┐                          ┌─> scenario::Scenario
//! CRAFT.toml ────┴─ toml_source ── check ───┴─> craft::Craft
//! LOG.csv ───────── csv_source ── log::time ──> log::RecordedLog
//! ```
//!
//! Whatever is wrong becomes an [`InputError`]: one or two lines with the file, the line and the key
//! or column, what is wrong there, and what to do about it.

mod check;
pub mod craft;
mod csv_problem;
mod csv_source;
pub mod error;
pub mod log;
mod nearest;
pub mod scenario;
mod toml_source;

pub use craft::Craft;
pub use error::InputError;
pub use log::RecordedLog;
pub use scenario::Scenario;

/// The six elements of an inertia tensor in the order in which files and reports list them.
///
/// An off-diagonal element is the tensor entry itself, that is −∫xy dm for `jxy`.
pub const ELEMENT_NAMES: [&str; 6] = ["jxx", "jyy", "jzz", "jxy", "jxz", "jyz"];
