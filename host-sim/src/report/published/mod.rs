//! Tables of the papers: published values beside reproduced ones.
//!
//! ```text
//! table   the values, as in the JSON document
//! text    the tables for the terminal
//! folder  a page, and one folder per paper: tables and points of figures as CSV
//! ```

pub mod folder;
mod table;
pub mod text;

pub use table::{PaperFigure, PublishedTable, Row, TablesReport};
