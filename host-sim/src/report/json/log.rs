//! Document of one of several logs.

use std::path::Path;

use serde::Serialize;

use super::ReplayReport;

/// Result of `replay` for one log and one estimator among several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogReport {
    /// The log.
    pub log: String,
    /// Reason of a result that is missing. Null with a result.
    pub error: Option<String>,
    /// Estimator of a result that is missing; the result has its own.
    #[serde(rename = "failed_estimator", skip_serializing_if = "Option::is_none")]
    pub estimator: Option<String>,
    /// The result, if there is one.
    #[serde(flatten)]
    pub result: Option<ReplayReport>,
}

impl LogReport {
    /// A result.
    pub fn of(log: &Path, result: ReplayReport) -> Self {
        let log = log.display().to_string();
        Self { log, error: None, estimator: None, result: Some(result) }
    }

    /// A missing result; `estimator` is empty if the log cannot be read.
    pub fn failed(log: &Path, estimator: &str, error: &str) -> Self {
        let estimator = (!estimator.is_empty()).then(|| estimator.to_owned());
        let log = log.display().to_string();
        Self { log, error: Some(error.to_owned()), estimator, result: None }
    }
}
