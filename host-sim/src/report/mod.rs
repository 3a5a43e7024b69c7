//! Output: JSON documents, tables for the terminal, CSV files, plots, and folders of them.
//!
//! ```text
//! estimation ─┬─► json::{ReplayReport, RunReport, CrlbReport} ─┬─► --json
//!             │                                                └─► table ──► stdout
//!             └─► history::HistoryRow ──► plots
//!                   all of these ──► out_dir: report.md, result.json, history.csv, log.csv, *.svg
//! campaign ───┬─► json::McReport ──► --json, table
//!             └─► runs::RunRow, one per run ──► CSV file
//! manoeuvre ──► json::DesignReport ──► --json, table, design: folder
//! fault ──────► json::FaultsReport ──► --json, table
//! papers ─────┬─► published::TablesReport ──► --json, published::text, published::folder
//!             └─► published::PaperFigure ──► published::folder
//! ground ───────► packet: one line of text or JSON per telemetry packet
//! ```
//!
//! The documents are plain numbers without types of the flight core. `assemble`, `campaign` and `pil`
//! fill them from results. Elements of an inertia tensor are ordered `jxx jyy jzz jxy jxz jyz`.

mod assemble;
mod campaign;
mod columns;
mod design;
mod faults;
mod files;
pub mod history;
pub mod json;
mod number;
pub mod out_dir;
pub mod packet;
#[cfg(unix)]
pub mod pil;
pub mod plots;
pub mod published;
pub mod runs;
pub mod table;

pub use design::{DesignFolder, write_trade};
pub use files::OutputError;
pub use history::{AccelerationRow, HistoryRow};
pub use json::{
    CrlbReport, DesignReport, DiagnosisReport, ExplanationReport, FaultsReport, LogReport,
    McReport, ReplayReport, RunReport, Status, TradeReport,
};
pub use out_dir::{ReportFolder, Simulated};
pub use published::TablesReport;
pub use published::text::tables as tables_text;
