//! A table of a paper: published, reproduced, bound, own estimator.

use serde::Serialize;

use crate::report::plots::Figure;

/// All tables of all papers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TablesReport {
    /// Runs of each table: the number requested, or fewer after Ctrl-C.
    pub runs: u64,
    /// Seed of the first run's noise. Run `i` has `seed + i`.
    pub seed: u64,
    /// Tables, paper by paper.
    pub tables: Vec<PublishedTable>,
}

/// One estimator's column of a published table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PublishedTable {
    /// Key of the paper, as `Kim2010`.
    pub paper: &'static str,
    /// Number of the table, or another place in the paper.
    pub table: &'static str,
    /// Content.
    pub title: String,
    /// Scenario.
    pub scenario: String,
    /// Reproduced estimator.
    pub estimator: String,
    /// Precision of the reproduced estimator.
    pub precision: String,
    /// Own estimator, on the same log. Null if it does not have this quantity.
    pub own_estimator: Option<String>,
    /// Observable directions of the six-dimensional space of inertia tensors.
    pub observed_directions: usize,
    /// One row per quantity.
    pub rows: Vec<Row>,
    /// Remark on the whole table.
    pub remark: Option<String>,
}

/// One quantity. Errors are absolute values.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Name of the quantity.
    pub quantity: String,
    /// Unit.
    pub unit: &'static str,
    /// True value, if known.
    pub truth: Option<f64>,
    /// Published value.
    pub published: Option<f64>,
    /// Mean of the reproduced estimator over the runs.
    pub mean: Option<f64>,
    /// Standard deviation of one run.
    pub sd: Option<f64>,
    /// Share of the reproduced runs below the published value, per cent. Equal values count half.
    pub percentile: Option<f64>,
    /// Cramér-Rao bound, one sigma, in the same unit.
    pub bound: Option<f64>,
    /// Mean of the own estimator over the runs.
    pub own_mean: Option<f64>,
    /// Standard deviation of one run of the own estimator.
    pub own_sd: Option<f64>,
    /// Remark on this row.
    pub remark: Option<String>,
}

/// Counterpart of a published figure.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperFigure {
    /// Key of the paper, as `Kim2010`.
    pub paper: &'static str,
    /// The figure, under the name of its file.
    pub figure: Figure,
}
