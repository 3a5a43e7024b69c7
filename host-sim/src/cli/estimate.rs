//! What `run` and `replay` share: a log goes through an estimator, and becomes a report.

use fsw_core::Status as CoreStatus;

use super::{Failure, Options};
use crate::estimation::{EstimatorName, Flown, Precision, SetUpError, Setup, fly, set_up};
use crate::input::log::LogRow;
use crate::input::{Craft, Scenario};
use crate::recording::history_row;
use crate::report::HistoryRow;
use crate::report::json::{ReplayReport, Status, matrix};
use crate::sensor::noise;

/// An estimate, and how it came about where that is asked for.
pub struct Estimated {
    /// The estimate after the last sample.
    pub report: ReplayReport,
    /// The estimate after each, if a report folder is wanted.
    pub history: Vec<HistoryRow>,
}

/// Streams `rows` through the estimator that `options` name.
pub fn estimate(
    options: &Options,
    craft: &Craft,
    rows: &[LogRow],
    file: &str,
) -> Result<Estimated, Failure> {
    let estimator = options.method.estimator;
    if estimator.needs_attitude() && rows.iter().all(|row| row.attitude.is_none()) {
        return Err(SetUpError::NoAttitude { estimator }.into());
    }
    note_ignored_unknowns(estimator, craft);
    let mut setup = Setup {
        estimator,
        precision: options.method.precision,
        craft,
        gyro_noise_rad_s: craft.gyro.noise_rad_s,
        sample_period_s: median_period_s(rows),
        refuse_spikes: true,
    };
    if setup.gyro_noise_rad_s.is_none() && !estimator.measures_gyro_noise() {
        setup.gyro_noise_rad_s = Some(noise_from_residuals(&setup, rows, file)?);
    }
    let mut history = Vec::new();
    let flown = fly(rows, set_up(&setup)?, |row, outcome, on_board| {
        if options.out.is_some() {
            history.push(history_row(row, outcome, on_board));
        }
    });
    Ok(Estimated {
        report: report(estimator, options.method.precision, rows.len(), &flown),
        history,
    })
}

/// Says so where the estimator leaves out unknowns that it is asked for.
pub(super) fn note_ignored_unknowns(estimator: EstimatorName, craft: &Craft) {
    let asked = craft.solve_for.torque || craft.solve_for.gyro_bias;
    if asked && !estimator.solves_for_disturbances() {
        eprintln!(
            "note: {estimator} doesn't estimate a disturbance torque or gyro bias; [disturbance] is ignored"
        );
    }
}

/// Says what an estimate is measured with where the inertia changes in flight.
pub(super) fn note_what_changes(scenario: &Scenario) {
    if let Some(last) = scenario.changes.sudden.last() {
        eprintln!(
            "note: the inertia changes in flight; the bound is of what follows the last change, at {} s",
            last.time_s
        );
    }
    if scenario.changes.drifts() {
        eprintln!(
            "note: the inertia drifts; the truth is that at the end of the flight, and the bound that \
             of whoever knows the drift, which no estimator does: look at NEES"
        );
    }
}

/// Passes over the log, at most, that look for the gyro's noise.
const NOISE_PASSES: usize = 8;

/// Residuals this much larger than the noise that was assumed ask for another pass.
const UNEXPLAINED: f64 = 1.1;

/// Gyro noise of a craft that doesn't state it: the residuals that an estimator leaves which was
/// told this very noise. Starts from third differences of the log, which miss whatever noise is
/// correlated from sample to sample (vibration).
fn noise_from_residuals(setup: &Setup<'_>, rows: &[LogRow], file: &str) -> Result<f64, Failure> {
    let mut noise = noise::from_third_differences(rows).ok_or_else(|| Failure::NoNoise {
        file: file.to_owned(),
        why: if rows.len() < 4 { "fewer than four samples" } else { "its rates don't change" },
    })?;
    for _ in 0..NOISE_PASSES {
        let setup = Setup { gyro_noise_rad_s: Some(noise), refuse_spikes: false, ..setup.clone() };
        let residual = fly(rows, set_up(&setup)?, |_, _, _| ()).estimate.residual_rms_rad_s;
        if residual <= UNEXPLAINED * noise {
            break;
        }
        noise = residual;
    }
    eprintln!(
        "note: gyro.noise_rad_s isn't given; estimated from the residuals: {noise:.3e} rad/s"
    );
    Ok(noise)
}

/// The typical time between samples, s; zero for a single sample.
fn median_period_s(rows: &[LogRow]) -> f64 {
    let mut periods: Vec<u64> = rows.windows(2).map(|w| w[1].time_us - w[0].time_us).collect();
    periods.sort_unstable();
    periods.get(periods.len() / 2).map_or(0.0, |us| *us as f64 * 1e-6)
}

/// What an estimator has found over so many samples.
pub(super) fn report(
    estimator: EstimatorName,
    precision: Precision,
    samples: usize,
    flown: &Flown,
) -> ReplayReport {
    let Flown { counts, estimate } = flown;
    let elements = estimate.inertia.elements_kg_m2();
    let (over_trace, over_trace_sigma) = estimate.over_trace();
    let rejected = counts.rejected().into_iter().filter(|(_, count)| *count > 0);
    ReplayReport {
        estimator: estimator.to_string(),
        precision: precision.to_string(),
        samples: samples as u64,
        accepted: u64::from(counts.accepted),
        rejected: rejected.map(|(reason, count)| (reason.to_owned(), u64::from(count))).collect(),
        status: status(estimate.status),
        inertia_kg_m2: matrix(&elements),
        sigma_kg_m2: estimate.sigma_kg_m2(),
        covariance_kg2_m4: estimate.covariance_kg2_m4.into(),
        observed_directions: usize::from(estimate.observed.directions),
        element_observed: estimate.observed.element,
        scale_observed: estimate.observed.scale,
        inertia_over_trace: matrix(&over_trace),
        inertia_over_trace_sigma: over_trace_sigma,
        physical: estimate.inertia.check().is_ok(),
        disturbance_torque_n_m: estimate.disturbance_torque_n_m.map(Into::into),
        gyro_bias_rad_s: estimate.gyro_bias_rad_s.map(Into::into),
        residual_rms_rad_s: estimate.residual_rms_rad_s,
        residuals_white: estimate.residuals_white,
        projected: estimate.projected,
        changes: u64::from(flown.changes()),
    }
}

/// The core's word as the reports have it.
pub(super) fn status(status: CoreStatus) -> Status {
    match status {
        CoreStatus::Converged => Status::Converged,
        CoreStatus::Partial => Status::Partial,
        CoreStatus::Unobservable => Status::Unobservable,
        CoreStatus::Diverged => Status::Diverged,
    }
}
