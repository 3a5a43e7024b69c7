//! A table of a paper, and what we find in its place.

use serde::Serialize;

/// All tables of all papers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TablesReport {
    /// Runs that were flown of each: those asked for, or fewer after Ctrl-C.
    pub runs: u64,
    /// Seed of the first run's noise; run `i` has this plus `i`.
    pub seed: u64,
    /// The tables, paper by paper.
    pub tables: Vec<PublishedTable>,
}

/// One estimator's column of a published table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PublishedTable {
    /// Key of the paper, as `Kim2010`.
    pub paper: &'static str,
    /// Number of the table, or where else in the paper it stands.
    pub table: &'static str,
    /// What it shows.
    pub title: String,
    /// The scenario that is flown.
    pub scenario: String,
    /// The estimator that is reproduced.
    pub estimator: String,
    /// Its arithmetic.
    pub precision: String,
    /// Our own estimator, which flew the same log; none where it doesn't have this quantity.
    pub own_estimator: Option<String>,
    /// Directions of the six-dimensional space of tensors that the manoeuvre shows.
    pub observed_directions: usize,
    /// One for each quantity.
    pub rows: Vec<Row>,
    /// What else is to be known of the whole table.
    pub remark: Option<String>,
}

/// One quantity: published, ours, what is possible, and what our own estimator does. Errors are
/// sizes, without their sign.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// What it is.
    pub quantity: String,
    /// Its unit.
    pub unit: &'static str,
    /// What is true in the simulation, where it is known.
    pub truth: Option<f64>,
    /// What the paper printed.
    pub published: Option<f64>,
    /// Mean of the reproduced estimator over the runs.
    pub mean: Option<f64>,
    /// Standard deviation of a run.
    pub sd: Option<f64>,
    /// Per cent of our runs that are below the published value, ties counting half.
    pub percentile: Option<f64>,
    /// Cramér-Rao bound, one sigma, in the same unit.
    pub bound: Option<f64>,
    /// Mean of our own estimator over the runs.
    pub own_mean: Option<f64>,
    /// Standard deviation of a run of it.
    pub own_sd: Option<f64>,
    /// Why the published value can't be right, or what else it takes to read it.
    pub remark: Option<String>,
}
