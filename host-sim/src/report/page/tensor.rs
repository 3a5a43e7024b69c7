//! The tensor: its elements with sigma, truth and bound, and its principal moments and axes.

use maud::{Markup, html};

use super::table;
use crate::input::ELEMENT_NAMES;
use crate::report::json::{ReplayReport, RunReport, elements, matrix};
use crate::report::number::{fixed, significant};
use crate::report::principal::{Principal, principal};
use crate::report::table::{DIGITS, EMPTY, UNOBSERVED, decimals, element, or, short};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Elements, and beside them truth, error and bound of a simulated flight.
pub(super) fn tensor(report: &ReplayReport, truth: Option<&RunReport>) -> Markup {
    let found = report.elements_kg_m2();
    let decimals = decimals(&report.sigma_kg_m2, &found);
    let mut header =
        vec!["kg m²", "estimated", "σ", "σ random", "σ systematic", "σ, %", "observed"];
    let (bound, bounds_kg_m2) = truth.map_or(("bound", [None; 6]), RunReport::measure);
    let over = format!("error/{bound}");
    if truth.is_some() {
        header.extend(["true", "error", "error, %", "error/σ", bound, &over]);
    }
    let row = |i: usize| {
        let sigma = report.sigma_kg_m2[i];
        let percent = 100.0 * sigma / found[i].abs();
        let mut cells = vec![
            ELEMENT_NAMES[i].to_owned(),
            element(found[i], decimals),
            significant(sigma, DIGITS),
            significant(report.sigma_random_kg_m2[i], DIGITS),
            significant(report.sigma_systematic_kg_m2[i], DIGITS),
            short(percent.is_finite().then_some(percent), EMPTY),
            if report.element_observed[i] { "yes" } else { "no" }.to_owned(),
        ];
        if let Some(truth) = truth {
            let error = found[i] - truth.truth_kg_m2[i];
            cells.extend([
                element(truth.truth_kg_m2[i], decimals),
                significant(error, DIGITS),
                short(truth.error_percent[i], EMPTY),
                or(truth.error_over_sigma[i].map(|ratio| fixed(ratio, 2)), EMPTY),
                short(bounds_kg_m2[i], UNOBSERVED),
                or(bounds_kg_m2[i].map(|bound| fixed(error / bound, 2)), EMPTY),
            ]);
        }
        cells
    };
    html! {
        p { "About the centre of mass, body axes, wheels locked and included; jxy = −∫ x y dm. σ is one sigma: the root \
             sum square of the random part, by the noise of the gyro, and the systematic part, by the stated and assumed \
             errors of the hardware." }
        (table(&header, &(0..6).map(row).collect::<Vec<_>>()))
    }
}

/// Principal moments and axes, with their error in a simulated flight.
pub(super) fn principal_axes(report: &ReplayReport, truth: Option<&RunReport>) -> Markup {
    let found = principal(&report.inertia_kg_m2, &report.covariance_kg2_m4);
    let moments = found.map(|p| p.moment_kg_m2);
    if !moments.iter().all(|moment| moment.is_finite()) {
        return html! {};
    }
    let truth = truth.map(|run| principal(&matrix(&run.truth_kg_m2), &[[0.0; 6]; 6]));
    let all: [f64; 6] = std::array::from_fn(|i| moments[i % 3]);
    let sigmas: [f64; 6] = std::array::from_fn(|i| found[i % 3].sigma_kg_m2);
    let decimals = decimals(&sigmas, &all);
    let mut header =
        vec!["moment, kg m²", "σ", "axis, body components", "from body axis", "σ of direction"];
    if truth.is_some() {
        header.extend(["true moment", "error/σ", "axis off by"]);
    }
    let row = |i: usize| {
        let p = &found[i];
        let (nearest, angle_rad) = p.nearest_body_axis();
        let axis: Vec<String> = p.axis.iter().map(|component| fixed(*component, 4)).collect();
        let mut cells = vec![
            element(p.moment_kg_m2, decimals),
            significant(p.sigma_kg_m2, DIGITS),
            axis.join(", "),
            format!("{}° from {}", degrees(angle_rad), AXES[nearest]),
            p.axis_sigma_rad
                .map_or("undetermined".to_owned(), |sigma| format!("{}°", degrees(sigma))),
        ];
        cells.extend(truth.iter().flat_map(|truth| of_truth(p, &truth[i], decimals)));
        cells
    };
    table(&header, &(0..3).map(row).collect::<Vec<_>>())
}

/// True moment, error over sigma, and angle to the true axis where the direction is determined.
fn of_truth(found: &Principal, truth: &Principal, decimals: i32) -> [String; 3] {
    let ratio = (found.moment_kg_m2 - truth.moment_kg_m2) / found.sigma_kg_m2;
    let off = found.axis_sigma_rad.map(|_| format!("{}°", degrees(found.angle_to(truth))));
    [
        element(truth.moment_kg_m2, decimals),
        or(ratio.is_finite().then(|| fixed(ratio, 2)), EMPTY),
        or(off, EMPTY),
    ]
}

fn degrees(angle_rad: f64) -> String {
    significant(angle_rad.to_degrees(), DIGITS)
}

/// Tensor over its trace, where only that is observed.
pub(super) fn ratios(report: &ReplayReport) -> Markup {
    if report.scale_observed || report.observed_directions == 0 {
        return html! {};
    }
    let ratio = elements(&report.inertia_over_trace);
    let row = |i: usize| {
        let sigma = significant(report.inertia_over_trace_sigma[i], DIGITS);
        vec![ELEMENT_NAMES[i].to_owned(), fixed(ratio[i], 5), sigma]
    };
    html! {
        p { "Only the ratios of the tensor are observed; its scale is that of the prior." }
        (table(&["element", "over trace", "σ"], &(0..6).map(row).collect::<Vec<_>>()))
    }
}
