//! Output: JSON documents, tables for the terminal, CSV and Parquet files, and folders of them with an HTML page.
//!
//! ```text
//! estimation ─┬─► json::{ReplayReport, RunReport, CrlbReport} ─┬─► --json
//!             │                                                └─► table ──► stdout
//!             └─► history::HistoryRow ──► plots
//!                   all of these ──► out_dir: page, result.json, history.csv, log.csv, data/*.csv
//! campaign ───┬─► json::McReport ──► --json, table
//!             └─► runs::RunRow, one per run ──► CSV or Parquet file, or campaign_dir: page and both
//! shards ─────► runs::RunRow, from the Parquet files of the shards of a campaign
//! manoeuvre ──► json::DesignReport ──► --json, table, design: folder
//! fault ──────► json::FaultsReport ──► --json, table, campaign_dir
//! papers ─────┬─► published::TablesReport ──► --json, published::text, published::folder
//!             └─► published::PaperFigure ──► published::folder
//! page ───────► report.html of each of these folders: verdict, tables, plots
//! ground ───────► packet: one line of text or JSON per telemetry packet
//! ```
//!
//! The documents are plain numbers without types of the flight core. `assemble`, `campaign` and `pil`
//! fill them from results. Elements of an inertia tensor are ordered `jxx jyy jzz jxy jxz jyz`.

mod assemble;
mod campaign;
pub mod campaign_dir;
mod columns;
mod design;
mod faults;
mod files;
mod frame;
pub mod history;
pub mod json;
mod number;
pub mod out_dir;
pub mod packet;
mod page;
#[cfg(unix)]
pub mod pil;
pub mod plots;
mod principal;
pub mod published;
pub mod record;
pub mod runs;
pub mod shards;
pub mod table;
mod verdict;

pub use design::{DesignFolder, write_trade};
pub use files::{Folder, OutputError};
pub use history::{AccelerationRow, HistoryRow};
pub use json::{
    CrlbReport, DesignReport, DiagnosisReport, ExplanationReport, FaultsReport, LogReport,
    McReport, ReplayReport, RunReport, Status, TradeReport,
};
pub use out_dir::{FlightResult, ReportFolder, Simulated};
pub use published::TablesReport;
pub use published::text::tables as tables_text;
