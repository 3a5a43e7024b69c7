//! Estimation and its notes, shared by `run` and `replay`.

use super::Failure;
use super::notes::Notes;
use crate::diagnosis::innovations;
use crate::estimation::{
    EstimationResult, EstimatorName, HealthHistory, Method, Setup, estimate_log, key,
};
use crate::fault::Computer;
use crate::input::craft::hardware::DATA_SHEET;
use crate::input::log::LogRow;
use crate::input::scenario::Fault;
use crate::input::{Craft, Scenario};
use crate::report::{HistoryRow, ReplayReport};

/// Report of a log, and its time history.
pub(super) struct Estimated {
    /// Report of the estimate after the last sample.
    pub report: ReplayReport,
    /// State of the estimator after each sample; empty unless it is kept.
    pub history: Vec<HistoryRow>,
}

/// Estimate from a log. `source` is the log's name in errors. `faults` are those of the computer, with their seed.
/// The report has `notes` and those on the set-up.
pub(super) fn estimate(
    method: Method,
    keep_history: bool,
    craft: &Craft,
    rows: &[LogRow],
    source: &str,
    (faults, seed): (&[Fault], u64),
    mut notes: Notes,
) -> Result<Estimated, Failure> {
    let failure = |error| Failure::SetUp { source_name: source.to_owned(), error };
    note_ignored_disturbances(method.estimator, craft, &mut notes);
    let setup = Setup::for_log(method, craft, rows).map_err(failure)?;
    if let Some(noise) = setup.measured_gyro_noise_rad_s() {
        notes.add(format!(
            "gyro.noise_rad_s is not given; estimated from the residuals: {noise:.3e} rad/s"
        ));
    }
    let (mut history, mut health) = (Vec::new(), HealthHistory::default());
    let estimator = Computer::with(&setup, faults, seed).map_err(failure)?;
    let result = estimate_log(rows, estimator, |row, outcome, estimator| {
        health.step(row.time_us, outcome, estimator);
        if keep_history {
            history.push(HistoryRow::new(row, outcome, estimator));
        }
    });
    if history.iter().all(|row| row.innovation_rad_s.is_none()) && !history.is_empty() {
        let all = innovations(craft, rows, &result);
        history.iter_mut().zip(all).for_each(|(row, innovation)| row.set_innovation(innovation));
    }
    note_assumptions(method.estimator, craft, &result, &mut notes);
    let mut report = ReplayReport::new(method, rows.len(), &result).with_health(&health);
    let assumed = &craft.hardware.assumed;
    report.hardware.iter_mut().for_each(|parameter| parameter.mark_assumed(assumed));
    report.notes = notes.into_list();
    Ok(Estimated { report, history })
}

/// Note for an estimator that cannot solve for the craft's disturbances: ignored, or considered where their sigma is
/// stated.
pub(super) fn note_ignored_disturbances(
    estimator: EstimatorName,
    craft: &Craft,
    notes: &mut Notes,
) {
    let properties = estimator.properties();
    if properties.solves_for_disturbances {
        return;
    }
    let (asked, hardware) = (&craft.solve_for, &craft.hardware);
    let disturbances =
        [(asked.torque, hardware.torque_sigma_n_m), (asked.gyro_bias, hardware.bias_sigma_rad_s)];
    let is_considered = |sigma: Option<f64>| properties.considers_disturbances && sigma.is_some();
    if disturbances.iter().any(|(asked, sigma)| *asked && !is_considered(*sigma)) {
        notes.add(format!(
            "{estimator} does not estimate disturbance torque or gyro bias; [disturbance] is \
             ignored"
        ));
    }
    if disturbances.iter().any(|(_, sigma)| is_considered(*sigma)) {
        notes.add(format!(
            "{estimator} does not estimate disturbance torque or gyro bias; their stated sigma is in \
             the covariance"
        ));
    }
}

/// Note on the data-sheet values that the craft file leaves to assumption, or on an estimator without errors of the
/// hardware.
fn note_assumptions(
    estimator: EstimatorName,
    craft: &Craft,
    result: &EstimationResult,
    notes: &mut Notes,
) {
    let hardware = &craft.hardware;
    if result.hardware.is_empty() && result.estimate.sigma_random_kg_m2.is_none() {
        if estimator != EstimatorName::Window && !hardware.is_ideal() {
            notes.add(format!(
                "{estimator} does not consider errors of gyro, wheels and torque; its sigma is that of the noise"
            ));
        }
        return;
    }
    let is_used = |path: &str| {
        let mut used = result.hardware.iter().map(|finding| key(finding.parameter));
        result.hardware.is_empty() || used.any(|used| used == path)
    };
    let is_assumed = |path: &&str| hardware.assumed.contains(path) && is_used(path);
    let rows = DATA_SHEET.iter().filter(|row| is_assumed(&row.path));
    let values: Vec<String> = rows.map(|row| format!("{} {}", row.path, row.value)).collect();
    if !values.is_empty() {
        notes.add(format!(
            "assumed: {}; state them in the craft file, zero included",
            values.join(", ")
        ));
    }
}

/// Notes on truth and bound of a scenario with a changing inertia.
pub(super) fn note_changes(scenario: &Scenario, notes: &mut Notes) {
    if let Some(last) = scenario.changes.sudden.last() {
        notes.add(format!(
            "the inertia changes in flight; the bound is of the data after the last change, at {} s",
            last.time_s
        ));
    }
    if scenario.changes.drifts() {
        notes.add(
            "the inertia drifts; the truth is at the end of the flight, and the bound assumes a \
             known drift: the error may exceed it, and NEES is the measure",
        );
    }
}
