//! Campaigns under a torque that the estimator does not model, in units of the torque that `crlb`
//! resolves from the residuals.

use std::fs;

use anyhow::{Context, Result, ensure};

use super::campaign::{Row, fly};
use crate::program::{HostSim, repository};

/// Torque of each column, in sigmas.
const SIGMAS: [f64; 3] = [5.0, 6.0, 8.0];

/// Numbers of runs whose residuals are called not white; the title of the row is the axis.
pub(super) fn cells(host_sim: &HostSim, row: &Row, runs: u64) -> Result<Vec<String>> {
    let bound = fly(host_sim, &["crlb".to_owned(), row.scenario.to_owned()])?;
    let axis = ["x", "y", "z"].iter().position(|axis| *axis == row.title);
    let axis = axis.with_context(|| format!("`{}` is no axis", row.title))?;
    let sigma_n_m = bound["torque_bound_n_m"][axis].as_f64().context("crlb gives no torque")?;

    let path = repository().join(format!("host-sim/scenarios/{}.toml", row.scenario));
    let scenario = fs::read_to_string(path)?;
    ensure!(!scenario.contains("[disturbance]"), "{} has a disturbance", row.scenario);
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("disturbed.toml");
    let disturbed = path.to_str().context("the temporary folder is not Unicode")?;

    let mut cells = Vec::new();
    for sigmas in SIGMAS {
        let mut torque_n_m = [0.0; 3];
        torque_n_m[axis] = sigmas * sigma_n_m;
        fs::write(&path, format!("{scenario}\n[disturbance]\ntorque_n_m = {torque_n_m:?}\n"))?;
        let words = ["mc", disturbed, "--runs", &runs.to_string()];
        let report = fly(host_sim, &words.map(str::to_owned))?;
        cells.push(report["residuals_not_white"].to_string());
    }
    Ok(cells)
}
