//! Tables of the papers: published values beside reproduced ones.
//!
//! ```text
//! table   the values, as in the JSON document
//! text    the tables for the terminal
//! folder  one folder per paper: tables as CSV, figures as SVG
//! ```

pub mod folder;
mod table;
pub mod text;

pub use table::{PaperFigure, PublishedTable, Row, TablesReport};
