//! Verdict of a result in one or two sentences, on top of its page.

use super::history::HistoryRow;
use super::json::{ReplayReport, RunReport, Status};
use super::number::significant;
use super::table::in_words;
use crate::input::ELEMENT_NAMES;

/// Body axes of each element.
const AXES: [&[usize]; 6] = [&[0], &[1], &[2], &[0, 1], &[0, 2], &[1, 2]];
/// Names of the body axes.
const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];
/// Sigmas that an element must exceed for its own size to be the measure of its sigma: to 10 %.
const NONZERO_SIGMAS: f64 = 10.0;

/// Verdict of an estimate, as `All six elements to 0.05 to 1.1 % (one sigma), limited by wheel spin inertia.`
pub(super) fn of_estimate(report: &ReplayReport, history: &[HistoryRow]) -> String {
    let accuracy = match report.status {
        Status::Converged => format!("{}{}.", all(report), limit(report)),
        Status::Partial => {
            let unobserved = unobserved(report, history);
            format!("{}{}{unobserved}.", some(report), limit(report))
        }
        Status::Unobservable => {
            let unobserved = unobserved(report, history);
            format!("No result: the motion shows no direction of the tensor{unobserved}.")
        }
        Status::Diverged => "No result to rely on: the model does not explain the data.".to_owned(),
    };
    format!("{accuracy}{}", doubts(report))
}

/// Verdict of a simulated flight: that of the estimate, and the error against its sigma.
pub(super) fn of_run(report: &RunReport, history: &[HistoryRow]) -> String {
    let over_sigma = report.error_over_sigma;
    let worst = (0..6)
        .filter_map(|i| Some((i, over_sigma[i]?.abs())))
        .max_by(|(_, a), (_, b)| a.total_cmp(b));
    let error = worst.map(|(i, ratio)| {
        let ratio = significant(ratio, 2);
        format!(" The largest error is {ratio} sigma, of {}.", ELEMENT_NAMES[i])
    });
    of_estimate(&report.estimate, history) + &error.unwrap_or_default()
}

/// Accuracy of six observed elements.
fn all(report: &ReplayReport) -> String {
    let elements = report.elements_kg_m2();
    let percent = shares(report, &[0, 1, 2, 3, 4, 5]);
    if (0..6).all(|i| elements[i].abs() > NONZERO_SIGMAS * report.sigma_kg_m2[i]) {
        return format!("All six elements to {percent} (one sigma)");
    }
    let largest = report.sigma_kg_m2[3..].iter().copied().fold(0.0, f64::max);
    let moments = shares(report, &[0, 1, 2]);
    format!(
        "All six elements: the moments to {moments}, the products to {} kg m² (one sigma)",
        significant(largest, 2)
    )
}

/// Accuracy of those elements that are observed.
fn some(report: &ReplayReport) -> String {
    let observed: Vec<usize> = (0..6).filter(|i| report.element_observed[*i]).collect();
    let directions = report.observed_directions;
    if observed.is_empty() {
        let scale = if report.scale_observed { "" } else { ", the scale is not" };
        return format!("{directions} of 6 directions are observed{scale}, no element by itself");
    }
    let names: Vec<&str> = observed.iter().map(|i| ELEMENT_NAMES[*i]).collect();
    format!("{} to {} (one sigma)", listed(&names), shares(report, &observed))
}

/// Smallest and largest sigma of these elements over their size, as `0.05 to 1.1 %`.
fn shares(report: &ReplayReport, which: &[usize]) -> String {
    let elements = report.elements_kg_m2();
    let percent = |i: &usize| 100.0 * report.sigma_kg_m2[*i] / elements[*i].abs();
    let percents = || which.iter().map(percent).filter(|percent| percent.is_finite());
    let (low, high) = (percents().fold(f64::INFINITY, f64::min), percents().fold(0.0, f64::max));
    match (significant(low, 2), significant(high, 2)) {
        (low, high) if low == high => format!("{low} %"),
        (low, high) => format!("{low} to {high} %"),
    }
}

/// Kind of hardware error that limits the result; the noise where its part is larger.
fn limit(report: &ReplayReport) -> String {
    match &report.largest_systematic {
        Some(kind) if report.is_limited_by_hardware() => format!(", limited by the {kind}"),
        _ => ", limited by the gyro noise".to_owned(),
    }
}

/// Elements that are not observed, with the motion that would show them.
///
/// The momentum `J ω` has an element `jab` as a factor of `ω_a` and `ω_b` alone: it takes a rate about one of them.
fn unobserved(report: &ReplayReport, history: &[HistoryRow]) -> String {
    let mean_square = |axis: usize| {
        let squares = history.iter().map(|row| row.measured_rate_rad_s[axis].powi(2));
        squares.filter(|square| square.is_finite()).sum::<f64>()
    };
    let needs = |i: usize| {
        let axes = AXES[i].iter().copied();
        // Of its axes, the one with less motion.
        let axis = axes.min_by(|a, b| mean_square(*a).total_cmp(&mean_square(*b))).unwrap_or(0);
        format!("{} needs motion about {}", ELEMENT_NAMES[i], AXIS_NAMES[axis])
    };
    let missing = (0..6).filter(|i| !report.element_observed[*i]).map(needs);
    missing.map(|needs| format!("; {needs}")).collect()
}

/// Reasons to doubt the numbers.
fn doubts(report: &ReplayReport) -> String {
    let mut doubts = String::new();
    if report.residuals_white == Some(false) || report.status == Status::Diverged {
        doubts += match report.residuals_white {
            Some(false) => " The residuals are not white: an effect outside the model",
            _ => " An effect outside the model is present",
        };
        doubts += &report.explanations.first().map_or(String::new(), |best| {
            let share = significant(100.0 * best.share_explained, 2);
            format!(", best explained by {} ({share} % of it)", best.name)
        });
        doubts += ".";
    }
    for parameter in report.hardware.iter().filter(|p| p.is_contradicted()) {
        let value = in_words(parameter.value, &parameter.unit);
        doubts += &format!(" The {}, {value}, is beyond five stated sigmas.", parameter.name);
    }
    if !report.physical {
        doubts += " No rigid body has this tensor.";
    }
    if report.projected {
        doubts += " The tensor was moved to the nearest one of a rigid body.";
    }
    doubts
}

/// Names as `jxx, jyy and jzz`.
fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::json::examples;
    use super::*;

    #[test]
    fn converged_result_has_its_accuracy_and_its_limit() {
        assert_eq!(
            of_run(&examples::run(), &[]),
            "All six elements to 0.014 to 1.3 % (one sigma), limited by the gyro noise. The largest error is 1.00 sigma, of jxz."
        );
        assert_eq!(
            of_estimate(&examples::with_hardware(), &[]),
            "All six elements to 0.58 to 1.4 % (one sigma), limited by the wheel spin inertia."
        );
    }

    #[test]
    fn products_near_zero_have_an_absolute_sigma() {
        let mut report = examples::replay();
        report.inertia_kg_m2[0][1] = 0.0;
        report.inertia_kg_m2[1][0] = 0.0;
        assert_eq!(
            of_estimate(&report, &[]),
            "All six elements: the moments to 0.014 to 0.019 %, the products to 0.0016 kg m² (one sigma), limited by \
             the gyro noise."
        );
    }

    #[test]
    fn partial_result_names_the_motion_that_is_missing() {
        let mut report = examples::replay();
        report.status = Status::Partial;
        report.observed_directions = 4;
        report.element_observed = [false, true, true, true, true, false];
        assert_eq!(
            of_estimate(&report, &[]),
            "jyy, jzz, jxy and jxz to 0.014 to 1.3 % (one sigma), limited by the gyro noise; jxx needs motion about x; \
             jyz needs motion about y."
        );
    }

    #[test]
    fn result_that_the_model_does_not_explain_is_no_result() {
        let mut report = examples::replay();
        report.status = Status::Diverged;
        report.residuals_white = Some(false);
        assert_eq!(
            of_estimate(&report, &[]),
            "No result to rely on: the model does not explain the data. The residuals are not white: an effect \
             outside the model."
        );
    }
}
