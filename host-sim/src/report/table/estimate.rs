//! Tables of `replay` and `run`: the estimate, with truth and bound if they are known.

use std::collections::BTreeMap;

use super::cells::{DIGITS, EMPTY, UNOBSERVED, decimals, element, heading, or, short, vector};
use super::explanation::explanations;
use super::hardware::{solved, systematic};
use crate::input::ELEMENT_NAMES;
use crate::report::columns::Columns;
use crate::report::json::{HealthChange, ReplayReport, RunReport, Status, elements};
use crate::report::number::{fixed, significant};

/// Table of a simulated flight: estimate, truth and bound.
pub fn run(report: &RunReport) -> String {
    let estimate = &report.estimate;
    let found = estimate.elements_kg_m2();
    let decimals = decimals(&estimate.sigma_kg_m2, &found);
    let (bound, bounds_kg_m2) = report.measure();
    let over = format!("error/{bound}");
    let mut columns = vec![
        ("element", ""),
        ("true", "kg m²"),
        ("estimated", "kg m²"),
        ("error", "kg m²"),
        ("error", "%"),
        ("one sigma", "kg m²"),
    ];
    columns.extend(random_column(estimate));
    columns.extend([("error/sigma", ""), (bound, "kg m²"), (&*over, "")]);
    let mut table = Columns::new(&columns);
    for i in 0..6 {
        let error = found[i] - report.truth_kg_m2[i];
        let mut cells = vec![
            ELEMENT_NAMES[i].to_owned(),
            element(report.truth_kg_m2[i], decimals),
            element(found[i], decimals),
            significant(error, DIGITS),
            short(report.error_percent[i], EMPTY),
            significant(estimate.sigma_kg_m2[i], DIGITS),
        ];
        cells.extend(random_cell(estimate, i));
        cells.push(or(report.error_over_sigma[i].map(|ratio| fixed(ratio, 2)), EMPTY));
        cells.push(short(bounds_kg_m2[i], UNOBSERVED));
        cells.push(or(bounds_kg_m2[i].map(|bound| fixed(error / bound, 2)), EMPTY));
        table.row(cells);
    }
    let scenario = heading("scenario", &format!("{}, seed {}", report.scenario, report.seed));
    [scenario, summary(estimate), "\n".to_owned(), table.finish(), solved(estimate)].concat()
}

/// Column of the sigma by noise alone, for hardware with errors.
fn random_column(report: &ReplayReport) -> Option<(&'static str, &'static str)> {
    (!report.hardware.is_empty()).then_some(("by noise", "kg m²"))
}

/// Cell of that column.
fn random_cell(report: &ReplayReport, i: usize) -> Option<String> {
    random_column(report).map(|_| significant(report.sigma_random_kg_m2[i], DIGITS))
}

/// Table of a recorded log: estimate and sigma.
pub fn replay(report: &ReplayReport) -> String {
    let found = report.elements_kg_m2();
    let decimals = decimals(&report.sigma_kg_m2, &found);
    let mut columns =
        vec![("element", ""), ("estimated", "kg m²"), ("one sigma", "kg m²"), ("one sigma", "%")];
    columns.extend(random_column(report));
    columns.push(("observed", ""));
    let mut table = Columns::new(&columns);
    for i in 0..6 {
        let sigma = report.sigma_kg_m2[i];
        let percent = 100.0 * sigma / found[i].abs();
        let mut cells = vec![
            ELEMENT_NAMES[i].to_owned(),
            element(found[i], decimals),
            significant(sigma, DIGITS),
            short(percent.is_finite().then_some(percent), EMPTY),
        ];
        cells.extend(random_cell(report, i));
        cells.push(if report.element_observed[i] { "yes" } else { "no" }.to_owned());
        table.row(cells);
    }
    let moments = report.principal_moments_kg_m2();
    let moments = moments.map(|moment| element(moment, decimals)).join(", ");
    let mut parts = vec![
        summary(report),
        "\n".to_owned(),
        table.finish(),
        "\n".to_owned(),
        heading("principal moments", &format!("{moments} kg m²")),
        solved(report),
    ];
    if !report.scale_observed && report.observed_directions > 0 {
        parts.push(ratios(report));
    }
    if !report.explanations.is_empty() {
        /// Most explanations below the estimate.
        const LISTED: usize = 3;
        parts.push("\n".to_owned());
        parts.push(explanations(&report.explanations, LISTED));
    }
    parts.concat()
}

/// The status, with its meaning unless it is the desired one.
fn status(status: Status) -> String {
    let meaning = match status {
        Status::Converged => return status.to_string(),
        Status::Partial => "some directions unobserved; they hold the prior and its sigma",
        Status::Unobservable => "no direction observed, or too little motion for a first estimate",
        Status::Diverged => "the model does not explain the data",
    };
    format!("{status}: {meaning}")
}

/// Lines above a table of estimates.
fn summary(report: &ReplayReport) -> String {
    let scale = if report.scale_observed { "scale observed" } else { "scale not observed" };
    let observed = format!("{} of 6 directions, {scale}", report.observed_directions);
    let physical = match (report.physical, report.projected) {
        (true, false) => "yes",
        (true, true) => "yes: projected, since the unconstrained estimate is not physical",
        (false, _) => "no: no rigid body has this tensor",
    };
    let mut lines = heading("estimator", &format!("{}, {}", report.estimator, report.precision));
    if !report.skipped_rows.is_empty() {
        lines += &heading("rows skipped", &counts(&report.skipped_rows));
    }
    lines += &heading("samples", &samples(report));
    lines += &heading("status", &status(report.status));
    lines += &heading("observed", &observed);
    lines += &heading("physical", physical);
    lines += &heading("residual", &residual(report));
    lines += &systematic(report);
    lines += &events(report);
    lines += &health(report);
    if let Some(torque) = &report.disturbance_torque_n_m {
        lines += &heading("disturbance torque", &format!("{} N m", vector(torque)));
    }
    if let Some(bias) = &report.gyro_bias_rad_s {
        lines += &heading("gyro bias", &format!("{} rad/s", vector(bias)));
    }
    lines
}

/// A line for each kind of event: number and first times.
fn events(report: &ReplayReport) -> String {
    let line = |name: &str, count: usize, times_s: &[f64], effect: &str| match count {
        0 => String::new(),
        _ => heading(name, &format!("{count}, at {}{effect}", times(count, times_s))),
    };
    let spikes = &report.spikes;
    [
        line("gaps", report.gaps.len(), &report.gaps, ""),
        line("restarts", report.restarts.len(), &report.restarts, ""),
        line(
            "interruptions",
            report.interruptions.len(),
            &report.interruptions,
            ": the earlier estimate is in doubt",
        ),
        line(
            "changes",
            report.changes.len(),
            &report.changes,
            ": the earlier estimate was discarded",
        ),
        line("spikes", spikes.count as usize, &spikes.first_s, ""),
    ]
    .concat()
}

/// The health and its first changes; nothing for a log that was nominal throughout.
fn health(report: &ReplayReport) -> String {
    /// Most changes in the line.
    const LISTED: usize = 4;
    let changes = &report.health_changes;
    let change = |change: &HealthChange| {
        let driver = change.driver.as_deref().filter(|_| change.health != "nominal");
        let driver = driver.map(|driver| format!(" ({driver})")).unwrap_or_default();
        format!("{}{driver} at {} s", change.health, change.t_s)
    };
    let mut listed: Vec<String> = changes.iter().take(LISTED).map(change).collect();
    if listed.len() < changes.len() {
        listed.push("…".to_owned());
    }
    match listed.is_empty() {
        true => String::new(),
        false => heading("health", &format!("{}: {}", report.health, listed.join(", "))),
    }
}

/// The first times, as `12.3, 45.6, … s`.
fn times(count: usize, times_s: &[f64]) -> String {
    /// Largest number of times in a line.
    const LISTED: usize = 5;
    let mut listed: Vec<String> = times_s.iter().take(LISTED).map(f64::to_string).collect();
    if listed.len() < count {
        listed.push("…".to_owned());
    }
    listed.join(", ") + " s"
}

/// Accepted samples, and rejected samples by reason.
fn samples(report: &ReplayReport) -> String {
    let rejected = report.rejected_total();
    let reasons = match rejected {
        0 => String::new(),
        _ => format!(" ({})", counts(&report.rejected)),
    };
    format!("{}, {} accepted, {rejected} rejected{reasons}", report.samples, report.accepted)
}

/// Counts by reason, as `2 spike, 1 stuck`; reasons that did not occur are left out.
fn counts(by_reason: &BTreeMap<String, u64>) -> String {
    let counts = by_reason.iter().filter(|(_, count)| **count > 0);
    counts.map(|(reason, count)| format!("{count} {reason}")).collect::<Vec<_>>().join(", ")
}

/// RMS residual, and the result of the test for white noise.
fn residual(report: &ReplayReport) -> String {
    let white = match report.residuals_white {
        None => "",
        Some(true) => ", white",
        Some(false) => ", not white: an effect outside the model",
    };
    match report.residual_rms_rad_s {
        0.0 => "none: no sample was predicted".to_owned(),
        rms => format!("{} rad/s RMS{white}", significant(rms, 4)),
    }
}

/// Table of the tensor over its trace: the observable part of torque-free motion without wheels.
fn ratios(report: &ReplayReport) -> String {
    let ratio = elements(&report.inertia_over_trace);
    let mut table = Columns::new(&[("element", ""), ("over trace", ""), ("one sigma", "")]);
    for i in 0..6 {
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            fixed(ratio[i], 5),
            significant(report.inertia_over_trace_sigma[i], DIGITS),
        ]);
    }
    let note = "\nOnly the ratios of the tensor are observed; its scale is that of the prior:\n\n";
    [note.to_owned(), table.finish()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::json::{Spikes, Status, examples, matrix};

    #[test]
    fn run_table_has_estimate_truth_and_bound() {
        assert_eq!(
            run(&examples::run()),
            "\
scenario            stsat3-spin-up, seed 7
estimator           joint-ekf, f32
samples             6001, 5998 accepted, 3 rejected (2 spike, 1 stuck)
status              converged
observed            6 of 6 directions, scale observed
physical            yes
residual            0.0001815 rad/s RMS, white
spikes              2, at 12.3, 45.6 s

element      true  estimated     error    error  one sigma  error/sigma     bound  error/bound
            kg m²      kg m²     kg m²        %      kg m²                  kg m²
jxx      14.20000   14.20102   0.00102  0.00718    0.00275         0.37   0.00275         0.37
jyy      17.30000   17.29780  -0.00220  -0.0127    0.00250        -0.88   0.00249        -0.88
jzz      20.30000   20.30110   0.00110  0.00542    0.00320         0.34   0.00319         0.34
jxy       0.08670    0.08722  0.000520    0.600    0.00110         0.47   0.00112         0.46
jxz       0.13570    0.13410  -0.00160    -1.18    0.00160        -1.00   0.00162        -0.99
jyz       0.60160    0.60150  -1.00e-4  -0.0166   0.000860        -0.12  0.000854        -0.12
"
        );
    }

    #[test]
    fn replay_table_has_estimate_and_sigma() {
        let mut report = examples::replay();
        report.disturbance_torque_n_m = Some([1.5e-6, -2e-7, 0.0]);
        report.gyro_bias_rad_s = Some([0.01, -0.02, 0.003]);
        (report.gaps, report.changes) = (vec![12.3], (1..8).map(f64::from).collect());
        report.skipped_rows.insert("incomplete".to_owned(), 1);
        report.element_observed[4] = false;
        report.observed_directions = 5;
        report.status = Status::Partial;
        let change = |t_s, health: &str| HealthChange {
            t_s,
            health: health.to_owned(),
            driver: Some("gap".to_owned()),
        };
        report.health_changes = vec![change(12.3, "degraded"), change(15.5, "nominal")];
        assert_eq!(
            replay(&report),
            "\
estimator           joint-ekf, f32
rows skipped        1 incomplete
samples             6001, 5998 accepted, 3 rejected (2 spike, 1 stuck)
status              partial: some directions unobserved; they hold the prior and its sigma
observed            5 of 6 directions, scale observed
physical            yes
residual            0.0001815 rad/s RMS, white
gaps                1, at 12.3 s
changes             7, at 1, 2, 3, 4, 5, … s: the earlier estimate was discarded
spikes              2, at 12.3, 45.6 s
health              nominal: degraded (gap) at 12.3 s, nominal at 15.5 s
disturbance torque  1.50e-6, -2.00e-7, 0 N m
gyro bias           0.0100, -0.0200, 0.00300 rad/s

element  estimated  one sigma  one sigma  observed
             kg m²      kg m²          %
jxx       14.20102    0.00275     0.0194       yes
jyy       17.29780    0.00250     0.0145       yes
jzz       20.30110    0.00320     0.0158       yes
jxy        0.08722    0.00110       1.26       yes
jxz        0.13410    0.00160       1.19        no
jyz        0.60150   0.000860      0.143       yes

principal moments   14.19627, 17.18303, 20.42062 kg m²
"
        );
    }

    #[test]
    fn replay_table_without_observed_scale_has_the_ratios() {
        let mut report = examples::replay();
        report.scale_observed = false;
        report.rejected.clear();
        report.spikes = Spikes::default();
        report.inertia_kg_m2 = matrix(&[4.6e-8, 3.7e-9, 5.0e-8, 0.0, 1e-10, 0.0]);
        report.sigma_kg_m2 = [1e-8, 1e-9, 1e-8, 1e-10, 1e-10, 1e-10];
        assert_eq!(
            replay(&report),
            "\
estimator           joint-ekf, f32
samples             6001, 5998 accepted, 0 rejected
status              converged
observed            6 of 6 directions, scale not observed
physical            yes
residual            0.0001815 rad/s RMS, white

element    estimated  one sigma  one sigma  observed
               kg m²      kg m²          %
jxx       4.60000e-8    1.00e-8       21.7       yes
jyy       3.70000e-9    1.00e-9       27.0       yes
jzz       5.00000e-8    1.00e-8       20.0       yes
jxy                0   1.00e-10          -       yes
jxz      1.00000e-10   1.00e-10        100       yes
jyz                0   1.00e-10          -       yes

principal moments   3.70000e-9, 4.59975e-8, 5.00025e-8 kg m²

Only the ratios of the tensor are observed; its scale is that of the prior:

element  over trace  one sigma
jxx         0.27415    5.31e-5
jyy         0.33393    4.83e-5
jzz         0.39191    6.18e-5
jxy         0.00168    2.12e-5
jxz         0.00259    3.09e-5
jyz         0.01161    1.66e-5
"
        );
    }
}
