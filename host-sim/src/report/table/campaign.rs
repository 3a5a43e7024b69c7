//! Table of `mc`: RMS error and bias beside the bound.

use super::cells::{DIGITS, EMPTY, UNOBSERVED, decimals, element, heading, or, short};
use crate::campaign::MAX_CONSISTENT_SIGMAS;
use crate::input::ELEMENT_NAMES;
use crate::report::columns::Columns;
use crate::report::json::McReport;
use crate::report::number::{fixed, significant};

/// Table of a campaign.
pub fn mc(report: &McReport) -> String {
    let decimals = decimals(&report.rmse_kg_m2.map(Option::unwrap_or_default), &report.truth_kg_m2);
    let measure = report.measure();
    let mut columns = vec![
        ("element", ""),
        ("true", "kg m²"),
        ("RMS error", "kg m²"),
        ("bias", "kg m²"),
        (measure.name, "kg m²"),
        ("RMS/bound", ""),
        ("bias/bound", ""),
    ];
    if report.largest_systematic.is_some() {
        columns.extend([("one sigma", "kg m²"), ("by noise", "kg m²")]);
    }
    let mut table = Columns::new(&columns);
    let ratio = |value: Option<f64>| or(value.map(|value| fixed(value, 2)), EMPTY);
    for i in 0..6 {
        let mut cells = vec![
            ELEMENT_NAMES[i].to_owned(),
            element(report.truth_kg_m2[i], decimals),
            short(report.rmse_kg_m2[i], EMPTY),
            short(report.bias_kg_m2[i], EMPTY),
            short(measure.bound_kg_m2[i], UNOBSERVED),
            ratio(measure.rmse_over_bound[i]),
            ratio(measure.bias_over_bound[i]),
        ];
        if report.largest_systematic.is_some() {
            cells.push(short(report.sigma_kg_m2[i], EMPTY));
            cells.push(short(report.sigma_random_kg_m2[i], EMPTY));
        }
        table.row(cells);
    }
    let last_seed = report.seed.wrapping_add(report.runs.saturating_sub(1));
    [
        heading("scenario", &format!("{}, seeds {} to {last_seed}", report.scenario, report.seed)),
        heading("estimator", &format!("{}, {}", report.estimator, report.precision)),
        heading("runs", &runs(report)),
        heading("changes", &format!("found in {} runs", report.changes)),
        heading("residuals", &format!("not white in {} runs", report.residuals_not_white)),
        heading("silent lies", &silent_lies(report)),
        heading("NEES", &nees(report)),
        heading("RMS/bound", &rms_over_bound(report)),
        report
            .largest_systematic
            .as_ref()
            .map_or(String::new(), |kind| heading("systematic", &format!("{kind} in most runs"))),
        heading("speed", &speed(report)),
        "\n".to_owned(),
        table.finish(),
    ]
    .concat()
}

/// Number of runs, and of those left out of the statistics.
fn runs(report: &McReport) -> String {
    let not_shown = match report.not_shown {
        0 => String::new(),
        count => format!("{count} with unobserved elements (left out below), "),
    };
    format!(
        "{}: {not_shown}{} diverged (left out below), {} of the others not converged",
        report.runs, report.diverged, report.not_converged
    )
}

/// Number of silent lies, and their definition.
fn silent_lies(report: &McReport) -> String {
    format!(
        "{} runs converged, not found non-white, and beyond {MAX_CONSISTENT_SIGMAS} sigma",
        report.silent_lies
    )
}

/// RMS error over the bound, all elements together.
fn rms_over_bound(report: &McReport) -> String {
    let measure = report.measure();
    let ratio = measure.rmse_over_bound_of_all.map(|ratio| fixed(ratio, 3));
    ratio.map_or("none: not all elements are observed".to_owned(), |ratio| {
        format!("{ratio} over all elements of {} runs{}", report.used, measure.of)
    })
}

/// Mean NEES per degree of freedom, and the 95 % interval of a consistent covariance.
fn nees(report: &McReport) -> String {
    let (Some(nees), Some([low, high])) = (report.nees_per_dof, report.nees_95) else {
        let reason = if report.used == 0 {
            "every run diverged"
        } else {
            "no covariance is positive definite"
        };
        return format!("none: {reason}");
    };
    let (nees, low, high) = (significant(nees, 4), significant(low, 4), significant(high, 4));
    let of = if report.nees_runs == report.used {
        String::new()
    } else {
        format!(", of the {} runs with a positive definite covariance", report.nees_runs)
    };
    format!("{nees} per degree of freedom (consistent: {low} to {high}, 95 %){of}")
}

/// Steps, duration, and speed of the estimator alone; of merged files the steps.
fn speed(report: &McReport) -> String {
    let Some(wall_s) = report.wall_s else { return format!("{} steps", report.steps) };
    let estimator = report.steps_per_s_per_core.map_or(String::new(), |speed| {
        format!("; the estimator alone {} steps/s per core", significant(speed, DIGITS))
    });
    format!("{} steps in {} s{estimator}", report.steps, significant(wall_s, DIGITS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::json::examples;

    #[test]
    fn mc_table_has_rms_bias_and_bound() {
        assert_eq!(
            mc(&examples::mc()),
            "\
scenario            stsat3-spin-up, seeds 100 to 149
estimator           joint-ekf, f32
runs                50: 2 diverged (left out below), 1 of the others not converged
changes             found in 3 runs
residuals           not white in 0 runs
silent lies         0 runs converged, not found non-white, and beyond 5 sigma
NEES                1.092 per degree of freedom (consistent: 0.8881 to 1.119, 95 %)
RMS/bound           1.250 over all elements of 48 runs
speed               300050 steps in 1.26 s; the estimator alone 512346 steps/s per core

element     true  RMS error       bias     bound  RMS/bound  bias/bound
           kg m²      kg m²      kg m²     kg m²
jxx      14.2000    0.00344  -0.000275   0.00275       1.25       -0.10
jyy      17.3000    0.00311  -0.000249   0.00249       1.25       -0.10
jzz      20.3000    0.00399  -0.000319   0.00319       1.25       -0.10
jxy       0.0867    0.00140  -0.000112   0.00112       1.25       -0.10
jxz       0.1357    0.00202  -0.000162   0.00162       1.25       -0.10
jyz       0.6016    0.00107   -8.54e-5  0.000854       1.25       -0.10
"
        );
    }

    #[test]
    fn mc_table_measures_by_the_joint_bound_where_there_is_one() {
        let mut report = examples::mc();
        report.joint_bound_kg_m2 = report.bound_kg_m2.map(|bound| Some(2.0 * bound?));
        report.rmse_over_joint_bound =
            [Some(0.5), Some(1.0), Some(1.0), Some(1.0), Some(1.0), None];
        let heading = "RMS/bound           none: not all elements are observed\n";
        assert!(mc(&report).contains(heading), "{}", mc(&report));
        report.rmse_over_joint_bound[5] = Some(1.5);
        let table = mc(&report);
        // √((0.25 + 4 + 2.25) / 6)
        let heading =
            "1.041 over all elements of 48 runs, errors of the hardware among the unknowns";
        assert!(table.contains(heading), "{table}");
        assert!(table.contains("joint bound  RMS/bound"), "{table}");
        let jxx = table.lines().find(|line| line.starts_with("jxx")).unwrap();
        let cells: Vec<&str> = jxx.split_whitespace().collect();
        assert_eq!(cells, ["jxx", "14.2000", "0.00344", "-0.000275", "0.00550", "0.50", "-0.05"]);
    }

    #[test]
    fn mc_table_without_bound_or_covariance_has_the_reason() {
        let mut report = examples::mc();
        report.nees_runs = 40;
        report.bound_kg_m2[0] = None;
        (report.rmse_over_bound[0], report.bias_over_bound[0]) = (None, None);
        report.rmse_over_bound_of_all = None;
        report.not_shown = 3;
        let table = mc(&report);
        assert!(table.contains("50: 3 with unobserved elements (left out below), 2 diverged"));
        assert!(table.contains("RMS/bound           none: not all elements are observed\n"));
        assert!(table.contains("95 %), of the 40 runs with a positive definite covariance"));
        assert!(table.contains("unobserved          -           -\n"), "{table}");

        (report.rmse_kg_m2, report.bias_kg_m2) = ([None; 6], [None; 6]);
        (report.nees_per_dof, report.nees_95) = (None, None);
        assert!(
            mc(&report).contains("NEES                none: no covariance is positive definite\n")
        );
        report.used = 0;
        assert!(mc(&report).contains("NEES                none: every run diverged\n"));
    }
}
