//! How a row of a published table is filled from the runs.

use super::distribution::Distribution;
use crate::report::published::Row;

impl Row {
    /// A row with nothing in it yet.
    pub fn new(quantity: impl Into<String>, unit: &'static str) -> Self {
        Self { quantity: quantity.into(), unit, ..Self::default() }
    }

    /// What is true.
    pub fn truth(self, truth: f64) -> Self {
        Self { truth: Some(truth), ..self }
    }

    /// What the reproduced estimator came to, beside what was published.
    pub fn ours(self, published: Option<f64>, ours: &Distribution) -> Self {
        Self {
            published,
            mean: ours.mean(),
            sd: ours.standard_deviation(),
            percentile: published.and_then(|value| ours.percentile(value)),
            ..self
        }
    }

    /// What our own estimator came to.
    pub fn own(self, own: &Distribution) -> Self {
        Self { own_mean: own.mean(), own_sd: own.standard_deviation(), ..self }
    }

    /// What no unbiased estimator can beat.
    pub fn bound(self, bound: Option<f64>) -> Self {
        Self { bound, ..self }
    }

    /// A few words.
    pub fn remark(self, remark: impl Into<String>) -> Self {
        Self { remark: Some(remark.into()), ..self }
    }
}
