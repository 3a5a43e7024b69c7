//! What goes out: JSON for scripts, a table for people, a time history, plots, and the folder that
//! holds them all.
//!
//! ```text
//! estimation ─┬─> json::{ReplayReport, RunReport, CrlbReport} ─┬─> --json
//!             │                                                └─> table ──> stdout
//!             └─> Vec<history::HistoryRow> ──> plots
//!                  all of these ──> out_dir: report.md, result.json, history.csv, log.csv, *.svg
//! campaign ───┬─> json::McReport ──> --json, table
//!             └─> runs::RunRow, one for each ──> a CSV file
//! papers ─────┬─> published::TablesReport ──> --json, published_text, papers_dir
//!             └─> figures ──> papers_dir
//! ground ─────────> packet: one line of text or JSON for each telemetry packet
//! ```
//!
//! The types of the documents are plain numbers. `assemble`, `campaign` and `pil` fill them from
//! results. Elements of an inertia tensor are ordered `jxx jyy jzz jxy jxz jyz`.

mod assemble;
mod campaign;
mod columns;
pub mod history;
pub mod json;
mod number;
pub mod out_dir;
pub mod packet;
pub mod papers_dir;
#[cfg(unix)]
pub mod pil;
pub mod plots;
pub mod published;
mod published_text;
pub mod runs;
pub mod table;

pub use history::{AccelerationRow, HistoryRow};
pub use json::{CrlbReport, McReport, ReplayReport, RunReport, Status};
pub use out_dir::{OutputError, ReportFolder, Simulated};
pub use published::TablesReport;
pub use published_text::tables as tables_text;
