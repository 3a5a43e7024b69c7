//! Readers of craft files and recorded logs, shared by the simulator and the firmware's build
//! script.
//!
//! Every value is checked while its file and line are known. A [`Craft`] and a [`RecordedLog`] hold
//! finite numbers, unit axes, physical inertia tensors and increasing time stamps; no later stage
//! repeats these checks. Quantities are `f64` in SI units, vectors in body axes.
//!
//! ```text
//! CRAFT.toml ── toml_source ── section ──> craft::Craft
//! LOG.csv ───── csv_source ─── clock ────> log::RecordedLog
//! ```
//!
//! A rejected file is an [`InputError`]: one or two lines with the file, the line and the key or
//! column, the fault and the remedy. The rows of [`key`] hold the type, unit, range, default and
//! meaning of each key: the checks and the reference page both derive from them.

pub mod craft;
pub mod csv_dialect;
pub mod csv_problem;
pub mod csv_source;
mod csv_text;
pub mod error;
pub mod inertia;
pub mod key;
pub mod log;
pub mod nearest;
pub mod section;
pub mod text;
pub mod toml_source;
pub mod units;
pub mod words;

pub use craft::Craft;
pub use error::InputError;
pub use inertia::ELEMENT_NAMES;
pub use log::RecordedLog;
