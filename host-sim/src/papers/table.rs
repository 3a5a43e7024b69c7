//! Construction of a published table and its rows from the statistics of the trials.

use super::case::{Case, OWN};
use super::distribution::Distribution;
use crate::estimation::Method;
use crate::report::published::{PublishedTable, Row};

impl PublishedTable {
    /// A table of `paper`, reproduced by `method` on the scenario of `case`. The own estimator
    /// stands beside it.
    ///
    /// `place` is the number of the table in the paper, or another place in it.
    pub(super) fn new(
        paper: &'static str,
        place: &'static str,
        title: impl Into<String>,
        case: &Case,
        method: Method,
        rows: Vec<Row>,
    ) -> Self {
        Self {
            paper,
            table: place,
            title: title.into(),
            scenario: case.scenario.name.clone(),
            estimator: method.estimator.to_string(),
            precision: method.precision.to_string(),
            own_estimator: Some(OWN.estimator.to_string()),
            observed_directions: case.flight.bound.observed_directions,
            rows,
            remark: None,
        }
    }

    /// The table of a quantity that the own estimator does not have.
    pub(super) fn without_own(self) -> Self {
        Self { own_estimator: None, ..self }
    }

    /// Adds a remark on the whole table.
    pub(super) fn remark(self, remark: impl Into<String>) -> Self {
        Self { remark: Some(remark.into()), ..self }
    }
}

impl Row {
    /// An empty row.
    pub(super) fn new(quantity: impl Into<String>, unit: &'static str) -> Self {
        Self { quantity: quantity.into(), unit, ..Self::default() }
    }

    /// Adds the true value.
    pub(super) fn truth(self, truth: f64) -> Self {
        Self { truth: Some(truth), ..self }
    }

    /// Adds the published value and the distribution of the reproduced one.
    pub(super) fn ours(self, published: Option<f64>, ours: &Distribution) -> Self {
        Self {
            published,
            mean: ours.mean(),
            sd: ours.standard_deviation(),
            percentile: published.and_then(|value| ours.percentile(value)),
            ..self
        }
    }

    /// Adds the distribution of the own estimator.
    pub(super) fn own(self, own: &Distribution) -> Self {
        Self { own_mean: own.mean(), own_sd: own.standard_deviation(), ..self }
    }

    /// Adds the Cramér-Rao bound, one sigma.
    pub(super) fn bound(self, bound: Option<f64>) -> Self {
        Self { bound, ..self }
    }

    /// Adds a remark on this row.
    pub(super) fn remark(self, remark: impl Into<String>) -> Self {
        Self { remark: Some(remark.into()), ..self }
    }
}
