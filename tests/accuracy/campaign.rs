//! One campaign, and the cells of its row.

use anyhow::{Context, Result, bail};
use serde_json::Value;

use super::tables::Columns;
use crate::program::HostSim;

/// One campaign of `host-sim mc`.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Name for the reader, or the axis of a torque.
    pub title: &'static str,
    /// Built-in scenario.
    pub scenario: &'static str,
    /// Number of runs, seeds from 0.
    pub runs: u64,
    /// Estimator; the default of `mc` if none.
    pub estimator: Option<&'static str>,
    /// Double precision instead of single.
    pub is_double: bool,
}

impl Row {
    /// A campaign with the default estimator, in single precision.
    pub const fn window(scenario: &'static str, runs: u64) -> Self {
        Self { title: "", scenario, runs, estimator: None, is_double: false }
    }

    /// The same with a name.
    pub const fn titled(self, title: &'static str) -> Self {
        Self { title, ..self }
    }

    /// The same with another estimator.
    pub const fn by(self, estimator: &'static str) -> Self {
        Self { estimator: Some(estimator), ..self }
    }

    /// The same in double precision.
    pub const fn in_double(self) -> Self {
        Self { is_double: true, ..self }
    }

    /// Arguments of `host-sim` for this number of runs.
    pub fn arguments(&self, runs: u64) -> Vec<String> {
        let mut words = vec!["mc".to_owned(), self.scenario.to_owned()];
        words.extend(["--runs".to_owned(), runs.to_string()]);
        if let Some(estimator) = self.estimator {
            words.extend(["--estimator".to_owned(), estimator.to_owned()]);
        }
        if self.is_double {
            words.extend(["--precision".to_owned(), "f64".to_owned()]);
        }
        words
    }

    /// Arguments of `host-sim` that print the figures of this row.
    pub fn command(&self) -> String {
        self.arguments(self.runs).join(" ")
    }

    /// Result of this number of runs, the JSON document of `mc`.
    ///
    /// # Errors
    /// The campaign cannot be flown.
    pub fn fly(&self, host_sim: &HostSim, runs: u64) -> Result<Value> {
        fly(host_sim, &self.arguments(runs))
    }
}

/// JSON document of `host-sim` with these arguments.
pub(super) fn fly(host_sim: &HostSim, arguments: &[String]) -> Result<Value> {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).chain(["--json"]).collect();
    let text = host_sim.output(&arguments).with_context(|| arguments.join(" "))?;
    Ok(serde_json::from_str(&text)?)
}

/// The cells of a row, after those that the list gives.
pub(super) fn cells(columns: Columns, report: &Value) -> Result<Vec<String>> {
    let count = |key: &str| {
        report[key].as_u64().with_context(|| format!("the report of mc has no count `{key}`"))
    };
    let (diverged, not_converged) = (count("diverged")?, count("not_converged")?);
    // With stated errors of the hardware, the bound is that of a solution for them.
    let of_joint = six(report, "rmse_over_joint_bound")?;
    let over_bound = match of_joint {
        Some(values) => Some(values),
        None => six(report, "rmse_over_bound")?,
    };
    let over_bound = over_bound.map_or("–".to_owned(), |values| range(&values));
    let failed = (diverged + not_converged).to_string();
    Ok(match columns {
        Columns::Summary => vec![over_bound, nees(report), failed],
        Columns::Full => vec![
            over_bound,
            largest(report, "bias_over_bound")?,
            nees(report),
            diverged.to_string(),
            not_converged.to_string(),
            count("changes")?.to_string(),
            count("residuals_not_white")?.to_string(),
        ],
        Columns::Hardware => vec![
            over_bound,
            nees(report),
            count("silent_lies")?.to_string(),
            diverged.to_string(),
            not_converged.to_string(),
            count("residuals_not_white")?.to_string(),
        ],
        Columns::Verdicts => {
            let converged = count("used")? - not_converged;
            vec![converged.to_string(), not_converged.to_string(), diverged.to_string()]
        }
        Columns::WhiteResiduals => bail!("not a campaign of one command"),
    })
}

/// Six numbers of the report; none where one of them is missing.
fn six(report: &Value, key: &str) -> Result<Option<Vec<f64>>> {
    let list = report[key].as_array().with_context(|| format!("no list `{key}`"))?;
    Ok(list.iter().map(Value::as_f64).collect())
}

/// Least and largest of some numbers.
fn range(values: &[f64]) -> String {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{least:.2} to {most:.2}")
}

/// Largest magnitude of six numbers.
fn largest(report: &Value, key: &str) -> Result<String> {
    Ok(six(report, key)?.map_or("–".to_owned(), |values| {
        format!("{:.2}", values.iter().fold(0.0, |most: f64, x| most.max(x.abs())))
    }))
}

/// Mean NEES over its degrees of freedom, with the interval of an honest covariance.
fn nees(report: &Value) -> String {
    let interval = (report["nees_95"][0].as_f64(), report["nees_95"][1].as_f64());
    match (report["nees_per_dof"].as_f64(), interval) {
        (Some(mean), (Some(low), Some(high))) => format!("{mean:.3} ({low:.2}–{high:.2})"),
        _ => "–".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without stated hardware the joint bound is a list without numbers.
    #[test]
    fn error_is_over_the_joint_bound_where_there_is_one() {
        let mut report = serde_json::json!({
            "diverged": 0, "not_converged": 1, "rmse_over_bound": [9.0, 8.0, 7.0, 7.5, 8.5, 9.5],
            "rmse_over_joint_bound": [null, null, null, null, null, null],
        });
        let first = |report: &Value| cells(Columns::Summary, report).unwrap()[0].clone();
        assert_eq!(first(&report), "7.00 to 9.50");
        report["rmse_over_joint_bound"] = serde_json::json!([1.0, 0.9, 1.1, 1.0, 1.0, 1.0]);
        assert_eq!(first(&report), "0.90 to 1.10");
    }
}
